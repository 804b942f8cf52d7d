"""NumPy in the place of JAX: generated modules run as they are written, line by line, without compilation.

What JAX does differently from NumPy is done JAX's way: indices past the end are clamped where an array is read and dropped where it
is written, arrays are never changed in place, numbers written in the text have no dtype of their own. One thing is stricter: two
different values written to one place are an error here (under JAX either may win).
"""

import builtins
import contextlib
import dataclasses
import importlib.util
import warnings
from collections.abc import Callable
from functools import cache
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np

from sjdsl.compiler.ir.operations import CALCULATIONS

NUMBERS = {
    "float32": np.float32,
    "int32": np.int32,
    "uint32": np.uint32,
    "uint8": np.uint8,
    "bool_": np.bool_,
}
NARROW = {
    np.dtype(np.float64): np.float32,
    np.dtype(np.int64): np.int32,
    np.dtype(np.uint64): np.uint32,
}


class Array(np.ndarray):
    """An array that is indexed as JAX's are."""

    def __getitem__(self, index: Any) -> Any:
        return as_array(np.ndarray.__getitem__(self, _clamped(index, self.shape)))

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        plain = [x.view(np.ndarray) if type(x) is Array else x for x in inputs]
        try:
            result = getattr(ufunc, method)(*plain, **options)
        except OverflowError:  # a number of the text beside unsigned ones: JAX lets it wrap
            unsigned = next(
                x.dtype
                for x in plain
                if isinstance(x, np.ndarray | np.generic) and x.dtype.kind == "u"
            )
            wrapped = [
                np.asarray(x % 2 ** (8 * unsigned.itemsize)).astype(unsigned)
                if type(x) is int
                else x
                for x in plain
            ]
            result = getattr(ufunc, method)(*wrapped, **options)
        return result.view(Array) if type(result) is np.ndarray else result

    @property
    def at(self) -> "At":
        return At(self)


@dataclasses.dataclass(frozen=True)
class At:
    """`array.at`; with an index, one place of it."""

    array: Array
    index: Any = None

    def __getitem__(self, index: Any) -> "At":
        return At(self.array, index)

    def set(
        self, values: Any, mode: str = "", wrap_negative_indices: bool = True, **_: Any
    ) -> Array:
        """Returns a copy with the values in their places; raises AssertionError if two that differ want one place."""
        result = np.array(self.array)
        index, values = self._inside(values, wrap_negative_indices)
        result[index] = values
        if (
            mode == "promise_in_bounds"
        ):  # kernels only, that know what they do: agents that are nowhere share a place
            return as_array(result)
        read_back = np.asarray(result[index])
        wanted = np.broadcast_to(np.asarray(values).astype(result.dtype), read_back.shape)
        assert np.array_equal(read_back, wanted, equal_nan=result.dtype.kind == "f"), (
            "two values for one place"
        )
        return as_array(result)

    def get(self, mode: str, wrap_negative_indices: bool = True) -> Array:
        """Returns the values of the places; of one past the end the last value, as JAX documents it for this mode."""
        assert mode == "promise_in_bounds"
        assert wrap_negative_indices or (np.asarray(self.index) >= 0).all()
        array = np.asarray(self.array)
        return as_array(
            array[np.minimum(self.index, len(array) - 1)]
            if not isinstance(self.index, tuple)
            else array[self.index]
        )

    def add(self, values: Any, **_: Any) -> Array:
        """Returns a copy with the values added, as often as their places are named."""
        result = np.array(self.array)
        index, values = self._inside(values)
        np.add.at(result, index, np.asarray(values).astype(result.dtype))
        return as_array(result)

    def max(self, values: Any, **_: Any) -> Array:
        """Returns a copy in which each place has the greatest of its value and those given for it."""
        return self._folded(np.maximum, values)

    def min(self, values: Any, **_: Any) -> Array:
        return self._folded(np.minimum, values)

    def _folded(self, fold: Any, values: Any) -> Array:
        result = np.array(self.array)
        index, values = self._inside(values)
        fold.at(result, index, np.asarray(values).astype(result.dtype))
        return as_array(result)

    def _inside(self, values: Any, negative: bool = True) -> tuple[Any, Any]:
        """Returns the index and the values without those whose place is outside. `negative`: whether such numbers count from the end."""
        parts = self.index if isinstance(self.index, tuple) else (self.index,)
        numbers = [np.asarray(p) for p in parts if not isinstance(p, slice)]
        if len(numbers) < len(parts):
            assert all(n.ndim == 0 for n in numbers), f"arrays beside slices: {parts}"
            return parts, values
        arrays = np.broadcast_arrays(*numbers)
        shape = self.array.shape
        assert len(arrays) <= len(shape), (parts, shape)
        inside = np.ones(arrays[0].shape, bool)
        for array, size in zip(arrays, shape, strict=False):
            inside &= (array >= (-size if negative else 0)) & (array < size)
        rest = shape[len(arrays) :]
        spread = np.broadcast_to(np.asarray(values), (*inside.shape, *rest))
        return tuple(a[inside] for a in arrays), spread[inside]


def as_array(value: Any, dtype: Any = None) -> Any:
    """Returns an array; a number written in the text as JAX would keep it (32 bits)."""
    made = np.asarray(value, dtype)
    if dtype is None and made.dtype in NARROW:
        made = made.astype(NARROW[made.dtype])
    return made.view(Array)


def _clamped(index: Any, shape: tuple[int, ...]) -> Any:
    parts = index if isinstance(index, tuple) else (index,)
    given = sum(p is not None and p is not Ellipsis for p in parts)
    result, axis = [], 0
    for part in parts:
        if part is Ellipsis:
            axis += len(shape) - given
        elif isinstance(part, np.ndarray | np.integer) and np.asarray(part).dtype.kind in "iu":
            size = shape[axis]
            part = np.clip(np.asarray(part).astype(np.int64), -size, size - 1)
            axis += 1
        elif part is not None:
            axis += 1
        result.append(part)
    return tuple(result)


def _wrapping(function: Callable[..., Any]) -> Callable[..., Any]:
    def wrapped(*args: Any, **options: Any) -> Any:
        options.pop("mode", None)
        return as_array(function(*args, **options))

    return wrapped


def where(condition: Any, a: Any, b: Any) -> Array:
    """Returns a or b; two numbers of the text become 32 bits wide."""
    if all(isinstance(x, int | float) and not isinstance(x, bool | np.generic) for x in (a, b)):
        a, b = (as_array(x) for x in (a, b))
    return as_array(np.where(condition, a, b))


def _namespace() -> SimpleNamespace:
    same = ("zeros", "ones", "full", "arange", "sum", "any", "all", "max", "min", "argmax", "clip", "take_along_axis",
            "concatenate", "broadcast_to", "zeros_like", "full_like", "stack", "eye", "select", "rot90", "repeat", "ones_like",
            "moveaxis", "split", "add", "logical_or", "sqrt")  # fmt: skip
    calculating = {
        row.array.removeprefix("jnp.")
        for row in CALCULATIONS.values()
        if row.array.startswith("jnp.")
    }
    return SimpleNamespace(
        asarray=as_array,
        where=where,
        issubdtype=np.issubdtype,
        dtype=np.dtype,
        inf=np.inf,
        **{name: _wrapping(getattr(np, name)) for name in {*same, *calculating}},
        **NUMBERS,
    )


def _while_loop(test: Callable[[Any], Any], body: Callable[[Any], Any], state: Any) -> Any:
    while bool(test(state)):
        state = body(state)
    return state


def _fori_loop(low: int, high: int, body: Callable[[int, Any], Any], state: Any) -> Any:
    for i in range(low, high):
        state = body(i, state)
    return state


class _CustomVmap:
    """A function that says how it is batched; nothing is batched here."""

    def __init__(self, function: Callable[..., Any]):
        self.function = function

    def __call__(self, *arguments: Any) -> Any:
        return self.function(*arguments)

    def def_vmap(self, rule: Callable[..., Any]) -> Callable[..., Any]:
        return rule


def _pad(array: Any, value: Any, edges: list[tuple[int, int, int]]) -> Array:
    return as_array(
        np.pad(
            np.asarray(array),
            [(low, high) for low, high, _ in edges],
            constant_values=np.asarray(value),
        )
    )


def _reduce_window(
    array: Any,
    start: Any,
    add: Any,
    size: tuple[int],
    step: tuple[int],
    padding: list[tuple[int, int]],
) -> Array:
    assert add == "add"
    assert size == step
    padded = np.pad(np.asarray(array), padding, constant_values=start)
    return as_array(padded.reshape(-1, *size).sum(axis=1, dtype=padded.dtype))


def _reduce(
    arrays: Any, start: Any, together: Callable[[Any, Any], Any], axes: tuple[int, ...]
) -> Any:
    """Returns the arrays with one axis folded from its first entry to its last, by a function of tuples."""
    (axis,) = axes
    result = start
    for i in range(arrays[0].shape[axis]):
        result = together(result, tuple(np.take(np.asarray(a), i, axis=axis) for a in arrays))
    return tuple(as_array(r) for r in result)


def _dynamic_slice(array: Any, starts: tuple[Any, ...], sizes: tuple[int, ...]) -> Array:
    begin = [
        min(max(int(s), 0), n - size) for s, n, size in zip(starts, array.shape, sizes, strict=True)
    ]
    return as_array(
        np.asarray(array)[tuple(slice(b, b + size) for b, size in zip(begin, sizes, strict=True))]
    )


def _dynamic_index_in_dim(array: Any, index: Any, axis: int, keepdims: bool) -> Array:
    assert not keepdims
    return as_array(
        np.take(np.asarray(array), np.clip(int(index), 0, array.shape[axis] - 1), axis=axis)
    )


def _select_n(which: Any, *cases: Any) -> Array:
    """Returns for each place the case of its number; the first for False, the second for True."""
    number, arrays = np.asarray(which).astype(int), [np.asarray(case) for case in cases]
    assert len({(a.shape, a.dtype) for a in arrays}) == 1, "cases are alike in shape and type"
    assert ((number >= 0) & (number < len(cases))).all()
    return as_array(np.choose(np.broadcast_to(number, arrays[0].shape), arrays))


def _bitcast(array: Any, dtype: Any) -> Array:
    """Returns the bits of numbers as numbers of another type; of a narrower one along one more axis."""
    bits = np.ascontiguousarray(np.asarray(array)[..., None]).view(dtype)
    return as_array(
        bits[..., 0] if bits.dtype.itemsize == np.asarray(array).dtype.itemsize else bits
    )


def _vmap(function: Callable[..., Any]) -> Callable[..., Any]:
    return lambda *arrays: as_array(np.stack([function(*row) for row in zip(*arrays, strict=True)]))


def _on_cpu(cpu: Callable[..., Any], gpu: Callable[..., Any], *arguments: Any) -> Any:
    del gpu
    return cpu(*arguments)


def _dataclass(cls: type) -> type:
    made = dataclasses.dataclass(frozen=True)(cls)
    made.replace = dataclasses.replace  # type: ignore[attr-defined]
    return made


JNP = _namespace()
LAX = SimpleNamespace(
    while_loop=_while_loop,
    fori_loop=_fori_loop,
    pad=_pad,
    add="add",
    dynamic_slice=_dynamic_slice,
    reduce=_reduce,
    reduce_window=_reduce_window,
    select_n=_select_n,
    dynamic_index_in_dim=_dynamic_index_in_dim,
    population_count=_wrapping(np.bitwise_count),
    bitcast_convert_type=_bitcast,
)
JAX = SimpleNamespace(
    numpy=JNP,
    lax=LAX,
    jit=lambda f, **_: f,
    vmap=_vmap,
    Array=Array,
    dtypes=SimpleNamespace(),
    random=SimpleNamespace(),
    ensure_compile_time_eval=contextlib.nullcontext,
)
STANDING_IN = {
    "jax": JAX,
    "jax.numpy": JNP,
    "jax.custom_batching": SimpleNamespace(custom_vmap=_CustomVmap),
    "flax": SimpleNamespace(struct=SimpleNamespace(dataclass=_dataclass)),
    "sjdsl.runtime.forms": SimpleNamespace(
        by_platform=_on_cpu, one_function=lambda kernel, **_: kernel
    ),
    "sjdsl.runtime.varying": SimpleNamespace(
        settled=lambda _, start: start, either=lambda test, yes, no: yes() if bool(test) else no()
    ),
}


def _import(
    name: str, names: Any = None, local: Any = None, fromlist: Any = (), level: int = 0
) -> Any:
    if name in STANDING_IN:
        return STANDING_IN[name] if fromlist or "." not in name else STANDING_IN[name.split(".")[0]]
    if name.startswith("sjdsl.runtime."):
        return kernel(name)
    if name == "sjdsl.runtime" and fromlist:
        return SimpleNamespace(**{one: kernel(f"{name}.{one}") for one in fromlist})
    return builtins.__import__(name, names, local, fromlist, level)


@cache
def kernel(name: str) -> ModuleType:
    """Returns a module of `sjdsl.runtime` on NumPy."""
    spec = importlib.util.find_spec(name)
    assert spec is not None and spec.origin is not None
    with open(spec.origin, encoding="utf-8") as file:
        return load(file.read(), name)


def load(text: str, name: str) -> ModuleType:
    """Returns a module's text as a module on NumPy."""
    module = ModuleType(f"numpy.{name}")
    module.__dict__["__builtins__"] = {**vars(builtins), "__import__": _import}
    with warnings.catch_warnings(
        action="error"
    ):  # what Python warns of is a mistake in a generated text
        exec(compile(text, f"<{name} on NumPy>", "exec"), module.__dict__)
    return module
