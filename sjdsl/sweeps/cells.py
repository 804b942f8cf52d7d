"""The cells of a sweep: each is one game and one configuration, with all its seeds, and a folder that is an ordinary run."""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

from sjdsl.experiments.refusals import ExperimentError
from sjdsl.stored_hashes import current_hash
from sjdsl.sweeps.axes import PARAM, VARIANT, as_configured, as_number, with_number
from sjdsl.sweeps.protocols import Point
from sjdsl.trainers.config import Config, make_config, require_code, stored_config
from sjdsl.trainers.config_errors import ConfigError
from sjdsl.trainers.extensions import short_name
from sjdsl.trainers.own_settings import spread
from sjdsl.trainers.preset import load_preset

LONGEST = 120  # characters of a name, which is one of a folder
UNUSUAL = re.compile(r"[^A-Za-z0-9._\-]+")

# A game's name or file, its variant and its numbers -> the arguments of `sjdsl.make`, and the name and the hash of the game.
Describe = Callable[[str, str | None, Mapping[str, Any]], tuple[dict[str, Any], str, str]]


@dataclass(frozen=True)
class Cell:
    """One cell; all fields are JSON values."""

    name: str  # of its folder
    game: str  # by the name in its file
    hash: str
    provenance: Mapping[str, Any]  # the arguments of `sjdsl.make`
    config: Mapping[str, Any]
    values: Mapping[str, Any]  # what its axes and its protocol set
    stage: int
    point: Any  # its place in the protocol; None without one

    @property
    def seeds(self) -> range:
        """The numbers of its seeds."""
        config = self.configuration()
        return range(config.seed, config.seed + config.seeds)

    def configuration(self) -> Config:
        """Returns its configuration; nothing that it names is imported. Raises ConfigError where this version knows no such one."""
        return stored_config(self.config)

    def require_code(self) -> None:
        """Checks that the caller has named the code of its configuration. Raises NotAllowed."""
        require_code(self.configuration(), f"the cell {self.name} of a sweep", to_act=False)

    def described(self) -> dict[str, Any]:
        """Returns what `sweep.json` says of it."""
        return {key: value for key, value in asdict(self).items() if key != "name"}

    @staticmethod
    def read(name: str, described: Mapping[str, Any]) -> "Cell":
        """Returns the cell that `described` said, with the hash that its game has now."""
        return Cell(name=name, **{**described, "hash": current_hash(described["hash"])})


@dataclass(frozen=True)
class Fixed:
    """What all cells of a sweep have."""

    settings: Mapping[str, Any]  # of the configuration
    preset: str | None
    variant: str | None
    params: Mapping[str, Any]  # numbers of the game
    describe: Describe


def make_cell(game: str, point: Point, chosen: Mapping[str, Any], fixed: Fixed, first_seed: int | None = None) -> Cell:
    """Returns the cell of a game at a point of the protocol and of the axes.

    Args:
      game: a name or a file.
      chosen: the value on each axis.
      first_seed: instead of that of the settings.
    Raises:
      ExperimentError: the values do not fit each other, the algorithm or the game.
    """
    keys = {name: as_configured(value) for name, value in chosen.items() if name != VARIANT and not name.startswith(PARAM)}
    changes = {**spread(fixed.settings), **keys, **point.values} | ({} if first_seed is None else {"seed": first_seed})
    where = f"{Path(game).stem} with {', '.join(f'{name} {value}' for name, value in {**point.values, **chosen}.items()) or 'no axis'}"
    asked = {*keys, *point.values}  # settings of all cells are those of some: which ones, the plan looks at
    try:
        preset = load_preset(fixed.preset, changes, game, asked) if fixed.preset is not None else None
        config = make_config(changes, asked=asked) if preset is None else preset.config
    except ConfigError as error:
        raise ExperimentError(f"{where}: {error}{_advice(error, chosen, fixed)}") from None
    kept = {} if preset is None else dict(preset.environment)
    params = {**kept.pop("params", {}), **fixed.params}
    for name, value in chosen.items():
        if name.startswith(PARAM):
            params = with_number(params, name.removeprefix(PARAM), as_number(value))
    variant = chosen.get(VARIANT, fixed.variant if fixed.variant is not None else kept.get("variant"))
    try:
        provenance, own_name, digest = fixed.describe(game, variant, params)
    except ValueError as error:
        raise ExperimentError(f"{where}: {error}") from None
    provenance = provenance | {key: value for key, value in kept.items() if provenance.get(key) is None}
    described = config.model_dump(mode="json")
    values = dict(_values({**point.values, **chosen}, spread(described)))
    suffix = f"_stage-{point.stage}" if point.stage > 1 else ""
    return Cell(name_of(own_name, values) + suffix, own_name, digest, provenance, described, values, point.stage, point.place)


def _values(given: Mapping[str, Any], config: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yields what a cell has on each axis, as one value however it was written: 0.5 for `.50`."""
    for name, value in given.items():
        if name in config:
            listed = config[name]
            yield name, listed[0] if isinstance(listed, list) and len(listed) == 1 else listed
        else:
            yield name, as_number(value) if name.startswith(PARAM) else value


def name_of(game: str, values: Mapping[str, Any]) -> str:
    """Returns the name of a cell's folder: `coins_reward-exchange_exchange_ratio-0.25`."""
    parts = [f"{_word(name.removeprefix(PARAM))}-{_word(value)}" for name, value in values.items()]
    whole = "_".join([game, *parts])
    return whole if len(whole) <= LONGEST else f"{whole[:LONGEST]}_{sha256(whole.encode()).hexdigest()[:8]}"


def _word(value: Any) -> str:
    value = short_name(value) if isinstance(value, str) else value
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return UNUSUAL.sub("-", text).strip("-") if not isinstance(value, int | float) else text


def _advice(error: ConfigError, chosen: Mapping[str, Any], fixed: Fixed) -> str:
    """Returns what to do about a key of one algorithm in a sweep over several."""
    if "it is one of" not in str(error) or not ({*chosen} | {*fixed.settings}):
        return ""
    return ". In a sweep over algorithms, put the keys of one into a preset of your own, in its table [algorithm.NAME]"
