"""Packs observations into as few bytes as their planes need, for rollouts and the replay buffer.

A plane of six words takes three bits of its byte; several planes go into one byte where they fit, none into two.
"""

from dataclasses import dataclass

import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.planes import TokenPlane

BYTE = 8


@dataclass(frozen=True)
class Packing:
    """Where each plane's bits are."""

    places: tuple[tuple[int, int, int], ...]  # of each plane: number of the byte, lowest bit, number of bits
    window: tuple[int, int]  # rows and columns

    @property
    def num_bytes(self) -> int:
        """Bytes of a cell."""
        return 1 + max(byte for byte, _, _ in self.places)

    def pack(self, observation: Array) -> Array:
        """Returns `[..., P, rows, cols]` uint8 as `[..., bytes, rows * cols]` uint8."""
        cells = observation.reshape(*observation.shape[:-2], -1)  # rows would be too short for vector instructions
        packed = []
        for number in range(self.num_bytes):
            inside = [cells[..., plane, :] << jnp.uint8(low) for plane, (byte, low, _) in enumerate(self.places) if byte == number]
            together = inside[0]
            for bits in inside[1:]:
                together = together | bits
            packed.append(together)
        return jnp.stack(packed, axis=-2)

    def unpack(self, packed: Array) -> Array:
        """Returns the observation that `pack` packed."""
        planes = [(packed[..., byte, :] >> jnp.uint8(low)) & jnp.uint8(2**bits - 1) for byte, low, bits in self.places]
        cells = jnp.stack(planes, axis=-2)
        return cells.reshape(*cells.shape[:-1], *self.window)


def make_packing(planes: tuple[TokenPlane, ...], window: tuple[int, int]) -> Packing:
    """Returns the packing of planes, each into the first byte that has room."""
    used: list[int] = []
    places = []
    for plane in planes:
        bits = bits_of(plane)
        byte = next((number for number, taken in enumerate(used) if taken + bits <= BYTE), len(used))
        if byte == len(used):
            used.append(0)
        places.append((byte, used[byte], bits))
        used[byte] += bits
    return Packing(tuple(places), window)


def bits_of(plane: TokenPlane) -> int:
    """Returns how many bits a plane's largest value needs."""
    match plane.encoding:
        case "word":
            return max(len(plane.labels) - 1, 1).bit_length()
        case "bits":
            return max(len(plane.labels), 1)
        case "number":
            return max(plane.high, 1).bit_length()
