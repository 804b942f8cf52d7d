"""Cells of tables: what the seeds of one way of training found, chosen by what a table asks for."""

import json
import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from sjdsl.report import published
from sjdsl.report.evidence import Evidence, Point, RandomRow, Run, Seed
from sjdsl.trainers.estimates import Estimate, estimate

Row = TypeVar("Row")
Key = TypeVar("Key")


@dataclass(frozen=True)
class Cell:
    """One figure of one way of training, by its seeds. A cell of which a seed has failed has no mean: nothing is averaged without it."""

    run: Run
    values: tuple[float, ...]  # by seed
    failed: int  # seeds whose loss was not finite
    steps: int  # environment steps of a seed
    hardware: str

    @cached_property
    def estimate(self) -> Estimate | None:
        """The mean over seeds with its 95 % interval by Student's t; None where a seed has failed."""
        return None if self.failed or not self.values else estimate(np.array(self.values))

    @property
    def seeds(self) -> int:
        """How many seeds there are, failed ones included."""
        return len(self.values) + self.failed

    @property
    def origins(self) -> tuple[str, str, str]:
        """Seeds, steps and hardware, in words."""
        return f"{self.seeds} seed{'s' if self.seeds > 1 else ''}", f"{short(self.steps)} steps", shown(self.hardware)

    @property
    def origin(self) -> str:
        """The same, in one phrase."""
        return ", ".join(self.origins)


def each_once(names: Iterable[str]) -> str:
    """Returns the hardware of several seeds or cells as one phrase."""
    return " and ".join(dict.fromkeys(names))


def shown(hardware: str) -> str:
    """Returns the hardware as pages show it: some runs know of theirs no more than that it is a CPU."""
    return " and ".join("unnamed CPU" if name == "cpu" else name for name in hardware.split(" and "))


def short(number: float) -> str:
    """Returns `3M`, `300M`, `1.5M`, `20k`: a large number in three digits at most."""
    for size, letter in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if number >= size:
            return f"{number / size:.3g}{letter}"
    return f"{number:g}"


@dataclass(frozen=True)
class Setting:
    """A game as it was played: its rules, numbers, map and agents."""

    game: str
    hash: str
    variant: str
    params: str
    map: str
    num_agents: int

    @property
    def plain(self) -> bool:
        """Whether it is the game as its file has it, or a variant of it."""
        return not (self.params or self.map)


def setting_of(run: Run) -> Setting:
    """Returns the game of a run. Under the paper's rules, numbers that the released code sets for one way of training are part of them."""
    released = run.variant == published.variant(run.game) and _numbers(run.params) == published.params(run.game, run.algorithm, run.reward)
    return Setting(run.game, run.hash, run.variant, "" if released else run.params, run.map, run.num_agents)


def _numbers(params: str) -> dict[str, float] | None:
    """Returns the numbers of `a=1 b=2e-3` by name; None where a value is no number."""
    try:
        return {name: float(value) for name, value in (entry.split("=", 1) for entry in params.split())}
    except ValueError:
        return None


def settings_apart(run: Run, other: Run) -> dict[str, tuple[str, str]]:
    """Returns the settings that two ways of training do not have alike: what each has, `the default` where it is that."""
    own, theirs = (json.loads(each.settings) for each in (run, other))
    names = sorted(own.keys() | theirs.keys())
    return {name: (_said(own, name), _said(theirs, name)) for name in names if own.get(name) != theirs.get(name)}


def settings_between(what: str, cells: Mapping[str, Cell | None]) -> list[str]:
    """Returns what to say of the settings that the cells of a column, by game, or of a row, by column, do not have alike: a line for each."""
    settings = {place: json.loads(cell.run.settings) for place, cell in cells.items() if cell is not None}
    lines = []
    for name in sorted({name for own in settings.values() for name in own}):
        places: dict[str, list[str]] = defaultdict(list)
        for place, own in settings.items():
            places[_said(own, name)].append(place)
        if len(places) > 1:
            said = (f"{value} in {', '.join(named)}" for value, named in places.items())
            lines.append(f"* {what}: `{name}` is {'; '.join(said)}.")
    return lines


def _said(settings: Mapping[str, Any], name: str) -> str:
    return json.dumps(settings[name]) if name in settings else "the default"


class Index:
    """Evidence, looked up by game and run. Notes say where several ways of training compete for a cell."""

    def __init__(self, evidence: Evidence) -> None:
        self.evidence = evidence
        self.notes: dict[str, None] = {}
        self._seeds: Mapping[str, list[Seed]] = _grouped(evidence.seeds, lambda row: row.run)
        self._runs: Mapping[Setting, list[Run]] = _grouped(evidence.runs, setting_of)
        self._curves: Mapping[str, list[Point]] = _grouped(evidence.curves, lambda row: row.run)
        self._measures = {(row.run, row.seed, row.measure): row.value for row in evidence.measures}

    @property
    def settings(self) -> list[Setting]:
        """The games that were trained in."""
        return sorted(self._runs, key=lambda s: (s.game, s.variant, s.params, s.map, s.num_agents, s.hash))

    def returns(self, setting: Setting, wanted: Callable[[Run], bool]) -> Cell | None:
        """Returns the collective return of the way of training that a table wants; None where there is none."""
        return self._cell(setting, wanted, lambda row: row.collective_return)

    def measured(self, setting: Setting, wanted: Callable[[Run], bool], measure: str) -> Cell | None:
        """Returns another figure of its evaluation, likewise."""
        return self._cell(setting, wanted, lambda row: self._measures.get((row.run, row.seed, measure)))

    def runs(self, setting: Setting) -> list[Run]:
        """Returns the ways of training in a game of which a seed is done or has failed."""
        return [run for run in self._runs.get(setting, []) if any(row.status != "unfinished" for row in self._seeds.get(run.run, []))]

    def seeds(self, run: Run) -> list[Seed]:
        """Returns the seeds of a way of training, in order."""
        return sorted(self._seeds.get(run.run, []), key=lambda row: row.seed)

    def has_failed(self, run: Run) -> bool:
        """Returns whether the loss of a seed was not finite."""
        return any(row.status == "failed" for row in self.seeds(run))

    def curve(self, run: Run) -> list[Point]:
        """Returns the points of its learning curves, all seeds."""
        return self._curves.get(run.run, [])

    def random(self, game: str, rules: str) -> RandomRow | None:
        """Returns what a random policy earns in a game of these rules."""
        return next((row for row in self.evidence.random if (row.game, row.hash) == (game, rules)), None)

    def _cell(self, setting: Setting, wanted: Callable[[Run], bool], value: Callable[[Seed], float | None]) -> Cell | None:
        cells = [cell for run in self.runs(setting) if wanted(run) and (cell := self._of_run(run, value)) is not None]
        if not cells:
            return None
        best, *others = sorted(cells, key=lambda cell: (-cell.steps, -cell.seeds, cell.run.run))
        for other in others:
            apart = settings_apart(other.run, best.run)
            self.notes[
                f"`{best.run.run}` ({best.origin}) is shown in tables, not `{other.run.run}` ({other.origin}), which differs in settings"
                + (f": {', '.join(f'{name} {mine}, not {theirs}' for name, (mine, theirs) in apart.items())}" if apart else "")
            ] = None
        return best

    def _of_run(self, run: Run, value: Callable[[Seed], float | None]) -> Cell | None:
        rows = self.seeds(run)
        found = [(row, value(row)) for row in rows if row.status == "done"]
        values = tuple(figure for _, figure in found if figure is not None and math.isfinite(figure))
        failed = sum(row.status == "failed" for row in rows)
        if not values and not failed:
            return None
        counted = [row for row in rows if row.status != "unfinished"]
        return Cell(run, values, failed, max(row.steps for row in counted), each_once(row.hardware for row in counted))


def _grouped(rows: Iterable[Row], key: Callable[[Row], Key]) -> dict[Key, list[Row]]:
    groups: dict[Key, list[Row]] = defaultdict(list)
    for row in rows:
        groups[key(row)].append(row)
    return dict(groups)
