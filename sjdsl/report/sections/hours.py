"""Hours of training to 1e9 environment steps, extrapolated from the speed of single updates."""

from typing import Any

from sjdsl.bench.tables import thousands
from sjdsl.report import published
from sjdsl.report.contents import Contents, called
from sjdsl.report.evidence import UpdateRow
from sjdsl.report.figure_text import bounded, number
from sjdsl.report.page import Section, Table
from sjdsl.report.ways import APART, NAMES, SHARED

STEPS = 1_000_000_000
SECONDS = 3600  # of an hour
# What the command for missing rows measures: action values are added up over agents, which share them.
WAYS = (("ippo", SHARED), ("ippo", APART), ("mappo", SHARED), ("mappo", APART), ("vdn", SHARED))


def hours(contents: Contents) -> Section:
    """Returns the section of training speed by algorithm."""
    found = contents.evidence.updates
    rows = tuple(_row(row) for name in contents.names for row in found if row.game == name)
    headings = (
        *("game", "algorithm", "network", "parameters", "env-steps/s", "hours to 1e9 steps, extrapolated", "published"),
        "environments x steps, rounds, hardware",
    )
    text = (
        "Hours are extrapolated: 1e9 environment steps at the speed of the updates that were timed, without evaluation and "
        "checkpoints. In brackets at the fastest and at the slowest round.",
        f"Published: {published.source('training')}.",
    )
    table = Table("hours", "Hours of training", headings, rows, tuple(_record(row) for row in found), 4)
    there = {(row.game, row.algorithm, row.sharing) for row in found}
    missing = [name for name in contents.plain_names if not {(name, *way) for way in WAYS} <= there]
    fill = [
        f"sjdsl bench {called(missing)} --training mlp --algorithm ippo,mappo,vdn --sharing shared,per_agent --hours 1e9 "
        "--json runs/training.json"
    ]
    return Section("Hours of training", text, (table,) if rows else (), fill=tuple(fill if missing else ()))


def _hours(rate: float) -> float:
    return STEPS / rate / SECONDS


def _row(row: UpdateRow) -> tuple[str, ...]:
    printed = published.hours(row.game)
    before = [f"{name} {number(needed)}" for name, needed in published.melting_pot_hours(row.game).items()]
    said = "" if printed is None else ", ".join([f"{number(printed)}", *before])
    shape = f"{row.num_envs} x {row.num_steps}, {row.rounds} round{'s' * (row.rounds != 1)}, {row.hardware}"
    rates = f"{thousands(row.rate)} [{thousands(row.slowest)}, {thousands(row.fastest)}]"
    needed = bounded(_hours(row.rate), _hours(row.fastest), _hours(row.slowest))
    way = (row.game, NAMES.get(row.algorithm, row.algorithm), row.network, row.sharing.replace("_", " "))
    return (*way, rates, needed, said, shape)


def _record(row: UpdateRow) -> dict[str, Any]:
    extrapolated = {"hours": _hours(row.rate), "hours_shortest": _hours(row.fastest), "hours_longest": _hours(row.slowest)}
    return {**vars(row), **extrapolated, "extrapolated": True, "published_hours": published.hours(row.game)}
