"""The keys of an episode that follow from its seed: for its start, its steps, agents' choices."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

# Folded into the seed's key for the agents' choices; the start has 0, the steps 1, 2, 3, …
CHOICES = 2**32 - 1
Key = TypeVar("Key")


@dataclass(frozen=True)
class EpisodeKeys(Generic[Key]):
    """The keys of one episode.

    key: of the seed; fold_in: `(key, number) -> key`, of JAX (`jax.random.fold_in`) or of plain
    integers (`sjdsl.trace.jax_random`).
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
        """Returns the key of the agents' choices in a step, by its number from 0."""
        return self.fold_in(self.fold_in(self.key, CHOICES), number)
