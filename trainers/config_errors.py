"""Error messages for wrong configurations."""

import re
from collections.abc import Mapping
from typing import Any

from sjdsl.near_names import meant, nearest

RETIRED: Mapping[str, str] = {
    "checkpoint_every": "checkpoints are written by time now, see `checkpoint_minutes` and `checkpoint_share`, or every `checkpoint_updates` "
    "updates; policies are stored every `policy_every` updates",
}  # keys that configurations had once, and what there is instead


class ConfigError(Exception):
    """A wrong key or value; the message has one line a fault."""


def sentence_of(fault: Mapping[str, Any], known: Mapping[str, Any], keys_of: Mapping[str, Mapping[str, Any]]) -> str:
    """Returns one of pydantic's faults as a sentence; `known` has the configuration's keys, `keys_of` those of every algorithm."""
    key = str(fault["loc"][0]) if fault["loc"] else "config"
    match fault["type"]:
        case "extra_forbidden" if key in RETIRED:
            return f"`{key}` is no key any more: {RETIRED[key]}"
        case "extra_forbidden":
            owners = [algorithm for algorithm, keys in keys_of.items() if key in keys]
            if owners:
                return f"unknown key `{key}` here: it is one of {' and '.join(owners)}"
            return f"unknown key `{key}`{meant(key, known, 'the keys are')}"
        case "greater_than":
            need = f"more than {fault['ctx']['gt']}"
        case "greater_than_equal":
            need = f"at least {fault['ctx']['ge']}"
        case "less_than_equal":
            need = f"at most {fault['ctx']['le']}"
        case "literal_error":
            need = fault["ctx"]["expected"]
        case "int_parsing" | "int_type" | "int_from_float":
            need = "a whole number"
        case "float_parsing" | "float_type" | "finite_number":
            need = "a finite number"
        case "bool_parsing" | "bool_type":
            need = "true or false"
        case "too_short":
            need = "one number or more"
        case "value_error":
            need = str(fault["ctx"]["error"])
        case _:
            need = fault["msg"]
    words = re.findall(r"'([^']+)'", need)  # those that are known where only some are
    near = nearest(fault["input"], words) if isinstance(fault["input"], str) else ""
    return f"`{key}` must be {need}, not {fault['input']!r}" + (f"; did you mean `{near}`?" if near else "")
