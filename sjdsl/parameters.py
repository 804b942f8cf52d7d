"""Run-time parameters from Python: values by name, checked against the limits and `require`s of the game."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.evaluate_constant import holds
from sjdsl.compiler.ir.names import param_attribute
from sjdsl.compiler.ir.printer import expression
from sjdsl.near_names import meant

if TYPE_CHECKING:
    from sjdsl.runtime.module import GameModule

Values = Mapping[str, Any]


def split_sizes(game_sizes: Sequence[str], params: Sequence[str], given: Values) -> tuple[dict[str, Any], dict[str, Any]]:
    """Returns the given values that are sizes (fixed when compiled) and those that are parameters.

    Raises ValueError for a name the game does not have.
    """
    sizes, rest = {}, {}
    for name, value in given.items():
        if name in game_sizes:
            sizes[name] = value
        elif name in params:
            rest[name] = value
        else:
            raise ValueError(f"the game has no number `{name}`{meant(name, [*game_sizes, *params], 'it has')}")
    return sizes, rest


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
      given: by name: a number, a word, or for a table a mapping by word (whole or in part) or nested sequences in the order of
        the words.
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


def _merged(name: str, before: Any, value: Any, by: tuple[tuple[str, ...], ...], type_: ir.Type) -> Any:
    if not by:
        return _checked(name, value, type_)
    words = by[0]
    if isinstance(value, Mapping):
        unknown = [w for w in value if w not in words]
        if unknown:
            raise ValueError(f"`{name}` has no entry `{unknown[0]}`; its words are {', '.join(words)}")
        return tuple(_merged(f"{name}[{w}]", before[i], value[w], by[1:], type_) if w in value else before[i] for i, w in enumerate(words))
    listed = value.tolist() if hasattr(value, "tolist") else value
    if not isinstance(listed, Sequence) or isinstance(listed, str) or len(listed) != len(words):
        raise ValueError(f"`{name}` wants {len(words)} values, for {', '.join(words)}")
    return tuple(_merged(f"{name}[{w}]", before[i], listed[i], by[1:], type_) for i, w in enumerate(words))


def _checked(name: str, value: Any, type_: ir.Type) -> Any:
    if type_.kind == "word":
        if value not in type_.words:
            raise ValueError(f"`{name}` is one of {', '.join(type_.words)}, not {value!r}")
        return value
    number = value.item() if hasattr(value, "item") else value
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
