"""Packs observations into as few bytes as their planes need, for rollouts and the replay buffer.

A plane of six words takes three bits of its byte; several planes go into one byte where they fit, none into two. Uniform planes are packed
once for a window, the others in each of its cells.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.planes import TokenPlane

BYTE = 8


@dataclass(frozen=True)
class Part:
    """Where the bits of some planes are, in each of a number of cells."""

    cells: int
    places: tuple[
        tuple[int, int, int, int], ...
    ]  # of each plane: its index, number of the byte, lowest bit, number of bits

    @property
    def num_bytes(self) -> int:
        """Bytes of a cell."""
        return max((byte + 1 for _, byte, _, _ in self.places), default=0)

    def pack(self, planes: Array) -> list[Array]:
        """Returns the bytes, `[..., cells]` uint8 each, of planes `[..., P, cells or more]`."""
        packed: list[Array] = []
        for number in range(self.num_bytes):
            inside = [
                planes[..., plane, : self.cells] << jnp.uint8(low)
                for plane, byte, low, _ in self.places
                if byte == number
            ]
            together = inside[0]
            for bits in inside[1:]:
                together = together | bits
            packed.append(together)
        return packed

    def unpack(self, packed: Array) -> dict[int, Array]:
        """Returns the planes, `[..., cells]` each, of bytes `[..., num_bytes * cells]`."""
        each = packed.reshape(*packed.shape[:-1], self.num_bytes, self.cells)
        return {
            plane: (each[..., byte, :] >> jnp.uint8(low)) & jnp.uint8(2**bits - 1)
            for plane, byte, low, bits in self.places
        }


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
        planes = observation.reshape(
            *observation.shape[:-2], -1
        )  # rows would be too short for vector instructions
        return jnp.concatenate([byte for part in self.parts for byte in part.pack(planes)], axis=-1)

    def unpack(self, packed: Array) -> Array:
        """Returns the observation that `pack` packed."""
        local, uniform = self.parts
        by_cell, once = jnp.split(packed, [local.num_bytes * local.cells], axis=-1)
        found = local.unpack(by_cell) | uniform.unpack(once)
        planes = [
            jnp.broadcast_to(found[plane], (*packed.shape[:-1], local.cells))
            for plane in range(len(found))
        ]
        observation = jnp.stack(planes, axis=-2)
        return observation.reshape(*observation.shape[:-1], *self.window)


def make_packing(planes: Sequence[TokenPlane], window: tuple[int, int]) -> Packing:
    """Returns the packing of planes, each into the first byte that has room."""
    return Packing((_part(planes, False, math.prod(window)), _part(planes, True, 1)), window)


def _part(planes: Sequence[TokenPlane], uniform: bool, cells: int) -> Part:
    used: list[int] = []
    places = []
    for index, plane in enumerate(planes):
        if plane.uniform != uniform:
            continue
        bits = bits_of(plane)
        byte = next(
            (number for number, taken in enumerate(used) if taken + bits <= BYTE), len(used)
        )
        if byte == len(used):
            used.append(0)
        places.append((index, byte, used[byte], bits))
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
