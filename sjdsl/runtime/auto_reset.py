"""Auto-reset: starts the next episode where one has ended, at low cost if none has."""

from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array, lax
from jax.custom_batching import custom_vmap

from sjdsl.runtime.forms import by_platform
from sjdsl.runtime.varying import either

State = Any
Params = Any


def reset_where(
    reset: Callable[[Params, Array], State], done: Array, words: Array, params: Params, state: State
) -> State:
    """Returns the first state of an episode where `done`, else `state`."""
    return by_platform(
        partial(_if_any_is_done, reset),
        partial(_always_computed, reset),
        done,
        words,
        params,
        state,
    )


def _always_computed(
    reset: Callable[[Params, Array], State], done: Array, words: Array, params: Params, state: State
) -> State:
    """The form for GPUs: a reset costs a few kernels, but a branch would wait for the host."""
    stored = lax.optimization_barrier(done)

    def chosen(new: Array, old: Array) -> Array:
        return jnp.where(stored if jnp.ndim(old) else done, new, old)

    return jax.tree.map(chosen, reset(params, words), state)


def _if_any_is_done(
    reset: Callable[[Params, Array], State], done: Array, words: Array, params: Params, state: State
) -> State:
    """The form for CPUs: resets of a batch are computed only if an environment is done.

    A `select` in every step would cost more than most phases. A second `vmap` around it, or a
    derivative, turns the choice back into a select, with the same values.
    """

    def plain(done: Array, words: Array, params: Params, state: State) -> State:
        return either(done, lambda: reset(params, words), lambda: state)

    cheap = custom_vmap(plain)

    @cheap.def_vmap
    def batched(
        size: int, in_batched: Any, done: Array, words: Array, params: Params, state: State
    ) -> tuple[State, Any]:
        """Resets in one `cond` for the whole batch: under `vmap`, each environment would reset."""
        done_batched, words_batched, params_batched, state_batched = in_batched

        def whole(leaf: Array, is_batched: bool) -> Array:
            return leaf if is_batched else jnp.broadcast_to(leaf, (size, *leaf.shape))

        state = jax.tree.map(whole, state, state_batched)
        done = whole(done, done_batched)
        axis_of_params = jax.tree.map(lambda is_batched: 0 if is_batched else None, params_batched)
        axes = (axis_of_params, 0 if words_batched else None)

        def chosen(new: Array, old: Array) -> Array:
            return jnp.where(done.reshape((size,) + (1,) * (old.ndim - 1)), new, old)

        def fresh() -> State:
            new = jax.vmap(reset, in_axes=axes, axis_size=size)(params, words)
            return jax.tree.map(chosen, new, state)

        all_batched = jax.tree.map(lambda _: True, state)
        return either(jnp.any(done), fresh, lambda: state), all_batched

    choose = jax.custom_jvp(cheap)  # JAX has no reverse-mode derivative of a `custom_vmap`

    @choose.defjvp
    def derivative(values: Any, changes: Any) -> tuple[State, State]:
        return jax.jvp(plain, values, changes)

    return choose(done, words, params, state)
