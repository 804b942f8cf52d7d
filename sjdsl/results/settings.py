"""The settings of training and the numbers of games in which loaded runs differ, as columns of
their own.
"""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cache
from itertools import chain
from types import SimpleNamespace
from typing import Any

from sjdsl.extras import needs
from sjdsl.results.bundled import numbers_now, variant_now
from sjdsl.sweeps.axes import PARAM, as_number
from sjdsl.trainers.settings.config import (
    ConfigError,
    Only,
    class_of,
    dependent_settings,
    stored_config,
)
from sjdsl.trainers.settings.own_settings import OWN, flatten_own

with needs("results"):
    import pandas as pd

METHOD = (  # columns that say how a run was trained
    "algorithm",
    "reward",
    "sharing",
    "exchange_ratio",
    "svo_weight",
    "svo_angle",
    "network",
    "total_timesteps",
)
# Settings that don't affect what is learnt: seeds, and what is written when.
WITHOUT_EFFECT = (
    "seed",
    "seeds",
    "keep_policies",
    "policy_every",
    "evaluate_every",
    "evaluation_episodes",
)
CHECKPOINTS = "checkpoint_"  # begins the names of more of these
ANGLES = "svo_angles"  # of agents that differ in it; the column `svo_angle` has numbers
GAME_NUMBERS = "numbers"  # a column while results are loaded: the numbers of a run's game as JSON


def settings_of(row: Any) -> dict[str, Any]:
    """Returns the settings of a seed's training that have no column in each table, by name; without
    those that nothing read.

    A setting of the user's own is `own.NAME`; there are only those that were set.
    """
    usual, conditions = _usual_settings(row.algorithm)
    stored = json.loads(row.settings or "{}")
    values = {
        **usual,
        **stored,
        "algorithm": row.algorithm,
        "reward": row.reward,
        "network": row.network,
    }
    config = SimpleNamespace(**values)
    unread = {name for name, condition in conditions.items() if not condition.holds(config)}
    if "svo_angle" in stored:
        values[ANGLES] = stored["svo_angle"]
    left_out = {*METHOD, *WITHOUT_EFFECT, *unread}
    shown = {
        name: value
        for name, value in values.items()
        if name not in left_out and not name.startswith(CHECKPOINTS)
    }
    return flatten_own(shown)


@cache
def _usual_settings(algorithm: str) -> tuple[Mapping[str, Any], Mapping[str, Only]]:
    """Returns the settings of an algorithm by default, and the conditions of those that aren't
    always read; none if this version doesn't know it.
    """
    try:
        usual = stored_config({"algorithm": algorithm}).model_dump(mode="json")
        return usual, dependent_settings(class_of(algorithm))
    except ConfigError:
        return {}, {}


def numbers_of(game: Mapping[str, Any], asked: Mapping[str, Any]) -> str:
    """Returns the numbers of a run's game as JSON; of tables only the entries that were set.

    Args:
      game: the game in a manifest, with `params`.
      asked: the numbers that were set, as `flat_numbers` returns them.
    """
    numbers = {}
    for name, value in game["params"].items():
        if isinstance(value, float):
            numbers[name] = float(f"{value:.7g}")  # stored as float32
        elif not isinstance(value, list | dict):
            numbers[name] = value
    return json.dumps(numbers | {name: as_number(value) for name, value in asked.items()})


def stored_numbers(row: Mapping[str, Any]) -> str:
    """Returns the numbers of a game as JSON for a row of a stored table, from its column `params`
    and the bundled game with its rules.
    """
    variant = variant_now(row["game"], row["hash"])
    usual = {} if variant is None else numbers_now(row["game"], variant)
    single = {
        name: value for name, value in usual.items() if isinstance(value, bool | int | float | str)
    }
    return json.dumps(single | _read_params(row.get("params", "")))


def flat_numbers(params: Mapping[str, Any]) -> dict[str, Any]:
    """Returns numbers of a game with the entries of tables one by one: `regrow[red]`."""
    return dict(chain.from_iterable(_entries(name, value) for name, value in params.items()))


def _entries(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Yields the entries of a table and their names, such as `regrow[red]`; a number as it is."""
    if not isinstance(value, Mapping):
        yield name, value
        return
    for word, entry in value.items():
        yield from _entries(f"{name}[{word}]", entry)


def _read_params(params: str) -> dict[str, Any]:
    """Returns the numbers of `a=1 b=2`, without the number of agents."""
    pairs = (part.partition("=") for part in params.split())
    return {
        name: as_number(value) for name, equals, value in pairs if equals and name != "num_agents"
    }


def differing(tables: Sequence[Mapping[str, Any]]) -> list[str]:
    """Returns the names of the settings in which runs differ, of the tables of `settings_of`.

    A run that a setting doesn't apply to, such as one of another algorithm, doesn't count.
    """
    names = sorted({name for table in tables for name in table})
    return [name for name in names if _differs(name, tables, unset_counts=name.startswith(OWN))]


def _differs(name: str, tables: Iterable[Mapping[str, Any]], unset_counts: bool) -> bool:
    """Returns whether tables have different values of a name.

    unset_counts: whether a table without the name counts as one with another value.
    """
    values = [table.get(name) for table in tables if unset_counts or name in table]
    hashable = (json.dumps(value) if isinstance(value, list | dict) else value for value in values)
    return len(set(hashable)) > 1


def with_settings(frame: "pd.DataFrame") -> "pd.DataFrame":
    """Returns a table of results with a column, after `settings`, for each setting and each number
    of a game in which its runs differ.

    Args:
      frame: with the index 0, 1, 2 and so on, and the column `GAME_NUMBERS`, which is left out.
    """
    seeds = frame[frame.record == "seed"]
    settings = {index: settings_of(row) for index, row in seeds.iterrows()}
    numbers = {
        index: {f"{PARAM}{name}": value for name, value in json.loads(text).items()}
        for index, text in seeds[GAME_NUMBERS].items()
    }
    names = differing([*settings.values()])
    for _, same_rules in seeds.groupby(["game", "hash"]):
        changed = {
            f"{PARAM}{name}" for params in same_rules.params for name in _read_params(params)
        }
        tables = [numbers[index] for index in same_rules.index]
        for name in sorted({*chain(*tables)}):
            if _differs(name, tables, unset_counts=name in changed):
                names.append(name)
    by_row = [settings.get(index, {}) | numbers.get(index, {}) for index in frame.index]
    columns = {
        name: column_of([values.get(name) for values in by_row]) for name in dict.fromkeys(names)
    }
    # The new columns stand right behind `settings`.
    others = frame.drop(columns=GAME_NUMBERS)
    middle = others.columns.get_loc("settings") + 1
    return pd.concat(
        [others.iloc[:, :middle], pd.DataFrame(columns, frame.index), others.iloc[:, middle:]],
        axis=1,
    )


def column_of(values: Sequence[Any]) -> "pd.Series":
    """Returns a column of values that may be None: whole numbers as `Int64`, numbers as floats,
    true and false as `boolean`, else texts.
    """
    types = {type(value) for value in values if value is not None}
    if types == {bool}:
        return pd.Series(values, dtype="boolean")
    if types <= {int, float}:
        with suppress(OverflowError):  # such a number stays a text
            return pd.Series(values, dtype="Int64" if types == {int} else "float")
    return pd.Series(["" if value is None else as_written(value) for value in values], dtype=object)


def as_written(value: Any) -> str:
    """Returns a setting as `--set` takes it: `0.5`, `true`, `45,90`, `1=random,2=stay`."""
    if not isinstance(value, list):
        return _write_value(value)
    texts = []
    for part in value:
        pair = part if isinstance(part, list) else [part]  # of a partner: its agent and its policy
        texts.append("=".join(map(_write_value, pair)))
    return ",".join(texts)


def _write_value(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:g}"
    return value if isinstance(value, str) else json.dumps(value)
