"""`sjdsl bench`: measures the speed of games, beside a hand-written game in the same process."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

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
    """Values between commas, each once. each: the type of one of them."""

    name = "list"

    def __init__(self, each: click.ParamType[Any]) -> None:
        self.each = each

    def convert(
        self, value: str, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[Any, ...]:
        return tuple(
            dict.fromkeys(self.each.convert(part.strip(), param, ctx) for part in value.split(","))
        )


LEAST = click.IntRange(min=1)
COUNTS = Listed(LEAST)


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
    "--repeats", type=LEAST, metavar="N", default=5, show_default=True, help="Rounds of timings."
)
@click.option(
    "--steps",
    type=LEAST,
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
    """Measures environment steps a second under random actions, in GAMEs or in the games of games/ itself.

    Beside each game runs the yardstick, a step of Commons Harvest written by hand. The speed of a machine
    varies over time; the ratio to the yardstick, taken round by round, does not.
    """
    if json_file:
        require_writable(Path(json_file).parent)
    disable_compilation_cache()
    made = [
        make_environment(EnvironmentOptions(variant).describe(game), observation)
        for game in games or main_games()
    ]
    from sjdsl.bench import game_task, measure
    from sjdsl.bench.loop import steps_for
    from sjdsl.bench.stored import write_found
    from sjdsl.bench.tables import notes_of_speeds, speed_tables

    tasks = [game_task(env, f"{env.name}+{variant}" if variant else env.name) for env in made]
    with stages("compiling") as tell:
        found = measure(tasks, envs, repeats, lambda number: steps or steps_for(number), tell)
    if json_file:
        write_found(Path(json_file), found)
    print_tables(speed_tables(found), found.machine, notes_of_speeds(found))


def disable_compilation_cache() -> None:
    """Stops JAX from storing and finding compiled programs, because seconds of compiling are measured too."""
    import jax
    from jax.experimental.compilation_cache import compilation_cache

    jax.config.update("jax_enable_compilation_cache", False)
    compilation_cache.reset_cache()  # JAX decides at the first program of a process, which an import may make


def print_tables(tables: "Sequence[Table]", machine: dict[str, Any], notes: Sequence[str]) -> None:
    """Prints the tables (at full width unless on a terminal), then the notes and the machine."""
    from sjdsl.bench.machine import machine_line

    console = Console()
    console = console if console.is_terminal else Console(width=200)
    for table in tables:
        shown = RichTable(box=box.SIMPLE, title_justify="left", title=table.title)
        for index, heading in enumerate(table.headings):
            shown.add_column(
                heading, justify="left" if index < table.labels else "right", no_wrap=index == 0
            )
        for row in table.rows:
            shown.add_row(*row)
        console.print(shown)
    for line in (*notes, machine_line(machine)):
        console.print(line, highlight=False, markup=False)
