"""Random bits for test play: keys of every step of an episode, and draws biased so that rare events happen often.

Both engines take the same draws, so a seed and an episode number stand for the same play on both.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from sjdsl.interpreter.threefry import WORD, Draws, Threefry

if TYPE_CHECKING:
    from jax import Array

RESET, STEP, POLICY = 0x52535400, 0x53544500, 0x504F4C00  # streams of an episode's own key
Bias = Literal["fair", "mixed", "good", "bad"]
BIASES: tuple[Bias, ...] = ("fair", "mixed", "good", "bad")


def episode_key(seed: int, episode: int) -> Threefry:
    """Returns the source of all keys of an episode."""
    return Threefry(seed & WORD, episode & WORD)


def reset_key(key: Threefry) -> Threefry:
    """Returns the key of the phase `start`."""
    return Threefry(key.bits(RESET, 0), key.bits(RESET, 1))


def step_key(key: Threefry, step: int) -> Threefry:
    """Returns the key of a step."""
    return Threefry(key.bits(STEP, 2 * step), key.bits(STEP, 2 * step + 1))


def policy_bits(key: Threefry, step: int, agents: int) -> list[tuple[int, int]]:
    """Returns the two 32-bit random numbers that each agent's policy gets in a step."""
    own = Threefry(key.bits(POLICY, 2 * step), key.bits(POLICY, 2 * step + 1))
    return [(own.bits(0, 2 * agent), own.bits(0, 2 * agent + 1)) for agent in range(agents)]


@dataclass(frozen=True)
class BiasedDraws:
    """Random draws with a bias: small numbers make every possible chance happen, large ones only certain ones.

    `fair`: as drawn; `good`: all small; `mixed`: half of them of any size, so that each branch of a chain happens at times; `bad`: large.
    Any number can be drawn in a game. So a violation under a bias is a real one, and only its probability is not told.
    """

    source: Draws
    bias: Bias

    def bits(self, stream: int, number: int) -> int:
        bits = self.source.bits(stream, number)
        match self.bias:
            case "good":
                return bits >> 24
            case "mixed":
                return bits >> (bits & 31) if bits & 32 else bits
            case "bad":
                return bits | 0xFF000000
            case _:
                return bits


def biased(draw: "Callable[..., Array]") -> "Callable[..., Array]":
    """Returns a function of `runtime.random_bits` whose key has a third word: the bias of what it draws, by its place in BIASES."""

    def drawn(key: "Array", *more: Any) -> "Array":
        import jax.numpy as jnp

        word = draw(key[:2], *more)
        mixed = jnp.where((word & 32) != 0, word >> (word & 31), word)
        found: Array = jnp.select(
            [key[2] == 1, key[2] == 2, key[2] == 3],
            [mixed, word >> 24, word | jnp.uint32(0xFF000000)],
            word,
        )
        return found

    return drawn
