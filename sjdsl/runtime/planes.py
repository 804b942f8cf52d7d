"""The meaning of the planes of an observation, without JAX."""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class TokenPlane:
    """One uint8 plane of an observation.

    encoding: of a `word` plane, value v means `labels[v]`; of a `bits` plane, bit k means
    `labels[k]`; a `number` plane has numbers, 0 .. `high`.
    uniform: whether the value is the same in all cells of a window, as for a field of the observer;
    networks and rollouts need it only once.
    """

    name: str
    encoding: Literal["word", "bits", "number"]
    labels: tuple[str, ...] = ()
    high: int = 0
    uniform: bool = False

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the plane's one-hot channels, in order."""
        if self.encoding == "number":
            return (self.name,)
        return tuple(f"{self.name}: {label}" for label in self.labels)


def channel_names(planes: tuple[TokenPlane, ...]) -> tuple[str, ...]:
    """Returns the names of all one-hot channels, plane by plane."""
    return tuple(name for plane in planes for name in plane.channels)
