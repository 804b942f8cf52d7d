"""The cells of a sweep: each is one game and one configuration, with all its seeds, and a folder that is an ordinary run."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ConfigDict

from sjdsl.experiments.refusals import ExperimentError
from sjdsl.library.stored_hashes import current_hash
from sjdsl.several import several
from sjdsl.sweeps.axes import PARAM, VARIANT, Axis, as_configured, as_number, with_number
from sjdsl.trainers.config import FORMER, Config, make_config, require_code, stored_config
from sjdsl.trainers.config_errors import ConfigError
from sjdsl.trainers.extensions import short_name
from sjdsl.trainers.own_settings import spread
from sjdsl.trainers.preset import load_preset

if TYPE_CHECKING:
    from sjdsl.trainers.loggers import LoggerName

LONGEST = 120  # characters of a cell's name, which names its folder
UNUSUAL = re.compile(r"[^A-Za-z0-9._\-]+")

# A game's name or file, its variant and its numbers -> the arguments of `sjdsl.make`, and the name and the hash of the game.
Describe = Callable[[str, str | None, Mapping[str, Any]], tuple[dict[str, Any], str, str]]


class Cell(BaseModel):
    """One cell; all fields are JSON values. Cells of earlier versions have more fields."""

    model_config = ConfigDict(frozen=True, extra="ignore")

    name: str  # and that of its folder
    game: str  # by the name in its file
    hash: str
    provenance: Mapping[str, Any]  # the arguments of `sjdsl.make`
    config: Mapping[str, Any]
    values: Mapping[str, Any]  # what its axes set

    @property
    def seeds(self) -> range:
        """The numbers of its seeds."""
        config = self.configuration()
        return range(config.seed, config.seed + config.seeds)

    def configuration(self) -> Config:
        """Returns its configuration; nothing it names is imported. Raises ConfigError if this version doesn't know it."""
        return stored_config(self.config)

    def require_code(self) -> None:
        """Checks that the caller has allowed the code its configuration names. Raises NotAllowed."""
        require_code(self.configuration(), f"the cell {self.name} of a sweep", to_act=False)

    def described(self) -> dict[str, Any]:
        """Returns what `sweep.json` says of it."""
        return self.model_dump(exclude={"name"})

    @staticmethod
    def read(name: str, described: Mapping[str, Any]) -> "Cell":
        """Returns the cell that `described` describes; its hash becomes the one that the same rules have now.

        Raises ValidationError.
        """
        cell = Cell.model_validate({**described, "name": name})
        config = {key: value for key, value in cell.config.items() if key not in FORMER}
        return cell.model_copy(update={"config": config, "hash": current_hash(cell.hash)})


@dataclass(frozen=True)
class SweepSpec:
    """What a sweep trains. Of games, axes and loggers one may stand for itself."""

    games: Sequence[str]  # names, or files
    axes: Sequence[Axis] = ()
    settings: Mapping[str, Any] = field(default_factory=dict)  # of the configuration, of all cells; `seed` and `seeds` among them
    preset: str | None = None
    variant: str | None = None
    params: Mapping[str, Any] = field(default_factory=dict)  # numbers of the game
    episodes: int = 30  # in the evaluation of each seed's last policy
    loggers: "Sequence[LoggerName]" = ()  # where else the metrics of cells that start from now on go: tensorboard, wandb

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
    keys = {name: as_configured(value) for name, value in chosen.items() if name != VARIANT and not name.startswith(PARAM)}
    changes = {**spread(spec.settings), **keys}
    where = f"{Path(game).stem} with {', '.join(f'{name} {value}' for name, value in chosen.items())}"
    asked = {*keys}  # whether some cell reads each setting of all cells is for the plan to check
    try:
        preset = load_preset(spec.preset, changes, game, asked) if spec.preset is not None else None
        config = make_config(changes, asked=asked) if preset is None else preset.config
    except ConfigError as error:
        raise ExperimentError(f"{where}: {error}") from None
    kept = {} if preset is None else dict(preset.environment)
    params = {**kept.pop("params", {}), **spec.params}
    for name, value in chosen.items():
        if name.startswith(PARAM):
            params = with_number(params, name.removeprefix(PARAM), as_number(value))
    variant = chosen.get(VARIANT, spec.variant if spec.variant is not None else kept.get("variant"))
    try:
        provenance, own_name, digest = describe(game, variant, params)
    except ValueError as error:
        raise ExperimentError(f"{where}: {error}") from None
    provenance = provenance | {key: value for key, value in kept.items() if provenance.get(key) is None}
    described = config.model_dump(mode="json")
    listed = spread(described)
    values: dict[str, Any] = {}  # each written in one way: 0.5 for `.50`
    for name, value in chosen.items():
        known = listed.get(name, as_number(value) if name.startswith(PARAM) else value)
        values[name] = known[0] if name in listed and isinstance(known, list) and len(known) == 1 else known
    return Cell(name=name_of(own_name, values), game=own_name, hash=digest, provenance=provenance, config=described, values=values)


def name_of(game: str, values: Mapping[str, Any]) -> str:
    """Returns the name of a cell's folder: `coins_reward-exchange_exchange_ratio-0.25`."""
    parts = [f"{_in_folder_name(name.removeprefix(PARAM))}-{_in_folder_name(value)}" for name, value in values.items()]
    whole = "_".join([game, *parts])
    return whole if len(whole) <= LONGEST else f"{whole[:LONGEST]}_{sha256(whole.encode()).hexdigest()[:8]}"


def _in_folder_name(value: Any) -> str:
    value = short_name(value) if isinstance(value, str) else value
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return UNUSUAL.sub("-", text).strip("-") if not isinstance(value, int | float) else text
