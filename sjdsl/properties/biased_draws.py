"""Random bits for test play: the keys of an episode's steps, and draws biased towards rare events.

Both engines take the same draws, so a seed and an episode number stand for the same play on both.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from sjdsl.interpreter.threefry import WORD, Draws, Threefry

if TYPE_CHECKING:
    from jax import Array

# Streams of an episode's key: "RST", "STE" and "POL" in ASCII.
RESET = 0x52535400
STEP = 0x53544500
POLICY = 0x504F4C00
Bias = Literal["fair", "mixed", "good", "bad"]
BIASES: tuple[Bias, ...] = ("fair", "mixed", "good", "bad")


def episode_key(seed: int, episode: int) -> Threefry:
    """Returns the key from which all keys of an episode are derived."""
    return Threefry(seed & WORD, episode & WORD)


def reset_key(key: Threefry) -> Threefry:
    """Returns the key of the phase `start`."""
    return Threefry(key.bits(RESET, 0), key.bits(RESET, 1))


def step_key(key: Threefry, step: int) -> Threefry:
    """Returns the key of a step."""
    return Threefry(key.bits(STEP, 2 * step), key.bits(STEP, 2 * step + 1))


def policy_bits(key: Threefry, step: int, agents: int) -> list[tuple[int, int]]:
    """Returns the two 32-bit random numbers that each agent's policy gets in a step."""
    draws = Threefry(key.bits(POLICY, 2 * step), key.bits(POLICY, 2 * step + 1))
    return [(draws.bits(0, 2 * agent), draws.bits(0, 2 * agent + 1)) for agent in range(agents)]


@dataclass(frozen=True)
class BiasedDraws:
    """Draws with a bias.

    Small numbers make every possible chance happen, large ones only certain ones.
    `fair`: as drawn; `good`: all small; `bad`: all large; `mixed`: half of them of any size, so
    that each branch of a chain happens at times.
    A game can draw any number. So a violation under a bias is a real one; only its probability
    isn't known.
    """

    source: Draws
    bias: Bias

    def bits(self, stream: int, number: int) -> int:
        """Returns the biased word of an instance in a stream."""
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
    """Returns a function of `runtime.random_bits` that draws as `BiasedDraws` does.

    Its key has a third number, the index of the bias in BIASES.
    """

    def draw_biased(key: "Array", *arguments: Any) -> "Array":
        """Returns biased words. key: three uint32, the last one the index of the bias."""

        import jax.numpy as jnp

        bits = draw(key[:2], *arguments)
        by_bias: dict[Bias, Array] = {
            "fair": bits,
            "mixed": jnp.where((bits & 32) != 0, bits >> (bits & 31), bits),
            "good": bits >> 24,
            "bad": bits | jnp.uint32(0xFF000000),
        }
        biased_bits: Array = jnp.select(
            [key[2] == number for number in range(len(BIASES))],
            [by_bias[bias] for bias in BIASES],
        )
        return biased_bits

    return draw_biased
