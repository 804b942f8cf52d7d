"""The random number generator threefry-2x32 in plain integers, and a recorder of what it drew."""

from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol, TypeVar

WORD = 0xFFFFFFFF
_PARITY = 0x1BD11BDA
_ROTATIONS = (13, 15, 26, 6, 17, 29, 16, 24)
ROUNDS = 13  # as in `runtime/random_bits.py`
_RETURN = 0x52455455  # "RETU" in ASCII
T = TypeVar("T")


class Draws(Protocol):
    """Streams of random bits, 32 for each number of a stream."""

    def bits(self, stream: int, number: int) -> int:
        """Returns the 32 bits `number` of `stream`."""
        ...


def threefry(
    key: tuple[int, int], counter: tuple[int, int], rounds: int = ROUNDS
) -> tuple[int, int]:
    """Returns threefry-2x32.

    Source: Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC 2011.
    """
    schedule = (*key, key[0] ^ key[1] ^ _PARITY)
    x0 = (counter[0] + key[0]) & WORD
    x1 = (counter[1] + key[1]) & WORD
    for turn in range(rounds):
        distance = _ROTATIONS[turn % 8]
        x0 = (x0 + x1) & WORD
        x1 = ((x1 << distance | x1 >> (32 - distance)) & WORD) ^ x0
        if turn % 4 == 3:
            group = turn // 4
            x0 = (x0 + schedule[(group + 1) % 3]) & WORD
            x1 = (x1 + schedule[(group + 2) % 3] + group + 1) & WORD
    return x0, x1


@dataclass(frozen=True)
class Threefry:
    """The random bits of a key."""

    k0: int
    k1: int

    def bits(self, stream: int, number: int) -> int:
        assert 0 <= stream <= WORD, stream
        assert 0 <= number <= WORD, number
        return threefry((self.k0, self.k1), (stream, number // 2))[number % 2]


class Used(NamedTuple):
    """Random bits that were read."""

    stream: int
    number: int
    bits: int


class Chosen(NamedTuple):
    """A choice by random bits."""

    stream: int
    number: int
    left: tuple[Any, ...]  # the candidates, in order
    taken: int  # the index of the chosen one


@dataclass
class Recorded:
    """Random bits of another source, with a record of those that were read."""

    source: Draws
    used: list[Used] = field(default_factory=list)
    chosen: list[Chosen] = field(default_factory=list)

    def bits(self, stream: int, number: int) -> int:
        bits = self.source.bits(stream, number)
        self.used.append(Used(stream, number, bits))
        return bits


def take(draws: Draws, stream: int, number: int, left: list[T]) -> tuple[T, int]:
    """Removes one element of a list, all equally likely; returns it and the random bits."""
    bits = draws.bits(stream, number)
    index = bits * len(left) >> 32
    if isinstance(draws, Recorded):
        draws.chosen.append(Chosen(stream, number, tuple(left), index))
    return left.pop(index), bits


def return_stream(stream: int) -> int:
    """Returns the stream for agents that come back at a `tick`.

    It takes the place of the statement's stream.
    """
    return (stream ^ _RETURN) & WORD
