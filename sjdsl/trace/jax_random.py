"""JAX's random number functions in plain integers (keys, `split`, `randint`), and draws that are recorded for traces.

Source: the counter-based generator of JAX (`jax.random.key`, `split`, `randint`; threefry-2x32, partitionable).
"""

from dataclasses import dataclass, field

from sjdsl.interpreter.threefry import WORD, Draws, threefry
from sjdsl.runtime.episode_keys import EpisodeKeys

JAX_ROUNDS = 20

Key = tuple[int, int]


@dataclass
class RecordedDraws:
    """Draws that remember the random numbers taken since the last account, by stream and index."""

    source: Draws
    numbers: dict[tuple[int, int], int] = field(default_factory=dict)

    def bits(self, stream: int, number: int) -> int:
        self.numbers[stream, number] = self.source.bits(stream, number)
        return self.numbers[stream, number]


def key_of(seed: int) -> Key:
    """Returns the two 32-bit numbers of `jax.random.key(seed)`."""
    return 0, seed & WORD


def split(key: Key, count: int) -> list[Key]:
    """Returns the keys of `jax.random.split(key, count)`."""
    return [threefry(key, (0, number), JAX_ROUNDS) for number in range(count)]


def fold_in(key: Key, number: int) -> Key:
    """Returns the key of `jax.random.fold_in(key, number)`."""
    return threefry(key, (0, number & WORD), JAX_ROUNDS)


def keys_of(seed: int) -> EpisodeKeys[Key]:
    """Returns the keys of the episode of a seed."""
    return EpisodeKeys(key_of(seed), fold_in)


def random_numbers(key: Key, count: int, below: int) -> list[int]:
    """Returns `jax.random.randint(key, (count,), 0, below)`: two 32-bit draws a number, so that all numbers are equally likely."""
    high, low = split(key, 2)
    weight = (2**16 % below) ** 2 % below
    found = []
    for number in range(count):
        (a, b), (c, d) = (
            threefry(high, (0, number), JAX_ROUNDS),
            threefry(low, (0, number), JAX_ROUNDS),
        )
        found.append((((a ^ b) % below * weight + (c ^ d) % below) & WORD) % below)
    return found
