"""A training run as pure functions (init, collect, learn), with one signature for every algorithm."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import flax
import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.policy import Policy

from .rollout import Worlds

Metrics = dict[str, Any]


@flax.struct.dataclass
class TrainState:
    """What one update hands to the next, and a checkpoint holds."""

    key: Array  # [] typed key, consumed by the next update
    learner: Any  # parameters, optimiser state, replayed steps: depends on the algorithm
    worlds: Worlds  # the B environments
    updates: Array  # [] int32, updates done
    diverged: Array  # [] bool, the loss or a parameter was not finite in some update; since then nothing is learnt
    own: Any = ()  # what a user's own algorithm also keeps; the bundled ones pass it on


@dataclass(frozen=True)
class Train:
    """A training run as pure functions, which can be jitted, and vmapped or mapped over seeds."""

    init: Callable[[Array], TrainState]  # key -> state before the first update
    collect: Callable[
        [TrainState], tuple[TrainState, Any]
    ]  # plays; what was played goes to `learn`
    learn: Callable[
        [TrainState, Any], tuple[TrainState, Metrics]
    ]  # gradient steps on what was played
    parameters: Callable[[TrainState], Any]  # of the agents' networks, from a state
    adopt: Callable[[TrainState, Any], TrainState] | None = (
        None  # a state with other parameters, of a policy trained before
    )
    policy: Callable[[Any, bool | None], Policy] | None = (
        None  # from parameters, and whether to act greedily: as `trained_policy`
    )
    loops: bool = True  # whether a loop over seeds may be faster than `vmap`; not if a state is large, as the loop would copy it

    def update(self, state: TrainState) -> tuple[TrainState, Metrics]:
        """Plays and learns."""
        return self.learn(*self.collect(state))


def keep_if_finite(loss: Array, new: Any, old: Any, diverged: Array) -> tuple[Any, Array]:
    """Returns `new` and the loss; or `old` and NaN if the loss or an entry of `new` isn't finite, or the run has diverged before.

    So the last good parameters survive a run that diverges, even if the memory of `old` is reused. If one of several parallel seeds
    diverges, it keeps its parameters while the others continue.
    """
    numbers = [leaf for leaf in jax.tree.leaves(new) if jnp.issubdtype(leaf.dtype, jnp.floating)]
    good = (
        ~diverged
        & jnp.isfinite(loss)
        & jnp.stack([jnp.isfinite(leaf).all() for leaf in numbers]).all()
    )
    return jax.tree.map(lambda a, b: jnp.where(good, a, b), new, old), jnp.where(
        good, loss, jnp.nan
    )
