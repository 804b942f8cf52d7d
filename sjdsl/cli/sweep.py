"""`sjdsl sweep`: trains all cells of a grid, and resumes where it was stopped."""

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.environment_options import EnvironmentOptions, environment_options
from sjdsl.cli.run_options import RunOptions, check_policies, run_options
from sjdsl.cli.stages import LOADING, stages
from sjdsl.compiler import ir
from sjdsl.compiler.ir.hash import game_hash
from sjdsl.sweeps.axes import read_axis
from sjdsl.sweeps.cells import Cell, SweepSpec
from sjdsl.sweeps.plan import plan_sweep
from sjdsl.trainers.runs.run_errors import DiskError

if TYPE_CHECKING:
    from sjdsl.sweeps.cells import Describe
    from sjdsl.sweeps.running import Outcome


@click.command("sweep")
@click.argument("games", nargs=-1, required=True, metavar="GAME...")
@click.option(
    "--axis",
    "axes",
    multiple=True,
    metavar="NAME=v,v,...",
    help="What varies: a setting, own.X, variant or param.X.",
)
@click.option("--run", "run_dir", required=True, metavar="DIR", help="Folder of the sweep.")
@run_options(seeds=3)
@click.option(
    "--episodes",
    type=click.IntRange(min=1),
    metavar="N",
    default=30,
    show_default=True,
    help="Episodes of each evaluation.",
)
@click.option(
    "--workers",
    type=click.IntRange(min=1),
    metavar="K",
    default=1,
    show_default=True,
    help="Processes at a time, each with a GPU if there are any.",
)
@click.option("--retry", "again", is_flag=True, help="Try failed cells again.")
@click.option("--dry-run", is_flag=True, help="List the cells and their progress, and stop.")
@environment_options
def command(
    games: tuple[str, ...],
    axes: tuple[str, ...],
    run_dir: str,
    run: RunOptions,
    episodes: int,
    workers: int,
    again: bool,
    dry_run: bool,
    options: EnvironmentOptions,
) -> int:
    """Trains every cell of a sweep in GAMEs. Each combination of the values of all axes is a cell, with K seeds.

    The folder gets sweep.json, a run in cells/NAME for each cell, and results.csv. The same command resumes a stopped sweep; a
    new value or axis adds cells. Several processes can work on one folder: docs/sweeps.md.
    """
    listed = [read_axis(text) for text in axes]
    of_game = options.variant, options.params
    spec = SweepSpec(
        games,
        listed,
        run.settings,
        run.preset,
        *of_game,
        episodes,
        run.loggers,
        options.map,
        options.num_agents,
    )
    read: dict[str, ir.Game] = {}
    describe = _describer(read)
    cells = plan_sweep(spec, describe)  # what doesn't fit is refused before JAX loads
    for cell in cells:
        for stage in cell.stages:
            check_policies(stage.configuration(), read[stage.hash])
    folder = Path(run_dir)
    with stages(LOADING):
        from sjdsl.sweeps.gpus import gpus_for_workers
        from sjdsl.sweeps.running import check_sweep, sweep
        from sjdsl.sweeps.work import Watch

    if dry_run:
        gpus_for_workers(workers)  # as in the sweep itself, a run is checked for one device
        check_sweep(spec, cells, folder.resolve())
        _list(cells, folder, episodes)
        return 0
    watch = Watch("auto", lambda line: click.echo(line, err=True))
    try:
        outcome = sweep(spec, folder, describe, workers, again, watch)
    except (KeyboardInterrupt, OSError, DiskError):
        click.echo(f"what was trained is kept in {folder}; the same command resumes it", err=True)
        raise
    return _report(outcome, folder)


def _describer(read: dict[str, ir.Game]) -> "Describe":
    """Returns a function that describes a game: the arguments of its environment, its name and its hash. It needs no JAX.

    Each game is read once, and added to `read` by its hash.
    """
    known: dict[str, tuple[str, str]] = {}

    def describe(
        game: str,
        variant: str | None,
        params: Mapping[str, Any],
        map: str | None = None,
        num_agents: int | None = None,
    ) -> tuple[dict[str, Any], str, str]:
        asked = EnvironmentOptions(variant, map, num_agents, params)
        provenance = asked.describe(game)
        key = repr(sorted(provenance.items(), key=str))
        if key not in known:
            made, _ = asked.read(game)
            known[key] = made.game.name, game_hash(made.game)
            read[known[key][1]] = made.game
        return provenance, *known[key]

    return describe


def _list(cells: Sequence[Cell], folder: Path, episodes: int) -> None:
    """Prints the cells of a plan and the progress of those in the folder."""
    from sjdsl.sweeps.folder import progress_of, steps_of

    states = [progress_of(folder, cell, episodes) for cell in cells]
    width = max(len(cell.name) for cell in cells)
    for cell, found in zip(cells, states, strict=True):
        seeds = (
            f"seeds {cell.seeds[0]} to {cell.seeds[-1]}"
            if len(cell.seeds) > 1
            else f"seed {cell.seeds[0]}"
        )
        click.echo(
            f"{cell.name:{width}}  {seeds}  {steps_of(cell):>13,} steps each  {found.summary}"
        )
    steps = sum(
        steps_of(cell) * len(cell.seeds)
        for cell, found in zip(cells, states, strict=True)
        if found.state != "done"
    )
    by_state = ", ".join(
        f"{number} {state}" for state, number in Counter(found.state for found in states).items()
    )
    click.echo(f"\n{_counted(len(cells))}: {by_state}; at most {steps:,} environment steps left")


def _counted(cells: int) -> str:
    return f"{cells} cell{'s' * (cells != 1)}"


def _report(outcome: "Outcome", folder: Path) -> int:
    """Prints the result of a sweep; returns the exit status, 1 unless every cell is done."""
    total = len(outcome.done) + len(outcome.failed) + len(outcome.stopped)
    click.echo(f"\n{len(outcome.done)} of {_counted(total)} are done")
    for name in ("sweep.json", "results.csv", "cells"):
        click.echo(f"  {folder / name}")
    for name, reason in outcome.failed.items():
        click.echo(f"failed: {name}: {reason}", err=True)
    if outcome.failed:
        click.echo("the same command with --retry tries these again", err=True)
    for name in outcome.stopped:
        click.echo(
            f"stopped: {name}: its process ended early, perhaps for lack of memory; the same command resumes it",
            err=True,
        )
    return 1 if outcome.failed or outcome.stopped else 0
