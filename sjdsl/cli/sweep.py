"""`sjdsl sweep`: trains all cells of a grid, and resumes where it was stopped."""

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.environment_options import EnvironmentOptions, environment_options
from sjdsl.cli.episode_options import episodes_option
from sjdsl.cli.run_options import RunOptions, check_policies, run_options
from sjdsl.cli.stages import LOADING, stages
from sjdsl.compiler import ir
from sjdsl.compiler.ir.hash import game_hash
from sjdsl.sweeps.axes import read_axis
from sjdsl.sweeps.cells import Cell, SweepSpec
from sjdsl.sweeps.plan import plan_sweep
from sjdsl.trainers.runs.run_errors import DiskError

if TYPE_CHECKING:
    from sjdsl.sweeps.running import Outcome


@click.command("sweep")
@click.argument("games", nargs=-1, required=True, metavar="GAME...")
@click.option(
    "--axis",
    "axes",
    multiple=True,
    metavar="NAME=v,v,...",
    help="What varies: a setting, own.X, param.X, variant, tasks, split or problem.",
)
@click.option("--run", "run_dir", required=True, metavar="DIR", help="Folder of the sweep.")
@run_options(seeds=3)
@episodes_option(30, "Episodes of each evaluation.")
@click.option(
    "--workers",
    type=click.IntRange(min=1),
    metavar="K",
    default=1,
    show_default=True,
    help="Processes at a time, each with a GPU if there are any.",
)
@click.option("--retry", is_flag=True, help="Try failed cells again.")
@click.option("--dry-run", is_flag=True, help="List the cells and their progress, and stop.")
@environment_options
def command(
    games: tuple[str, ...],
    axes: tuple[str, ...],
    run_dir: str,
    run: RunOptions,
    episodes: int,
    workers: int,
    retry: bool,
    dry_run: bool,
    options: EnvironmentOptions,
) -> int:
    """Trains every cell of a sweep in GAMEs. Each combination of the values of all axes is a cell,
    with K seeds.

    The folder gets sweep.json, a run in cells/NAME for each cell, and results.csv. The same command
    resumes a stopped sweep; a new value or axis adds cells. Several processes can work on one
    folder: docs/sweeps.md.
    """
    spec = SweepSpec(
        games=games,
        axes=[read_axis(text) for text in axes],
        settings=run.settings,
        preset=run.preset,
        variant=options.variant,
        params=options.params,
        episodes=episodes,
        loggers=run.loggers,
        map=options.map,
        num_agents=options.num_agents,
        **options.of_tasks,
    )
    describe = GameReader()
    cells = plan_sweep(spec, describe)  # settings that don't fit are refused before JAX loads
    for cell in cells:
        for stage in cell.stages:
            check_policies(stage.configuration(), describe.games[stage.hash])
    folder = Path(run_dir)
    with stages(LOADING):
        from sjdsl.sweeps.gpus import gpus_for_workers
        from sjdsl.sweeps.running import check_sweep, sweep
        from sjdsl.sweeps.work import Watch

    if dry_run:
        gpus_for_workers(workers)  # each run is checked for one device, as in the sweep itself
        check_sweep(spec, cells, folder.resolve())
        _list_cells(cells, folder, episodes)
        return 0
    watch = Watch("auto", lambda line: click.echo(line, err=True))
    try:
        outcome = sweep(spec, folder, describe, workers, retry, watch)
    except (KeyboardInterrupt, OSError, DiskError):
        click.echo(f"what was trained is kept in {folder}; the same command resumes it", err=True)
        raise
    return _report(outcome, folder)


class GameReader:
    """Describes the games of a sweep, as `plan_sweep` asks for; reads each once, without JAX.

    `games` has those read so far, by their hashes.
    """

    def __init__(self) -> None:
        self.games: dict[str, ir.Game] = {}
        self._hashes: dict[str, str] = {}  # by the arguments of the environment

    def __call__(
        self,
        game: str,
        variant: str | None,
        params: Mapping[str, Any],
        map: str | None = None,
        num_agents: int | None = None,
        **of_tasks: Any,
    ) -> tuple[dict[str, Any], str, str]:
        """Returns the arguments of a game's environment, its name and its hash."""
        options = EnvironmentOptions(variant, map, num_agents, params, **of_tasks)
        arguments = options.describe(game)
        key = repr(sorted(arguments.items(), key=str))
        if key not in self._hashes:
            built, _ = options.read(game)
            hash_ = game_hash(built.game)
            self._hashes[key] = hash_
            self.games[hash_] = built.game
        hash_ = self._hashes[key]
        return arguments, self.games[hash_].name, hash_


def _list_cells(cells: Sequence[Cell], folder: Path, episodes: int) -> None:
    """Prints the cells of a plan and the progress of those in the folder."""
    from sjdsl.sweeps.folder import progress_of, steps_of

    width = max(len(cell.name) for cell in cells)
    states: Counter[str] = Counter()
    steps_left = 0
    for cell in cells:
        first = cell.seeds[0]
        last = cell.seeds[-1]
        seeds = f"seed {first}" if first == last else f"seeds {first} to {last}"
        progress = progress_of(folder, cell, episodes)
        steps = steps_of(cell)
        click.echo(f"{cell.name:{width}}  {seeds}  {steps:>13,} steps each  {progress.summary}")
        states[progress.state] += 1
        if progress.state != "done":
            steps_left += steps * len(cell.seeds)
    by_state = ", ".join(f"{number} {state}" for state, number in states.items())
    click.echo(
        f"\n{_count_text(len(cells))}: {by_state}; at most {steps_left:,} environment steps left"
    )


def _count_text(cells: int) -> str:
    return "1 cell" if cells == 1 else f"{cells} cells"


def _report(outcome: "Outcome", folder: Path) -> int:
    """Prints the result of a sweep; returns the exit status, 1 unless every cell is done."""
    total = len(outcome.done) + len(outcome.failed) + len(outcome.stopped)
    click.echo(f"\n{len(outcome.done)} of {_count_text(total)} are done")
    for name in ("sweep.json", "results.csv", "cells"):
        click.echo(f"  {folder / name}")
    for name, reason in outcome.failed.items():
        click.echo(f"failed: {name}: {reason}", err=True)
    if outcome.failed:
        click.echo("the same command with --retry tries these again", err=True)
    for name in outcome.stopped:
        click.echo(
            f"stopped: {name}: its process ended early, perhaps for lack of memory; "
            "the same command resumes it",
            err=True,
        )
    return 1 if outcome.failed or outcome.stopped else 0
