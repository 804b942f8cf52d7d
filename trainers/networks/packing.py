"""Packs observations into as few bytes as their planes need, for rollouts and the replay buffer.

A plane of six words takes three bits of its byte; several planes go into one byte where they fit,
none into two. Uniform planes are packed once for a window, the others in each of its cells.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.planes import TokenPlane

BYTE = 8


class Place(NamedTuple):
    """Where the bits of a plane are in a cell."""

    plane: int
    byte: int
    low: int  # the lowest bit
    bits: int


@dataclass(frozen=True)
class Part:
    """Where the bits of some planes are, in each of a number of cells."""

    cells: int
    places: tuple[Place, ...]

    @property
    def num_bytes(self) -> int:
        """Bytes of a cell."""
        return max((place.byte + 1 for place in self.places), default=0)

    def pack(self, planes: Array) -> list[Array]:
        """Returns the bytes, `[..., cells]` uint8 each, of planes `[..., P, cells or more]`."""
        packed: dict[int, Array] = {}
        for place in self.places:
            bits = planes[..., place.plane, : self.cells] << jnp.uint8(place.low)
            if place.byte in packed:
                bits = packed[place.byte] | bits
            packed[place.byte] = bits
        return [*packed.values()]

    def unpack(self, packed: Array) -> dict[int, Array]:
        """Returns the planes, `[..., cells]` each, of bytes `[..., num_bytes * cells]`."""
        by_byte = packed.reshape(*packed.shape[:-1], self.num_bytes, self.cells)
        planes = {}
        for place in self.places:
            shifted = by_byte[..., place.byte, :] >> jnp.uint8(place.low)
            planes[place.plane] = shifted & jnp.uint8(2**place.bits - 1)
        return planes


@dataclass(frozen=True)
class Packing:
    """How windows are packed: planes with a value for each cell, then uniform ones."""

    parts: tuple[Part, Part]
    window: tuple[int, int]  # rows and columns

    @property
    def size(self) -> int:
        """Bytes of a window."""
        return sum(part.num_bytes * part.cells for part in self.parts)

    def pack(self, observation: Array) -> Array:
        """Returns `[..., P, rows, cols]` uint8 as `[..., size]` uint8."""
        # rows would be too short for vector instructions
        planes = observation.reshape(*observation.shape[:-2], -1)
        return jnp.concatenate([byte for part in self.parts for byte in part.pack(planes)], axis=-1)

    def unpack(self, packed: Array) -> Array:
        """Returns the observation that `pack` packed."""
        local, uniform = self.parts
        by_cell, once = jnp.split(packed, [local.num_bytes * local.cells], axis=-1)
        planes = local.unpack(by_cell) | uniform.unpack(once)
        shape = (*packed.shape[:-1], local.cells)
        in_order = [jnp.broadcast_to(planes[index], shape) for index in range(len(planes))]
        observation = jnp.stack(in_order, axis=-2)
        return observation.reshape(*observation.shape[:-1], *self.window)


def make_packing(planes: Sequence[TokenPlane], window: tuple[int, int]) -> Packing:
    """Returns the packing of planes, each into the first byte that has room."""
    by_cell = _part(planes, False, math.prod(window))
    once = _part(planes, True, 1)
    return Packing((by_cell, once), window)


def _part(planes: Sequence[TokenPlane], uniform: bool, cells: int) -> Part:
    """Returns where the bits of the planes that are uniform, or aren't, go in each cell."""
    used: list[int] = []  # bits of each byte
    places = []
    for index, plane in enumerate(planes):
        if plane.uniform != uniform:
            continue
        bits = bits_of(plane)
        fitting = (byte for byte, taken in enumerate(used) if taken + bits <= BYTE)
        byte = next(fitting, len(used))
        if byte == len(used):
            used.append(0)
        places.append(Place(index, byte, used[byte], bits))
        used[byte] += bits
    return Part(cells, tuple(places))


def bits_of(plane: TokenPlane) -> int:
    """Returns how many bits a plane's largest value needs."""
    match plane.encoding:
        case "word":
            return max(len(plane.labels) - 1, 1).bit_length()
        case "bits":
            return max(len(plane.labels), 1)
        case "number":
            return max(plane.high, 1).bit_length()
