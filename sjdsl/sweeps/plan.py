"""The plan of a sweep: from games and axes to cells, in the order in which they run."""

import math
from collections.abc import Sequence
from itertools import product
from pathlib import Path

from sjdsl.experiments.refusals import ExperimentError
from sjdsl.sweeps.axes import IN_GAME, PARAM
from sjdsl.sweeps.cells import Cell, Describe, SweepSpec, make_cell
from sjdsl.trainers.settings.config import KEYS_OF, only_of_others
from sjdsl.trainers.settings.own_settings import OWN, flatten_own

MAX_CELLS = 10_000


def plan_sweep(spec: SweepSpec, describe: Describe) -> tuple[Cell, ...]:
    """Returns the cells of a sweep, in the order in which they run; needs no JAX.

    Raises:
      ExperimentError: games and axes don't fit each other. What `describe` raises.
    """
    _check_axes(spec)
    names = [axis.name for axis in spec.axes]
    cells = []
    for game in spec.games:
        for values in product(*(axis.values for axis in spec.axes)):
            chosen = dict(zip(names, values, strict=True))
            cells.append(make_cell(game, chosen, spec, describe))
    _check_names(cells)
    _check_angles(cells)
    _check_settings(spec, cells)
    return tuple(cells)


def _check_angles(cells: Sequence[Cell]) -> None:
    """Raises ExperimentError if cells of SVO with weight 0 differ in their angle only: they would
    be the same run."""
    seen: set[str] = set()
    for cell in cells:
        if "svo_angle" not in cell.values or cell.config.get("svo_weight") != 0:
            continue
        others = {name: value for name, value in cell.values.items() if name != "svo_angle"}
        but_for_angle = f"{cell.game} {others}"
        if but_for_angle in seen:
            raise ExperimentError(
                f"{cell.name}: `svo_angle` has no effect while `svo_weight` is 0; "
                "sweep over weights above 0"
            )
        seen.add(but_for_angle)


def _check_settings(spec: SweepSpec, cells: Sequence[Cell]) -> None:
    """Raises ExperimentError for a setting that no cell reads."""
    configurations = [stage.configuration() for cell in cells for stage in cell.stages]
    for name in flatten_own(spec.settings):
        own_name = name.removeprefix(OWN)
        is_taken = any(own_name in dict(config.own) for config in configurations)
        if name.startswith(OWN) and not is_taken:
            raise ExperimentError(
                f"`{name}` does nothing in any cell: no algorithm, loss, network or reward of your "
                "own takes it"
            )
        with_key = [config for config in configurations if not only_of_others(name, type(config))]
        if not with_key:
            owners = " and ".join(algorithm for algorithm, keys in KEYS_OF.items() if name in keys)
            raise ExperimentError(f"`{name}` does nothing in any cell: it is a key of {owners}")
        if all(name in config.unread for config in with_key):
            condition = with_key[0].unread[name]
            raise ExperimentError(
                f"`{name}` does nothing in any cell: it is read where `{condition.setting}` is "
                f"{condition.values}"
            )


def _check_axes(spec: SweepSpec) -> None:
    """Raises ExperimentError for mistakes in games and axes that show before a game is read."""
    if not spec.games:
        raise ExperimentError(
            "name the games to train in, as in "
            "`sjdsl sweep coins clean_up --axis reward=individual,common --run DIR`"
        )
    if twice := _first_repeated([Path(game).stem for game in spec.games]):
        raise ExperimentError(f"the game `{twice}` is named twice; cells are named by their games")
    if twice := _first_repeated([axis.name for axis in spec.axes]):
        raise ExperimentError(
            f"the axis `{twice}` is given twice; name all its values at once: "
            f"--axis {twice}=value,value"
        )
    if not spec.axes:
        raise ExperimentError("say what varies: --axis NAME=value,value,…")
    fixed = {*flatten_own(spec.settings), *(f"{PARAM}{name}" for name in spec.params)}
    fixed |= {name for name in IN_GAME if getattr(spec, name) is not None}
    for axis in spec.axes:
        if not axis.values:
            raise ExperimentError(f"the axis `{axis.name}` has no values; name one or more")
        if axis.name in fixed:
            raise ExperimentError(
                f"`{axis.name}` is an axis, and is also set for all cells; do only one of the two"
            )
    number = len(spec.games) * math.prod(len(axis.values) for axis in spec.axes)
    if number > MAX_CELLS:
        raise ExperimentError(
            f"this sweep has {number:,} cells, and {MAX_CELLS:,} are the most; "
            "make the axes shorter"
        )


def _first_repeated(names: Sequence[str]) -> str | None:
    return next((name for name in names if names.count(name) > 1), None)


def _check_names(cells: Sequence[Cell]) -> None:
    """Raises ExperimentError if two cells would have the same folder."""
    first: dict[str, Cell] = {}
    for cell in cells:
        other = first.setdefault(cell.name, cell)
        if other is cell:
            continue
        if other.values == cell.values:
            raise ExperimentError(
                f"two cells are the same: {cell.name} is asked for twice; "
                "name each value of an axis once"
            )
        raise ExperimentError(
            f"two cells would have the same folder, {cell.name}: "
            f"{dict(other.values)} and {dict(cell.values)}"
        )
