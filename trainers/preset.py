"""Presets: TOML files that say which game to train and how, some of them in this package.

extends = "paper"       # optional: another preset, or a file beside this one; values here win over its values
game = "coins"          # optional: the game to train in if none is named
only_listed = true      # optional: refuse games without a table

[environment]           # further arguments of sjdsl.make, for the preset's game if it names one, else for any
num_agents = 2

[config]                # keys of the configuration
learning_rate = 1e-3

[config.own]            # settings for the user's own algorithm, loss, network or reward
bonus = 0.1

[algorithm.mappo]       # as [config], for one algorithm; a user's own has the settings of ippo
[reward.svo]            # for one reward
[algorithm.ippo.reward.common]  # for one algorithm with one reward
[games.coins.config]    # for one game, by the name in its file; and so .environment, .algorithm.NAME, .reward.NAME

Later tables win over earlier ones, and the command line over all. A preset may have settings that some rewards, networks or algorithms
don't read: with those, they are left out.
"""

import tomllib
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any, get_args

from sjdsl.files import MEGABYTE, read_bytes
from sjdsl.near_names import meant

from .config import KEYS_OF, Config, ConfigError, make_config, only_of_others
from .extensions import Algorithm, RewardMode
from .own_settings import OWN, spread

FOR_ANY = {"environment": dict, "config": dict, "algorithm": dict, "reward": dict}
ENVIRONMENT = {"variant": str, "map": str, "num_agents": int, "params": dict}
SECTIONS = {"extends": str, "game": str, "only_listed": bool, "games": dict, **FOR_ANY}
NAMES = {"algorithm": get_args(Algorithm), "reward": get_args(RewardMode)}
LARGEST = MEGABYTE  # bytes of a preset's file
MEANS = {str: "text", int: "a whole number", bool: "true or false", dict: "a table"}


@dataclass(frozen=True)
class Preset:
    """A game and how to train in it."""

    game: str | None  # first argument of `sjdsl.make`; None: any
    environment: Mapping[str, Any]  # its other arguments
    config: Config
    left_out: tuple[str, ...]  # its settings that nothing reads in `config`


def load_preset(
    name: str | Path, changes: Mapping[str, Any] | None = None, game: str | None = None, asked: Collection[str] | None = None
) -> Preset:
    """Returns a preset, with `changes` in place of values of its configuration.

    Args:
      name: of a preset in this package, such as `two_cores`, or the path of a `.toml` file.
      changes: configuration keys and their new values; text such as `"3e-4"` is read as a number.
      game: name of a game, or the path of its file, instead of the preset's own.
      asked: those of `changes` that are refused if nothing reads them, as in `make_config`; None: all.
    Raises:
      ConfigError: no such preset, a wrong key or value, a change that nothing reads, or a game that the preset has no table for.
    """
    content = _content(name)
    chosen = game or content.get("game")
    stem = Path(chosen).stem if chosen else None
    own = content.get("games", {}).get(stem, {})
    if content.get("only_listed") and stem is not None and not own:
        raise ConfigError(f"the preset `{name}` has no table for `{stem}`; it has {', '.join(content.get('games', {}))}")
    kept = content.get("environment", {}) if content.get("game") is None or stem == Path(content["game"]).stem else {}
    changes = spread(changes or {})
    values = _layered(content, own, changes)
    config = make_config(values, asked=changes if asked is None else asked)
    unread = {*config.unread, *(key for key in values if key.startswith(OWN) or only_of_others(key, type(config)))}
    unread -= {f"{OWN}{name}" for name, _ in config.own}
    left_out = tuple(key for key in values if key in unread and key not in changes)
    return Preset(chosen, {**kept, **own.get("environment", {})}, config, left_out)


def _content(name: str | Path, extended_by: tuple[str | Path, ...] = ()) -> dict[str, Any]:
    """Returns the tables of a preset, merged with those of the presets that it extends."""
    if _identity(name) in map(_identity, extended_by):
        raise ConfigError(f"{extended_by[0]}: presets extend each other in a circle: {' -> '.join(map(str, (*extended_by, name)))}")
    try:
        content = tomllib.loads(_read(name))
    except ValueError as error:  # also an integer of too many digits
        raise ConfigError(f"{name}: {error}") from None
    except RecursionError:
        raise ConfigError(f"{name}: it is nested too deep") from None
    _check(content, SECTIONS, str(name))
    _check_named(content, str(name))
    _check(content.get("games", {}), dict.fromkeys(content.get("games", {}), dict), f"{name}: games")
    for listed, tables in content.get("games", {}).items():
        _check(tables, FOR_ANY, f"{name}: games.{listed}")
        _check_named(tables, f"{name}: games.{listed}")
    if "extends" not in content:
        return content
    extended = content["extends"]
    under = Path(name).parent / extended if Path(extended).suffix == ".toml" else extended
    return _over(_content(under, (*extended_by, name)), content)


def _identity(name: str | Path) -> str | Path:
    """Returns a file by its one whole path, a preset of this package by its name."""
    return Path(name).resolve() if Path(name).suffix == ".toml" else str(name)


def _over(under: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """Returns two trees of tables merged; values of `above` win."""
    both = {name: _over(under[name], above[name]) for name in under.keys() & above.keys() if isinstance(above[name], dict)}
    return {**under, **above, **both}


def _layered(content: Mapping[str, Any], own: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the values of the configuration: for all, the algorithm, the reward, both together; the same for the game; changes."""
    first = {**content.get("config", {}), **own.get("config", {}), **changes}
    algorithm = _name_in(first, "algorithm", "ippo")
    algorithm = algorithm if algorithm in KEYS_OF else "ippo"  # a user's own has the settings of ippo
    reward = _name_in(first, "reward", KEYS_OF[algorithm]["reward"].default)
    values: dict[str, Any] = {}
    for tables in (content, own):
        of_algorithm = tables.get("algorithm", {}).get(algorithm, {})
        of_rewards = _of_rewards(of_algorithm)
        values |= spread(tables.get("config", {}))
        values |= spread({key: value for key, value in of_algorithm.items() if value is not of_rewards})
        values |= spread(tables.get("reward", {}).get(reward, {}))
        values |= spread(of_rewards.get(reward, {}))
    return values | dict(changes)


def _name_in(values: Mapping[str, Any], key: str, default: str) -> str:
    """Returns the name in a value; the configuration refuses what is none."""
    value = values.get(key, default)
    return value if isinstance(value, str) else default


def _of_rewards(algorithm: Mapping[str, Any]) -> dict[Any, Any]:
    """Returns the tables of rewards inside that of an algorithm; there the key `reward` can also be a value."""
    found = algorithm.get("reward")
    return found if isinstance(found, dict) else {}


def _check_named(tables: Mapping[str, Any], where: str) -> None:
    """Raises ConfigError for an unknown argument of the environment, algorithm or reward."""
    _check(tables.get("environment", {}), ENVIRONMENT, f"{where}: environment")
    for section, names in NAMES.items():
        _check(tables.get(section, {}), dict.fromkeys(names, dict), f"{where}: {section}")
    for algorithm, values in tables.get("algorithm", {}).items():
        _check(_of_rewards(values), dict.fromkeys(NAMES["reward"], dict), f"{where}: algorithm.{algorithm}.reward")


def _check(tables: Mapping[str, Any], known: Mapping[str, type], where: str) -> None:
    """Raises ConfigError for an unknown key, or a value of the wrong type."""
    for key, value in tables.items():
        if key not in known:
            raise ConfigError(f"{where}: unknown key `{key}`{meant(key, known, 'the keys are')}")
        if not isinstance(value, known[key]):
            raise ConfigError(f"{where}: `{key}` must be {MEANS[known[key]]}, not {value!r}")


def _read(name: str | Path) -> str:
    if Path(name).suffix == ".toml":
        try:
            return read_bytes(Path(name), LARGEST).decode()
        except FileNotFoundError:
            raise ConfigError(f"{name} does not exist") from None
        except OSError as error:
            raise ConfigError(f"{name} can't be read: {(error.strerror or 'unknown reason').lower()}") from None
    packaged = {file.name.removesuffix(".toml"): file for file in (files(__package__) / "presets").iterdir()}
    if name not in packaged:
        raise ConfigError(f"unknown preset `{name}`{meant(str(name), packaged, 'the presets are')}")
    return packaged[str(name)].read_text(encoding="utf-8")
