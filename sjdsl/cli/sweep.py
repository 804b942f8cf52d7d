"""`sjdsl sweep`: trains all cells of a grid, or of a protocol of the paper, and goes on where it was stopped."""

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.configuration_options import check_policies, configuration_options, log_option, read_configuration, read_texts
from sjdsl.cli.environment_options import build_game, describe_environment, environment_options, read_assignments
from sjdsl.cli.stages import LOADING, stages
from sjdsl.compiler import ir
from sjdsl.compiler.ir.hash import game_hash
from sjdsl.sweeps.axes import as_number, read_axis
from sjdsl.sweeps.plan import Asked, Plan, plan_sweep
from sjdsl.sweeps.protocols import ANGLES
from sjdsl.trainers.run_errors import DiskError

if TYPE_CHECKING:
    from sjdsl.sweeps.cells import Describe
    from sjdsl.sweeps.running import Outcome
    from sjdsl.trainers.loggers import LoggerName


@click.command("sweep")
@click.argument("games", nargs=-1, required=True, metavar="GAME...")
@click.option(
    "--axis",
    "axes",
    multiple=True,
    metavar="NAME=v,v,...",
    help="What is varied: a key of the configuration (reward, algorithm, svo_weight, sharing), own.NAME, variant, or param.NAME. Of several axes "
    "every combination is a cell.",
)
@click.option(
    "--protocol",
    metavar="P",
    help="A sweep of the paper by name: exchange (ratios 0 to 1), svo (weights, then angles), algorithms (six columns), sharing.",
)
@click.option(
    "--run", "run_dir", required=True, metavar="DIR", help="The folder of the sweep; the same command goes on with a stopped one."
)
@configuration_options
@click.option("--seeds", type=click.IntRange(min=1), default=3, show_default=True, metavar="K", help="Seeds of each cell, side by side.")
@click.option(
    "--episodes",
    type=click.IntRange(min=1),
    metavar="N",
    default=30,
    show_default=True,
    help="Episodes to evaluate the last policy of each seed.",
)
@click.option("--engine", default="local", show_default=True, metavar="E", help="Who runs the cells: local, ray or slurm.")
@click.option(
    "--workers",
    type=click.IntRange(min=1),
    metavar="K",
    help="Processes (with a share of the cores each), tasks or jobs at once.  [default: 1 process; as many tasks or jobs as fit]",
)
@click.option(
    "--engine-set",
    "engine_options",
    multiple=True,
    metavar="NAME=VALUE",
    help="An option of ray (num_gpus=0.5) or slurm (timeout_min=600, slurm_partition=gpu).",
)
@click.option(
    "--together",
    type=click.IntRange(min=1),
    metavar="K",
    help="Train up to K cells as one program, where they differ in numbers without shape.  [default: 1 on a CPU; else as many as fit]",
)
@log_option
@click.option("--retry", "again", is_flag=True, help="Try failed cells again.")
@click.option("--dry-run", is_flag=True, help="List the cells and how far they are, and stop.")
@environment_options
def command(
    games: tuple[str, ...],
    axes: tuple[str, ...],
    protocol: str | None,
    run_dir: str,
    algorithm: str | None,
    reward: str | None,
    preset: str | None,
    changes: tuple[str, ...],
    seed: int | None,
    seeds: int,
    init_from: str | None,
    partners: tuple[str, ...],
    episodes: int,
    engine: str,
    workers: int | None,
    engine_options: tuple[str, ...],
    together: int | None,
    loggers: "tuple[LoggerName, ...]",
    again: bool,
    dry_run: bool,
    variant: str | None,
    map_file: str | None,
    agents: int | None,
    params: tuple[str, ...],
) -> int:
    """Trains every cell of a sweep in GAMEs: each combination of the values of all axes, with K seeds, is a cell.

    The folder gets sweep.json, a run folder cells/NAME for each cell, results.csv with a row for each cell and seed, and status.csv.
    The same command goes on with a stopped sweep; a new value of an axis adds cells. Several processes may work on one folder.
    """
    settings = {**read_texts(changes), **read_configuration(algorithm, reward, seed, seeds, init_from, partners)}
    given = read_assignments(params)
    asked = Asked(games, [read_axis(text) for text in axes], protocol, settings, preset, variant, given, episodes, loggers)
    read: dict[str, ir.Game] = {}
    describe = _describer(map_file, agents, read)
    plan = plan_sweep(asked, describe)  # what does not fit is said before JAX is loaded
    for cell in plan.cells:
        check_policies(cell.configuration(), read[cell.hash])
    folder = Path(run_dir)
    options = {name: as_number(value) for name, value in read_texts(engine_options).items()}
    with stages(LOADING):
        from sjdsl.sweeps.engines import Crew
        from sjdsl.sweeps.running import check_sweep, sweep

    crew = Crew(engine, workers, options, "auto", lambda line: click.echo(line, err=True))
    if dry_run:
        _list(plan, folder, check_sweep(asked, plan, folder.resolve(), crew))
        return 0
    try:
        outcome = sweep(asked, folder, describe, crew, together, again)
    except (KeyboardInterrupt, OSError, DiskError):
        click.echo(f"what was trained is kept in {folder}; the same command goes on with it", err=True)
        raise
    return _report(outcome, folder)


def _describer(map_file: str | None, agents: int | None, read: dict[str, ir.Game]) -> "Describe":
    """Returns what makes the arguments of a game's environment, its name and its hash, without JAX; the same only once.

    The games that it has read are then in `read`, by their hashes.
    """
    known: dict[str, tuple[str, str]] = {}

    def describe(game: str, variant: str | None, params: Mapping[str, Any]) -> tuple[dict[str, Any], str, str]:
        provenance = describe_environment(game, variant, map_file, agents, params)
        key = repr(sorted(provenance.items(), key=str))
        if key not in known:
            made, _ = build_game(game, dict(params), variant, map_file, agents)
            known[key] = made.game.name, game_hash(made.game)
            read[known[key][1]] = made.game
        return provenance, *known[key]

    return describe


def _list(plan: Plan, folder: Path, known: Mapping[str, Any]) -> None:
    """Prints the cells of a plan, and how far those are that the folder has; `known`: what its `sweep.json` is to say."""
    from sjdsl.sweeps.folder import progress_of, steps_of
    from sjdsl.sweeps.running import following_cells

    cells = [*plan.cells]
    following = following_cells(folder, plan, known) if plan.follows else []
    cells += following or []
    states = [progress_of(folder, cell, plan.asked.episodes) for cell in cells]
    width = max(len(cell.name) for cell in cells)
    for cell, found in zip(cells, states, strict=True):
        seeds = f"seeds {cell.seeds[0]} to {cell.seeds[-1]}" if len(cell.seeds) > 1 else f"seed {cell.seeds[0]}"
        click.echo(f"{cell.name:{width}}  {seeds}  {steps_of(cell):>13,} steps each  {found.state}{_why(found.reason)}")
    steps = sum(steps_of(cell) * len(cell.seeds) for cell, found in zip(cells, states, strict=True) if found.state != "done")
    click.echo(
        f"\n{_counted(len(cells), 'cell')}: {_by_state([found.state for found in states])}; {steps:,} environment steps are left at most"
    )
    if following is None:
        groups = len({(cell.game, *(str(cell.values[axis.name]) for axis in plan.asked.axes)) for cell in plan.cells})
        click.echo(
            f"then a second stage: {_counted(groups * len(ANGLES), 'cell')} of angles, at the weight that is best in the first, with seeds of their own"
        )


def _why(reason: str) -> str:
    return f": {reason}" if reason else ""


def _by_state(states: Sequence[str]) -> str:
    return ", ".join(f"{number} {state}" for state, number in Counter(states).items())


def _counted(number: int, thing: str) -> str:
    return f"{number} {thing}{'s' * (number != 1)}"


def _report(outcome: "Outcome", folder: Path) -> int:
    """Prints what came of a sweep; returns the exit status, 1 where a cell has failed."""
    total = len(outcome.done) + len(outcome.failed) + len(outcome.stopped)
    click.echo(f"\n{len(outcome.done)} of {_counted(total, 'cell')} are done")
    for name in ("sweep.json", "results.csv", "status.csv", "cells"):
        click.echo(f"  {folder / name}")
    for name, reason in outcome.failed.items():
        click.echo(f"failed: {name}: {reason}", err=True)
    if outcome.failed:
        click.echo("the same command with --retry tries these again", err=True)
    return 1 if outcome.failed or not outcome.complete else 0
