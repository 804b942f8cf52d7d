"""Reads the JSON of `sjdsl bench`: speeds of random play, and of training."""

import statistics
from pathlib import Path
from typing import Any

from sjdsl.bench.loop import YARDSTICK
from sjdsl.bench.machine import devices_said
from sjdsl.bench.stored import read_found
from sjdsl.bench.timing import Report
from sjdsl.bench.training import Training
from sjdsl.files import read_json
from sjdsl.report.evidence import Evidence, SpeedRow, UpdateRow, rounded
from sjdsl.report.refusals import ReportError

SORT = "sort"  # the key by which the JSON of a benchmark is known
CROWD = "+crowd"  # behind the name of a game on the map for many agents


def is_benchmark(path: Path) -> bool:
    """Returns whether a file is the JSON of a benchmark."""
    try:
        return path.suffix == ".json" and path.is_file() and SORT in read_json(path)
    except (OSError, ValueError, TypeError):
        return False


def read_benchmark(path: Path) -> Evidence:
    """Returns the speeds in a file; other measurements are no part of a report, which a note says. Raises ReportError."""
    try:
        found = read_found(path)
    except ValueError as error:
        raise ReportError(str(error)) from None
    match found:
        case Report():
            return Evidence(speeds=_speeds(found))
        case Training():
            return Evidence(updates=_updates(found))
    return Evidence(notes=(f"`{path}` holds a measurement that no table shows ({type(found).__name__.lower()})",))


def hardware_of(machine: dict[str, Any]) -> str:
    """Returns what figures were measured on: the processor with its cores, or the accelerator."""
    cores = f", {machine['cpu_cores']} cores" if machine["platform"] == "cpu" else ""
    return f"{machine['device']}{cores}{devices_said(machine)}"


def _speeds(found: Report) -> tuple[SpeedRow, ...]:
    return tuple(
        SpeedRow(
            speed.name.removesuffix(CROWD),
            speed.num_agents,
            speed.crowd is not None,
            speed.observation,
            speed.num_envs,
            rounded(speed.env_steps_per_s),
            rounded(speed.slowest),
            rounded(speed.fastest),
            found.repeats,
            hardware_of(found.machine),
        )
        for speed in found.speeds
        if speed.name != YARDSTICK
    )


def _updates(found: Training) -> tuple[UpdateRow, ...]:
    rows = []
    for split in found.splits:
        steps, seconds = split.num_envs * split.num_steps, split.update
        rate, slowest, fastest = (rounded(steps / time) for time in (statistics.median(seconds), max(seconds), min(seconds)))
        way = (split.name, split.num_agents, split.algorithm, split.sharing, split.network, split.num_envs, split.num_steps)
        rows.append(UpdateRow(*way, rate, slowest, fastest, len(seconds), hardware_of(found.machine)))
    return tuple(rows)
