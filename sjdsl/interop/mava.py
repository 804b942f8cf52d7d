"""Mava adapter: a compiled game as a `MarlEnv`, which is an environment of Jumanji with a few attributes more."""

import importlib
from functools import cache, cached_property, wraps
from typing import Any, Literal, NamedTuple

import jax
import jax.numpy as jnp
from flax import struct
from jax import Array

from sjdsl.extras import needs
from sjdsl.interop.copies import Copied
from sjdsl.interop.spaces import channel_bounds
from sjdsl.library.factory import make as make_game
from sjdsl.runtime.env import Encoding

with needs("mava"):
    from jumanji import Environment, specs
    from jumanji.types import TimeStep, restart, truncation

SCENARIO = "sjdsl"  # the name of our games in Mava's configuration


class Observation(NamedTuple):
    """The observations of the agents, as in `mava.types`.

    agents_view: `[N, features]` or `[N, rows, cols, channels]` float32; action_mask: `[N, A]` bool, the actions that are allowed;
    step_count: `[N]` int32, steps since the episode began.
    """

    agents_view: Array
    action_mask: Array
    step_count: Array


class ObservationGlobalState(NamedTuple):
    """The same with the input of a central critic, a copy for each agent: `[N, size]` or `[N, rows, cols, N * channels]` float32."""

    agents_view: Array
    action_mask: Array
    global_state: Array
    step_count: Array


@struct.dataclass
class State:
    """The state of the game, and the key of its next step."""

    key: Array
    game: Any


class MavaGame(Copied, Environment):
    """One environment of a game, without autoreset, which Mava's and Jumanji's wrappers do.

    Rewards and discounts are `[N]` float32, the rewards raw. An episode's last step has discount 1 where it is cut off, 0 where the rules
    end it. `timestep.extras` has the `events` and `metrics` of the step by name; at the first timestep of an episode all events are 0.

    Attributes:
      env: the `sjdsl.Environment`; num_agents; action_dim: how many actions there are; time_limit: the length of an episode.
    """

    def __init__(
        self,
        game: str,
        observation: Encoding = "onehot",
        flat: bool = True,
        global_state: Literal["observations", "state"] | None = None,
        common_reward: bool = False,
        **arguments: Any,
    ) -> None:
        """Makes the environment.

        Args:
          game, observation, arguments: of `sjdsl.make`.
          flat: whether observations are vectors; otherwise `[rows, cols, channels]`, for convolutions.
          global_state: adds `observation.global_state`: all agents' observations, or the state's vector.
          common_reward: whether every agent gets the sum of all rewards.
        Raises:
          ValueError: there is no such global state.
        """
        if global_state not in (None, "observations", "state"):
            raise ValueError(f"global_state must be None, `observations` or `state`, not {global_state!r}")
        self.env = make_game(game, observation=observation, **arguments)
        self.num_agents, self.action_dim, self.time_limit = self.env.num_agents, self.env.num_actions, self.env.episode_length
        self._flat, self._global_state, self._common_reward = flat, global_state, common_reward
        key, actions = jax.random.key(0), jnp.zeros(self.num_agents, jnp.int32)
        self._first = jax.eval_shape(lambda: self.env.reset(key))[1]
        self._events = jax.eval_shape(lambda state: self.env.step_env(key, state, actions), self._first)[-1]["events"]
        super().__init__()

    def __repr__(self) -> str:
        return f"MavaGame({self.env!r})"

    def reset(self, key: Array) -> tuple[State, TimeStep]:
        """Returns the first state and timestep of an episode."""
        key, first = jax.random.split(key)
        view, game = self.env.reset(first)
        nothing = {name: jnp.zeros(count.shape, count.dtype) for name, count in self._events.items()}
        extras = {"events": nothing, "metrics": self.env.module.measures(game, self.env.params)}
        return State(key, game), restart(self._observation(view, game), extras, (self.num_agents,), jnp.float32)

    def step(self, state: State, action: Array) -> tuple[State, TimeStep]:
        """Plays one step. `action`: `[N]` integers."""
        key, now = jax.random.split(state.key)
        view, game, reward, done, info = self.env.step_env(now, state.game, action)
        reward = jnp.broadcast_to(reward.sum(), reward.shape) if self._common_reward else reward
        discount = jnp.where(info["terminated"], jnp.zeros_like(reward), jnp.ones_like(reward))
        extras = {"events": info["events"], "metrics": info["metrics"]}
        made = truncation(reward, self._observation(view, game), discount, extras)
        made.step_type = jnp.where(done, made.step_type, jnp.ones_like(made.step_type))
        return State(key, game), made

    @cached_property
    def observation_spec(self) -> specs.Spec:
        """The spec of all agents' observations."""
        seen = jax.eval_shape(self._observation, jax.eval_shape(self.env.observe, self._first), self._first)
        greatest = {"agents_view": float(channel_bounds(self.env).max()), "action_mask": True, "step_count": self.time_limit}
        if self._global_state is not None:
            greatest["global_state"] = greatest["agents_view"] if self._global_state == "observations" else 1.0
        least = {"global_state": -1.0 if self._global_state == "state" else 0.0}
        parts = {
            name: specs.BoundedArray(leaf.shape, leaf.dtype, least.get(name, 0), greatest[name], name)
            for name, leaf in seen._asdict().items()
        }
        return specs.Spec(type(seen), "ObservationSpec", **parts)

    @cached_property
    def action_spec(self) -> specs.MultiDiscreteArray:
        """The spec of all agents' actions, `[N]` int32."""
        return specs.MultiDiscreteArray(jnp.full(self.num_agents, self.action_dim), jnp.int32, "action")

    @cached_property
    def reward_spec(self) -> specs.Array:
        """The spec of all agents' rewards."""
        return specs.Array((self.num_agents,), jnp.float32, "reward")

    @cached_property
    def discount_spec(self) -> specs.BoundedArray:
        """The spec of all agents' discounts."""
        return specs.BoundedArray((self.num_agents,), jnp.float32, 0.0, 1.0, "discount")

    def _observation(self, observation: Array, game: Any) -> Any:
        alone, together = observation_classes()
        views = jnp.moveaxis(observation, 1, -1).astype(jnp.float32)
        views = views.reshape(self.num_agents, -1) if self._flat else views
        mask = self.env.allowed_actions(game)
        count = jnp.broadcast_to(jnp.asarray(game.step, jnp.int32), (self.num_agents,))
        if self._global_state is None:
            return alone(agents_view=views, action_mask=mask, step_count=count)
        whole = self.env.state_vector(game) if self._global_state == "state" else jnp.concatenate(list(views), axis=-1)
        everywhere = jnp.broadcast_to(whole, (self.num_agents, *whole.shape))
        return together(agents_view=views, action_mask=mask, global_state=everywhere, step_count=count)


@cache
def observation_classes() -> tuple[type, type]:
    """Returns Mava's own classes, which its central critics test for, or ours if Mava isn't installed."""
    try:
        theirs = importlib.import_module("mava.types")
        return theirs.Observation, theirs.ObservationGlobalState
    except (ModuleNotFoundError, AttributeError):  # another package is also named `mava`
        return Observation, ObservationGlobalState


def register() -> None:
    """Makes our games available to Mava's scripts as `env=sjdsl env.game=NAME`; calling it again changes nothing.

    NAME is a bundled or installed game, or the path of a `.sj` file; `env.kwargs` has the arguments of `MavaGame`.
    """
    from hydra.core.config_store import ConfigStore
    from omegaconf import OmegaConf

    make_env: Any = importlib.import_module("mava.utils.make_env")
    theirs = make_env.make
    if getattr(theirs, "makes_compiled_games", False):
        return

    @wraps(theirs)
    def make(config: Any, add_global_state: bool = False) -> Any:
        if config.env.scenario.name != SCENARIO:
            return theirs(config, add_global_state)
        arguments = {
            "global_state": "observations" if add_global_state else None,
            **OmegaConf.to_container(config.env.kwargs, resolve=True),
        }
        return make_env.add_extra_wrappers(MavaGame(config.env.game, **arguments), MavaGame(config.env.game, **arguments), config)

    make.makes_compiled_games = True  # type: ignore[attr-defined]
    make_env.make = make
    ConfigStore.instance().store(
        group="env",
        name=SCENARIO,
        node={
            "game": "???",  # Hydra's marker for a required value
            "env_name": SCENARIO,
            "scenario": {"name": SCENARIO, "task_name": "${env.game}"},
            "eval_metric": "episode_return",
            "implicit_agent_id": False,
            "log_win_rate": False,
            "kwargs": {},
        },
    )
