"""One moment of an episode: a state, and what the step that led to it did and paid."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from sjdsl.render.snapshot import Snapshot


@dataclass(frozen=True)
class Moment:
    """One moment.

    snapshot: what a picture shows; actions: number of each agent's action in the last step, `()` at the start of an episode;
    reward: `[N]` float of that step; events: its counts that are not zero, a number or `[N]`; done: the episode is over.
    """

    snapshot: Snapshot
    actions: tuple[int, ...]
    reward: np.ndarray
    events: Mapping[str, np.ndarray]
    done: bool
