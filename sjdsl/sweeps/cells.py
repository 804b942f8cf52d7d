"""The cells of a sweep: each is one game and one configuration, with all its seeds, and a folder that is an ordinary run."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ConfigDict

from sjdsl.experiments.refusals import ExperimentError
from sjdsl.several import several
from sjdsl.sweeps.axes import PARAM, VARIANT, Axis, as_configured, as_number, with_number
from sjdsl.trainers.settings.config import Config, make_config, require_code, stored_config
from sjdsl.trainers.settings.config_errors import ConfigError
from sjdsl.trainers.settings.extensions import short_name
from sjdsl.trainers.settings.own_settings import spread
from sjdsl.trainers.settings.preset import Preset, load_preset

if TYPE_CHECKING:
    from sjdsl.trainers.runs.loggers import LoggerName

LONGEST = 120  # characters of a cell's name, which names its folder
OTHERS = ("map", "num_agents")  # arguments of the environment that can't be axes
UNUSUAL = re.compile(r"[^A-Za-z0-9._\-]+")

# A game's name or file, its variant and its numbers, and, by name, `map` and `num_agents` if they are set -> the arguments of `sjdsl.make`,
# and the name and the hash of the game.
Describe = Callable[..., tuple[dict[str, Any], str, str]]


class CellStage(BaseModel):
    """A stage of a cell; all fields are JSON values."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    hash: str
    provenance: Mapping[str, Any]  # the arguments of `sjdsl.make`
    config: Mapping[str, Any]

    @property
    def steps(self) -> int:
        """Environment steps of each seed, rounded up to whole updates."""
        config = self.configuration()
        return config.num_updates * config.steps_per_update

    def configuration(self) -> Config:
        """Returns its configuration; nothing it names is imported. Raises ConfigError if this version doesn't know it."""
        return stored_config(self.config)


class Cell(CellStage):
    """One cell, and its last or only stage."""

    name: str  # and that of its folder
    game: str  # by the name in its file
    values: Mapping[str, Any]  # what its axes set
    earlier: list[CellStage] = []  # the stages before

    @property
    def stages(self) -> tuple[CellStage, ...]:
        """All its stages."""
        return (*self.earlier, self)

    @property
    def seeds(self) -> range:
        """The numbers of its seeds."""
        config = self.configuration()
        return range(config.seed, config.seed + config.seeds)

    def require_code(self) -> None:
        """Checks that the caller has allowed the code its configurations name. Raises NotAllowed."""
        for stage in self.stages:
            require_code(stage.configuration(), f"the cell {self.name} of a sweep", to_act=False)

    def described(self) -> dict[str, Any]:
        """Returns what `sweep.json` says of it."""
        return self.model_dump(exclude={"name", *(() if self.earlier else ("earlier",))})

    @staticmethod
    def read(name: str, described: Mapping[str, Any]) -> "Cell":
        """Returns the cell that `described` describes. Raises ValidationError."""
        return Cell.model_validate({**described, "name": name})


@dataclass(frozen=True)
class SweepSpec:
    """What a sweep trains. Of games, axes and loggers one may stand for itself."""

    games: Sequence[str]  # names, or files
    axes: Sequence[Axis] = ()
    settings: Mapping[str, Any] = field(
        default_factory=dict
    )  # of the configuration, of all cells; `seed` and `seeds` among them
    preset: str | None = None
    variant: str | None = None
    params: Mapping[str, Any] = field(default_factory=dict)  # numbers of the game
    episodes: int = 30  # in the evaluation of each seed's last policy
    loggers: "Sequence[LoggerName]" = ()  # where else the metrics of cells that start from now on go: tensorboard, wandb
    map: str | None = None  # a file
    num_agents: int | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "games", tuple(map(str, several(self.games))))
        object.__setattr__(self, "axes", several(self.axes))
        object.__setattr__(self, "loggers", several(self.loggers))


def make_cell(game: str, chosen: Mapping[str, Any], spec: SweepSpec, describe: Describe) -> Cell:
    """Returns the cell of a game at a point of the axes.

    Args:
      game: a name or a file.
      chosen: the value on each axis.
    Raises:
      ExperimentError: the values don't fit each other, the algorithm or the game.
    """
    keys = {
        name: as_configured(value)
        for name, value in chosen.items()
        if name != VARIANT and not name.startswith(PARAM)
    }
    changes = {**spread(spec.settings), **keys}
    where = (
        f"{Path(game).stem} with {', '.join(f'{name} {value}' for name, value in chosen.items())}"
    )
    asked = {*keys}  # whether some cell reads each setting of all cells is for the plan to check
    try:
        preset = (
            load_preset(spec.preset, changes, game, asked)
            if spec.preset is not None
            else Preset(game, {}, make_config(changes, asked=asked))
        )
        preset.refuse_of_stages([*_set_in_game(spec), *(name.partition("[")[0] for name in chosen)])
    except ConfigError as error:
        raise ExperimentError(f"{where}: {error}") from None
    stages = []
    for stage in (*preset.earlier, preset):
        try:
            provenance, own_name, digest = _describe_stage(
                game, stage.environment, chosen, spec, describe
            )
        except ValueError as error:
            raise ExperimentError(f"{where}: {error}") from None
        stages.append(
            CellStage(
                hash=digest, provenance=provenance, config=stage.config.model_dump(mode="json")
            )
        )
    *earlier, last = stages
    listed = spread(last.config)
    values: dict[str, Any] = {}  # each written in one way: 0.5 for `.50`
    for name, value in chosen.items():
        known = listed.get(name, as_number(value) if name.startswith(PARAM) else value)
        values[name] = (
            known[0] if name in listed and isinstance(known, list) and len(known) == 1 else known
        )
    return Cell(
        name=name_of(own_name, values), game=own_name, values=values, earlier=earlier, **dict(last)
    )


def _set_in_game(spec: SweepSpec) -> list[str]:
    """Returns what a sweep sets in the game of all its cells, by the names of arguments; numbers as `param.X`."""
    arguments = [name for name in (VARIANT, *OTHERS) if getattr(spec, name) is not None]
    return [*arguments, *(f"{PARAM}{name}" for name in spec.params)]


def _describe_stage(
    game: str,
    preset: Mapping[str, Any],
    chosen: Mapping[str, Any],
    spec: SweepSpec,
    describe: Describe,
) -> tuple[dict[str, Any], str, str]:
    """Returns what `describe` does of the game of a stage. preset: arguments of the environment."""
    params = {**preset.get("params", {}), **spec.params}
    for name, value in chosen.items():
        if name.startswith(PARAM):
            params = with_number(params, name.removeprefix(PARAM), as_number(value))
    arguments = {
        name: value for name in (VARIANT, *OTHERS) if (value := getattr(spec, name)) is not None
    }
    arguments = {**preset, **arguments}
    others = {name: arguments[name] for name in OTHERS if name in arguments}
    return describe(game, chosen.get(VARIANT, arguments.get(VARIANT)), params, **others)


def name_of(game: str, values: Mapping[str, Any]) -> str:
    """Returns the name of a cell's folder: `coins_reward-exchange_exchange_ratio-0.25`."""
    parts = [
        f"{_in_folder_name(name.removeprefix(PARAM))}-{_in_folder_name(value)}"
        for name, value in values.items()
    ]
    whole = "_".join([game, *parts])
    return (
        whole
        if len(whole) <= LONGEST
        else f"{whole[:LONGEST]}_{sha256(whole.encode()).hexdigest()[:8]}"
    )


def _in_folder_name(value: Any) -> str:
    value = short_name(value) if isinstance(value, str) else value
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return UNUSUAL.sub("-", text).strip("-") if not isinstance(value, int | float) else text
