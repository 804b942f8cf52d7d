"""JAX's random number functions in plain integers, and draws that are recorded for traces.

Source: the counter-based generator of JAX (`jax.random.key`, `split`, `randint`; threefry-2x32,
partitionable).
"""

from dataclasses import dataclass, field

from sjdsl.interpreter.threefry import WORD, Draws, threefry
from sjdsl.runtime.episode_keys import EpisodeKeys

JAX_ROUNDS = 20

Key = tuple[int, int]


@dataclass
class RecordedDraws:
    """Draws that remember the random numbers since the last account, by stream and number."""

    source: Draws
    numbers: dict[tuple[int, int], int] = field(default_factory=dict)

    def bits(self, stream: int, number: int) -> int:
        bits = self.source.bits(stream, number)
        self.numbers[stream, number] = bits
        return bits


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
    """Returns `jax.random.randint(key, (count,), 0, below)`.

    Each number takes 64 random bits, so that all are almost equally likely.
    """
    high_key, low_key = split(key, 2)
    weight = (2**16 % below) ** 2 % below  # 2^32 modulo `below`
    numbers = []
    for index in range(count):
        high = _random_bits(high_key, index) % below
        low = _random_bits(low_key, index) % below
        numbers.append(((high * weight + low) & WORD) % below)
    return numbers


def _random_bits(key: Key, index: int) -> int:
    """Returns an entry of `jax.random.bits(key, ...)`, 32 bits."""
    first, second = threefry(key, (0, index), JAX_ROUNDS)
    return first ^ second
