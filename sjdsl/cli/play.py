"""`sjdsl play`: lets a person control one agent in the terminal."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.environment_options import SEED, EnvironmentOptions, environment_options, make_environment
from sjdsl.cli.folders import require_folder_of
from sjdsl.cli.policies import NAMES, check_policy, choose_policy, code_option
from sjdsl.cli.stages import stages
from sjdsl.cli.terminal import can_show_screen, run_screen
from sjdsl.compiler.ir.hash import game_hash
from sjdsl.interpreter.board import board_of, declared_world
from sjdsl.interpreter.evaluate import evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.replay import save_recording
from sjdsl.screen.session import Choose, Compiled, Interpreted, Prepared, Session, choice_of, policy_choice
from sjdsl.trace.choices import no_actions, random_actions, scripted_actions
from sjdsl.trainers.policy_names import UNTRAINED

if TYPE_CHECKING:
    from sjdsl.compiler import ir
    from sjdsl.render.moment import Moment

LITTLE = 60_000  # cells times steps that the interpreter plays faster than a game compiles
NO_TERMINAL = (
    "there is no terminal to play in: keys are read from standard input and the screen is drawn on standard error, and one of them is a "
    "file or a pipe. Run `sjdsl play` in a terminal; or let all agents act by themselves with --watch, and store the episode with "
    "--record FILE"
)


@click.command("play")
@click.argument("game")
@click.option("--agent", type=click.IntRange(min=0), metavar="N", default=0, show_default=True, help="The agent to control.")
@click.option("--watch", is_flag=True, help="Control no agent: all follow the policy of --others.")
@click.option("--others", default="random", show_default=True, metavar="P", help=f"The other agents' policy: {NAMES}")
@code_option
@click.option("--seed", type=SEED, metavar="N", default=0, show_default=True, help="Seed of the episode.")
@click.option("--steps", type=click.IntRange(min=1), metavar="N", help="Most steps to play; by default the whole episode.")
@click.option(
    "--speed", type=click.FloatRange(min=0.5, max=1000), metavar="N", default=8.0, show_default=True, help="Steps a second, with --watch."
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
    speed: float,
    record: str | None,
    options: EnvironmentOptions,
) -> int:
    """Plays one episode of GAME: arrow keys move and turn, `,` and `.` step aside, space stays, digits are the game's own actions."""
    environment = options.describe(game)
    if not watch and not can_show_screen():
        raise click.ClickException(NO_TERMINAL)
    if record is not None:
        require_folder_of(Path(record))
    made, values = options.build(game)
    if agent >= made.game.agents.number:
        raise click.ClickException(f"{made.game.name} has no agent {agent}; its agents are 0 to {made.game.agents.number - 1}")
    choose = _choice_of(others, made.game, seed)
    session = begin_session(made.game, values, seed, choose, None if watch else agent, steps)
    play_on(session, made.game, values, environment, others, seed, speed)

    if record is not None:
        save_recording(session.recording(environment, game_hash(made.game), seed), Path(record))
        click.echo(f"{record}  {len(session.actions)} steps of {made.game.title or made.game.name}")
    click.echo(describe_returns(session.moment.snapshot.returns))
    return 0


def begin_session(
    game: "ir.Game", values: dict[str, Any], seed: int, choose: "Choose", agent: int | None, steps: int | None = None
) -> "Session":
    """Returns a session on the interpreter. `steps`: at most this many; None is the whole episode."""
    board = board_of(game)
    whole = int(evaluate(game.episode, Instance(board, declared_world(board, values))))
    return Session(Interpreted(game, values, seed), choose, agent, whole if steps is None else min(whole, steps))


def play_on(
    session: "Session",
    game: "ir.Game",
    values: dict[str, Any],
    environment: dict[str, Any],
    others: str,
    seed: int,
    speed: float,
    show: Callable[["Moment"], object] = lambda _: None,
) -> None:
    """Plays a session to its end, or until the person stops: on the screen, or through `show` where there is no screen."""
    trained = others not in (*UNTRAINED, *(policy.name for policy in game.policies))

    def compiled() -> Any:
        env = make_environment(environment)
        choose = policy_choice(env, choose_policy(others, env), seed) if trained else None
        return Prepared(Compiled(env, values, seed), choose)

    if can_show_screen():
        run_screen(game, session, compiled, speed, waits=trained)
        return
    if trained or session.length * len(game.rows) * len(game.rows[0]) > LITTLE:
        with stages(f"compiling {game.name}"):
            ready = compiled()
        session.hand_over(ready.player, 0, ready.choose)
    show(session.moment)
    while not session.is_over:
        show(session.step())


def _choice_of(others: str, game: "ir.Game", seed: int) -> "Choose":
    """Returns what the others do, as far as that needs no JAX. Raises ClickException if it isn't a policy."""
    check_policy(others, game)
    if any(policy.name == others for policy in game.policies):
        return choice_of(scripted_actions(game, others, seed))
    return choice_of(random_actions(game, seed) if others == "random" else no_actions(game))


def describe_returns(returns: Any) -> str:
    """Returns `returns 0: 3  1: 5`: each agent's number and return."""
    return f"returns {'  '.join(f'{number}: {value:g}' for number, value in enumerate(returns))}"
