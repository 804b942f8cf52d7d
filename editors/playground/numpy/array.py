"""Arrays in plain Python: a flat list with a shape."""

import operator
from collections.abc import Callable, Iterator, Sequence
from itertools import product
from math import prod
from typing import Any

from .dtypes import bool_, common, dtype, dtype_of, int64

Shape = tuple[int, ...]


class ndarray:
    """An array. flat: its elements in C order, which `reshape` shares; everything else that gives an array copies."""

    __slots__ = ("dtype", "flat", "shape")
    __hash__ = None  # type: ignore[assignment]
    __array_priority__ = 1

    def __init__(self, flat: list[Any], shape: Shape, type_: dtype) -> None:
        assert len(flat) == prod(shape), (len(flat), shape)
        self.flat, self.shape, self.dtype = flat, shape, type_

    # ---- what it is

    @property
    def size(self) -> int:
        return len(self.flat)

    @property
    def ndim(self) -> int:
        return len(self.shape)

    @property
    def T(self) -> "ndarray":
        rows, cols = self.shape
        return ndarray(
            [self.flat[row * cols + col] for col in range(cols) for row in range(rows)],
            (cols, rows),
            self.dtype,
        )

    def __len__(self) -> int:
        return self.shape[0]

    def __iter__(self) -> Iterator[Any]:
        return (self[number] for number in range(len(self)))

    def __bool__(self) -> bool:
        if self.size != 1:
            raise ValueError("the truth of an array with several elements is not clear")
        return bool(self.flat[0])

    def __int__(self) -> int:
        return int(self.item())

    def __float__(self) -> float:
        return float(self.item())

    __index__ = __int__

    def item(self) -> Any:
        (value,) = self.flat
        return value

    def tolist(self) -> Any:
        plain = [float(v) for v in self.flat] if self.dtype.kind == "f" else self.flat
        return _nested(plain, self.shape)

    def __repr__(self) -> str:
        return f"array({self.tolist()}, {self.dtype.name})"

    # ---- others of it

    def astype(self, asked: Any) -> "ndarray":
        type_ = dtype_of(asked)
        return ndarray([type_.cast(value) for value in self.flat], self.shape, type_)

    def copy(self) -> "ndarray":
        return ndarray(list(self.flat), self.shape, self.dtype)

    def reshape(self, *shape: Any) -> "ndarray":
        wanted = (
            tuple(shape[0]) if len(shape) == 1 and isinstance(shape[0], tuple | list) else shape
        )
        if -1 in wanted:
            rest = prod(n for n in wanted if n != -1)
            wanted = tuple(self.size // rest if n == -1 else n for n in wanted)
        return ndarray(self.flat, wanted, self.dtype)

    def reduced(
        self, fn: Callable[[list[Any]], Any], axis: int | None, type_: dtype | None = None
    ) -> Any:
        """Returns `fn` of all elements, or of those along an axis."""
        if axis is None:
            return fn(self.flat)
        axis %= self.ndim
        outer, length, inner = (
            prod(self.shape[:axis]),
            self.shape[axis],
            prod(self.shape[axis + 1 :]),
        )
        found = [
            fn(self.flat[o * length * inner + i : (o + 1) * length * inner : inner])
            for o, i in product(range(outer), range(inner))
        ]
        shape = self.shape[:axis] + self.shape[axis + 1 :]
        return ndarray(found, shape, type_ or self.dtype) if shape else found[0]

    def any(self, axis: int | None = None) -> Any:
        return self.reduced(any, axis, bool_)

    def all(self, axis: int | None = None) -> Any:
        return self.reduced(all, axis, bool_)

    def sum(self, axis: int | None = None) -> Any:
        return self.reduced(sum, axis, int64 if self.dtype.kind in "biu" else self.dtype)

    def min(self, axis: int | None = None) -> Any:
        return self.reduced(min, axis)

    def max(self, axis: int | None = None) -> Any:
        return self.reduced(max, axis)

    # ---- parts of it

    def __getitem__(self, key: Any) -> Any:
        places, shape = self._places(key)
        if shape is None:
            return self.flat[places[0]]
        return ndarray([self.flat[place] for place in places], shape, self.dtype)

    def __setitem__(self, key: Any, value: Any) -> None:
        places, shape = self._places(key)
        if isinstance(value, ndarray | list | tuple):
            values = _stretched(as_array(value), shape or ())
        else:
            values = [value] * len(places)
        cast = self.dtype.cast
        for place, new in zip(places, values, strict=True):
            self.flat[place] = cast(new)

    def _places(self, key: Any) -> tuple[list[int], Shape | None]:
        """Returns where the elements of a part are, and its shape; None for a single element."""
        keys = list(key) if isinstance(key, tuple) else [key]
        if Ellipsis in [k for k in keys if not isinstance(k, ndarray | list)]:
            at = next(i for i, k in enumerate(keys) if k is Ellipsis)
            keys[at : at + 1] = [slice(None)] * (self.ndim + 1 - len(keys))
        keys = [part for k in keys for part in _without_mask(k)]
        keys += [slice(None)] * (self.ndim - sum(k is not None for k in keys))
        listed = [k for k in keys if isinstance(k, ndarray)]
        joint = joined_shape([k.shape for k in listed])
        together = [0] * prod(
            joint
        )  # what the listed numbers of all axes come to; they stand where the first of them stands
        offset, axis, place, shape, choices = 0, 0, None, [], []
        for k in keys:
            if k is None:
                shape.append((1,))
                choices.append([0])
                continue
            length, stride = self.shape[axis], prod(self.shape[axis + 1 :])
            axis += 1
            if isinstance(k, slice):
                choices.append([number * stride for number in range(*k.indices(length))])
                shape.append((len(choices[-1]),))
            elif isinstance(k, ndarray):
                if place is None:
                    place = len(choices)
                    choices.append(together)
                    shape.append(joint)
                for at, number in enumerate(_stretched(k, joint)):
                    together[at] += _inside(int(number), length) * stride
            else:
                offset += _inside(operator.index(k), length) * stride
        if not choices:
            return [offset], None
        if len(choices) == 1:
            return [offset + part for part in choices[0]], sum(shape, ())
        return [offset + sum(parts) for parts in product(*choices)], sum(shape, ())

    # ---- arithmetic

    def __neg__(self) -> "ndarray":
        return ndarray([-value for value in self.flat], self.shape, self.dtype)

    def __invert__(self) -> "ndarray":
        return apply(operator.not_, self) if self.dtype is bool_ else apply(operator.invert, self)


def _without_mask(key: Any) -> list[Any]:
    """Returns a key as keys of one axis each: a mask, or a list, as arrays of numbers."""
    if isinstance(key, list):
        key = as_array(key) if key else ndarray([], (0,), int64)
    if isinstance(key, ndarray) and key.dtype is bool_:
        return list(nonzero(key))
    return [key]


def _inside(number: int, length: int) -> int:
    if not -length <= number < length:
        raise IndexError(f"{number} is outside an axis of {length}")
    return number % length


def _nested(flat: Sequence[Any], shape: Shape) -> Any:
    if not shape:
        return flat[0]
    if len(shape) == 1:
        return list(flat)
    inner = prod(shape[1:])
    return [_nested(flat[n * inner : (n + 1) * inner], shape[1:]) for n in range(shape[0])]


def as_array(value: Any, asked: Any = None) -> ndarray:
    """Returns an array of a number, of nested sequences, or of arrays."""
    if isinstance(value, ndarray):
        return value if asked is None or dtype_of(asked) is value.dtype else value.astype(asked)
    shape, flat = _flattened(value)
    type_ = common(flat) if asked is None else dtype_of(asked)
    return ndarray([type_.cast(v) for v in flat], shape, type_)


def _flattened(value: Any) -> tuple[Shape, list[Any]]:
    if isinstance(value, ndarray):
        return value.shape, list(value.flat)
    if not isinstance(value, list | tuple):
        return (), [value]
    inner = [_flattened(entry) for entry in value]
    shapes = {shape for shape, _ in inner}
    if len(shapes) > 1:
        raise ValueError("rows of different lengths")
    return (len(inner), *(shapes.pop() if shapes else ())), [v for _, flat in inner for v in flat]


def nonzero(array: ndarray) -> tuple[ndarray, ...]:
    """Returns the numbers of the elements that are not zero, an array for each axis."""
    found = [
        at for at, value in zip(product(*map(range, array.shape)), array.flat, strict=True) if value
    ]
    return tuple(
        ndarray([at[axis] for at in found], (len(found),), int64) for axis in range(array.ndim)
    )


def joined_shape(shapes: list[Shape]) -> Shape:
    """Returns the shape that several are broadcast to."""
    joint: list[int] = []
    for shape in shapes:
        joint = [1] * (len(shape) - len(joint)) + joint
        for axis in range(1, len(shape) + 1):
            if joint[-axis] == 1:
                joint[-axis] = shape[-axis]
            elif shape[-axis] not in (1, joint[-axis]):
                raise ValueError(f"shapes do not fit: {shapes}")
    return tuple(joint)


def _stretched(array: ndarray, shape: Shape) -> list[Any]:
    """Returns the elements of an array that is broadcast to a shape."""
    if array.shape == shape:
        return array.flat
    if array.size == 1:
        return array.flat * prod(shape)
    own = (1,) * (len(shape) - array.ndim) + array.shape
    if any(n not in (1, wanted) for n, wanted in zip(own, shape, strict=True)):
        raise ValueError(f"{array.shape} is not broadcast to {shape}")
    steps = [0 if n == 1 else prod(own[axis + 1 :]) for axis, n in enumerate(own)]
    places = [0]
    for wanted, step in zip(shape, steps, strict=True):
        places = [place + n * step for place in places for n in range(wanted)]
    return [array.flat[place] for place in places]


def broadcast_to(value: Any, shape: Shape) -> ndarray:
    array = as_array(value)
    return ndarray(list(_stretched(array, tuple(shape))), tuple(shape), array.dtype)


def apply(fn: Callable[..., Any], *values: Any, type_: dtype | None = None) -> Any:
    """Returns a function of each element, of arrays broadcast to one shape; of numbers alone a number."""
    arrays = [as_array(value) for value in values]
    shape = joined_shape([array.shape for array in arrays])
    found = list(map(fn, *(_stretched(array, shape) for array in arrays)))
    if not shape:
        return found[0]
    chosen = type_ or _of_result(found, arrays)
    return ndarray([chosen.cast(v) for v in found] if chosen.kind != "O" else found, shape, chosen)


def _of_result(found: list[Any], arrays: list[ndarray]) -> dtype:
    """Returns the type of a result: of one kind with an array that goes into it, that array's."""
    plain = common(found) if found else arrays[0].dtype
    return (
        next((a.dtype for a in arrays if a.shape and a.dtype.kind == plain.kind), plain)
        if plain.kind not in "iuf"
        else _number(plain, arrays)
    )


def _number(plain: dtype, arrays: list[ndarray]) -> dtype:
    """Returns the type of numbers: that of the arrays, the widest of them, if they say; numbers of Python beside them do not count."""
    types = [a.dtype for a in arrays if a.shape]
    of_kind = [t for t in types if (t.kind == "f") == (plain.kind == "f") and t.kind != "b"]
    if not of_kind or (plain.kind == "f" and any(t.kind in "iu" for t in types)):
        return plain
    return max(of_kind, key=lambda t: _WIDTH[t.name])


_WIDTH = {"uint8": 0, "uint16": 1, "int32": 2, "int64": 3, "float32": 0, "float64": 1}


def _ahead(fn: Callable[[Any, Any], Any], type_: dtype | None = None) -> tuple[Any, Any, Any]:
    def forward(left: ndarray, right: Any) -> Any:
        return apply(fn, left, right, type_=type_)

    def backward(left: ndarray, right: Any) -> Any:
        return apply(fn, right, left, type_=type_)

    def in_place(left: ndarray, right: Any) -> ndarray:
        left.flat[:] = _stretched(apply(fn, left, right, type_=left.dtype), left.shape)
        return left

    return forward, backward, in_place


for _name, _fn in {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "truediv": operator.truediv,
    "floordiv": operator.floordiv,
    "mod": operator.mod,
    "and": operator.and_,
    "or": operator.or_,
    "xor": operator.xor,
}.items():
    for _sort, _method in zip(("", "r", "i"), _ahead(_fn), strict=True):
        setattr(ndarray, f"__{_sort}{_name}__", _method)
for _name in ("lt", "le", "gt", "ge", "eq", "ne"):
    setattr(ndarray, f"__{_name}__", _ahead(getattr(operator, _name), bool_)[0])
