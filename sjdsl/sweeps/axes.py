"""The axes of a sweep: what is varied, read from `NAME=v,v,…`."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sjdsl.experiments.refusals import ExperimentError
from sjdsl.near_names import meant
from sjdsl.trainers.config import KEYS_OF
from sjdsl.trainers.own_settings import OWN

PARAM = "param."  # before the name of one of the game's numbers
VARIANT = "variant"
SEEDS = ("seed", "seeds")  # every cell has all seeds: they are no axis


@dataclass(frozen=True)
class Axis:
    """What is varied, and the values it takes: as they were written, or as they are."""

    name: str  # a key of the configuration, `own.NAME`, `variant`, or `param.NAME`, NAME a number of the game, `table[word]` included
    values: tuple[Any, ...]


def read_axis(text: str) -> Axis:
    """Returns the axis of `NAME=v,v,…`; commas inside brackets belong to a value: `roles=[0,0,1],[0,1,1]`.

    Raises:
      ExperimentError: it has another form, or there is no such axis.
    """
    name, equals, listed = text.partition("=")
    values = tuple(value.strip() for value in split_values(listed))
    if not equals or not name.strip() or not all(values):
        raise ExperimentError(f"`{text}` must have the form NAME=value,value,… with a value or more, as in reward=individual,common")
    return Axis(check_name(name.strip()), values)


def split_values(text: str) -> list[str]:
    """Returns the parts between the commas of a text that stand in no bracket."""
    parts, depth = [""], 0
    for character in text:
        depth += (character in "[({") - (character in "])}")
        if character == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    return parts


def check_name(name: str) -> str:
    """Returns the name of an axis. Raises ExperimentError where there is none of that name."""
    if name in SEEDS:
        raise ExperimentError(f"`{name}` is no axis, for each cell has all seeds: say --seed and --seeds")
    keys = [key for key in dict.fromkeys(key for known in KEYS_OF.values() for key in known) if key not in SEEDS]
    if any(name.startswith(prefix) and name != prefix for prefix in (PARAM, OWN)):
        return name
    if name not in (*keys, VARIANT):
        near = meant(name, [*keys, VARIANT, PARAM, OWN], "")
        raise ExperimentError(
            f"there is no axis `{name}`{near or ': an axis is a key of the configuration (`sjdsl train --keys` lists them), own.NAME, variant, or param.NAME'}"
        )
    return name


def check_axes(axes: Sequence[Axis]) -> None:
    """Raises ExperimentError where two axes are one."""
    names = [axis.name for axis in axes]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice:
        raise ExperimentError(f"the axis `{twice}` is given twice; name all its values at once: --axis {twice}=value,value")


def as_configured(value: Any) -> Any:
    """Returns the value of a configuration key as its own type reads it: without the brackets that kept its commas together."""
    return value[1:-1] if isinstance(value, str) and value[:1] + value[-1:] in ("[]", "()") else value


def as_number(value: Any) -> Any:
    """Returns the value of one of a game's numbers: what it is in JSON, or a word."""
    try:
        return json.loads(value) if isinstance(value, str) else value
    except ValueError:
        return value


def with_number(params: Mapping[str, Any], path: str, value: Any) -> dict[str, Any]:
    """Returns numbers of a game with one of them set; `regrow[red]` is an entry of a table."""
    name, *words = path.replace("]", "").split("[")
    if not words:
        return {**params, name: value}
    inner = params.get(name, {})
    return {**params, name: with_number(inner if isinstance(inner, Mapping) else {}, "[".join(words), value)}
