"""`sjdsl play`: a person steers one agent in the terminal."""

import sys
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.environment import describe_environment, environment_options, make_environment, read_assignments
from sjdsl.cli.render import choose_policy

if TYPE_CHECKING:
    from sjdsl.replay import Course, Moment
    from sjdsl.runtime.env import Environment

KEYS = {
    "\x1b[A": "forward",
    "\x1b[B": "backward",
    "\x1b[D": "turn_left",
    "\x1b[C": "turn_right",
    ",": "step_left",
    ".": "step_right",
    " ": "stay",
}
NAMES = {"\x1b[A": "up", "\x1b[B": "down", "\x1b[D": "left", "\x1b[C": "right", " ": "space", "\r": "enter"}
QUIT = ("q", "\x03", "\x04")
Show = Callable[["Moment", str], None]


@click.command("play")
@click.argument("game")
@click.option("--agent", type=click.IntRange(min=0), default=0, show_default=True, help="Whom to steer.")
@click.option("--watch", is_flag=True, help="Steer nobody: all agents follow the policy.")
@click.option(
    "--others", default="random", show_default=True, metavar="P", help="What the others do: random, stay, a run, or a stored policy."
)
@click.option("--seed", type=int, default=0, show_default=True, help="Of the episode.")
@click.option("--steps", type=click.IntRange(min=1), help="At most so many; by default the whole episode.")
@click.option("--speed", type=click.FloatRange(min=0.5, max=1000), default=8.0, show_default=True, help="Steps a second, with --watch.")
@click.option("--record", metavar="FILE", help="Keep the episode for `sjdsl replay`.")
@environment_options
def command(
    game: str, agent: int, watch: bool, others: str, seed: int, steps: int | None, speed: float, record: str | None, **described: Any
) -> int:
    """Plays one episode of GAME: arrow keys move and turn, `,` and `.` step aside, space stays, digits are the game's own actions."""
    described["params"] = read_assignments(described["params"])
    environment = describe_environment(game, **described)
    env = make_environment(environment)
    if agent >= env.num_agents:
        raise click.ClickException(f"{env.name} has no agent {agent}: 0 to {env.num_agents - 1}")
    if not watch and not sys.stdin.isatty():
        raise click.ClickException("steering an agent takes a terminal; --watch does not")

    from sjdsl.replay import Course, save_recording

    course = Course(env, seed)
    keys = None if watch else own_keys(env)
    show = make_show(env, speed) if sys.stdout.isatty() else _show_nothing
    legend = "" if keys is None else f"agent {agent}: {describe_keys(keys, env.action_names)}  q stops"
    try:
        for moment in moments(course, choose_policy(others, env), agent, keys, click.getchar, steps or sys.maxsize):
            show(moment, legend)
    except KeyboardInterrupt:
        click.echo()
    if record is not None:
        save_recording(course.recording(environment), Path(record))
        click.echo(f"{record}  {len(course.actions)} steps of {env.title or env.name}")
    click.echo(f"returns {'  '.join(f'{number}: {value:g}' for number, value in enumerate(course.returns))}")
    return 0


def own_keys(env: "Environment") -> dict[str, int]:
    """Returns the number of the action of each key; digits from 1 stand for the game's own actions."""
    names = list(env.action_names)
    keys = {key: names.index(name) for key, name in KEYS.items() if name in names}
    own = [name for name in names if name not in KEYS.values()]
    return keys | {str(digit): names.index(name) for digit, name in enumerate(own[:9], 1)} | ({"\r": names.index(own[0])} if own else {})


def describe_keys(keys: dict[str, int], action_names: Sequence[str]) -> str:
    """Returns `up forward  left turn_left  1 zap` and so on."""
    return "  ".join(f"{NAMES.get(key, key)} {action_names[number]}" for key, number in keys.items())


def moments(
    course: "Course", policy: Any, agent: int, keys: dict[str, int] | None, read_key: Callable[[], str], steps: int
) -> Iterator["Moment"]:
    """Yields the first moment and the one after each step, until the episode ends or the person stops.

    Args:
      policy: of the others; of all where `keys` is None.
      keys: the number of the action of each key; others are not heard.
    """
    import jax

    from sjdsl.runtime.policy import take_actions, with_memory

    remembering = with_memory(policy)
    memory, act = remembering.start, jax.jit(partial(take_actions, course.env, remembering))
    key = jax.random.fold_in(jax.random.key(course.seed), 2**32 - 1)  # not one of the steps' keys
    yield course.now()
    while not course.done and len(course.actions) < steps:
        chosen = None
        while keys is not None and chosen is None:
            pressed = read_key()
            if pressed in QUIT:
                return
            chosen = keys.get(pressed)
        memory, actions = act(memory, jax.random.fold_in(key, len(course.actions)), course.observation, course.state)
        everybody = actions.tolist()
        if chosen is not None:
            everybody[agent] = chosen
        yield course.step(everybody)


def make_show(env: "Environment", speed: float, hold: Callable[[float], None] = time.sleep) -> Show:
    """Returns what draws moments in the terminal, each for its time where nobody steers."""
    from rich.console import Console

    from sjdsl.render.look import make_look
    from sjdsl.render.terminal import board_text

    console, look, tiles = Console(highlight=False), make_look(env), {}

    def show(moment: "Moment", legend: str) -> None:
        console.clear()
        console.print(board_text(look, moment.snapshot, tiles), end="", no_wrap=True, crop=True)
        console.print(describe_moment(moment))
        if legend:
            console.print(legend, style="dim")
        else:
            hold(1 / speed)

    return show


def describe_moment(moment: "Moment") -> str:
    """Returns the step, the returns and what has just happened, a line each."""
    returns = "  ".join(f"{number}: {value:g}" for number, value in enumerate(moment.snapshot.returns))
    events = ", ".join(f"{name} {int(count.sum())}" for name, count in moment.events.items())
    return f"step {moment.snapshot.step}\nreturns {returns}\n{events or '-'}"


def _show_nothing(moment: "Moment", legend: str) -> None:
    """Where the output is no terminal."""
