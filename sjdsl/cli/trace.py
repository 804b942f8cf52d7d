"""`sjdsl trace`: prints what happens in a game step by step: every change, its rule and why it
happened.
"""

from typing import TYPE_CHECKING

import click

from sjdsl.cli.environment_options import EnvironmentOptions, environment_options
from sjdsl.cli.episode_options import SEED_OF_FIRST, seed_option
from sjdsl.compiler.ir.queries import beginning_phases
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.overflow import LeavesFloat32
from sjdsl.near_names import meant
from sjdsl.trace.actions import RANDOM, policy_actions, read_actions
from sjdsl.trace.episode import play
from sjdsl.trace.lines import make_teller, moment_lines
from sjdsl.trace.rules import Rules

if TYPE_CHECKING:
    from sjdsl.compiler import ir

STEPS = 10


@click.command("trace")
@click.argument("game")
@click.option(
    "--steps",
    type=click.IntRange(min=0),
    metavar="N",
    help=f"Steps to play; by default {STEPS}, or as many as --actions has.",
)
@seed_option(SEED_OF_FIRST)
@click.option(
    "--phase", "phases", multiple=True, metavar="P", help="Only this phase, `tick` or `start`."
)
@click.option(
    "--actions",
    metavar="A",
    help="What agents do: random (the default), or 'forward, stay; zap, stay'.",
)
@click.option("--policy", metavar="P", help="All agents follow this policy of the game's file.")
@environment_options
def command(
    game: str,
    steps: int | None,
    seed: int,
    phases: tuple[str, ...],
    actions: str | None,
    policy: str | None,
    options: EnvironmentOptions,
) -> None:
    """Plays GAME on the reference interpreter and prints what each rule did, in the order of the
    schedule.

    Below each rule (file and line) are the cells and agents it changed, rewards and events, and
    why: the conditions and draws behind a change, and the values that they read. In --actions, each
    part up to `;` is a step, with an action for each agent or one for all.
    """
    if actions is not None and policy is not None:
        raise click.UsageError(
            "--actions and --policy both choose what the agents do: give only one of them"
        )
    built, values = options.build(game)
    rules = Rules(built.sources)
    try:
        if policy is not None:
            choices = policy_actions(policy, built.game)
        else:
            choices, written_steps = read_actions(actions or RANDOM, built.game, steps)
            steps = written_steps if steps is None else steps
    except ValueError as error:
        raise click.ClickException(str(error)) from None
    check_phases(phases, built.game)
    teller = make_teller(board_of(built.game), rules, phases)
    moments = play(built.game, values, seed, STEPS if steps is None else steps, choices)
    try:
        click.echo(f"{built.game.title or built.game.name}, seed {seed}")
        click.echo(f"  {teller.looks.legend_line()}\n")
        for moment in moments:
            for line in moment_lines(moment, teller):
                click.echo(line)
    except LeavesFloat32 as overflow:
        raise click.ClickException(rules.overflow(overflow)) from None


def check_phases(phases: tuple[str, ...], game: "ir.Game") -> None:
    """Raises ClickException for a phase that the game doesn't have."""
    turns = (*beginning_phases(game), *game.schedule)
    labels = [getattr(turn, "label", "tick") for turn in turns]
    names = list(dict.fromkeys([*labels, *(label.partition("(")[0] for label in labels)]))
    for phase in phases:
        if phase not in names:
            raise click.ClickException(
                f"the schedule has no phase `{phase}`{meant(phase, names, 'its phases are')}"
            )
