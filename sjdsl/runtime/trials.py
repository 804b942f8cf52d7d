"""Trials: parts of an episode that each begin as an episode does, but for the fields kept."""

from typing import Any, TypeGuard

from jax import Array

from sjdsl.runtime.auto_reset import reset_where
from sjdsl.runtime.module import GameModule, TrialsModule

State = Any
Params = Any


def has_trials(module: GameModule) -> TypeGuard[TrialsModule]:
    """Returns whether the episodes of a game have trials."""
    return hasattr(module, "next_trial")


def steps_of_trial(module: GameModule, params: Params) -> Array:
    """Returns the steps until a trial is truncated, or the episode in a game without trials."""
    return module.trial_length(params) if has_trials(module) else module.episode_length(params)


def is_last_trial(module: TrialsModule, state: State) -> Array:
    """Returns whether a state is in the last trial of its episode."""
    last: Array = state.world_trial >= module.NUM_TRIALS - 1
    return last


def begin_trial_where(
    module: TrialsModule,
    is_over: Array,
    is_last: Array,
    words: Array,
    params: Params,
    state: State,
) -> State:
    """Returns the first state of the next trial where a trial is over, else `state`.

    After the last trial (`is_last`) the next one is of the next episode.
    """

    def begin(ended: tuple[State, Array, Params], words: Array) -> State:
        before, last, params = ended
        return module.next_trial(before, last, params, words)

    return reset_where(begin, is_over, words, (state, is_last, params), state)
