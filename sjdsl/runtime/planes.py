"""The meaning of the planes of an observation, without JAX."""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class TokenPlane:
    """One uint8 plane of an observation.

    encoding `word`: value v means `labels[v]`; `bits`: bit k means `labels[k]`; `number`: the value itself, 0 .. `high`.
    uniform: the value is the same in all cells of a window, as for a field of the observer; networks and rollouts need it only once.
    """

    name: str
    encoding: Literal["word", "bits", "number"]
    labels: tuple[str, ...] = ()
    high: int = 0
    uniform: bool = False

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the one-hot channels this plane becomes, in order."""
        return (
            (self.name,)
            if self.encoding == "number"
            else tuple(f"{self.name}: {label}" for label in self.labels)
        )


def channel_names(planes: tuple[TokenPlane, ...]) -> tuple[str, ...]:
    """Returns the names of all one-hot channels, plane by plane."""
    return tuple(name for plane in planes for name in plane.channels)
