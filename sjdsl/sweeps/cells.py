"""The cells of a sweep: each is one game and one configuration with all seeds, and its folder is
that of an ordinary run."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ConfigDict

from sjdsl.experiments.refusals import ExperimentError
from sjdsl.library.tasks import ARGUMENTS as OF_TASKS
from sjdsl.library.tasks import Tasks, replaced_tasks
from sjdsl.several import several
from sjdsl.sweeps.axes import (
    IN_GAME,
    PARAM,
    VARIANT,
    Axis,
    as_argument,
    as_configured,
    as_number,
    with_number,
)
from sjdsl.trainers.settings.config import Config, make_config, require_code, stored_config
from sjdsl.trainers.settings.config_errors import ConfigError
from sjdsl.trainers.settings.extensions import short_name
from sjdsl.trainers.settings.own_settings import flatten_own
from sjdsl.trainers.settings.preset import Preset, load_preset

if TYPE_CHECKING:
    from sjdsl.trainers.runs.loggers import LoggerName

MAX_NAME = 120  # characters of a cell's name, which is that of its folder
FIXED = ("map", "num_agents")  # arguments of the environment that can't be axes
UNUSUAL = re.compile(r"[^A-Za-z0-9._\-]+")

# A game's name or file, its variant and its numbers, and, by name, other arguments of `sjdsl.make`
# if they are set -> its arguments, and the name and the hash of the game.
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
        """Returns its configuration; nothing it names is imported. Raises ConfigError if this
        version doesn't know it.
        """
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
        """Checks that the caller has allowed the code its configurations name. Raises
        NotAllowed.
        """
        for stage in self.stages:
            require_code(stage.configuration(), f"the cell {self.name} of a sweep", to_act=False)

    def described(self) -> dict[str, Any]:
        """Returns what `sweep.json` says of it."""
        return self.model_dump(exclude={"name"} if self.earlier else {"name", "earlier"})

    @staticmethod
    def read(name: str, described: Mapping[str, Any]) -> "Cell":
        """Returns the cell that `described` describes. Raises ValidationError."""
        return Cell.model_validate({**described, "name": name})


@dataclass(frozen=True)
class SweepSpec:
    """The games, axes and settings of a sweep. A single game, axis or logger needs no list."""

    games: Sequence[str]  # names, or files
    axes: Sequence[Axis] = ()
    # Settings of the configuration for all cells, with `seed` and `seeds`.
    settings: Mapping[str, Any] = field(default_factory=dict)
    preset: str | None = None
    variant: str | None = None
    params: Mapping[str, Any] = field(default_factory=dict)  # numbers of the game
    episodes: int = 30  # in the evaluation of each seed's last policy
    # Where else the metrics go, for cells that haven't begun: tensorboard, wandb.
    loggers: "Sequence[LoggerName]" = ()
    map: str | None = None  # a file
    num_agents: int | None = None
    tasks: Tasks | None = None  # these three as in `sjdsl.make`
    split: str | None = None
    problem: int | None = None

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
    point = ", ".join(f"{name} {value}" for name, value in chosen.items())
    in_words = f"{Path(game).stem} with {point}"
    keys = {
        name: as_configured(value)
        for name, value in chosen.items()
        if name not in IN_GAME and not name.startswith(PARAM)
    }
    changes = {**flatten_own(spec.settings), **keys}
    asked = set(keys)  # not the settings of all cells: the plan checks whether some cell reads them
    try:
        if spec.preset is None:
            preset = Preset(game, {}, make_config(changes, asked=asked))
        else:
            preset = load_preset(spec.preset, changes, game, asked)
        names = [name.partition("[")[0] for name in chosen]
        preset.refuse_of_stages([*_set_in_game(spec), *names])
    except ConfigError as error:
        raise ExperimentError(f"{in_words}: {error}") from None
    stages = []
    for stage in (*preset.earlier, preset):
        try:
            provenance, game_name, digest = _describe_stage(
                game, stage.environment, chosen, spec, describe
            )
        except (ValueError, TypeError) as error:
            raise ExperimentError(f"{in_words}: {error}") from None
        config = stage.config.model_dump(mode="json")
        stages.append(CellStage(hash=digest, provenance=provenance, config=config))
    *earlier, last = stages
    settings = flatten_own(last.config)
    values: dict[str, Any] = {}  # as the configuration has them: 0.5 for `.50`
    for name, value in chosen.items():
        if name in settings:
            value = settings[name]
            if isinstance(value, list) and len(value) == 1:
                (value,) = value
        elif name == "problem" or name.startswith(PARAM):
            value = as_number(value)
        values[name] = value
    return Cell(
        name=name_of(game_name, values),
        game=game_name,
        values=values,
        earlier=earlier,
        **dict(last),
    )


def _set_in_game(spec: SweepSpec) -> list[str]:
    """Returns the arguments that a sweep sets in the games of all cells; numbers as `param.X`."""
    names = [name for name in (*IN_GAME, *FIXED) if getattr(spec, name) is not None]
    names += [f"{PARAM}{name}" for name in spec.params]
    return names


def _describe_stage(
    game: str,
    preset: Mapping[str, Any],
    chosen: Mapping[str, Any],
    spec: SweepSpec,
    describe: Describe,
) -> tuple[dict[str, Any], str, str]:
    """Returns the result of `describe` for the game of a stage.

    `preset` has the arguments of the environment in the preset.
    """
    params = {**preset.get("params", {}), **spec.params}
    given = {}
    for name in (*IN_GAME, *FIXED):
        if getattr(spec, name) is not None:
            given[name] = getattr(spec, name)
    for name, value in chosen.items():
        if name in IN_GAME:
            given[name] = as_argument(name, value)
        elif name.startswith(PARAM):
            params = with_number(params, name.removeprefix(PARAM), as_number(value))
    of_tasks = {name: given[name] for name in OF_TASKS if name in given}
    arguments = {**replaced_tasks(preset, of_tasks), **given}
    others = {name: arguments[name] for name in (*FIXED, *OF_TASKS) if name in arguments}
    return describe(game, arguments.get(VARIANT), params, **others)


def name_of(game: str, values: Mapping[str, Any]) -> str:
    """Returns the name of a cell's folder: `coins_reward-exchange_exchange_ratio-0.25`."""
    parts = [
        f"{_in_folder_name(name.removeprefix(PARAM))}-{_in_folder_name(value)}"
        for name, value in values.items()
    ]
    name = "_".join([game, *parts])
    if len(name) <= MAX_NAME:
        return name
    return f"{name[:MAX_NAME]}_{sha256(name.encode()).hexdigest()[:8]}"


def _in_folder_name(value: Any) -> str:
    """Returns a value as text without characters that are unusual in names of folders."""
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, int):
        return str(value)
    text = short_name(value) if isinstance(value, str) else str(value)
    return UNUSUAL.sub("-", text).strip("-")
