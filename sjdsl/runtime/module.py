"""The contents of a generated module: all that an environment needs to know of its game."""

from collections.abc import Callable
from typing import Any, Protocol

from jax import Array

from sjdsl.runtime.fields import StateField
from sjdsl.runtime.planes import TokenPlane


class GameModule(Protocol):
    """The names of a generated module, with N agents and A actions."""

    NAME: str
    TITLE: str
    HASH: str  # equal for two games if and only if their rules are
    ACTIONS: tuple[str, ...]
    NUM_AGENTS: int
    FORBIDS_ACTIONS: bool  # whether `allowed_actions` is ever false
    MAP: tuple[str, ...]
    PAD: int  # cells around the map, on each side
    FRAME: tuple[int, int]  # rows and columns of the map with that
    WINDOW: tuple[int, int]  # rows and columns that an agent sees
    TOKEN_PLANES: tuple[TokenPlane, ...]
    # Counts of a step: name, attribute of Outcome, entry of its last axis.
    EVENTS: tuple[tuple[str, str, int | None], ...]
    FIELDS: tuple[StateField, ...]  # declared fields, in the order of the state vector
    ROLE: str | None  # attribute of State with the agents' roles, if no step writes it

    default_params: Callable[[], Any]
    initial_state: Callable[[], Any]  # all that is declared; nobody stands on the map
    reset: Callable[[Any, Array], Any]  # params, key words -> state
    # state, actions [N], params, key words -> state, outcome
    step: Callable[[Any, Array, Any, Array], tuple[Any, Any]]
    observe: Callable[[Any, Any], Array]  # state, params -> [N, P, rows, columns] uint8
    measures: Callable[[Any, Any], dict[str, Array]]  # state, params -> float32 scalars
    allowed_actions: Callable[[Any, Any], Array]  # state, params -> [N, A] bool
    episode_length: Callable[[Any], Array]  # params -> int32 scalar


class TrialsModule(GameModule, Protocol):
    """A generated module whose episodes have several trials: State has `world_trial`, from 0."""

    NUM_TRIALS: int
    trial_length: Callable[[Any], Array]  # params -> int32 scalar
    # state, whether its trial is the last, params, key words -> the first state of the next trial,
    # or of the next episode
    next_trial: Callable[[Any, Array, Any, Array], Any]
