"""Words for playing: the keys of every step of an episode, and words that make what is unlikely happen often.

Both engines take the same: a course or an episode is one seed and one number.
"""

from dataclasses import dataclass
from typing import Literal

from sjdsl.interpreter.threefry import WORD, Draws, Threefry

RESET, STEP, POLICY = 0x52535400, 0x53544500, 0x504F4C00  # streams of an episode's own key
Luck = Literal["fair", "mixed", "good", "bad"]
LUCKS: tuple[Luck, ...] = ("fair", "mixed", "good", "bad")


def episode_key(seed: int, episode: int) -> Threefry:
    """Returns the words from which all keys of an episode are made."""
    return Threefry(seed & WORD, episode & WORD)


def reset_key(key: Threefry) -> Threefry:
    """Returns the key of the phase `start`."""
    return Threefry(key.word(RESET, 0), key.word(RESET, 1))


def step_key(key: Threefry, step: int) -> Threefry:
    """Returns the key of a step."""
    return Threefry(key.word(STEP, 2 * step), key.word(STEP, 2 * step + 1))


def policy_words(key: Threefry, step: int, agents: int) -> list[tuple[int, int]]:
    """Returns the two words that each agent's policy has in a step."""
    own = Threefry(key.word(POLICY, 2 * step), key.word(POLICY, 2 * step + 1))
    return [(own.word(0, 2 * agent), own.word(0, 2 * agent + 1)) for agent in range(agents)]


@dataclass(frozen=True)
class Lucky:
    """Words with luck: a small word makes every chance come that can come, a large one none but certain ones.

    `fair`: as drawn; `good`: all small; `mixed`: half of them of any size, so that each branch of a chain comes now and then; `bad`: all
    large. Any words may come up in a game, so what breaks under these is broken; only how often is not told.
    """

    source: Draws
    luck: Luck

    def word(self, stream: int, number: int) -> int:
        word = self.source.word(stream, number)
        match self.luck:
            case "good":
                return word >> 24
            case "mixed":
                return word >> (word & 31) if word & 32 else word
            case "bad":
                return word | 0xFF000000
            case _:
                return word


@dataclass(frozen=True)
class SameForAll:
    """Words that do not depend on the sentence that draws: two sentences that say the same of two agents draw alike."""

    source: Draws

    def word(self, stream: int, number: int) -> int:
        del stream
        return self.source.word(0, number)
