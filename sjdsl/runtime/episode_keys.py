"""The keys that the seed of an episode gives: for its start, its steps and the agents' choices, whatever plays or shows the episode."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

CHOICES = (
    2**32 - 1
)  # folded into the seed's key for the agents' choices; the start has 0, the steps 1, 2, 3, …
Key = TypeVar("Key")


@dataclass(frozen=True)
class EpisodeKeys(Generic[Key]):
    """The keys of one episode, by JAX (`jax.random.fold_in`) or in plain integers (`sjdsl.trace.jax_random`).

    key: that of the seed. fold_in: `(key, number) -> key`.
    """

    key: Key
    fold_in: Callable[[Key, Any], Key]

    def start(self) -> Key:
        """Returns the key of the environment's `reset`."""
        return self.fold_in(self.key, 0)

    def of_step(self, number: Any) -> Key:
        """Returns the key of a step, by its number from 0."""
        return self.fold_in(self.key, number + 1)

    def of_choices(self, number: Any) -> Key:
        """Returns the key of what agents choose before a step, by its number from 0."""
        return self.fold_in(self.fold_in(self.key, CHOICES), number)
