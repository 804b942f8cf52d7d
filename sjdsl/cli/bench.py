"""`sjdsl bench`: measures the speed of games, beside a hand-written game in the same process."""

import contextlib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from rich import box
from rich.console import Console
from rich.table import Table as RichTable

from sjdsl.cli.environment_options import EnvironmentOptions, make_environment
from sjdsl.cli.game_file import variant_option
from sjdsl.cli.stages import stages
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.library.games_folder import main_games

if TYPE_CHECKING:
    from sjdsl.bench import Task
    from sjdsl.bench.tables import Table
    from sjdsl.runtime.env import Encoding

RACED = (1, 128, 1024, 4096)  # environments
CROWD = "crowd"  # the variant with room for many agents, of games that have too little
OBSERVATIONS: tuple["Encoding", "Encoding"] = ("tokens", "onehot")


class Listed(click.ParamType["tuple[Any, ...]"]):
    """Values between commas, each once.

    Args:
      read: reads one value; raises ValueError.
      expected: what the values are, for the message.
    """

    name = "list"

    def __init__(self, read: Callable[[str], Any], expected: str) -> None:
        self.read, self.expected = read, expected

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> tuple[Any, ...]:
        try:
            return tuple(dict.fromkeys(self.read(part.strip()) for part in value.split(",")))
        except ValueError:
            self.fail(f"`{value}` is not {self.expected}", param, ctx)


def _count(text: str) -> int:
    if not text.isdecimal() or int(text) == 0:
        raise ValueError(text)
    return int(text)


def words(known: Sequence[str]) -> Listed:
    """Returns the type of `tokens,onehot`: words out of those that are known."""
    each = ", ".join(f"`{word}`" for word in known)
    return Listed(lambda word: known[known.index(word)], f"{each} or `{','.join(known[:2])}`")


COUNTS = Listed(_count, "a list of whole numbers such as 1,128,1024")
AGENTS = Listed(lambda text: None if text == "own" else _count(text), "a list of numbers of agents such as own,20")


@click.command("bench")
@click.argument("games", nargs=-1, metavar="[GAME...]")
@click.option("--envs", type=COUNTS, metavar="N,N", help="Numbers of environments at once.  [default: 1,128,1024,4096]")
@click.option(
    "--observation",
    "observations",
    type=words(OBSERVATIONS),
    default="tokens",
    show_default=True,
    metavar="O,O",
    help="Forms of observations: tokens, onehot or tokens,onehot.",
)
@click.option("--agents", type=AGENTS, metavar="N,N", default="own", show_default=True, help="Numbers of agents, such as own,20.")
@click.option(
    "--devices",
    type=click.IntRange(min=1),
    metavar="N",
    default=1,
    show_default=True,
    help="Split the environments over N devices: GPUs, or parts of the CPU with a core each.",
)
@click.option("--repeats", type=click.IntRange(min=1), metavar="N", default=5, show_default=True, help="Rounds of timings.")
@click.option(
    "--steps", type=click.IntRange(min=1), metavar="N", help="Steps of one timing; by default about 40,000 environment steps in all."
)
@click.option("--json", "json_file", metavar="FILE", help="Write the figures to a file as well.")
@variant_option
@click.pass_context
def command(
    context: click.Context,
    /,
    games: tuple[str, ...],
    envs: tuple[int, ...] | None,
    observations: "tuple[Encoding, ...]",
    agents: tuple[int | None, ...],
    devices: int,
    repeats: int,
    steps: int | None,
    json_file: str | None,
    variant: str | None,
) -> None:
    """Measures environment steps a second under random actions, in GAMEs or in the games of games/ itself.

    Beside each game runs the yardstick, a step of Commons Harvest written by hand. The speed of a machine
    varies over time; the ratio to the yardstick, taken round by round, does not.
    """
    divide_cpu(devices)
    disable_compilation_cache()
    raced = envs or tuple(number for number in RACED if number % devices == 0)
    check_devices(context, devices, raced)
    tasks, refused = choose_tasks(games or main_games(), variant, observations, agents)
    from sjdsl.bench import measure
    from sjdsl.bench.loop import steps_for
    from sjdsl.bench.stored import write_found
    from sjdsl.bench.tables import memory_note, speed_tables

    with stages("compiling") as tell:
        found = measure(tasks, raced, repeats, lambda number: steps or steps_for(number), tell, devices=devices)
    if json_file:
        write_found(Path(json_file), found)
    print_tables(speed_tables(found), found.machine, [*refused, *memory_note(found)])


def divide_cpu(devices: int) -> None:
    """Makes JAX divide the CPU into this many devices. That works only before the first computation of a process."""
    if devices == 1:
        return
    import jax

    with contextlib.suppress(RuntimeError):  # JAX has begun; `check_devices` complains if it has too few devices
        jax.config.update("jax_num_cpu_devices", devices)


def disable_compilation_cache() -> None:
    """Stops JAX from storing and finding compiled programs, because seconds of compiling are measured too."""
    import jax
    from jax.experimental.compilation_cache import compilation_cache

    jax.config.update("jax_enable_compilation_cache", False)
    compilation_cache.reset_cache()  # JAX decides at the first program of a process, which an import may make


def check_devices(context: click.Context, devices: int, num_envs: Sequence[int]) -> None:
    """Checks that these numbers of environments can be split over the devices.

    Raises:
      UsageError: the number of environments is not a multiple of the number of devices.
      ClickException: JAX has fewer devices.
    """
    if devices == 1:
        return
    for number in num_envs:
        if number % devices:
            raise click.UsageError(f"--envs {number} cannot be split evenly over {devices} devices; change --envs or --devices", context)
    if not num_envs:
        raise click.UsageError(f"name --envs that are multiples of {devices}, such as --envs {devices * 128}", context)
    import jax

    if len(found := jax.devices()) < devices:
        some = f"{len(found)} device{'s' * (len(found) > 1)}"
        raise click.ClickException(f"JAX has {some} here ({found[0].platform}), not {devices}; change --devices")


def choose_tasks(
    games: Sequence[str], variant: str | None, observations: "Sequence[Encoding]", agents: Sequence[int | None]
) -> tuple[list["Task"], list[str]]:
    """Returns the tasks to measure, and a line for each form that its game refuses.

    Args:
      games: names or files.
      variant: of all of them.
      observations: `tokens`, `onehot` or both.
      agents: numbers of agents; None is the game's own.
    Raises CompileError, ClickException: a game that can't be compiled as it is, or no form that is accepted.
    """
    tasks: list[Task] = []
    refused: list[str] = []
    for game in games:
        EnvironmentOptions(variant).make(game)  # a fault of the game itself isn't a refused number
        for number in agents:
            try:
                tasks += _tasks_of(game, variant, number, observations)
            except CompileError as error:
                messages = "; ".join(mistake.message for mistake in error.diagnostics)
                refused.append(f"{game} can't have {number} agents: {messages}")
    if not tasks:
        raise click.ClickException("; ".join(refused))
    return tasks, refused


def _tasks_of(game: str, variant: str | None, number: int | None, observations: "Sequence[Encoding]") -> Iterator["Task"]:
    """Yields a game by observation, or its variant `crowd` if the game has no room for this number of agents. Raises CompileError."""
    from sjdsl.bench import game_task

    form = EnvironmentOptions(variant, num_agents=number).describe(game)
    try:
        make_environment(form)
    except CompileError as refusal:
        form["variant"] = f"{variant}+{CROWD}" if variant else CROWD
        try:
            make_environment(form)
        except CompileError:
            raise refusal from None
    for observation in observations:
        env = make_environment(form, observation)
        yield game_task(env, f"{env.name}+{form['variant']}" if form["variant"] else env.name, number)


def print_tables(tables: "Sequence[Table]", machine: dict[str, Any], notes: Sequence[str]) -> None:
    """Prints the tables (at full width unless on a terminal), then the notes and the machine."""
    from sjdsl.bench.machine import machine_line

    console = Console()
    console = console if console.is_terminal else Console(width=200)
    for table in tables:
        shown = RichTable(box=box.SIMPLE, title_justify="left", title=table.title)
        for index, heading in enumerate(table.headings):
            shown.add_column(heading, justify="left" if index < table.labels else "right", no_wrap=index == 0)
        for row in table.rows:
            shown.add_row(*row)
        console.print(shown)
    for line in (*notes, machine_line(machine)):
        console.print(line, highlight=False, markup=False)
