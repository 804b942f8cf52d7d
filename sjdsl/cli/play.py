"""`sjdsl play`: one episode in the terminal, with a line to read and a line to type for each
step.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice, repeat
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from sjdsl.cli.asked_episodes import host_of, require_model
from sjdsl.cli.environment_options import (
    EnvironmentOptions,
    environment_options,
    make_environment,
    written_options,
)
from sjdsl.cli.episode_options import seed_option
from sjdsl.cli.folders import require_folder_of
from sjdsl.cli.model_options import limit_options
from sjdsl.cli.policies import (
    FROM_FILE,
    NAMES,
    SIDE_BY_SIDE,
    check_policy,
    choose_policy,
    code_option,
    read_seats,
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
from sjdsl.models import Limits, Talks
from sjdsl.models.reasons import Reasons
from sjdsl.printable import printable
from sjdsl.render.letters import Letters, board_rows, make_letters
from sjdsl.render.moment import Moment, moment_of
from sjdsl.render.readings import agent_readings, join_readings, world_readings
from sjdsl.replay import Recording, save_recording
from sjdsl.replay.recording import with_tasks_played
from sjdsl.runtime.episode_keys import EpisodeKeys
from sjdsl.trace.choices import Chosen, chooser
from sjdsl.trace.jax_random import keys_of
from sjdsl.trace.rules import Rules
from sjdsl.trainers.settings.policy_names import UNTRAINED, YOU

if TYPE_CHECKING:
    from sjdsl.runtime.env import Environment

QUIT = "quit"
# For each step, the actions of the agents that a person controls. Where it ends, the episode ends.
Steering = Iterable[Mapping[int, int]]


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
@click.option(
    "--slots",
    metavar="P,P,...",
    help=f"Instead of --agent and --others: who plays each agent, `{YOU}` yourself, and any name "
    "that --others takes.",
)
@code_option
@seed_option("Seed of the episode.")
@click.option(
    "--steps",
    type=click.IntRange(min=1),
    metavar="N",
    help="Most steps to play; by default the whole episode.",
)
@click.option("--record", metavar="FILE", help="Store the episode for `sjdsl replay`.")
@environment_options
@limit_options
def command(
    game: str,
    agent: int,
    watch: bool,
    others: str,
    slots: str | None,
    seed: int,
    steps: int | None,
    record: str | None,
    options: EnvironmentOptions,
    limits: Limits,
) -> None:
    """Plays one episode of GAME: shows the board, and reads what your agent does next.

    Type an action's number, its name or the first letters of its name; an empty line is `stay`.
    Several actions with spaces between them are taken one after the other. `quit` or Ctrl-D ends
    the episode.
    """
    if slots is not None and {"--agent", "--watch", "--others"} & set(written_options()):
        raise click.UsageError("--slots says who plays each agent, without --agent and --others")
    arguments = options.describe(game)
    if record is not None:
        require_folder_of(Path(record))
    built, values = options.build(game)
    rules = built.game
    board = board_of(rules)
    player = None if watch else agent
    seats: list[str] = []
    if slots is not None:
        seats, player = read_seats(slots, rules)
    elif agent >= rules.agents.number:
        raise click.ClickException(
            f"{rules.name} has no agent {agent}; its agents are 0 to {rules.agents.number - 1}"
        )
    else:
        check_policy(others, rules)

    require_model(limits, seats or [others])
    length = int(evaluate(rules.episode, Instance(board, declared_world(board, values))))
    most_steps = min(length, steps or length)
    steering: Steering
    if player is None:
        steering = repeat({}, most_steps)
    else:
        typed = typed_actions(rules.agents.actions)
        steering = islice(({player: action} for action in typed), most_steps)
    reasons = Reasons(Talks(limits=limits).part("play"))
    is_declared = others in (*UNTRAINED, *(policy.name for policy in rules.policies))
    if not seats and is_declared:
        moments = play_interpreted(rules, values, seed, chooser(rules, others, seed), steering)
    else:
        with stages(f"compiling {rules.name}"):
            env = make_environment(arguments)
            from sjdsl.trainers.policies.seating import seated_policy

            if not seats and host_of(others) is not None:
                seats = [others] * rules.agents.number
                if player is not None:
                    seats[player] = YOU
            if seats:
                policy = seated_policy(seats, env, choose_policy, reasons.ask, limits.parallel)
            else:
                policy = choose_policy(others, env)
            moments = play_compiled(env, policy, seed, steering)

    title = title_of(rules)
    you_play = "" if player is None else f": you play agent {player}"
    click.echo(f"{title}, seed {seed}, {length} steps{you_play}")
    letters = make_letters(rules)
    click.echo(letters.legend_line())
    if player is not None:
        click.echo(f"the actions are {_listed(rules.agents.actions)}; `{QUIT}` ends the episode")
    actions: list[list[int]] = []
    returns = [0.0] * rules.agents.number
    try:
        for moment in moments:
            if moment.actions:
                actions.append(list(moment.actions))
            returns = moment.snapshot.returns.tolist()
            lines = moment_lines(moment, letters, board, player, seats)
            click.echo("\n" + "\n".join(lines))
    except LeavesFloat32 as overflow:
        raise click.ClickException(Rules(built.sources).overflow(overflow)) from None
    finally:  # also after Ctrl-C
        if record is not None:
            recording = Recording(
                environment=with_tasks_played(arguments, rules.task),
                hash=game_hash(rules),
                seed=seed,
                actions=actions,
                returns=returns,
                players=seats or None,
                why=reasons.table(len(actions), rules.agents.number),
            )
            save_recording(recording, Path(record))
            click.echo(f"\n{record}  {len(actions)} steps of {title}")


def moment_lines(
    moment: Moment,
    letters: Letters,
    board: Board,
    player: int | None = None,
    seats: Sequence[str] = (),
) -> Iterator[str]:
    """Yields the lines that show a moment: the board, and after a step what each agent did and got.

    Args:
      player: the agent that a person controls, if any.
      seats: the name of who plays each agent, if there are several.
    """
    snapshot = moment.snapshot
    world = join_readings(world_readings(board.game), snapshot)
    yield f"step {snapshot.step}" + (f"  {world}" if world else "")
    board_lines = board_rows(letters, board, snapshot)
    if player is not None and snapshot.row[player] >= 0:
        line = board_lines[snapshot.row[player]]
        col = int(snapshot.col[player])
        marked = click.style(line[col], reverse=True)  # click prints the style only in a terminal
        board_lines[snapshot.row[player]] = line[:col] + marked + line[col + 1 :]
    yield from (f"  {line}" for line in board_lines)
    if not moment.actions:
        return
    names = board.game.agents.actions
    width = max(map(len, names))
    readings = agent_readings(board.game)
    names_of_agents = dict(enumerate(seats))
    if player is not None:
        names_of_agents[player] = YOU
    labels = [
        f"{agent} {names_of_agents.get(agent, '')}".strip() for agent in range(len(moment.actions))
    ]
    margin = max(6, *map(len, labels))
    yield f"  {'agent':{margin}}  {'action':{width}}  reward  return"
    for agent, action in enumerate(moment.actions):
        cells = [
            f"{labels[agent]:{margin}}",
            f"{names[action]:{width}}",
            f"{moment.reward[agent]:6.4g}",
            f"{snapshot.returns[agent]:6.4g}",
        ]
        if snapshot.row[agent] < 0:
            cells.append("away")
        elif snapshot.held[agent]:
            cells.append("can only stay")
        text = join_readings(readings, snapshot, agent)
        if text:
            cells.append(text)
        yield "  " + "  ".join(cells)
    if moment.events:
        yield "  " + ", ".join(f"{name} {np.sum(count)}" for name, count in moment.events.items())
    for agent, why in enumerate(moment.why):
        if why:
            yield f"  {labels[agent]}: {printable(why)}"
    if moment.done:
        yield "  the episode is over"


def typed_actions(names: Sequence[str]) -> Iterator[int]:
    """Yields the numbers of the actions that a person types, until `quit` or the end of standard
    input.

    A line with a mistake is answered with a message, and the next line is read.
    """
    while True:
        try:
            texts = [text for text in split_actions(input("> "), r"\s+") if text]
            numbers = [_read_action(text, names) for text in texts or ["stay"]]
        except EOFError:
            return
        except ValueError as error:
            click.echo(error)
            continue
        for number in numbers:
            if number == len(names):
                return
            yield number


def _read_action(text: str, names: Sequence[str]) -> int:
    """Returns the number of an action; for `quit` the one after the last.

    Raises ValueError for a text that is the beginning of no name, or of several.
    """
    if text.isdecimal() and int(text) < len(names):
        return int(text)
    known = [*names, QUIT]
    if text in known:
        return known.index(text)
    candidates = [name for name in known if name.startswith(text)]
    if len(candidates) != 1:
        fault = f"can be {' or '.join(candidates)}" if candidates else "is no action"
        raise ValueError(
            f"`{text}` {fault}; the actions are {_listed(names)}; `{QUIT}` ends the episode"
        )
    return known.index(candidates[0])


def _listed(names: Sequence[str]) -> str:
    """Returns `0 stay, 1 forward`."""
    return ", ".join(f"{number} {name}" for number, name in enumerate(names))


def play_interpreted(
    game: ir.Game, params: Mapping[str, Value], seed: int, choose: Chosen, steering: Steering
) -> Iterator[Moment]:
    """Yields the moments of an episode, with the start, without JAX.

    For the same seed and actions, they are those that `EpisodePlayer` plays.

    Args:
      params: every parameter of the game, reals as float32.
      choose: the actions of the agents that `steering` doesn't control.

    Raises:
      LeavesFloat32.
    """
    keys = keys_of(seed)
    world = copied(reset(game, params, Threefry(*keys.start())))
    moment = moment_of(game, world, [0.0] * game.agents.number)
    yield moment
    for number, controlled in enumerate(steering):
        chosen = enumerate(choose(number, world))
        actions = [controlled.get(agent, action) for agent, action in chosen]
        world, outcome = step(game, world, actions, params, Threefry(*keys.of_step(number)))
        returns = moment.snapshot.returns + np.array(outcome.reward, float)
        moment = moment_of(game, world, returns, actions, outcome)
        yield moment
        if moment.done:
            return


def play_compiled(
    env: "Environment", policy: Any, seed: int, steering: Steering
) -> Iterator[Moment]:
    """Yields the moments of an episode of the compiled game, with the start.

    `policy` chooses the actions of the agents that `steering` doesn't control.
    """
    import jax
    import jax.numpy as jnp

    from sjdsl.replay import EpisodePlayer
    from sjdsl.runtime.policy import compiled_actions, with_memory

    player = EpisodePlayer(env, seed)
    keys = EpisodeKeys(jax.random.key(seed), jax.random.fold_in)
    recurrent = with_memory(policy)
    act, after_step = compiled_actions(env, recurrent)
    memory = recurrent.start
    yield player.now()
    for number, controlled in enumerate(steering):
        key = keys.of_choices(number)
        memory, actions = act(memory, key, player.observation, player.state)
        chosen = enumerate(actions.tolist())
        moment = player.step([controlled.get(agent, action) for agent, action in chosen])
        yield moment
        if moment.done:
            return
        played = jnp.array(moment.actions, jnp.int32)
        memory = after_step(memory, played, jnp.array(moment.reward), player.info)
