"""Evidence: all that a report is made of, as rows of a few tables, whatever folder they were read from.

    folders --read_folders--> Evidence --sections--> tables and figures --markdown--> report.md

The tables are kept as CSV beside every report, so that it can be made again without the runs, and so that later results are only more rows.
"""

import json
from collections.abc import Iterable, Mapping, Set
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Annotated, Any, Literal

from pydantic import AfterValidator

DIGITS = 6  # significant ones that are kept of a figure


def _settings(text: str) -> str:
    """Returns a text that is a JSON object. Raises ValueError where it is none."""
    if not isinstance(json.loads(text), dict):
        raise ValueError("it must be a JSON object")
    return text


Settings = Annotated[str, AfterValidator(_settings)]
Status = Literal["done", "failed", "unfinished"]


def rounded(value: float) -> float:
    """Returns a figure with as many digits as are kept."""
    return float(f"{value:.{DIGITS}g}")


@dataclass(frozen=True)
class Run:
    """A way of training in a game: all that a run depends on but its seed. Seeds of the same way, from whatever folders, are one run."""

    run: str  # its name: game, algorithm, reward, and a digest of everything
    game: str
    hash: str  # of the rules
    variant: str
    num_agents: int
    params: str  # numbers of the game that were asked for, as `a=1 b=2`
    map: str
    algorithm: str
    reward: str
    sharing: str
    exchange_ratio: float | None  # None where the reward is not exchanged
    svo_weight: float | None  # None where the reward is not svo
    svo_angle: float | None  # degrees; None, too, where agents differ in it
    stage: int | None  # of a sweep of svo: 1 weights, 2 angles at the weight that was chosen, with fresh seeds
    network: str
    steps: int  # environment steps that were asked for
    settings: Settings  # what else of the configuration is not its default, as a JSON object


@dataclass(frozen=True)
class Seed:
    """A seed of a run, and what its last policy earned."""

    run: str
    seed: int
    status: Status
    steps: int  # environment steps it learnt from
    hardware: str
    episodes: int  # that its last policy was evaluated in; 0: it was not
    collective_return: float | None  # mean over the episodes; None where it was not evaluated


@dataclass(frozen=True)
class Measure:
    """A figure of the evaluation of a seed, besides its return: the mean over its episodes."""

    run: str
    seed: int
    measure: str  # its name in an evaluation: `event eaten`, `mean apples_left`
    value: float


@dataclass(frozen=True)
class Point:
    """A point of the learning curve of a seed: the collective return of the episodes that ended about then."""

    run: str
    seed: int
    env_steps: int
    collective_return: float


@dataclass(frozen=True)
class DiagramRow:
    """A Schelling diagram: its contrasts with the bounds that hold at 95 % together, and its verdict."""

    game: str
    hash: str
    params: str  # numbers that a bundled game has otherwise
    num_agents: int
    cooperators: str
    defectors: str
    unit: str  # `training seed` or `episode`
    units: int
    episodes: int
    outcome: str
    fear: bool
    greed: bool
    reason: str
    caution: str  # what is to be said of a verdict on samples without spread
    A: float
    A_low: float | None
    A_high: float | None
    B: float
    B_low: float | None
    B_high: float | None
    fear_mean: float
    fear_low: float | None
    fear_high: float | None
    greed_mean: float
    greed_low: float | None
    greed_high: float | None


@dataclass(frozen=True)
class SpeedRow:
    """Environment steps a second of random play: the median of the rounds, the slowest and the fastest."""

    game: str
    num_agents: int
    crowd: bool  # another number of agents than the game's own
    observation: str
    num_envs: int
    rate: float
    slowest: float
    fastest: float
    rounds: int
    hardware: str


@dataclass(frozen=True)
class UpdateRow:
    """Environment steps a second of training: the median of the rounds, the slowest and the fastest."""

    game: str
    num_agents: int
    algorithm: str
    sharing: str
    network: str
    num_envs: int
    num_steps: int
    rate: float
    slowest: float
    fastest: float
    rounds: int
    hardware: str


@dataclass(frozen=True)
class RandomRow:
    """The collective return of a random policy, with its 95 % interval over episodes."""

    game: str
    hash: str
    mean: float
    low: float | None
    high: float | None
    episodes: int


@dataclass(frozen=True)
class Meeting:
    """What an agent of a policy earned in a mixture, with its 95 % interval."""

    game: str
    hash: str
    params: str  # numbers that a bundled game has otherwise
    num_agents: int
    mixture: str
    policy: str
    mean: float
    low: float | None
    high: float | None
    unit: str  # what the interval is over: `training seed` or `episode`
    units: int
    episodes: int  # of all seeds together


@dataclass(frozen=True)
class Evidence:
    """All that a report is made of; `notes` are what its readers must know of how it was read, a sentence each."""

    runs: tuple[Run, ...] = ()
    seeds: tuple[Seed, ...] = ()
    measures: tuple[Measure, ...] = ()
    curves: tuple[Point, ...] = ()
    diagrams: tuple[DiagramRow, ...] = ()
    speeds: tuple[SpeedRow, ...] = ()
    updates: tuple[UpdateRow, ...] = ()
    random: tuple[RandomRow, ...] = ()
    meetings: tuple[Meeting, ...] = ()
    notes: tuple[str, ...] = ()

    def rows(self) -> dict[str, tuple[Any, ...]]:
        """Returns the rows of each table by its name."""
        return {name: getattr(self, name) for name in ROW_TYPES}


ROW_TYPES: Mapping[str, type] = {
    "runs": Run,
    "seeds": Seed,
    "measures": Measure,
    "curves": Point,
    "diagrams": DiagramRow,
    "speeds": SpeedRow,
    "updates": UpdateRow,
    "random": RandomRow,
    "meetings": Meeting,
}
# What makes two rows say the same thing: the fields before the first that is a finding.
FINDINGS: Mapping[str, str] = {
    "runs": "game",
    "seeds": "status",
    "measures": "value",
    "curves": "collective_return",
    "diagrams": "unit",
    "speeds": "rate",
    "updates": "rate",
    "random": "mean",
    "meetings": "mean",
}

SINGULAR: Mapping[str, str] = {
    "runs": "run",
    "diagrams": "the diagram",
    "speeds": "the speed",
    "updates": "the training speed",
    "random": "the random policy",
    "meetings": "the mixture",
}


def key_of(table: str, row: Any) -> tuple[Any, ...]:
    """Returns what a row is about: two rows with the same key are the same thing found twice. Hardware is part of a speed."""
    names = [entry.name for entry in fields(row)]
    key = [*names[: names.index(FINDINGS[table])], *(("hardware",) if table in ("speeds", "updates") else ())]
    return tuple(getattr(row, name) for name in key)


def merged(parts: Iterable[Evidence]) -> Evidence:
    """Returns several evidences as one. What is found twice is taken from the later one, with a note where they differ.

    A seed comes with its measures and its curve; one that is done is never replaced by one that is not.
    """
    whole = Evidence()
    for part in parts:
        whole = _joined(whole, part)
    ordered = {name: tuple(sorted(rows, key=partial(key_of, name))) for name, rows in whole.rows().items()}
    return replace(whole, notes=tuple(dict.fromkeys(whole.notes)), **ordered)


def _joined(before: Evidence, after: Evidence) -> Evidence:
    done = {(row.run, row.seed) for row in before.seeds if row.status == "done"}
    after = _without(after, done & {(row.run, row.seed) for row in after.seeds if row.status != "done"})
    again = {(row.run, row.seed) for row in after.seeds}
    told = [f"seed {row.seed} of {row.run}" for row in before.seeds if (row.run, row.seed) in done & again and row not in after.seeds]
    before = _without(before, again)
    joined: dict[str, tuple[Any, ...]] = {}
    for name, rows in before.rows().items():
        found = {key_of(name, row): row for row in rows}
        for row in getattr(after, name):
            if found.setdefault(key_of(name, row), row) != row:
                told.append(f"{SINGULAR[name]} {', '.join(str(part) for part in key_of(name, row))}")
            found[key_of(name, row)] = row
        joined[name] = tuple(found.values())
    notes = [f"{what} was found twice, with different figures: those of the folder named later are shown" for what in told]
    return Evidence(**joined, notes=(*before.notes, *after.notes, *notes))


def _without(evidence: Evidence, seeds: Set[tuple[str, int]]) -> Evidence:
    """Returns the evidence without some seeds of runs, their measures and their curves."""
    tables = ("seeds", "measures", "curves")
    left = {name: tuple(row for row in getattr(evidence, name) if (row.run, row.seed) not in seeds) for name in tables}
    return replace(evidence, **left)
