"""JaxMARL adapter: a compiled game as a `MultiAgentEnv`."""

from collections.abc import Mapping
from functools import partial, wraps
from typing import Any, Literal

import jax
import jax.numpy as jnp
from flax import struct
from jax import Array

from sjdsl.extras import needs
from sjdsl.interop.calls import by_name
from sjdsl.interop.copies import Copied
from sjdsl.interop.spaces import channel_bounds
from sjdsl.library.factory import make as make_environment
from sjdsl.library.games_folder import bundled
from sjdsl.runtime.env import Encoding

with needs("jaxmarl"):
    import jaxmarl
    from jaxmarl import registration
    from jaxmarl.environments import spaces
    from jaxmarl.environments.multi_agent_env import MultiAgentEnv, State

ByAgent = dict[str, Array]
# The names of our games in JaxMARL's registry begin with these: the first is for scripts that name
# files after them.
PREFIXES = ("sjdsl_", "sjdsl/")


@struct.dataclass
class GameState(State):
    """JaxMARL's `done` and `step`, and the state of the game."""

    game: Any


class JaxMARLGame(Copied, MultiAgentEnv):
    """One environment of a game; agents are `agent_0`, `agent_1` and so on, and all end together.

    Rewards are raw. Every leaf of the infos has shape `(num_agents,)`, as JaxMARL's scripts need
    it: events and metrics of the step by name, `truncated` and `terminated`. Actions may have shape
    `()` or `(1,)`.

    Attributes:
      env: the `sjdsl.Environment`; max_steps: the length of an episode.
    """

    def __init__(
        self,
        game: str,
        observation: Encoding = "onehot",
        flat: bool = True,
        world_state: Literal["observations", "state"] | None = None,
        common_reward: bool = False,
        shaped_reward: bool = False,
        terminal_observation: bool = False,
        **arguments: Any,
    ) -> None:
        """Makes the environment.

        Args:
          game, observation, arguments: of `sjdsl.make`.
          flat: whether observations are vectors, as scripts with dense or recurrent networks need,
            or `[rows, cols, channels]`; float32.
          world_state: adds `obs["world_state"]`, `[num_agents, size]`, for central critics: all
            observations, or the state's vector.
          common_reward: whether every agent gets the sum of all rewards.
          shaped_reward: adds `info["shaped_reward"]`, zeros by agent, which scripts written for
            Overcooked remove.
          terminal_observation: adds `info["terminal_observation"]`, `[num_agents, ...]`, which
            `step` would drop at an episode's end.
        Raises:
          ValueError: another `world_state`.
        """
        if world_state not in (None, "observations", "state"):
            raise ValueError(
                f"world_state must be None, `observations` or `state`, not {world_state!r}"
            )
        self.env = make_environment(game, observation=observation, **arguments)
        super().__init__(self.env.num_agents)
        self.max_steps = self.env.episode_length
        self._flat = flat
        self._world_state = world_state
        self._common_reward = common_reward
        self._shaped_reward = shaped_reward
        self._terminal_observation = terminal_observation
        _, channels, rows, cols = self.env.observation_shape
        shape = (rows * cols * channels,) if flat else (rows, cols, channels)
        box = spaces.Box(0.0, float(channel_bounds(self.env).max()), shape, jnp.float32)
        self.observation_spaces = dict.fromkeys(self.agents, box)
        self.action_spaces = dict.fromkeys(self.agents, spaces.Discrete(self.env.num_actions))

    @property
    def name(self) -> str:
        """The game's name."""
        return self.env.name

    @property
    def agent_classes(self) -> dict[str, list[str]]:
        """The agents of each role, or all of them under `agents`."""
        roles = self.env.roles
        if roles is None:
            return {"agents": list(self.agents)}
        classes: dict[str, list[str]] = {f"role_{role}": [] for role in sorted(set(roles))}
        for agent, role in zip(self.agents, roles, strict=True):
            classes[f"role_{role}"].append(agent)
        return classes

    def observation_space(self, agent: str | None = None) -> spaces.Box:
        """Returns the space of an agent; all agents have the same."""
        return self.observation_spaces[self.agents[0] if agent is None else agent]

    def action_space(self, agent: str | None = None) -> spaces.Discrete:
        """Returns the space of an agent; all agents have the same."""
        return self.action_spaces[self.agents[0] if agent is None else agent]

    def world_state_size(self) -> int:
        """Returns the size of a row of `obs["world_state"]`."""
        observations = jax.eval_shape(self.reset, jax.random.key(0))[0]
        if "world_state" not in observations:
            raise ValueError(
                "there is no world state: make the environment with "
                'world_state="observations" or "state"'
            )
        result: int = observations["world_state"].shape[1]
        return result

    @partial(jax.jit, static_argnums=(0,))
    def reset(self, key: Array) -> tuple[ByAgent, GameState]:
        """Returns the first observations and state of an episode."""
        observation, game = self.env.reset(key)
        return self._observations(observation, game), _make_state(game, jnp.asarray(False))

    @partial(jax.jit, static_argnums=(0,))
    def step(
        self,
        key: Array,
        state: GameState,
        actions: Mapping[str, Array],
        reset_state: GameState | None = None,
    ) -> tuple[ByAgent, GameState, ByAgent, ByAgent, dict[str, Any]]:
        """Plays one step.

        After a finished episode, returns the first state of the next, or `reset_state`.
        """
        if reset_state is not None:
            result: tuple[ByAgent, GameState, ByAgent, ByAgent, dict[str, Any]] = super().step(
                key, state, actions, reset_state
            )
            return result
        # The base class computes resets in every step, the game only if an environment is done.
        observation, game, reward, done, info = self.env.step(
            key, _game_of(state), self._actions(actions)
        )
        return (
            self._observations(observation, game),
            _make_state(game, jnp.asarray(False)),
            *self._results(reward, done, info),
        )

    @partial(jax.jit, static_argnums=(0,))
    def step_env(
        self, key: Array, state: GameState, actions: Mapping[str, Array]
    ) -> tuple[ByAgent, GameState, ByAgent, ByAgent, dict[str, Any]]:
        """As `step`, but without a reset."""
        observation, game, reward, done, info = self.env.step_env(
            key, _game_of(state), self._actions(actions)
        )
        return (
            self._observations(observation, game),
            _make_state(game, done),
            *self._results(reward, done, info),
        )

    @partial(jax.jit, static_argnums=(0,))
    def get_obs(self, state: GameState) -> ByAgent:
        """Returns the observations of a state."""
        return self._observations(self.env.observe(state.game), state.game)

    @partial(jax.jit, static_argnums=(0,))
    def get_avail_actions(self, state: GameState) -> ByAgent:
        """Returns which actions each agent may take, `[num_actions]` bool."""
        return self._by_agent(self.env.allowed_actions(state.game))

    def _actions(self, actions: Mapping[str, Array]) -> Array:
        """Returns the actions in the order of the agents, `[N]`."""
        return jnp.stack([jnp.asarray(actions[agent]).reshape(()) for agent in self.agents])

    def _by_agent(self, values: Array) -> ByAgent:
        return {agent: values[index] for index, agent in enumerate(self.agents)}

    def _windows(self, observation: Array) -> Array:
        """Returns windows `[N, V, V, P]` float32, or `[N, V * V * P]` if they are flat."""
        windows = jnp.moveaxis(observation, -3, -1).astype(jnp.float32)
        return windows.reshape(self.num_agents, -1) if self._flat else windows

    def _observations(self, observation: Array, game: Any) -> ByAgent:
        """Returns the observations by agent, with the world state if it was asked for."""
        windows = self._windows(observation)
        observations = self._by_agent(windows)
        match self._world_state:
            case "state":
                world = self.env.state_vector(game)
            case "observations":
                world = windows.reshape(-1)
            case _:
                return observations
        observations["world_state"] = jnp.broadcast_to(world, (self.num_agents, world.size))
        return observations

    def _results(
        self, reward: Array, done: Array, info: dict[str, Any]
    ) -> tuple[ByAgent, ByAgent, dict[str, Any]]:
        """Returns rewards, dones and infos in JaxMARL's form."""
        if self._common_reward:
            reward = jnp.broadcast_to(reward.sum(), reward.shape)
        counts = by_name(info["metrics"], "metrics") | by_name(info["events"])
        counts |= {"truncated": info["truncated"], "terminated": info["terminated"]}
        infos: dict[str, Any] = {
            name: jnp.broadcast_to(count, (self.num_agents,)) for name, count in counts.items()
        }
        if self._shaped_reward:
            infos["shaped_reward"] = dict.fromkeys(self.agents, jnp.float32(0))
        if self._terminal_observation:
            infos["terminal_observation"] = self._windows(info["terminal_observation"])
        dones = {**dict.fromkeys(self.agents, done), "__all__": done}
        return self._by_agent(reward), dones, infos


def _make_state(game: Any, done: Array) -> GameState:
    return GameState(done=done, step=jnp.asarray(game.step, jnp.int32), game=game)


def _game_of(state: GameState) -> Any:
    """Returns the game's state at the step of JaxMARL's state, which its users may set."""
    return state.game.replace(step=jnp.asarray(state.step).astype(state.game.step.dtype))


def register() -> None:
    """Makes `jaxmarl.make` accept `sjdsl_NAME`, with the arguments of `JaxMARLGame`.

    Calling it again changes nothing.

    NAME is a bundled game, as listed in `jaxmarl.registered_envs`, or the path of a `.sj` file.
    `sjdsl/NAME` is the same game, but JaxMARL's scripts put the name of the environment into file
    names.
    """
    registered = registration.registered_envs
    names = [f"{prefix}{game}" for prefix in PREFIXES for game in bundled()]
    registered.extend(name for name in names if name not in registered)
    original_make = registration.make
    if getattr(original_make, "makes_compiled_games", False):
        return

    @wraps(original_make)
    def make(env_id: str, **env_kwargs: Any) -> Any:
        for prefix in PREFIXES:
            if env_id.startswith(prefix):
                return JaxMARLGame(env_id.removeprefix(prefix), **env_kwargs)
        return original_make(env_id, **env_kwargs)

    make.makes_compiled_games = True  # type: ignore[attr-defined]
    registration.make = make
    jaxmarl.make = make


register()
