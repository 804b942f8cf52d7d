"""`sjdsl bench`: measures the speed of games, beside a hand-written game in the same process."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click
from rich import box
from rich.console import Console
from rich.table import Table as RichTable

from sjdsl.cli.environment_options import EnvironmentOptions, make_environment
from sjdsl.cli.folders import require_writable
from sjdsl.cli.game_file import variant_option
from sjdsl.cli.stages import stages
from sjdsl.library.games_folder import main_games

if TYPE_CHECKING:
    from sjdsl.bench.tables import Table
    from sjdsl.runtime.env import Encoding


class Listed(click.ParamType["tuple[Any, ...]"]):
    """Values of a type, separated by commas; duplicates are dropped. item: the type."""

    name = "list"

    def __init__(self, item: click.ParamType[Any]) -> None:
        self.item = item

    def convert(
        self, value: str, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[Any, ...]:
        items = [self.item.convert(part.strip(), param, ctx) for part in value.split(",")]
        return tuple(dict.fromkeys(items))


POSITIVE = click.IntRange(min=1)
COUNTS = Listed(POSITIVE)


@click.command("bench")
@click.argument("games", nargs=-1, metavar="[GAME...]")
@click.option(
    "--envs",
    type=COUNTS,
    metavar="N,N",
    default="1,128,1024,4096",
    show_default=True,
    help="Numbers of environments at once.",
)
@click.option(
    "--observation",
    type=click.Choice(["tokens", "onehot"]),
    default="tokens",
    show_default=True,
    help="Form of observations.",
)
@click.option(
    "--repeats", type=POSITIVE, metavar="N", default=5, show_default=True, help="Rounds of timings."
)
@click.option(
    "--steps",
    type=POSITIVE,
    metavar="N",
    help="Steps of one timing; by default about 40,000 environment steps in all.",
)
@click.option("--json", "json_file", metavar="FILE", help="Write the figures to a file as well.")
@variant_option
def command(
    games: tuple[str, ...],
    envs: tuple[int, ...],
    observation: "Encoding",
    repeats: int,
    steps: int | None,
    json_file: str | None,
    variant: str | None,
) -> None:
    """Measures environment steps a second under random actions, in GAMEs or in the games of games/
    itself.

    Beside each game runs the yardstick, a step of Commons Harvest written by hand. The speed of a
    machine varies over time; the ratio to the yardstick, taken round by round, does not.
    """
    if json_file:
        require_writable(Path(json_file).parent)
    disable_compilation_cache()
    environments = [
        make_environment(EnvironmentOptions(variant).describe(game), observation)
        for game in games or main_games()
    ]
    from sjdsl.bench import game_task, measure
    from sjdsl.bench.loop import steps_for
    from sjdsl.bench.stored import write_figures
    from sjdsl.bench.tables import notes_of_speeds, speed_tables

    suffix = f"+{variant}" if variant else ""
    tasks = [game_task(env, env.name + suffix) for env in environments]
    with stages("compiling") as say:
        report = measure(tasks, envs, repeats, lambda number: steps or steps_for(number), say)
    if json_file:
        write_figures(Path(json_file), report)
    print_tables(speed_tables(report), report.machine, notes_of_speeds(report))


def disable_compilation_cache() -> None:
    """Stops JAX from storing and loading compiled programs, because compile time is measured
    too.
    """
    import jax
    from jax.experimental.compilation_cache import compilation_cache

    jax.config.update("jax_enable_compilation_cache", False)
    # JAX decides whether to use a cache at the first program of a process, which an import may run.
    compilation_cache.reset_cache()


def print_tables(tables: "Sequence[Table]", machine: dict[str, Any], notes: Sequence[str]) -> None:
    """Prints the tables (at full width unless on a terminal), then the notes and the machine."""
    from sjdsl.bench.machine import machine_line

    console = Console()
    if not console.is_terminal:
        console = Console(width=200)
    for table in tables:
        rich_table = RichTable(box=box.SIMPLE, title_justify="left", title=table.title)
        for index, heading in enumerate(table.headings):
            justify: Literal["left", "right"] = "left" if index < table.labels else "right"
            rich_table.add_column(heading, justify=justify, no_wrap=index == 0)
        for row in table.rows:
            rich_table.add_row(*row)
        console.print(rich_table)
    for line in (*notes, machine_line(machine)):
        console.print(line, highlight=False, markup=False)
