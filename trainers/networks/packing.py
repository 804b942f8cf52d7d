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
    """Where the bits of a plane are in a packed window."""

    first: int  # byte
    cells: int  # bytes, one for each cell, or a single one
    low: int  # the lowest bit in each of them
    bits: int


@dataclass(frozen=True)
class Packing:
    """How windows are packed: planes with a value for each cell, then uniform ones."""

    places: tuple[Place, ...]  # of each plane
    size: int  # bytes of a window
    window: tuple[int, int]  # rows and columns

    def pack(self, observation: Array) -> Array:
        """Returns `[..., P, rows, cols]` uint8 as `[..., size]` uint8."""
        # rows would be too short for vector instructions
        planes = observation.reshape(*observation.shape[:-2], -1)
        packed: dict[int, Array] = {}  # by their first byte
        for index, place in enumerate(self.places):
            bits = planes[..., index, : place.cells] << jnp.uint8(place.low)
            packed[place.first] = packed[place.first] | bits if place.low else bits
        return jnp.concatenate([packed[first] for first in sorted(packed)], axis=-1)

    def unpack(self, packed: Array) -> Array:
        """Returns the observation that `pack` packed."""
        shape = (*packed.shape[:-1], math.prod(self.window))
        planes = []
        for place in self.places:
            shifted = packed[..., place.first : place.first + place.cells] >> jnp.uint8(place.low)
            plane = shifted & jnp.uint8(2**place.bits - 1)
            planes.append(jnp.broadcast_to(plane, shape))
        observation = jnp.stack(planes, axis=-2)
        return observation.reshape(*observation.shape[:-1], *self.window)


def make_packing(planes: Sequence[TokenPlane], window: tuple[int, int]) -> Packing:
    """Returns the packing of planes, each into the first byte that has room."""
    places: dict[int, Place] = {}
    size = 0
    for uniform, cells in ((False, math.prod(window)), (True, 1)):
        used: list[int] = []  # bits of each byte
        for index, plane in enumerate(planes):
            if plane.uniform != uniform:
                continue
            bits = bits_of(plane)
            fitting = (byte for byte, taken in enumerate(used) if taken + bits <= BYTE)
            byte = next(fitting, len(used))
            if byte == len(used):
                used.append(0)
            places[index] = Place(size + byte * cells, cells, used[byte], bits)
            used[byte] += bits
        size += len(used) * cells
    return Packing(tuple(places[index] for index in range(len(planes))), size, window)


def bits_of(plane: TokenPlane) -> int:
    """Returns how many bits a plane's largest value needs."""
    match plane.encoding:
        case "word":
            return max(len(plane.labels) - 1, 1).bit_length()
        case "bits":
            return max(len(plane.labels), 1)
        case "number":
            return max(plane.high, 1).bit_length()
