"""Random numbers of an episode for traces: the keys made from its seed, and the actions of the random policy.

Source: the counter-based generator of JAX (`jax.random.key`, `split`, `randint`; threefry-2x32, partitionable).
"""

from dataclasses import dataclass, field

from sjdsl.interpreter.threefry import WORD, Draws, threefry

JAX_ROUNDS = 20

Key = tuple[int, int]


@dataclass
class Heard:
    """Words that were looked at since the last account, by stream and number."""

    source: Draws
    words: dict[tuple[int, int], int] = field(default_factory=dict)

    def word(self, stream: int, number: int) -> int:
        self.words[stream, number] = self.source.word(stream, number)
        return self.words[stream, number]


def key_of(seed: int) -> Key:
    """Returns the two words of `jax.random.key(seed)`."""
    return 0, seed & WORD


def split(key: Key, count: int) -> list[Key]:
    """Returns the keys of `jax.random.split(key, count)`."""
    return [threefry(key, (0, number), JAX_ROUNDS) for number in range(count)]


def fold_in(key: Key, number: int) -> Key:
    """Returns the key of `jax.random.fold_in(key, number)`."""
    return threefry(key, (0, number & WORD), JAX_ROUNDS)


def random_numbers(key: Key, count: int, below: int) -> list[int]:
    """Returns `jax.random.randint(key, (count,), 0, below)`: two words a number, so that every number is as likely as any other."""
    high, low = split(key, 2)
    weight = (2**16 % below) ** 2 % below
    found = []
    for number in range(count):
        (a, b), (c, d) = threefry(high, (0, number), JAX_ROUNDS), threefry(low, (0, number), JAX_ROUNDS)
        found.append((((a ^ b) % below * weight + (c ^ d) % below) & WORD) % below)
    return found
