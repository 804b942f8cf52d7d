"""A training run as pure functions (init, collect, learn), the same for every algorithm."""

from collections.abc import Callable
from dataclasses import dataclass, replace
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
    # [] bool, the loss or a parameter was not finite in some update; since then nothing is learnt
    diverged: Array
    own: Any = ()  # what a user's own algorithm also keeps; the bundled ones pass it on

    @classmethod
    def start(cls, key: Array, learner: Any, worlds: Worlds) -> "TrainState":
        """Returns the state before the first update."""
        return cls(key, learner, worlds, updates=jnp.int32(0), diverged=jnp.bool_(False))

    def after_update(self, key: Array, learner: Any, loss: Array) -> "TrainState":
        """Returns the state after an update whose loss isn't finite if it has diverged."""
        return replace(
            self,
            key=key,
            learner=learner,
            updates=self.updates + 1,
            diverged=~jnp.isfinite(loss),
        )


def with_parameters(state: TrainState, parameters: Any) -> TrainState:
    """Returns a state whose learner, of flax, has other parameters."""
    return replace(state, learner=replace(state.learner, params=parameters))


@dataclass(frozen=True)
class Train:
    """A training run as pure functions, which can be jitted, and vmapped or mapped over seeds."""

    # key -> state before the first update
    init: Callable[[Array], TrainState]
    # plays; what was played goes to `learn`
    collect: Callable[[TrainState], tuple[TrainState, Any]]
    # gradient steps on what was played
    learn: Callable[[TrainState, Any], tuple[TrainState, Metrics]]
    # of the agents' networks, from a state
    parameters: Callable[[TrainState], Any]
    # a state with other parameters, of a policy trained before
    adopt: Callable[[TrainState, Any], TrainState] | None = None
    # from parameters, and whether to act greedily: as `trained_policy`
    policy: Callable[[Any, bool | None], Policy] | None = None
    # whether a loop over seeds may be faster than `vmap`; not if a state is large, as it would be
    # copied
    loops: bool = True

    def update(self, state: TrainState) -> tuple[TrainState, Metrics]:
        """Plays and learns."""
        return self.learn(*self.collect(state))


def keep_if_finite(loss: Array, new: Any, old: Any, diverged: Array) -> tuple[Any, Array]:
    """Returns `new` and the loss, or `old` and NaN.

    The latter if the loss or an entry of `new` isn't finite, or the run has diverged before. So the
    last good parameters survive a run that diverges, even if the memory of `old` is reused. If one
    of several parallel seeds diverges, it keeps its parameters while the others continue.
    """
    numbers = [leaf for leaf in jax.tree.leaves(new) if jnp.issubdtype(leaf.dtype, jnp.floating)]
    are_finite = jnp.stack([jnp.isfinite(leaf).all() for leaf in numbers]).all()
    good = ~diverged & jnp.isfinite(loss) & are_finite
    kept = jax.tree.map(lambda new, old: jnp.where(good, new, old), new, old)
    return kept, jnp.where(good, loss, jnp.nan)
