"""The two engines of a scene, the compiled step and the interpreter, set to the same state."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import jax
import numpy as np

from sjdsl.compiler.ir.names import param_attribute
from sjdsl.interpreter.observe import observe
from sjdsl.interpreter.state import Outcome, World
from sjdsl.interpreter.step import action_mask, step
from sjdsl.interpreter.stored import loaded
from sjdsl.interpreter.threefry import Threefry
from sjdsl.runtime.env import Environment
from sjdsl.testing.differences import named_counts, outcome_differences, state_differences

# XLA spends less on optimising: it would cost more than it saves in a few steps.
QUICK = {
    "xla_backend_optimization_level": 0,
    "xla_llvm_disable_expensive_passes": True,
}


@dataclass(frozen=True)
class Compiled:
    """A compiled game."""

    env: Environment
    blank: Any  # the state before the phase `start`, as NumPy arrays
    # state, params -> observation, allowed actions
    look: Callable[[Any, Any], Any]
    # key, state, actions, params -> (observation, allowed actions), state, reward, done, info
    step: Callable[[Any, Any, Any, Any], Any]


@dataclass(frozen=True)
class Numbers:
    """Run-time numbers for the compiled game and, the same bit for bit, for the interpreter."""

    compiled: Any
    interpreted: dict[str, Any]


def compile_quickly(env: Environment) -> Compiled:
    """Returns the functions of an environment that a scene needs, compiled for few runs."""

    def look(state: Any, params: Any) -> Any:
        return env.observe(state, params), env.allowed_actions(state, params)

    def whole_step(key: Any, state: Any, actions: Any, params: Any) -> Any:
        observation, state, reward, done, info = env.step_env(key, state, actions, params)
        # The other entries of `info` are the state and the observation again.
        info = {name: info[name] for name in ("truncated", "terminated", "events", "metrics")}
        return (observation, env.allowed_actions(state, params)), state, reward, done, info

    return Compiled(
        env,
        jax.device_get(env.module.initial_state()),
        jax.jit(look, compiler_options=QUICK),
        jax.jit(whole_step, compiler_options=QUICK),
    )


@lru_cache(maxsize=1024)
def key_bits(seed: int) -> tuple[int, int]:
    """Returns the two uint32 numbers of `jax.random.key(seed)`."""
    high, low = np.asarray(jax.random.key_data(jax.random.key(seed)))
    return int(high), int(low)


def interpreter_params(env: Environment, params: Any) -> dict[str, Any]:
    """Returns the parameters of the compiled step for the interpreter, the same bit for bit."""
    return {
        param.name: loaded(np.asarray(getattr(params, param_attribute(param.name))), param.type)
        for param in env.game.params
    }


@dataclass
class Stepped:
    """The result of a step, as plain numbers."""

    state: Any
    world: World
    seen: tuple[np.ndarray, np.ndarray]  # observation, allowed actions
    reward: list[float]
    events: dict[str, Any]
    metrics: dict[str, float]
    terminated: bool
    truncated: bool


def take_step(
    compiled: Compiled,
    state: Any,
    world: World,
    actions: Sequence[int],
    numbers: Numbers,
    seed: int,
) -> Stepped:
    """Takes a step on both engines with the same draws.

    Raises AssertionError if the results differ.
    """
    env = compiled.env
    world, outcome = step(env.game, world, actions, numbers.interpreted, Threefry(*key_bits(seed)))
    seen, state, reward, _, info = compiled.step(
        jax.random.key(seed), state, np.asarray(actions, np.int32), numbers.compiled
    )
    observation, allowed = map(np.asarray, seen)
    differences = [
        *state_differences(env, state, world, observation, allowed),
        *outcome_differences(env, reward, info, outcome),
    ]
    if differences:
        raise AssertionError(
            "the compiled step and the interpreter differ:\n  " + "\n  ".join(differences)
        )
    return _stepped(env, state, world, (observation, allowed), outcome)


def look_at(
    compiled: Compiled, state: Any, world: World, params: Any
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the observation of a state and the allowed actions.

    Raises AssertionError if the state and the world differ.
    """
    observation, allowed = map(np.asarray, compiled.look(state, params))
    differences = state_differences(compiled.env, state, world, observation, allowed)
    if differences:
        raise AssertionError(
            "the compiled game and the interpreter differ:\n  " + "\n  ".join(differences)
        )
    return observation, allowed


def interpret_step(
    env: Environment, world: World, actions: Sequence[int], numbers: Numbers, seed: int
) -> Stepped:
    """Takes a step on the interpreter alone, with the draws that `take_step` would have.

    There is no compiled state.
    """
    world, outcome = step(env.game, world, actions, numbers.interpreted, Threefry(*key_bits(seed)))
    return _stepped(env, None, world, interpret_look(env, world), outcome)


def _stepped(
    env: Environment,
    state: Any,
    world: World,
    seen: tuple[np.ndarray, np.ndarray],
    outcome: Outcome,
) -> Stepped:
    """Returns the result of a step with the interpreter's outcome as plain numbers."""
    events: dict[str, Any] = {}
    for event in env.game.events:
        for name, counts in named_counts(event, outcome).items():
            events[name] = counts.tolist()
    return Stepped(
        state,
        world,
        seen,
        reward=[float(reward) for reward in outcome.reward],
        events=events,
        metrics={name: float(np.float32(value)) for name, value in outcome.measures.items()},
        terminated=outcome.terminated,
        truncated=outcome.truncated and not outcome.terminated,
    )


def interpret_look(env: Environment, world: World) -> tuple[np.ndarray, np.ndarray]:
    """Returns the observation of a state and the allowed actions, by the interpreter."""
    return observe(env.game, world), np.asarray(action_mask(env.game, world))
