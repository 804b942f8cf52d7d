"""Presets: TOML files that say which game to train and how, some of them in this package.

# Optional: another preset, or a file beside this one; values here win over its values.
extends = "paper"
game = "coins"          # optional: the game to train in if none is named
only_listed = true      # optional: refuse games without a table

[environment]           # further arguments of sjdsl.make, for the preset's game if it names one
num_agents = 2          # also variant, map, params, tasks, split and problem

[config]                # keys of the configuration
learning_rate = 1e-3

[config.own]            # settings for the user's own algorithm, loss, network or reward
bonus = 0.1

[algorithm.mappo]       # as [config], for one algorithm; a user's own has the settings of ippo
[reward.svo]            # for one reward
[algorithm.ippo.reward.common]  # for one algorithm with one reward
[games.coins.config]    # for one game, by the name in its file; so too .environment, .reward.NAME
                        # and .algorithm.NAME

# Optional: a run in stages, each of which continues from the policy of the one before.
[[stages]]
environment.map = "small.txt"       # what this stage has otherwise: tables as above, but `games`
config.total_timesteps = 1_000_000  # of this stage

# The last stage: its game is that of the run, in which policies are evaluated.
[[stages]]
config.total_timesteps = 4_000_000

[[games.coins.stages]]  # for one game, instead of those for all

Later tables win over earlier ones, those of a stage over all others, and the command line over all;
but it can't change what a stage sets. A preset may have settings that some rewards, networks or
algorithms don't read: with those, they are left out.
"""

import tomllib
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path
from typing import Any, get_args

from sjdsl.files import MEGABYTE, read_bytes
from sjdsl.near_names import meant

from .config import KEYS_OF, Config, ConfigError, make_config, only_of_others
from .extensions import Algorithm, RewardMode
from .own_settings import OWN, flatten_own
from .stage_settings import STAGES, check_settings

# The keys of a table, each with the type of its value; where that may be a table, or a list of
# tables, with the keys of these too. `ANY` stands for all other keys.
Schema = Mapping[str, Any]
ANY = "*"
REWARDS: Schema = dict.fromkeys(get_args(RewardMode), dict)
FOR_ALGORITHM: Schema = {"reward": (object, REWARDS), ANY: object}
ENVIRONMENT: Schema = {
    "variant": str,
    "map": str,
    "num_agents": int,
    "params": dict,
    "tasks": str | dict,
    "split": str,
    "problem": int,
}
FOR_ANY: Schema = {
    "environment": (dict, ENVIRONMENT),
    "config": dict,
    "algorithm": (dict, dict.fromkeys(get_args(Algorithm), (dict, FOR_ALGORITHM))),
    "reward": (dict, REWARDS),
}
FOR_A_GAME: Schema = {**FOR_ANY, STAGES: (list, FOR_ANY)}
SECTIONS: Schema = {
    "extends": str,
    "game": str,
    "only_listed": bool,
    "games": (dict, {ANY: (dict, FOR_A_GAME)}),
    **FOR_A_GAME,
}
LARGEST = MEGABYTE  # bytes of a preset's file
MEANS: Mapping[Any, str] = {
    str: "text",
    int: "a whole number",
    bool: "true or false",
    dict: "a table",
    list: "a list of tables",
    str | dict: "text or a table",
}


@dataclass(frozen=True)
class Preset:
    """A game and how to train in it; of a preset with stages, in its last one."""

    game: str | None  # first argument of `sjdsl.make`; None: any
    environment: Mapping[str, Any]  # its other arguments
    config: Config
    left_out: tuple[str, ...] = ()  # its settings that nothing reads in `config`
    unread: frozenset[str] = frozenset()  # these, and changes that nothing reads
    earlier: tuple["Preset", ...] = ()  # the stages before this one
    place: str = ""  # of its stages: `mine.toml: games.coins.stages`
    # what stages set: keys of the configuration, `map`, `param.X` and so on
    of_stages: frozenset[str] = frozenset()

    def refuse_of_stages(self, names: Collection[str]) -> None:
        """Raises ConfigError if a stage sets one of these keys or arguments of the environment."""
        for name in names:
            if name in self.of_stages:
                raise ConfigError(f"{self.place} set `{name}` themselves: change it there")


def load_preset(
    name: str | Path,
    changes: Mapping[str, Any] | None = None,
    game: str | None = None,
    asked: Collection[str] | None = None,
) -> Preset:
    """Returns a preset, with `changes` in place of values of its configuration.

    Args:
      name: of a preset in this package, such as `two_cores`, or the path of a `.toml` file.
      changes: configuration keys and their new values; text such as `"3e-4"` is read as a number.
        They hold in all stages, except that only the first one starts from the policy `init_from`.
      game: name of a game, or the path of its file, instead of the preset's own.
      asked: those of `changes` that are refused if nothing reads them, as in `make_config`; None:
        all.
    Raises:
      ConfigError: no such preset, a wrong key or value, a change that nothing reads or that a stage
        sets, stages that can't follow each other, or a game that the preset has no table for.
    """
    content = _read_content(name)
    games = content.get("games", {})
    chosen = game or content.get("game")
    stem = Path(chosen).stem if chosen else None
    of_game = games.get(stem, {})
    if content.get("only_listed") and stem is not None and not of_game:
        raise ConfigError(
            f"the preset `{name}` has no table for `{stem}`; it has {', '.join(games)}"
        )
    for_all = content
    if "game" in content and stem != Path(content["game"]).stem:
        for_all = {**content, "environment": {}}
    tables = (for_all, of_game)
    changes = flatten_own(changes or {})
    asked = changes if asked is None else asked
    stages = of_game.get(STAGES, content.get(STAGES, ()))
    if not stages:
        return _resolve(chosen, tables, changes, asked)
    place = f"{name}: games.{stem}.{STAGES}" if STAGES in of_game else f"{name}: {STAGES}"
    preset = _resolve_stages(chosen, tables, stages, changes, place)
    preset.refuse_of_stages(changes)
    all_stages = (*preset.earlier, preset)
    needless = [name for name in asked if all(name in stage.unread for stage in all_stages)]
    if needless:
        _resolve(chosen, (*tables, stages[-1]), changes, needless)  # raises
    return preset


def _resolve_stages(
    game: str | None,
    tables: Sequence[Mapping[str, Any]],
    stages: Sequence[Mapping[str, Any]],
    changes: Mapping[str, Any],
    place: str,
) -> Preset:
    """Returns the last stage of a preset, which holds the earlier ones.

    Args:
      game: its name or file, None if any.
      tables: the preset's settings for all stages; later tables win.
      stages: the table of each stage, which wins over `tables`.
      changes: settings that win over all tables. Only the first stage starts from the policy
        `init_from`: each other stage starts from the policy of the stage before it.
      place: where the stages are written, for messages: `mine.toml: stages`.
    Raises:
      ConfigError: a setting of a stage is wrong, or two stages can't follow each other.
    """
    resolved: list[Preset] = []
    set_by_stages: set[str] = set()
    changes_of_stage = dict(changes)
    for number, stage in enumerate(stages, 1):
        try:
            resolved.append(_resolve(game, (*tables, stage), changes_of_stage, ()))
        except ConfigError as error:
            raise ConfigError(f"{place}[{number}]: {error}") from None
        set_by_stages.update(_names_in(stage))
        changes_of_stage.pop("init_from", None)
    check_settings([stage.config for stage in resolved], place)
    *earlier, last = resolved
    return replace(last, earlier=tuple(earlier), place=place, of_stages=frozenset(set_by_stages))


def _resolve(
    game: str | None,
    tables: Sequence[Mapping[str, Any]],
    changes: Mapping[str, Any],
    asked: Collection[str],
) -> Preset:
    """Returns a preset without stages, or one stage of a preset.

    Args:
      tables: later ones win; changes: these win over all tables.
      asked: those of `changes` that are refused if nothing reads them.
    """
    values = _merge_settings(tables, changes)
    config = make_config(values, asked=asked)
    unread = set(config.unread)
    own_keys = {OWN + name for name, _ in config.own}
    for key in values:
        is_unknown_own = key.startswith(OWN) and key not in own_keys
        if is_unknown_own or only_of_others(key, type(config)):
            unread.add(key)
    environment: Mapping[str, Any] = {}
    for table in tables:
        environment = _merge(environment, table.get("environment", {}))
    left_out = tuple(key for key in values if key in unread and key not in changes)
    return Preset(game, environment, config, left_out, frozenset(unread))


def _names_in(tables: Mapping[str, Any]) -> Iterator[str]:
    """Yields what the tables of a stage set: arguments of the environment, `param.X` and settings."""
    for name, value in flatten_own(tables).items():
        if name == "params":
            yield from (f"param.{param}" for param in value)
        elif isinstance(value, dict) and name != "tasks":
            yield from _names_in(value)
        else:
            yield name


def _read_content(name: str | Path, extended_by: tuple[str | Path, ...] = ()) -> dict[str, Any]:
    """Returns the tables of a preset, merged with those of the presets that it extends.

    extended_by: the presets that led to this one, for the message about a circle.
    """
    if _identity(name) in map(_identity, extended_by):
        circle = " -> ".join(map(str, (*extended_by, name)))
        raise ConfigError(f"{extended_by[0]}: presets extend each other in a circle: {circle}")
    try:
        content = tomllib.loads(_read(name))
    except ValueError as error:  # also an integer of too many digits
        raise ConfigError(f"{name}: {error}") from None
    except RecursionError:
        raise ConfigError(f"{name}: it is nested too deep") from None
    _check(content, SECTIONS, f"{name}: ")
    if "extends" not in content:
        return content
    extended = content["extends"]
    if Path(extended).suffix == ".toml":
        extended = Path(name).parent / extended
    return _merge(_read_content(extended, (*extended_by, name)), content)


def _identity(name: str | Path) -> str | Path:
    """Returns a file by its one whole path, a preset of this package by its name."""
    return Path(name).resolve() if Path(name).suffix == ".toml" else str(name)


def _merge(lower: Mapping[str, Any], upper: Mapping[str, Any]) -> dict[str, Any]:
    """Returns two trees of tables merged; values of `upper` win."""
    merged = {**lower, **upper}
    for name, value in upper.items():
        if isinstance(value, dict) and isinstance(lower.get(name), dict):
            merged[name] = _merge(lower[name], value)
    return merged


def _merge_settings(
    layers: Sequence[Mapping[str, Any]], changes: Mapping[str, Any]
) -> dict[str, Any]:
    """Returns the settings of each layer (later ones win), then the changes.

    Of each layer those for all runs, and those for the algorithm and the reward that result.
    """
    for_all: dict[str, Any] = {}
    for tables in layers:
        for_all |= tables.get("config", {})
    for_all |= changes
    # The configuration refuses what isn't text.
    algorithm = str(for_all.get("algorithm", "ippo"))
    if algorithm not in KEYS_OF:
        algorithm = "ippo"  # whose settings a user's own algorithm has
    reward = str(for_all.get("reward", KEYS_OF[algorithm]["reward"].default))
    values: dict[str, Any] = {}
    for tables in layers:
        for table in _tables_for(algorithm, reward, tables):
            values |= flatten_own(table)
    return values | dict(changes)


def _tables_for(algorithm: str, reward: str, tables: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Yields the settings for all runs, for the algorithm, for the reward and for both together."""
    of_algorithm = tables.get("algorithm", {}).get(algorithm, {})
    of_rewards = of_algorithm.get("reward")
    if not isinstance(of_rewards, dict):  # but which reward to train with
        of_rewards = {}
    yield tables.get("config", {})
    yield {key: value for key, value in of_algorithm.items() if value is not of_rewards}
    yield tables.get("reward", {}).get(reward, {})
    yield of_rewards.get(reward, {})


def _check(tables: Mapping[str, Any], schema: Schema, place: str) -> None:
    """Raises ConfigError for an unknown key, or a value of the wrong type.

    place: of the tables, for messages: `mine.toml: ` or `mine.toml: games.coins.`.
    """
    for key, value in tables.items():
        kind = schema.get(key, schema.get(ANY))
        where = place.rstrip(".: ")
        if kind is None:
            raise ConfigError(f"{where}: unknown key `{key}`{meant(key, schema, 'the keys are')}")
        wanted, inner = kind if isinstance(kind, tuple) else (kind, {ANY: object})
        if not isinstance(value, wanted):
            raise ConfigError(f"{where}: `{key}` must be {MEANS[wanted]}, not {value!r}")
        if isinstance(value, dict):
            _check(value, inner, f"{place}{key}.")
        elif wanted is list:
            numbered = {f"{key}[{number}]": table for number, table in enumerate(value, 1)}
            _check(numbered, {ANY: (dict, inner)}, place)


def _read(name: str | Path) -> str:
    """Returns the text of a preset. Raises ConfigError if there is none."""
    if Path(name).suffix == ".toml":
        try:
            return read_bytes(Path(name), LARGEST).decode()
        except FileNotFoundError:
            raise ConfigError(f"{name} does not exist") from None
        except OSError as error:
            raise ConfigError(
                f"{name} can't be read: {(error.strerror or 'unknown reason').lower()}"
            ) from None
    folder = files(__package__) / "presets"
    packaged = {file.name.removesuffix(".toml"): file for file in folder.iterdir()}
    if name not in packaged:
        raise ConfigError(f"unknown preset `{name}`{meant(str(name), packaged, 'the presets are')}")
    return packaged[str(name)].read_text(encoding="utf-8")
