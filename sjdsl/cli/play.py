"""`sjdsl play`: one episode in the terminal, with a line to read and a line to type for each step."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import islice, repeat
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from sjdsl.cli.environment_options import (
    SEED,
    EnvironmentOptions,
    environment_options,
    make_environment,
)
from sjdsl.cli.folders import require_folder_of
from sjdsl.cli.policies import (
    FROM_FILE,
    NAMES,
    SIDE_BY_SIDE,
    check_policy,
    choose_policy,
    code_option,
)
from sjdsl.cli.stages import stages
from sjdsl.compiler import ir
from sjdsl.compiler.ir.hash import game_hash
from sjdsl.compiler.ir.queries import title_of
from sjdsl.interpreter.board import Board, board_of, declared_world
from sjdsl.interpreter.evaluate import evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.overflow import LeavesFloat32
from sjdsl.interpreter.state import Value, copied
from sjdsl.interpreter.step import reset, step
from sjdsl.interpreter.threefry import Threefry
from sjdsl.library.action_names import split_actions
from sjdsl.render.letters import Letters, board_rows, make_letters
from sjdsl.render.moment import Moment, moment_of
from sjdsl.render.readings import agent_readings, said_together, world_readings
from sjdsl.replay import Recording, save_recording
from sjdsl.trace.choices import Chosen, chooser
from sjdsl.trace.jax_random import keys_of
from sjdsl.trace.rules import Rules
from sjdsl.trainers.settings.policy_names import UNTRAINED

if TYPE_CHECKING:
    from sjdsl.runtime.env import Environment

QUIT = "quit"
Steering = Iterable[
    Mapping[int, int]
]  # for each step, the actions of the agents that don't choose by themselves; its end ends the episode


@click.command("play")
@click.argument("game")
@click.option(
    "--agent",
    type=click.IntRange(min=0),
    metavar="N",
    default=0,
    show_default=True,
    help="The agent to control.",
)
@click.option("--watch", is_flag=True, help="Control no agent: all follow the policy of --others.")
@click.option(
    "--others",
    default="random",
    show_default=True,
    metavar="P",
    help=f"The other agents' policy: {NAMES} {SIDE_BY_SIDE}: {FROM_FILE}.",
)
@code_option
@click.option(
    "--seed", type=SEED, metavar="N", default=0, show_default=True, help="Seed of the episode."
)
@click.option(
    "--steps",
    type=click.IntRange(min=1),
    metavar="N",
    help="Most steps to play; by default the whole episode.",
)
@click.option("--record", metavar="FILE", help="Store the episode for `sjdsl replay`.")
@environment_options
def command(
    game: str,
    agent: int,
    watch: bool,
    others: str,
    seed: int,
    steps: int | None,
    record: str | None,
    options: EnvironmentOptions,
) -> None:
    """Plays one episode of GAME: shows the board, and reads what your agent does next.

    Type an action's number, its name or the first letters of its name; an empty line is `stay`. Several actions with spaces between them
    are taken one after the other. `quit` or Ctrl-D ends the episode.
    """
    environment = options.describe(game)
    if record is not None:
        require_folder_of(Path(record))
    made, values = options.build(game)
    rules, board, letters = made.game, board_of(made.game), make_letters(made.game)
    if agent >= rules.agents.number:
        raise click.ClickException(
            f"{rules.name} has no agent {agent}; its agents are 0 to {rules.agents.number - 1}"
        )
    check_policy(others, rules)

    whole = int(evaluate(rules.episode, Instance(board, declared_world(board, values))))
    typed = ({agent: action} for action in typed_actions(rules.agents.actions))
    steering: Steering = islice(repeat({}) if watch else typed, min(whole, steps or whole))
    if others in (*UNTRAINED, *(policy.name for policy in rules.policies)):
        moments = interpreted(rules, values, seed, chooser(rules, others, seed), steering)
    else:
        with stages(f"compiling {rules.name}"):
            env = make_environment(environment)
            moments = compiled(env, choose_policy(others, env), seed, steering)

    title = title_of(rules)
    click.echo(
        f"{title}, seed {seed}, {whole} steps" + ("" if watch else f": you play agent {agent}")
    )
    click.echo(letters.legend_line())
    if not watch:
        click.echo(f"the actions are {_listed(rules.agents.actions)}; `{QUIT}` ends the episode")
    taken, returns = list[list[int]](), [0.0] * rules.agents.number
    try:
        for moment in moments:
            taken += [list(moment.actions)] if moment.actions else []
            returns = moment.snapshot.returns.tolist()
            click.echo(
                "\n" + "\n".join(moment_lines(moment, letters, board, None if watch else agent))
            )
    except LeavesFloat32 as left:
        raise click.ClickException(Rules(made.sources).overflow(left)) from None
    finally:  # also after Ctrl-C
        if record is not None:
            kept = Recording(
                environment=environment,
                hash=game_hash(rules),
                seed=seed,
                actions=taken,
                returns=returns,
            )
            save_recording(kept, Path(record))
            click.echo(f"\n{record}  {len(taken)} steps of {title}")


def moment_lines(
    moment: Moment, letters: Letters, board: Board, own: int | None = None
) -> Iterator[str]:
    """Yields the lines that show a moment: the board, and after a step what each agent did and got. `own`: the agent that a person plays."""
    snapshot, names = moment.snapshot, board.game.agents.actions
    world = said_together(world_readings(board.game), snapshot)
    yield f"step {snapshot.step}" + (f"  {world}" if world else "")
    rows = board_rows(letters, board, snapshot)
    if own is not None and snapshot.row[own] >= 0:
        row, col = int(snapshot.row[own]), int(snapshot.col[own])
        rows[row] = (
            rows[row][:col] + click.style(rows[row][col], reverse=True) + rows[row][col + 1 :]
        )  # only in a terminal
    yield from (f"  {row}" for row in rows)
    if not moment.actions:
        return
    width = max(map(len, names))
    readings = agent_readings(board.game)
    yield f"  agent   {'action':{width}}  reward  return"
    for agent, action in enumerate(moment.actions):
        who = f"{agent} you" if agent == own else str(agent)
        state = (
            "  away"
            if snapshot.row[agent] < 0
            else "  can only stay"
            if snapshot.held[agent]
            else ""
        )
        shown = said_together(readings, snapshot, agent)
        did = f"  {who:6}  {names[action]:{width}}  {moment.reward[agent]:6.4g}  {snapshot.returns[agent]:6.4g}{state}"
        yield f"{did}  {shown}" if shown else did
    if moment.events:
        yield "  " + ", ".join(f"{name} {np.sum(count)}" for name, count in moment.events.items())
    if moment.done:
        yield "  the episode is over"


def typed_actions(names: Sequence[str]) -> Iterator[int]:
    """Yields the numbers of the actions that a person types, until `quit` or the end of standard input; mistakes are answered."""
    while True:
        try:
            words = [word for word in split_actions(input("> "), r"\s+") if word]
            numbers = [_read_action(word, names) for word in words or ["stay"]]
        except EOFError:
            return
        except ValueError as mistake:
            click.echo(mistake)
            continue
        for number in numbers:
            if number == len(names):
                return
            yield number


def _read_action(word: str, names: Sequence[str]) -> int:
    """Returns the number of an action; for `quit` the one after the last. Raises ValueError for a word that means none, or several."""
    if word.isdecimal() and int(word) < len(names):
        return int(word)
    known = [*names, QUIT]
    meant = [name for name in known if name == word] or [
        name for name in known if name.startswith(word)
    ]
    if len(meant) != 1:
        wrong = f"can be {' or '.join(meant)}" if meant else "is no action"
        raise ValueError(
            f"`{word}` {wrong}; the actions are {_listed(names)}; `{QUIT}` ends the episode"
        )
    return known.index(meant[0])


def _listed(names: Sequence[str]) -> str:
    return ", ".join(f"{number} {name}" for number, name in enumerate(names))


def interpreted(
    game: ir.Game, params: Mapping[str, Value], seed: int, choose: Chosen, steering: Steering
) -> Iterator[Moment]:
    """Yields the moments of an episode, from the start on, without JAX: for the same seed and actions what `EpisodePlayer` plays.

    Args:
      params: every parameter of the game, reals as float32.
      choose: what the agents do by themselves.

    Raises:
      LeavesFloat32.
    """
    keys = keys_of(seed)
    world = copied(reset(game, params, Threefry(*keys.start())))
    moment = moment_of(game, world, [0.0] * game.agents.number)
    yield moment
    for number, given in enumerate(steering):
        actions = [given.get(agent, action) for agent, action in enumerate(choose(number, world))]
        world, outcome = step(game, world, actions, params, Threefry(*keys.of_step(number)))
        moment = moment_of(
            game, world, moment.snapshot.returns + np.array(outcome.reward, float), actions, outcome
        )
        yield moment
        if moment.done:
            return


def compiled(env: "Environment", policy: Any, seed: int, steering: Steering) -> Iterator[Moment]:
    """Yields the moments of an episode of the compiled game. `policy`: what the agents do by themselves."""
    import jax

    from sjdsl.replay import EpisodePlayer
    from sjdsl.runtime.policy import take_actions, with_memory

    player, remembering = EpisodePlayer(env, seed), with_memory(policy)
    memory, act = remembering.start, jax.jit(partial(take_actions, env, remembering))
    yield player.now()
    for number, given in enumerate(steering):
        memory, chosen = act(
            memory, player.keys.of_choices(number), player.observation, player.state
        )
        yield player.step(
            [given.get(agent, action) for agent, action in enumerate(chosen.tolist())]
        )
        if player.done:
            return
