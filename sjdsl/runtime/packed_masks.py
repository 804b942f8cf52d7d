"""Masks of cells that a program for GPUs keeps as words of bits: what is computed from packed masks is computed from their words.

A pick leaves the cells it took as words. The next pick's members are computed from cells that the first has changed:

    cells = where(unpack(taken), grown, cells)
    members = pack((cells == bare) & free)  ->  pack(cells before == bare) & ~taken & pack(free)

So no kernel for all cells stands between the two picks, and cells are written once, after the last.
"""

from collections.abc import Callable, Sequence
from functools import partial, reduce
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from sjdsl.runtime import bits

Words = list[Array]  # one by one, for work of which nothing is written to memory
Constant = Callable[[], Any]  # computed when it is asked for


class PackedMasks:
    """How the masks `[S]` bool of a program follow from words, and the fields `[S]` that were set where such masks hold."""

    def __init__(self) -> None:
        self._masks: dict[
            int, tuple[Any, Callable[[], Words]]
        ] = {}  # id of a mask: itself (else another could have its id), its words
        self._fields: dict[
            int, tuple[Any, Any, Any, Any]
        ] = {}  # of a field: itself, what it was, the mask where it was set, to what
        self._counted: dict[
            int, tuple[Any, Any]
        ] = {}  # of the integers 0 and 1 of a mask: themselves, the mask

    def note(
        self, name: str, given: Sequence[Any], constants: Sequence[Constant | None], result: Any
    ) -> None:
        """Notes what an equation says of a result with one axis. constants: of the operands, None for those that are none."""
        if jnp.ndim(result) != 1:
            return
        match name, given:
            case "unpack", [words]:
                self._note(result, lambda: bits.apart(words))
            case "and" | "or", [one, other] if self._is_packed(one) or self._is_packed(other):
                combined = lax.bitwise_and if name == "and" else lax.bitwise_or
                self._note(
                    result,
                    lambda: list(
                        map(
                            combined, *(self._words(each, result.shape[0]) for each in (one, other))
                        )
                    ),
                )
            case "not", [mask] if self._is_packed(mask):
                self._note(
                    result,
                    lambda: _without(_all_of(mask.shape[0]), self._words(mask, mask.shape[0])),
                )
            case "select_n", [mask, before, _] if (
                self._is_packed(mask) and (value := _number(constants[2])) is not None
            ):
                self._fields[id(result)] = result, before, mask, value
            case "eq", [one, other]:
                for field, constant in ((one, constants[1]), (other, constants[0])):
                    if id(field) in self._fields and (value := _number(constant)) is not None:
                        self._note(result, partial(self._where_equal, field, value))
            case "convert_element_type", [mask] if self._is_packed(mask):
                self._counted[id(result)] = result, mask

    def packed(self, mask: Any) -> Array | None:
        """Returns the words of a mask that follows from words, else None."""
        return jnp.stack(self._words(mask, mask.shape[0])) if self._is_packed(mask) else None

    def count(self, integers: Any) -> Array | None:
        """Returns the sum of the integers 0 and 1 of a mask that follows from words, else None."""
        if id(integers) not in self._counted:
            return None
        words = self._words(self._counted[id(integers)][1], integers.shape[0])
        return reduce(lax.add, map(lax.population_count, words)).astype(integers.dtype)

    def _note(self, mask: Any, words: Callable[[], Words]) -> None:
        self._masks[id(mask)] = mask, words

    def _is_packed(self, mask: Any) -> bool:
        return id(mask) in self._masks

    def _words(self, mask: Any, size: int) -> Words:
        if jnp.ndim(mask) == 0:  # the same for all
            return [jnp.where(mask, word, jnp.uint32(0)) for word in _all_of(size)]
        if not self._is_packed(mask):
            words = bits.apart(bits.pack(mask))
            self._note(mask, lambda: words)
        return self._masks[id(mask)][1]()

    def _where_equal(self, field: Any, value: Any) -> Words:
        if id(field) not in self._fields:
            return bits.apart(bits.pack(field == value))
        _, before, mask, written = self._fields[id(field)]
        there = self._words(mask, field.shape[0])
        elsewhere = _without(self._where_equal(before, value), there)
        return list(map(lax.bitwise_or, elsewhere, there)) if written == value else elsewhere


def _number(constant: Constant | None) -> Any:
    """Returns the number that all entries of a constant are, None if there is none."""
    entries = np.empty(0) if constant is None else np.asarray(constant())
    return entries.flat[0] if entries.size and (entries == entries.flat[0]).all() else None


def _without(words: Words, others: Words) -> Words:
    return [
        lax.bitwise_and(word, lax.bitwise_not(other))
        for word, other in zip(words, others, strict=True)
    ]


def _all_of(size: int) -> Words:
    """Returns the words of a mask `[size]` that holds everywhere."""
    full, some = divmod(size, bits.WIDTH)
    return [jnp.uint32(2**bits.WIDTH - 1)] * full + ([jnp.uint32(2**some - 1)] if some else [])
