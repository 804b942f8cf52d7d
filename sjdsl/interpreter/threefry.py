"""The random number generator threefry-2x32 in plain integers, and a recorder of the numbers drawn."""

from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol, TypeVar

WORD = 0xFFFFFFFF
_PARITY = 0x1BD11BDA
_ROTATIONS = (13, 15, 26, 6, 17, 29, 16, 24)
ROUNDS = 13
_RETURN = 0x52455455
T = TypeVar("T")


class Draws(Protocol):
    """An endless table of 32-bit words, one row for each stream."""

    def word(self, stream: int, number: int) -> int:
        """Returns word `number` of `stream`."""
        ...


def threefry(
    key: tuple[int, int], counter: tuple[int, int], rounds: int = ROUNDS
) -> tuple[int, int]:
    """Returns threefry-2x32.

    Source: Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC 2011.
    """
    schedule = (*key, key[0] ^ key[1] ^ _PARITY)
    x0, x1 = (counter[0] + key[0]) & WORD, (counter[1] + key[1]) & WORD
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
    """The words of one step's key."""

    k0: int
    k1: int

    def word(self, stream: int, number: int) -> int:
        assert 0 <= stream <= WORD, stream
        assert 0 <= number <= WORD, number
        return threefry((self.k0, self.k1), (stream, number // 2))[number % 2]


class Used(NamedTuple):
    """One word that was looked at."""

    stream: int
    number: int
    word: int


class Chosen(NamedTuple):
    """A word that chose one of several. `left`: what there was to choose from, in order; `taken`: the number of the one chosen."""

    stream: int
    number: int
    left: tuple[Any, ...]
    taken: int


@dataclass
class Recorded:
    """Another source of words, with a record of what was used."""

    source: Draws
    used: list[Used] = field(default_factory=list)
    chosen: list[Chosen] = field(default_factory=list)

    def word(self, stream: int, number: int) -> int:
        word = self.source.word(stream, number)
        self.used.append(Used(stream, number, word))
        return word


def take(draws: Draws, stream: int, number: int, left: list[T]) -> tuple[T, int]:
    """Takes one out of those that are left, all equally likely, and returns it and the word that chose it."""
    word = draws.word(stream, number)
    index = word * len(left) >> 32
    if isinstance(draws, Recorded):
        draws.chosen.append(Chosen(stream, number, tuple(left), index))
    return left.pop(index), word


def return_stream(stream: int) -> int:
    """Returns the stream that agents coming back at a `tick` use in place of the statement's own."""
    return (stream ^ _RETURN) & WORD
