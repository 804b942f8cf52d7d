"""Error messages for wrong configurations."""

import re
from collections.abc import Mapping
from typing import Any

from sjdsl.near_names import either, meant, nearest


class ConfigError(Exception):
    """A wrong key or value; the message has a line for each fault."""


# What a value must be, by pydantic's type of fault; `{}` is filled from the fault's context.
EXPECTED: Mapping[str, str] = {
    "greater_than": "more than {gt}",
    "greater_than_equal": "at least {ge}",
    "less_than_equal": "at most {le}",
    "literal_error": "{expected}",
    "value_error": "{error}",
    "too_short": "one number or more",
    **dict.fromkeys(("int_parsing", "int_type", "int_from_float"), "a whole number"),
    **dict.fromkeys(("float_parsing", "float_type", "finite_number"), "a finite number"),
    **dict.fromkeys(("bool_parsing", "bool_type"), "true or false"),
}


def sentence_of(
    fault: Mapping[str, Any], known: Mapping[str, Any], keys_of: Mapping[str, Mapping[str, Any]]
) -> str:
    """Returns one of pydantic's faults as a sentence.

    Args:
      known: the configuration's keys.
      keys_of: those of every algorithm.
    """
    key = str(fault["loc"][0]) if fault["loc"] else "config"
    kind = fault["type"]
    if kind == "extra_forbidden":
        owners = [algorithm for algorithm, keys in keys_of.items() if key in keys]
        if owners:
            return f"unknown key `{key}` here: it is one of {' and '.join(owners)}"
        return f"unknown key `{key}`{meant(key, known, 'the keys are')}"
    need = fault["msg"]
    if kind in EXPECTED:
        need = EXPECTED[kind].format(**fault.get("ctx", {}))
    sentence = f"`{key}` must be {need}, not {fault['input']!r}"
    if isinstance(fault["input"], str):
        known_values = re.findall(r"'([^']+)'", need)  # if there are only some
        near = nearest(fault["input"], known_values)
        if near:
            return f"{sentence}; did you mean {either(near)}?"
    return sentence
