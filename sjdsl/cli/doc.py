"""`sjdsl doc`: prints all the rules of a game on a page, or what a player is told of them."""

from pathlib import Path

import click

from sjdsl.cli.folders import require_folder_of
from sjdsl.cli.game_file import open_game, variant_option
from sjdsl.compiler import ir
from sjdsl.compiler.lower import NotSupported, token_planes
from sjdsl.doc import read_written, rule_sheet
from sjdsl.files import write_whole
from sjdsl.interpreter.observe import observe
from sjdsl.interpreter.step import action_mask
from sjdsl.library.checked_game import split_variants
from sjdsl.library.parameters import param_values
from sjdsl.told import Past, Window, message
from sjdsl.told import told as told_text
from sjdsl.told.message import HISTORY
from sjdsl.trace.choices import Chosen, random_actions
from sjdsl.trace.episode import play

SEED = 0  # of the episode whose message is shown


@click.command("doc")
@click.argument("game")
@variant_option
@click.option("-o", "output", metavar="FILE", help="Write to this file instead of printing.")
@click.option("--told", is_flag=True, help="Print what a player is told: the rules in English.")
@click.option(
    "--agent", type=click.IntRange(min=0), metavar="I", help="With --told: to this agent."
)
@click.option(
    "--step",
    type=click.IntRange(min=0),
    metavar="N",
    help="With --told: also the message after N steps in which all act at random.",
)
def command(
    game: str,
    variant: str | None,
    output: str | None,
    told: bool,
    agent: int | None,
    step: int | None,
) -> None:
    """Prints all the rules of GAME on a page, in the order of the ODD protocol for agent-based
    models (Grimm et al. 2020): tables of actions, numbers, sources and what agents see, and each
    rule as written, with its comments. With --told, it prints what a player is told, such as a
    language model: the rules in English, and nothing of policies, checks or tactics.

    GAME is a `.sj` file or a bundled game.
    """
    if not told and (agent is not None or step is not None):
        raise click.UsageError("--agent and --step go with --told")
    if output is not None:
        require_folder_of(Path(output))
    written = read_written(open_game(game), split_variants(variant))
    text = _told_text(written.game, agent, step) if told else rule_sheet(written)
    if output is None:
        click.echo(text, nl=False)
    else:
        write_whole(Path(output), text)
        click.echo(f"{output}  {len(text.splitlines())} lines")


def _told_text(game: ir.Game, agent: int | None, step: int | None) -> str:
    """Returns what a player is told, and its message after some steps if they are given.

    The message is to agent 0 if none is named.
    """
    if agent is None and step is not None:
        agent = 0
    try:
        text = told_text(game, agent)
        if agent is not None and step is not None:
            text += f"\n---- the message to agent {agent} after {step} steps\n\n"
            text += _message_after(game, agent, step)
    except (NotSupported, ValueError) as refusal:
        raise click.ClickException(str(refusal)) from None
    return text


def _message_after(game: ir.Game, agent: int, steps: int) -> str:
    """Returns the message to an agent after so many steps in which all act at random.

    Raises ValueError if the episode is over by then.
    """
    params = param_values(game, {})
    past: list[Past] = []

    def choices(seed: int, _before: int) -> Chosen:
        return random_actions(game, seed)

    moments = play(game, params, SEED, steps, choices)
    moment = next(moments)
    for moment in moments:
        assert moment.outcome is not None  # only the start of an episode has none
        reward = float(moment.outcome.reward[agent])
        chosen = game.agents.actions[moment.actions[agent]]
        if agent in moment.forbidden:
            past.append(Past("stay", reward, f"{chosen} was not allowed"))
        else:
            past.append(Past(chosen, reward))
        if moment.is_over:
            raise ValueError(f"the episode is over after {len(past)} steps")
    window = Window(game, token_planes(game))
    seen = observe(game, moment.world)[agent]
    allowed = action_mask(game, moment.world)[agent]
    trial = 0 if game.trials is None else int(moment.world.fields["trial"])
    return message(window, seen, allowed, past[-HISTORY:], trial=trial)
