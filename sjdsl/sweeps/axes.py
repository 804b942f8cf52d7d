"""The axes of a sweep, read from `NAME=v,v,…`."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sjdsl.experiments.refusals import ExperimentError
from sjdsl.library.tasks import ARGUMENTS as OF_TASKS
from sjdsl.several import several
from sjdsl.trainers.settings.config import KEYS_OF
from sjdsl.trainers.settings.config_errors import meant_key
from sjdsl.trainers.settings.own_settings import OWN

PARAM = "param."  # before the name of one of the game's numbers
VARIANT = "variant"
IN_GAME = (VARIANT, *OF_TASKS)  # axes that are arguments of `sjdsl.make`
SEEDS = ("seed", "seeds")  # every cell has all seeds, so neither is an axis


@dataclass(frozen=True)
class Axis:
    """A setting that varies, and its values, one or several: as texts, or as they are."""

    # A key of the configuration, `own.NAME`, `variant`, `tasks`, `split`, `problem`, or
    # `param.NAME`: NAME is a number of the game, or an entry of a table, `table[word]`.
    name: str
    values: Any  # becomes a tuple

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", several(self.values))


def read_axis(text: str) -> Axis:
    """Returns the axis of `NAME=v,v,…`; commas inside brackets belong to a value:
    `svo_angle=[45,90],[0,90]`.

    Raises:
      ExperimentError: the text has another form, or there is no such axis.
    """
    name, equals, listed = text.partition("=")
    values = tuple(value.strip() for value in split_values(listed))
    if not equals or not name.strip() or not all(values):
        raise ExperimentError(
            f"`{text}` must have the form NAME=value,value,… with at least one value, "
            "as in reward=individual,common"
        )
    return Axis(check_name(name.strip()), values)


def split_values(text: str) -> list[str]:
    """Returns the parts of a text between its commas; commas inside brackets don't count."""
    parts = [""]
    depth = 0
    for character in text:
        if character in "[({":
            depth += 1
        elif character in "])}":
            depth -= 1
        if character == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    return parts


def check_name(name: str) -> str:
    """Returns the name of an axis. Raises ExperimentError if there is no such axis."""
    if name in SEEDS:
        raise ExperimentError(
            f"`{name}` can't be an axis, as each cell has all seeds: use --seed and --seeds"
        )
    if name.startswith((PARAM, OWN)) and name not in (PARAM, OWN):
        return name
    keys = {key for keys in KEYS_OF.values() for key in keys}
    known = [*sorted(keys.difference(SEEDS)), *IN_GAME]
    if name not in known:
        hint = meant_key(name, [*known, PARAM, OWN]) or (
            ": an axis is a key of the configuration (`sjdsl train --keys` lists them), own.NAME, "
            "param.NAME, variant, tasks, split, or problem"
        )
        raise ExperimentError(f"there is no axis `{name}`{hint}")
    return name


def as_configured(value: Any) -> Any:
    """Returns the value of a configuration key without the brackets that kept its commas
    together.
    """
    is_bracketed = isinstance(value, str) and value[:1] + value[-1:] in ("[]", "()")
    return value[1:-1] if is_bracketed else value


def as_number(value: Any) -> Any:
    """Returns the value of a number of a game: a text as JSON, or unchanged if it isn't JSON."""
    if not isinstance(value, str):
        return value
    try:
        return json.loads(value)
    except ValueError:
        return value


def as_argument(name: str, value: Any) -> Any:
    """Returns the value of an argument of `sjdsl.make`: a number, or `hue=red` as a mapping."""
    if name == "problem":
        return as_number(value)
    if name == "tasks" and isinstance(value, str) and "=" in value:
        field, _, text = value.partition("=")
        return with_number({}, field, as_number(text))
    return value


def with_number(params: Mapping[str, Any], path: str, value: Any) -> dict[str, Any]:
    """Returns numbers of a game with one of them set; `regrow[red]` is an entry of a table."""
    name, *keys = path.replace("]", "").split("[")
    if keys:
        table = params.get(name)
        entries = table if isinstance(table, Mapping) else {}
        value = with_number(entries, "[".join(keys), value)
    return {**params, name: value}
