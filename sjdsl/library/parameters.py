"""Run-time params from Python, checked against the limits and `require`s of the game."""

from collections.abc import Mapping, Sequence
from math import isclose
from typing import TYPE_CHECKING, Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.checks.whole_numbers import beyond_int32, boundary
from sjdsl.compiler.diagnostics.limits import MAX_VALUE
from sjdsl.compiler.ir.entity_types import IndexSet
from sjdsl.compiler.ir.names import param_attribute
from sjdsl.compiler.ir.printer import expression_text, number_text
from sjdsl.compiler.ir.values import holds
from sjdsl.compiler.lower.state import param_value
from sjdsl.near_names import meant

if TYPE_CHECKING:
    from sjdsl.runtime.module import GameModule

Values = Mapping[str, Any]
ROUNDING = 2.0**-24  # relative: a limit rounded to float32 is still accepted


def split_sizes(
    size_names: Sequence[str], param_names: Sequence[str], values: Values
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Returns the values of sizes, which are fixed when the game is compiled, and those of params.

    Raises:
      ValueError: the game has no such name, or a value is None. TypeError: a name isn't a text.
    """
    sizes: dict[str, Any] = {}
    params: dict[str, Any] = {}
    names = [*size_names, *param_names]
    for name, value in values.items():
        if not isinstance(name, str):
            raise TypeError(
                f"params has names of numbers of the game, not {name!r}; it has {', '.join(names)}"
            )
        if value is None:
            raise ValueError(f"`{name}` is None: give it a number, or leave it out")
        if name in size_names:
            sizes[name] = plain_number(value)
        elif name in param_names:
            params[name] = value
        else:
            raise ValueError(f"the game has no number `{name}`{meant(name, names, 'it has')}")
    return sizes, params


def plain_number(value: Any) -> Any:
    """Returns a number of NumPy or JAX, or an array of shape `[]`, as one of Python.

    Anything else is returned unchanged.
    """
    return value.item() if hasattr(value, "item") and np.ndim(value) == 0 else value


def build_params(
    game: ir.Game, module: "GameModule", changes: Values, check_requires: bool = True
) -> Any:
    """Returns the game's `Params` with some values replaced.

    The arguments and errors are those of `param_values`.
    """
    values = param_values(game, changes, check_requires)
    defaults = module.default_params()
    changed = {param: values[param.name] for param in game.params if param.name in changes}
    return defaults.replace(**_arrays(defaults, changed))


def _arrays(defaults: Any, values: Mapping[ir.Param, Any]) -> dict[str, Any]:
    """Returns values as arrays with the dtypes of the game, by the names of their attributes."""
    import jax
    import jax.numpy as jnp

    arrays = {}
    # Known numbers have to stay known even if another function is being traced.
    with jax.ensure_compile_time_eval():
        for param, value in values.items():
            attribute = param_attribute(param.name)
            dtype = getattr(defaults, attribute).dtype
            arrays[attribute] = jnp.asarray(np.array(param_value(value, param.type)), dtype)
    return arrays


def admitted_params(game: ir.Game, module: "GameModule", params: Any) -> Any:
    """Returns a `Params` if the game accepts its values; Python's numbers in it become arrays.

    The values of traced arrays aren't known yet. If there are any, each other value is checked
    alone: neither a `require` nor whether whole numbers stay in int32.

    Raises:
      ValueError: as `param_values`, and for the shape or dtype of an array.
    """
    import jax

    from sjdsl.runtime.arguments import check_arrays

    defaults = module.default_params()
    check_arrays(params, defaults)
    known: dict[str, Any] = {}
    numbers: list[ir.Param] = []  # that aren't arrays yet
    for param in game.params:
        leaf = getattr(params, param_attribute(param.name))
        if isinstance(leaf, jax.core.Tracer):
            continue
        value = np.asarray(leaf).tolist()
        if param.type.kind == "word":
            value = _decoded(param.name, value, param.type)
        known[param.name] = value
        if not isinstance(leaf, jax.Array):
            numbers.append(param)
    values = _replaced(game, known)
    if len(known) == len(game.params):
        _check_together(game, values, known, check_requires=True)
    return params.replace(**_arrays(defaults, {param: values[param.name] for param in numbers}))


def _decoded(name: str, value: Any, type_: ir.Type) -> Any:
    """Returns the enum values with some numbers. Raises ValueError if there is none."""
    if isinstance(value, list):
        return [_decoded(name, entry, type_) for entry in value]
    if not 0 <= value < len(type_.words):
        raise ValueError(
            f"`{name}` is the number of a word, 0 .. {len(type_.words) - 1} "
            f"({', '.join(type_.words)}), not {value}"
        )
    return type_.words[value]


def param_values(game: ir.Game, changes: Values, check_requires: bool = True) -> dict[str, Any]:
    """Returns the value of every param by name, some replaced; indexed ones as nested tuples.

    Args:
      changes: by name, a number or an enum value. For an indexed param it is a mapping from enum
        values, numbers or numbers of agents, whole or in part, or nested sequences in the order of
        its entries.
      check_requires: whether the `require`s of the game must hold.

    Raises:
      ValueError: a name or an enum value is unknown, a value is outside its limits, a `require`
        fails, whole numbers of the rules could leave int32, or an episode would have no step.
    """
    values = _replaced(game, changes)
    _check_together(game, values, changes, check_requires)
    return values


def _replaced(game: ir.Game, changes: Values) -> dict[str, Any]:
    """Returns the value of every param; each changed one is checked alone."""
    values = {p.name: p.value for p in game.params}
    for name, value in changes.items():
        param = next((p for p in game.params if p.name == name), None)
        if param is None:
            raise ValueError(f"the game has no parameter `{name}`{meant(name, values, 'it has')}")
        values[name] = _merged(name, values[name], value, param.type.indexed_by, param.type)
    return values


def _check_together(game: ir.Game, values: Values, changes: Values, check_requires: bool) -> None:
    """Raises ValueError if a `require` fails, or if a whole number could leave int32."""
    for check in game.checks:
        if check_requires and check.kind == "require" and not holds(check.values[0], values):
            test = expression_text(check.values[0])
            raise ValueError(f"these parameters fail a check of the game: require {test}")
    problems = beyond_int32(game, values) if changes else []
    if problems:
        place = f"{problems[0].span.file}:{problems[0].span.line}"
        raise ValueError(f"{_limit(game, values, changes)}: {problems[0].message} ({place})")


def _limit(game: ir.Game, values: Values, changes: Values) -> str:
    """Returns which of the changed values is too large or too small, and what it may be at most.

    The limit holds with the other values as they are.
    """
    for param in game.params:
        if param.name not in changes or not isinstance(param.value, int):
            continue

        def is_playable(number: int, name: str = param.name) -> bool:
            return not beyond_int32(game, {**values, name: number})

        if is_playable(param.value):
            value = values[param.name]
            nearest = boundary(param.value, value, is_playable)
            side = "most" if value > nearest else "least"
            return f"`{param.name}` is {value}, and can be {nearest} at {side}"
    numbers = ", ".join(f"{name}: {values[name]}" for name in changes)
    return f"with these parameters a whole number leaves 32 bits ({numbers})"


def _merged(name: str, old: Any, value: Any, by: tuple[IndexSet, ...], type_: ir.Type) -> Any:
    """Returns the checked value of a param, with the old entries that it leaves out.

    Args:
      name: of the param or entry, for errors.
      by: its indices.
    """
    if not by:
        return _checked(name, value, type_)
    keys = by[0].keys
    if isinstance(value, Mapping):
        entries = {str(key): entry for key, entry in value.items()}
        for key in entries:
            if key not in keys:
                raise ValueError(f"`{name}` has no entry `{key}`; its {_entries_text(by[0])}")
        return tuple(
            _merged(f"{name}[{key}]", old_entry, entries[key], by[1:], type_)
            if key in entries
            else old_entry
            for key, old_entry in zip(keys, old, strict=True)
        )
    listed = value.tolist() if hasattr(value, "tolist") else value
    if not isinstance(listed, Sequence) or isinstance(listed, str) or len(listed) != len(keys):
        raise ValueError(f"`{name}` wants {len(keys)} values: its {_entries_text(by[0])}")
    return tuple(
        _merged(f"{name}[{key}]", old_entry, entry, by[1:], type_)
        for key, old_entry, entry in zip(keys, old, listed, strict=True)
    )


def _entries_text(index: IndexSet) -> str:
    """Returns what the entries of an index are."""
    match index.kind:
        case "word":
            return f"words are {', '.join(index.names)}"
        case "number":
            return f"entries are {index}"
        case _:
            return f"entries are the agents 0 .. {len(index) - 1}"


def _checked(name: str, value: Any, type_: ir.Type) -> Any:
    """Returns a value as a number of Python or an enum value, if the type has it."""
    if type_.kind == "word":
        if value not in type_.words:
            raise ValueError(f"`{name}` is one of {', '.join(type_.words)}, not {value!r}")
        return value
    number = plain_number(value)
    if isinstance(number, bool) or not isinstance(number, int | float) or number != number:
        raise ValueError(f"`{name}` is a number ({type_.unit}), not {value!r}")
    if type_.kind == "int" and isinstance(number, float) and not number.is_integer():
        raise ValueError(f"`{name}` is a whole number ({type_.unit}), not {value!r}")
    low = max(type_.low, -MAX_VALUE)
    high = min(type_.high, MAX_VALUE)
    nearest = min(max(number, low), high)
    is_rounded = (
        type_.kind == "real"
        and abs(number) <= 2 * MAX_VALUE
        and isclose(number, nearest, rel_tol=ROUNDING)
    )
    if number != nearest and not is_rounded:
        raise ValueError(f"`{name}` is {number}, outside {number_text(low)} .. {number_text(high)}")
    return int(number) if type_.kind == "int" else float(number)
