"""Run-time parameters from Python: values by name, checked against the limits and `require`s of the game."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.evaluate_constant import holds
from sjdsl.compiler.ir.names import param_attribute
from sjdsl.compiler.ir.printer import expression
from sjdsl.compiler.ir.sorts import Level, entry_name, level_text, sort_of
from sjdsl.near_names import meant

if TYPE_CHECKING:
    from sjdsl.runtime.module import GameModule

Values = Mapping[str, Any]


def split_sizes(game_sizes: Sequence[str], params: Sequence[str], given: Values) -> tuple[dict[str, Any], dict[str, Any]]:
    """Returns the given values that are sizes (fixed when compiled) and those that are parameters.

    Raises ValueError for a name the game does not have, TypeError for what is no name.
    """
    sizes, rest = {}, {}
    for name, value in given.items():
        if not isinstance(name, str):
            raise TypeError(f"params has names of numbers of the game, not {name!r}; it has {', '.join([*game_sizes, *params])}")
        if name in game_sizes:
            sizes[name] = plain_number(value)
        elif name in params:
            rest[name] = value
        else:
            raise ValueError(f"the game has no number `{name}`{meant(name, [*game_sizes, *params], 'it has')}")
    return sizes, rest


def plain_number(value: Any) -> Any:
    """Returns a number of NumPy or JAX, or an array of one without axes, as Python's own; anything else as it is."""
    return value.item() if hasattr(value, "item") and np.ndim(value) == 0 else value


def build_params(game: ir.Game, module: "GameModule", given: Values, check_requires: bool = True) -> Any:
    """Returns the game's `Params` with some values replaced; arguments and errors are those of `param_values`."""
    import jax.numpy as jnp

    values = param_values(game, given, check_requires)
    params = module.default_params()
    changed = {}
    for param in game.params:
        if param.name in given:
            attribute = param_attribute(param.name)
            array = np.array(_encoded(values[param.name], param.type))
            changed[attribute] = jnp.asarray(array, getattr(params, attribute).dtype)
    return params.replace(**changed)


def param_values(game: ir.Game, given: Values, check_requires: bool = True) -> dict[str, Any]:
    """Returns the value of every parameter of the game by name, some replaced; tables as nested tuples.

    Args:
      given: by name: a number, a word, or for a table a mapping (whole or in part) by word, by number or by the number of an agent,
        or nested sequences in the order of its entries.
      check_requires: whether a `require` of the game must hold.
    Raises ValueError: unknown name or word, a value outside its limits, a `require` of the game that no longer holds.
    """
    values = {p.name: p.value for p in game.params}
    for name, value in given.items():
        param = next((p for p in game.params if p.name == name), None)
        if param is None:
            raise ValueError(f"the game has no parameter `{name}`{meant(name, values, 'it has')}")
        values[name] = _merged(name, values[name], value, param.type.by, param.type)
    for check in game.checks:
        if check_requires and check.sort == "require" and not holds(check.values[0], values):
            raise ValueError(f"these parameters fail a check of the game: require {expression(check.values[0])}")
    return values


def _merged(name: str, before: Any, value: Any, by: tuple[Level, ...], type_: ir.Type) -> Any:
    if not by:
        return _checked(name, value, type_)
    names = [entry_name(entry) for entry in by[0]]
    if isinstance(value, Mapping):
        given = {str(key): entry for key, entry in value.items()}
        unknown = [key for key in given if key not in names]
        if unknown:
            raise ValueError(f"`{name}` has no entry `{unknown[0]}`; its {_entries(by[0])}")
        inner = {key: _merged(f"{name}[{key}]", before[names.index(key)], entry, by[1:], type_) for key, entry in given.items()}
        return tuple(inner.get(key, before[i]) for i, key in enumerate(names))
    listed = value.tolist() if hasattr(value, "tolist") else value
    if not isinstance(listed, Sequence) or isinstance(listed, str) or len(listed) != len(names):
        raise ValueError(f"`{name}` wants {len(names)} values: its {_entries(by[0])}")
    return tuple(_merged(f"{name}[{key}]", before[i], listed[i], by[1:], type_) for i, key in enumerate(names))


def _entries(level: Level) -> str:
    """Returns what the entries of a table are."""
    match sort_of(level):
        case "agent":
            return f"entries are the agents 0 .. {len(level) - 1}"
        case "number":
            return f"entries are {level_text(level)}"
        case _:
            return f"words are {', '.join(level)}"


def _checked(name: str, value: Any, type_: ir.Type) -> Any:
    if type_.kind == "word":
        if value not in type_.words:
            raise ValueError(f"`{name}` is one of {', '.join(type_.words)}, not {value!r}")
        return value
    number = plain_number(value)
    if isinstance(number, bool) or not isinstance(number, int | float) or not np.isfinite(number):
        raise ValueError(f"`{name}` is a number ({type_.unit}), not {value!r}")
    if type_.kind == "int" and number != int(number):
        raise ValueError(f"`{name}` is a whole number ({type_.unit}), not {value!r}")
    if not type_.low <= number <= type_.high:
        raise ValueError(f"`{name}` is {number}, outside {type_.low:g} .. {type_.high:g}")
    return int(number) if type_.kind == "int" else float(number)


def _encoded(value: Any, type_: ir.Type) -> Any:
    if isinstance(value, tuple):
        return [_encoded(v, type_) for v in value]
    return type_.words.index(value) if type_.kind == "word" else value
