"""A state of the interpreter as a module on NumPy has it."""

from typing import Any

from sjdsl.interpreter.state import World
from sjdsl.testing.states import compiled_state
from tests.fuzz import numpy_jax
from tests.fuzz.together import OnNumPy


def numpy_state(env: OnNumPy, world: World) -> Any:
    """Returns the compiled state that equals a world without its marks, which no rule reads."""
    state = compiled_state(env, env.module.initial_state(), world)
    return state.replace(**{name: numpy_jax.as_array(value) for name, value in vars(state).items()})
