"""Run-time parameters from Python: values by name, checked against the limits and `require`s of the game."""

from collections.abc import Mapping, Sequence
from math import isclose
from typing import TYPE_CHECKING, Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.checks.whole_numbers import beyond_int32, boundary
from sjdsl.compiler.diagnostics.limits import MAX_VALUE
from sjdsl.compiler.ir.names import param_attribute
from sjdsl.compiler.ir.printer import expression, number_text
from sjdsl.compiler.ir.sorts import Level
from sjdsl.compiler.ir.values import holds
from sjdsl.compiler.lower.state import param_value
from sjdsl.near_names import meant

if TYPE_CHECKING:
    from sjdsl.runtime.module import GameModule

Values = Mapping[str, Any]
ROUNDING = 2.0**-24  # a limit that is rounded to float32 is still inside


def split_sizes(
    game_sizes: Sequence[str], params: Sequence[str], given: Values
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Returns the given values that are sizes (fixed when compiled) and those that are parameters.

    Raises ValueError for a name the game does not have, and for None; TypeError for what is no name.
    """
    sizes, rest = {}, {}
    for name, value in given.items():
        if not isinstance(name, str):
            raise TypeError(
                f"params has names of numbers of the game, not {name!r}; it has {', '.join([*game_sizes, *params])}"
            )
        if value is None:
            raise ValueError(f"`{name}` is None: give it a number, or leave it out")
        if name in game_sizes:
            sizes[name] = plain_number(value)
        elif name in params:
            rest[name] = value
        else:
            raise ValueError(
                f"the game has no number `{name}`{meant(name, [*game_sizes, *params], 'it has')}"
            )
    return sizes, rest


def plain_number(value: Any) -> Any:
    """Returns a number of NumPy or JAX, or an array of one without axes, as Python's own; anything else as it is."""
    return value.item() if hasattr(value, "item") and np.ndim(value) == 0 else value


def build_params(
    game: ir.Game, module: "GameModule", given: Values, check_requires: bool = True
) -> Any:
    """Returns the game's `Params` with some values replaced; arguments and errors are those of `param_values`."""
    values = param_values(game, given, check_requires)
    defaults = module.default_params()
    return defaults.replace(
        **_arrays(
            defaults, {param: values[param.name] for param in game.params if param.name in given}
        )
    )


def _arrays(defaults: Any, values: Mapping[ir.Param, Any]) -> dict[str, Any]:
    """Returns values as arrays of the dtypes of the game, by their attributes."""
    import jax
    import jax.numpy as jnp

    found = {}
    with (
        jax.ensure_compile_time_eval()
    ):  # known numbers stay known where another function is traced
        for param, value in values.items():
            attribute = param_attribute(param.name)
            found[attribute] = jnp.asarray(
                np.array(param_value(value, param.type)), getattr(defaults, attribute).dtype
            )
    return found


def admitted_params(game: ir.Game, module: "GameModule", params: Any) -> Any:
    """Returns a `Params` of the game if the game takes its values; Python's numbers in it become arrays.

    What a traced array holds is not known yet. If there is one, only the other values are looked at, each by itself: no `require`, and not
    whether whole numbers stay in int32.

    Raises ValueError: as `param_values`, and for the shape or dtype of an array.
    """
    import jax

    from sjdsl.runtime.arguments import check_arrays

    defaults = module.default_params()
    check_arrays(params, defaults)
    given, numbers, traced = {}, [], False
    for param in game.params:
        leaf = getattr(params, param_attribute(param.name))
        if isinstance(leaf, jax.core.Tracer):
            traced = True
            continue
        value = np.asarray(leaf).tolist()
        given[param.name] = (
            _decoded(param.name, value, param.type) if param.type.kind == "word" else value
        )
        numbers += [] if isinstance(leaf, jax.Array) else [param]
    values = _replaced(game, given)
    if not traced:
        _check_together(game, values, given, check_requires=True)
    return params.replace(**_arrays(defaults, {param: values[param.name] for param in numbers}))


def _decoded(name: str, value: Any, type_: ir.Type) -> Any:
    """Returns words by their numbers."""
    if isinstance(value, list):
        return [_decoded(name, v, type_) for v in value]
    if not 0 <= value < len(type_.words):
        raise ValueError(
            f"`{name}` is the number of a word, 0 .. {len(type_.words) - 1} ({', '.join(type_.words)}), not {value}"
        )
    return type_.words[value]


def param_values(game: ir.Game, given: Values, check_requires: bool = True) -> dict[str, Any]:
    """Returns the value of every parameter of the game by name, some replaced; tables as nested tuples.

    Args:
      given: by name: a number, a word, or for a table a mapping (whole or in part) by word, by number or by the number of an agent,
        or nested sequences in the order of its entries.
      check_requires: whether a `require` of the game must hold.
    Raises ValueError: unknown name or word, a value outside its limits, a `require` of the game that no longer holds, whole numbers of the
      rules that could leave int32, an episode without a step.
    """
    values = _replaced(game, given)
    _check_together(game, values, given, check_requires)
    return values


def _replaced(game: ir.Game, given: Values) -> dict[str, Any]:
    """Returns the value of every parameter, each of those given looked at by itself."""
    values = {p.name: p.value for p in game.params}
    for name, value in given.items():
        param = next((p for p in game.params if p.name == name), None)
        if param is None:
            raise ValueError(f"the game has no parameter `{name}`{meant(name, values, 'it has')}")
        values[name] = _merged(name, values[name], value, param.type.by, param.type)
    return values


def _check_together(game: ir.Game, values: Values, given: Values, check_requires: bool) -> None:
    """Raises ValueError for values that do not go together, or that the rules cannot be played with."""
    for check in game.checks:
        if check_requires and check.sort == "require" and not holds(check.values[0], values):
            raise ValueError(
                f"these parameters fail a check of the game: require {expression(check.values[0])}"
            )
    problems = beyond_int32(game, values) if given else []
    if problems:
        place = f"{problems[0].span.file}:{problems[0].span.line}"
        raise ValueError(f"{_limit(game, values, given)}: {problems[0].message} ({place})")


def _limit(game: ir.Game, values: Values, given: Values) -> str:
    """Returns which of the given values is too large (or too small), and what it can be with the others as they are."""
    for param in game.params:
        own, value = param.value, values[param.name]

        def is_played(number: int, name: str = param.name) -> bool:
            return not beyond_int32(game, {**values, name: number})

        if param.name in given and isinstance(own, int) and is_played(own):
            nearest = boundary(own, value, is_played)
            return f"`{param.name}` is {value}, and can be {nearest} at {'most' if value > nearest else 'least'}"
    return (
        "with these parameters a whole number leaves 32 bits ("
        + ", ".join(f"{name}: {values[name]}" for name in given)
        + ")"
    )


def _merged(name: str, before: Any, value: Any, by: tuple[Level, ...], type_: ir.Type) -> Any:
    if not by:
        return _checked(name, value, type_)
    names = by[0].keys
    if isinstance(value, Mapping):
        given = {str(key): entry for key, entry in value.items()}
        unknown = [key for key in given if key not in names]
        if unknown:
            raise ValueError(f"`{name}` has no entry `{unknown[0]}`; its {_entries_text(by[0])}")
        inner = {
            key: _merged(f"{name}[{key}]", before[names.index(key)], entry, by[1:], type_)
            for key, entry in given.items()
        }
        return tuple(inner.get(key, before[i]) for i, key in enumerate(names))
    listed = value.tolist() if hasattr(value, "tolist") else value
    if not isinstance(listed, Sequence) or isinstance(listed, str) or len(listed) != len(names):
        raise ValueError(f"`{name}` wants {len(names)} values: its {_entries_text(by[0])}")
    return tuple(
        _merged(f"{name}[{key}]", before[i], listed[i], by[1:], type_)
        for i, key in enumerate(names)
    )


def _entries_text(level: Level) -> str:
    """Returns what the entries of a table are."""
    if level.sort == "word":
        return f"words are {', '.join(level.names)}"
    return (
        f"entries are {level}"
        if level.sort == "number"
        else f"entries are the agents 0 .. {len(level) - 1}"
    )


def _checked(name: str, value: Any, type_: ir.Type) -> Any:
    if type_.kind == "word":
        if value not in type_.words:
            raise ValueError(f"`{name}` is one of {', '.join(type_.words)}, not {value!r}")
        return value
    number = plain_number(value)
    if isinstance(number, bool) or not isinstance(number, int | float) or number != number:
        raise ValueError(f"`{name}` is a number ({type_.unit}), not {value!r}")
    if type_.kind == "int" and isinstance(number, float) and not number.is_integer():
        raise ValueError(f"`{name}` is a whole number ({type_.unit}), not {value!r}")
    low, high = max(type_.low, -MAX_VALUE), min(type_.high, MAX_VALUE)
    nearest = min(max(number, low), high)
    rounded = (
        type_.kind == "real"
        and abs(number) <= 2 * MAX_VALUE
        and isclose(number, nearest, rel_tol=ROUNDING)
    )
    if number != nearest and not rounded:
        raise ValueError(f"`{name}` is {number}, outside {number_text(low)} .. {number_text(high)}")
    return int(number) if type_.kind == "int" else float(number)
