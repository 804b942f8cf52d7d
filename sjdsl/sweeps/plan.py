"""The plan of a sweep: from games, axes and a protocol to cells, in the order in which they run."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

from sjdsl.experiments.refusals import ExperimentError
from sjdsl.near_names import meant
from sjdsl.sweeps.axes import PARAM, VARIANT, Axis
from sjdsl.sweeps.cells import Cell, Describe, SweepSpec, make_cell
from sjdsl.sweeps.protocols import PROTOCOLS, SETS, angles_at, points_of
from sjdsl.trainers.own_settings import OWN, spread

MOST = 10_000  # cells


@dataclass(frozen=True)
class Plan:
    """What to run."""

    spec: SweepSpec
    describe: Describe
    cells: tuple[Cell, ...]  # of the first stage

    @property
    def has_second_stage(self) -> bool:
        """Whether there is a second stage, which depends on the results of the first."""
        return self.spec.protocol == "svo"


def plan_sweep(spec: SweepSpec, describe: Describe) -> Plan:
    """Returns the plan of a sweep; needs no JAX.

    Raises:
      ExperimentError: games, axes and protocol don't fit each other. What `describe` raises.
    """
    _check(spec)
    cells = []
    for game in spec.games:
        for point in points_of(spec.protocol, Path(game).stem, spec.settings):
            for values in product(*(axis.values for axis in spec.axes)):
                chosen = {axis.name: value for axis, value in zip(spec.axes, values, strict=True)}
                cells.append(make_cell(game, point, chosen, spec, describe))
    _check_names(cells)
    _check_angles(cells)
    _check_settings(spec, cells)
    return Plan(spec, describe, tuple(cells))


def second_stage(plan: Plan, returns: Mapping[str, Sequence[float]]) -> list[Cell]:
    """Returns the second stage of `svo`: for each game and combination of axes, the angles at the weight that was best.

    Its seeds follow those of the first stage. The best of several noisy means is biased upwards, so the seeds that chose the weight would
    make 90 degrees look too good; seeds that had no part in the choice don't.

    Args:
      returns: cell of the first stage -> collective return of each seed. Of equal means, the smallest weight is taken.
    """
    groups: dict[str, list[Cell]] = {}
    for cell in plan.cells:
        others = {name: value for name, value in cell.values.items() if name != "svo_weight"}
        groups.setdefault(f"{cell.game} {others}", []).append(cell)
    found = []
    for cells in groups.values():
        best = max(cells, key=lambda cell: (sum(returns[cell.name]) / len(returns[cell.name]), -cell.values["svo_weight"]))
        for point in angles_at(best.values["svo_weight"]):
            chosen = _axis_values(best, plan.spec.axes)
            found.append(make_cell(best.provenance["game"], point, chosen, plan.spec, plan.describe, first_seed=best.seeds.stop))
    _check_names(found)
    return found


def _axis_values(cell: Cell, axes: Iterable[Axis]) -> dict[str, Any]:
    """Returns a cell's value on each axis as `make_cell` reads it: a list as the text it may be written as."""
    values = {axis.name: cell.values[axis.name] for axis in axes}
    return {
        name: ",".join(map(str, value)) if isinstance(value, list) and not name.startswith(PARAM) else value
        for name, value in values.items()
    }


def _check_angles(cells: Sequence[Cell]) -> None:
    """Raises ExperimentError if cells of SVO with weight 0 differ in their angle alone: they would be the same run."""
    known: dict[str, Cell] = {}
    for cell in cells:
        if "svo_angle" not in cell.values or cell.config.get("svo_weight") != 0:
            continue
        others = {name: value for name, value in cell.values.items() if name != "svo_angle"}
        if known.setdefault(f"{cell.game} {others}", cell) is not cell:
            raise ExperimentError(f"{cell.name}: `svo_angle` has no effect while `svo_weight` is 0; sweep over weights above 0")


def _check_settings(spec: SweepSpec, cells: Sequence[Cell]) -> None:
    """Raises ExperimentError for a setting that no cell reads."""
    unread = [cell.configuration().unread for cell in cells]
    for name in spread(spec.settings):
        if name.startswith(OWN) and not any(name.removeprefix(OWN) in cell.config["own"] for cell in cells):
            raise ExperimentError(f"`{name}` does nothing in any cell: no algorithm, loss, network or reward of your own takes it")
        if all(name in of_cell for of_cell in unread):
            mark = unread[0][name]
            raise ExperimentError(f"`{name}` does nothing in any cell: it is read where `{mark.setting}` is {mark.values}")


def _check(spec: SweepSpec) -> None:
    """Raises ExperimentError for what can be refused before a game is read."""
    if not spec.games:
        raise ExperimentError("name the games to train in, as in `sjdsl sweep coins clean_up --axis reward=individual,common --run DIR`")
    if twice := _first_repeated([Path(game).stem for game in spec.games]):
        raise ExperimentError(f"the game `{twice}` is named twice; cells are named by their games")
    if twice := _first_repeated([axis.name for axis in spec.axes]):
        raise ExperimentError(f"the axis `{twice}` is given twice; name all its values at once: --axis {twice}=value,value")
    if spec.protocol is not None and spec.protocol not in PROTOCOLS:
        raise ExperimentError(f"there is no protocol `{spec.protocol}`{meant(spec.protocol, PROTOCOLS, 'the protocols are')}")
    if spec.protocol is None and not spec.axes:
        raise ExperimentError(f"say what varies: --axis NAME=value,value,… or --protocol {', '.join(PROTOCOLS)}")
    sets = SETS.get(spec.protocol or "", ())
    fixed = {*spread(spec.settings), *(f"{PARAM}{name}" for name in spec.params), *([VARIANT] if spec.variant is not None else [])}
    for axis in spec.axes:
        if axis.name in sets:
            raise ExperimentError(f"the protocol {spec.protocol} sets `{axis.name}` itself: leave out the axis, or the protocol")
        if axis.name in fixed:
            raise ExperimentError(f"`{axis.name}` is an axis, and is also set for all cells; do only one of the two")
    for name in spec.settings:
        if name in sets:
            raise ExperimentError(f"the protocol {spec.protocol} sets `{name}` itself: leave it out of the other options")
    number = len(spec.games) * math.prod(len(axis.values) for axis in spec.axes)
    if number > MOST:
        raise ExperimentError(f"this sweep has {number:,} cells, and {MOST:,} are the most; make the axes shorter")


def _first_repeated(names: Sequence[str]) -> str | None:
    return next((name for name in names if names.count(name) > 1), None)


def _check_names(cells: Sequence[Cell]) -> None:
    """Raises ExperimentError if two cells would have the same folder."""
    known: dict[str, Cell] = {}
    for cell in cells:
        other = known.setdefault(cell.name, cell)
        if other is cell:
            continue
        if other.values == cell.values:
            raise ExperimentError(f"two cells are the same: {cell.name} is asked for twice; name each value of an axis once")
        raise ExperimentError(f"two cells would have the same folder, {cell.name}: {dict(other.values)} and {dict(cell.values)}")
