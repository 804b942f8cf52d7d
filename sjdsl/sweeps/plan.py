"""The plan of a sweep: from games, axes and a protocol to cells, in the order in which they are run."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sjdsl.experiments.refusals import ExperimentError
from sjdsl.near_names import meant
from sjdsl.sweeps.axes import PARAM, VARIANT, Axis, check_axes
from sjdsl.sweeps.cells import Cell, Describe, Fixed, make_cell
from sjdsl.sweeps.protocols import PROTOCOLS, SETS, angles_at, points_of
from sjdsl.trainers.own_settings import OWN, spread

if TYPE_CHECKING:
    from sjdsl.trainers.loggers import LoggerName

MOST = 10_000  # cells


@dataclass(frozen=True)
class Asked:
    """What a sweep is to be."""

    games: Sequence[str]  # names, or files
    axes: Sequence[Axis] = ()
    protocol: str | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)  # of the configuration, of all cells; `seed` and `seeds` among them
    preset: str | None = None
    variant: str | None = None
    params: Mapping[str, Any] = field(default_factory=dict)
    episodes: int = 30  # of the evaluation of each seed's last policy
    loggers: "Sequence[LoggerName]" = ()  # where metrics of cells that are begun from now on go besides: tensorboard, wandb


@dataclass(frozen=True)
class Plan:
    """What is to be run."""

    asked: Asked
    describe: Describe
    cells: tuple[Cell, ...]  # of the first stage

    @property
    def follows(self) -> bool:
        """Whether there is a second stage, which depends on what comes of the first."""
        return self.asked.protocol == "svo"


def plan_sweep(asked: Asked, describe: Describe) -> Plan:
    """Returns the plan of a sweep; needs no JAX.

    Raises:
      ExperimentError: games, axes and protocol do not fit each other. What `describe` raises.
    """
    _check(asked)
    fixed = _fixed(asked, describe)
    cells = []
    for game in asked.games:
        for point in points_of(asked.protocol, Path(game).stem, asked.settings):
            for values in product(*(axis.values for axis in asked.axes)):
                chosen = {axis.name: value for axis, value in zip(asked.axes, values, strict=True)}
                cells.append(make_cell(game, point, chosen, fixed))
    _check_names(cells)
    _check_angles(cells)
    _check_settings(asked, cells)
    return Plan(asked, describe, tuple(cells))


def made_again(plan: Plan, cell: Cell) -> Cell:
    """Returns the cell that this plan would have where a sweep with the same axes and protocol has one of its first stage.

    It differs from that one where the game's file has changed since, or where other settings are asked for.

    Args:
      cell: of one of the plan's games.

    Raises:
      ExperimentError: the plan's settings or the game, as it is now, do not fit those values. What `describe` raises.
    """
    game = next(other.provenance["game"] for other in plan.cells if other.game == cell.game)
    point = next(point for point in points_of(plan.asked.protocol, Path(game).stem, plan.asked.settings) if point.place == cell.point)
    chosen = {axis.name: _of_axis(cell, axis) for axis in plan.asked.axes}
    return make_cell(game, point, chosen, _fixed(plan.asked, plan.describe))


def second_stage(plan: Plan, returns: Mapping[str, Sequence[float]]) -> list[Cell]:
    """Returns the second stage of `svo`: for each game and combination of axes the angles, at the weight that was best.

    Its seeds follow those of the first stage. The best of several noisy means is biased upwards, so that figures of the seeds
    that chose the weight would be too good for 90 degrees; seeds that had no part in the choice are not.

    Args:
      returns: cell of the first stage -> collective return of each seed. Of equal means the smallest weight is taken.
    """
    found = []
    for members in _alike(plan.cells):
        best = max(members, key=lambda cell: (_mean(returns[cell.name]), -cell.values["svo_weight"]))
        fixed = _fixed(plan.asked, plan.describe)
        game = best.provenance["game"]
        chosen = {axis.name: _of_axis(best, axis) for axis in plan.asked.axes}
        for point in angles_at(best.values["svo_weight"]):
            found.append(make_cell(game, point, chosen, fixed, first_seed=best.seeds.stop))
    _check_names(found)
    return found


def _check_angles(cells: Sequence[Cell]) -> None:
    """Raises ExperimentError where cells of SVO differ in the angle alone and their weight is 0: they would be one run."""
    known: dict[str, Cell] = {}
    for cell in cells:
        if "svo_angle" not in cell.values or cell.config.get("svo_weight") != 0:
            continue
        others = {name: value for name, value in cell.values.items() if name != "svo_angle"}
        other = known.setdefault(f"{cell.game} {others}", cell)
        if other is not cell:
            raise ExperimentError(f"{cell.name}: `svo_angle` does nothing where `svo_weight` is 0; sweep over weights above 0")


def _check_settings(asked: Asked, cells: Sequence[Cell]) -> None:
    """Raises ExperimentError for a setting of all cells that none of them reads."""
    unread = [cell.configuration().unread for cell in cells]
    for name in spread(asked.settings):
        if name.startswith(OWN) and not any(name.removeprefix(OWN) in cell.config["own"] for cell in cells):
            raise ExperimentError(f"`{name}` does nothing in any cell: no algorithm, loss, network or reward of your own takes it")
        if all(name in of_cell for of_cell in unread):
            mark = unread[0][name]
            raise ExperimentError(f"`{name}` does nothing in any cell: it is read where `{mark.setting}` is {mark.values}")


def _mean(returns: Sequence[float]) -> float:
    return sum(returns) / len(returns)


def _of_axis(cell: Cell, axis: Axis) -> Any:
    """Returns the value of a cell on an axis as `make_cell` reads it: of a list the text that it may be written as."""
    value = cell.values[axis.name]
    return ",".join(map(str, value)) if isinstance(value, list) and not axis.name.startswith(PARAM) else value


def _alike(cells: Iterable[Cell]) -> list[list[Cell]]:
    """Returns the cells that differ in the weight alone, together."""
    groups: dict[str, list[Cell]] = {}
    for cell in cells:
        others = {name: value for name, value in cell.values.items() if name != "svo_weight"}
        groups.setdefault(f"{cell.game} {others}", []).append(cell)
    return list(groups.values())


def _fixed(asked: Asked, describe: Describe) -> Fixed:
    return Fixed(asked.settings, asked.preset, asked.variant, asked.params, describe)


def _check(asked: Asked) -> None:
    """Raises ExperimentError for what can be refused before a game is read."""
    if not asked.games:
        raise ExperimentError("name the games to train in, as in `sjdsl sweep coins clean_up --axis reward=individual,common --run DIR`")
    stems = [Path(game).stem for game in asked.games]
    twice = next((stem for stem in stems if stems.count(stem) > 1), None)
    if twice:
        raise ExperimentError(f"the game `{twice}` is named twice; cells are named by their games")
    check_axes(asked.axes)
    if asked.protocol is not None and asked.protocol not in PROTOCOLS:
        raise ExperimentError(f"there is no protocol `{asked.protocol}`{meant(asked.protocol, PROTOCOLS, 'the protocols are')}")
    if asked.protocol is None and not asked.axes:
        raise ExperimentError(f"say what is varied: --axis NAME=value,value,… or --protocol {', '.join(PROTOCOLS)}")
    sets = SETS.get(asked.protocol or "", ())
    for axis in asked.axes:
        if axis.name in sets:
            raise ExperimentError(f"the protocol {asked.protocol} sets `{axis.name}` itself: leave out the axis, or the protocol")
        of_all = {*spread(asked.settings), *(f"{PARAM}{name}" for name in asked.params), *([VARIANT] if asked.variant is not None else [])}
        if axis.name in of_all:
            raise ExperimentError(f"`{axis.name}` is an axis, and is also set for all cells; say it once")
    for name in asked.settings:
        if name in sets:
            raise ExperimentError(f"the protocol {asked.protocol} sets `{name}` itself: leave it out of the other options")
    number = len(asked.games)
    for axis in asked.axes:
        number *= len(axis.values)
    if number > MOST:
        raise ExperimentError(f"these are {number:,} cells, and {MOST:,} are the most; make the axes shorter")


def _check_names(cells: Sequence[Cell]) -> None:
    """Raises ExperimentError where two cells would have one folder."""
    known: dict[str, Cell] = {}
    for cell in cells:
        other = known.setdefault(cell.name, cell)
        if other is cell:
            continue
        if other.values == cell.values:
            raise ExperimentError(f"two cells are one: {cell.name} is asked for twice; name each value of an axis once")
        raise ExperimentError(f"two cells would have one folder, {cell.name}: {dict(other.values)} and {dict(cell.values)}")
