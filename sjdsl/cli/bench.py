"""`sjdsl bench`: how fast games run, beside the yardstick in the same process."""

import json
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

import click

from sjdsl.cli.environment import describe_environment, make_environment
from sjdsl.cli.game_file import variant_option
from sjdsl.games_folder import bundled

if TYPE_CHECKING:
    from rich.console import Console

    from sjdsl.bench import Report


class Counts(click.ParamType):
    """`1,128,1024` as whole numbers."""

    name = "numbers"

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> tuple[int, ...]:
        parts = value.split(",")
        if not all(part.strip().isdigit() and int(part) > 0 for part in parts):
            self.fail(f"`{value}` is not a list of whole numbers such as 1,128,1024", param, ctx)
        return tuple(int(part) for part in parts)


@click.command("bench")
@click.argument("games", nargs=-1, metavar="[GAME...]")
@click.option("--envs", type=Counts(), default="1,128,1024,4096", show_default=True, help="Numbers of environments at once.")
@click.option("--observation", type=click.Choice(["tokens", "onehot"]), default="tokens", show_default=True)
@click.option("--repeats", type=click.IntRange(min=1), default=5, show_default=True, help="Rounds of timings.")
@click.option("--steps", type=click.IntRange(min=1), help="Steps of one timing; by default about 40,000 environment steps.")
@click.option("--json", "json_file", metavar="FILE", help="Write the figures to a file as well.")
@variant_option
def command(
    games: tuple[str, ...],
    envs: tuple[int, ...],
    observation: str,
    repeats: int,
    steps: int | None,
    json_file: str | None,
    variant: str | None,
) -> None:
    """Measures environment steps a second under random actions: all bundled games, or the GAMEs named.

    Beside each game runs the yardstick, a step of Commons Harvest written by hand. Machines drift; the ratio to the
    yardstick, taken round by round, does not.
    """
    from rich.console import Console

    from sjdsl.bench import game_task, measure
    from sjdsl.bench.loop import steps_for

    tasks = []
    for name in games or bundled():
        env = make_environment(describe_environment(name, variant, None, None, {}), observation)
        tasks.append(game_task(env, f"{env.name}+{variant}" if variant else env.name))
    status = Console(stderr=True).status("compiling") if Console(stderr=True).is_terminal else nullcontext()
    with status as shown:
        report = measure(tasks, envs, repeats, lambda n: steps or steps_for(n), shown.update if shown else lambda _: None)
    console = Console()
    print_report(report, console if console.is_terminal else Console(width=150))
    if json_file:
        Path(json_file).write_text(json.dumps(report.to_json(), indent=2) + "\n", encoding="utf-8")


def print_report(report: "Report", console: "Console") -> None:
    """Prints one row a game: for each number of environments its speed, the spread of the rounds, and the ratio."""
    from rich import box
    from rich.table import Table

    machine = report.machine
    table = Table(box=box.SIMPLE, title_justify="left", title=f"environment steps a second, {report.observation}")
    table.add_column("game", no_wrap=True)
    numbers = sorted({speed.num_envs for speed in report.speeds})
    for heading in (*(f"{n:,} envs" for n in numbers), "loop compile", "step compile", "step lines"):
        table.add_column(heading, justify="right")
    steps = {step.name: step for step in report.compilations}
    for name in dict.fromkeys(speed.name for speed in report.speeds):
        speeds = {speed.num_envs: speed for speed in report.speeds if speed.name == name}
        cells = [f"{_thousands(s.env_steps_per_s)} ±{s.spread:.0%} x{s.ratio:.2f}" for s in (speeds[n] for n in numbers)]
        cells.append(f"{max(s.loop_compile_s for s in speeds.values()):.1f} s")
        cells += [f"{steps[name].compile_s:.1f} s", f"{steps[name].stablehlo_lines:,}"] if name in steps else ["", ""]
        table.add_row(name, *cells)
    console.print(table)
    where = f"{machine['device']}, {machine['cpu_cores']} cores, JAX {machine['jax']}"
    console.print(f"{where}; median of {report.repeats} rounds, spread, ratio to the yardstick round by round")


def _thousands(rate: float) -> str:
    """Returns `9.48k` or `1,293k`: three digits say all that a timing knows."""
    return f"{rate / 1000:,.0f}k" if rate >= 100_000 else f"{rate / 1000:.3g}k"
