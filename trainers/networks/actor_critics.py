"""Actor-critic networks of all agents: who shares parameters, and what critics observe."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, cast

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from ..environment import Environment, ObservableEnvironment, reset_shapes
from ..settings.config import ConfigError, PPOConfig
from .architectures import ActorCritic, Memory, Planes
from .last_step import make_last_step
from .masks import wants_masks
from .packing import Packing, make_packing
from .teams import make_teams, over_teams

AGENTS_AXIS = 2  # of observations, logits and values `[L, M, N, ...]`
# Critics read averages of rewards in this unit, nearly as they are below it, and above it as their
# logarithm.
REWARD_UNIT = 0.1


@dataclass(frozen=True)
class ActorCritics:
    """The networks of G teams of S agents, which differ in their parameters."""

    teams: np.ndarray  # [G, S] int32, numbers of agents
    network: ActorCritic
    # zeros [1, 1, ...] in place of what critics read besides windows; None: nothing
    blank_joint: Array | None
    # of one state `[K]` float32, if that is the critic's input
    state_vector: Callable[[Any], Array] | None
    packing: Packing  # of the observations in a rollout
    masks: bool  # whether forbidden actions are never taken

    @property
    def reads_rewards(self) -> bool:
        """Whether critics read averages of recent rewards."""
        return bool(self.network.config.reward_horizons)

    def init(self, key: Array, env: Environment) -> Any:
        """Returns initial parameters, leaves `[G, ...]`, drawn with a key for each team."""
        observation, _ = reset_shapes(env)
        number, size = self.teams.shape
        seen = jnp.zeros((1, 1, size, *observation.shape[1:]), observation.dtype)
        fresh = jnp.ones((1, 1), bool)
        memory = self.network.start_memory(1)
        agents = jnp.asarray(self.teams[0])
        joint = self.blank_joint
        if joint is not None and self.reads_rewards:
            joint = joint[:, :, agents]
        drawn = [
            self.network.init(team_key, memory, seen, joint, fresh, agents)
            for team_key in jax.random.split(key, number)
        ]
        return jax.tree.map(lambda *leaves: jnp.stack(leaves), *drawn)

    def start_memory(self, num_envs: int) -> Memory:
        """Returns the memory before the first step of B environments: leaves `[B, G, ...]`."""
        memory = self.network.start_memory(num_envs)
        return jax.tree.map(lambda leaf: jnp.repeat(leaf[:, None], len(self.teams), axis=1), memory)

    def after_step(
        self, memory: Memory, action: Array, reward: Array, info: Mapping[str, Any]
    ) -> Memory:
        """Returns the memory with what agents will read of the step that was just played.

        Args:
          memory: of `apply`, in which B environments' actions were chosen.
          action, reward: `[B, N]`, of all agents; rewards as the game pays them.
          info: as the step gave it.
        """
        reads = self.network.config.memory_reads
        if not reads:
            return memory
        last = make_last_step(reads, action, reward, info)
        of_teams = {name: leaf[:, self.teams[:, None]] for name, leaf in last.items()}
        return memory | {"last": of_teams}

    def for_critic(self, state: Any, recent: Array) -> Any:
        """Returns what critics read besides windows: states, recent rewards or None."""
        if self.state_vector is not None:
            return state
        return recent if self.reads_rewards else None

    def joint(self, observation: Array, for_critic: Any) -> Array | None:
        """Returns the input of critics besides an agent's own window `[L, M, ...]`, or None.

        It is all windows `[L, M, N, P, V, V]`, plane after plane; or states `[L, M, ...]` as
        vectors; or the averages of each agent's recent rewards `[L, M, N, K]`, by a function that
        grows like a logarithm, as the rewards of games differ in size.
        """
        if self.blank_joint is None:
            return None
        if self.state_vector is not None:
            return jax.vmap(jax.vmap(self.state_vector))(for_critic)
        if self.reads_rewards:
            return jnp.arcsinh(for_critic / REWARD_UNIT)
        return observation.reshape(*observation.shape[:2], *self.blank_joint.shape[2:])

    def apply(
        self, parameters: Any, memory: Memory, observation: Array, joint: Array | None, fresh: Array
    ) -> tuple[Memory, Array, Array]:
        """Reads L steps of M environments with all networks.

        Args:
          parameters: of `init`.
          memory: of `start_memory` or the step before.
          observation: `[L, M, N, P, V, V]` uint8.
          joint: of `joint`, `[L, M, ...]`.
          fresh: `[L, M]` bool, whether the episode starts with this step.
        Returns:
          the memory afterwards, logits `[L, M, N, A]`, values `[L, M, N]`.
        """
        number, size = self.teams.shape
        num_agents = observation.shape[AGENTS_AXIS]

        def of_teams(leaf: Array) -> Array:
            if number == 1 and size == num_agents:  # one team of everybody, in order
                return leaf[:, :, None]
            return leaf[:, :, jnp.asarray(self.teams)]

        joint_axis = None
        if joint is not None and self.reads_rewards:
            joint = of_teams(joint)
            joint_axis = AGENTS_AXIS
        apply = over_teams(
            self.network.apply,
            number,
            in_axes=(0, 1, AGENTS_AXIS, joint_axis, None, 0),
            out_axes=(1, AGENTS_AXIS, AGENTS_AXIS),
        )
        agents = jnp.asarray(self.teams)
        memory, logits, values = apply(
            parameters, memory, of_teams(observation), joint, fresh, agents
        )
        return memory, self._by_agent(logits, num_agents), self._by_agent(values, num_agents)

    def _by_agent(self, results: Array, num_agents: int) -> Array:
        """Returns results `[L, M, G, S, ...]` of all teams as `[L, M, N, ...]`.

        They are zeros for agents in no team, which don't learn.
        """
        results = results.reshape(*results.shape[:2], -1, *results.shape[4:])
        if self.teams.size == num_agents:
            return results
        shape = (*results.shape[:2], num_agents, *results.shape[3:])
        return jnp.zeros(shape, results.dtype).at[:, :, self.teams.ravel()].set(results)


def make_actor_critics(env: Environment, config: PPOConfig) -> ActorCritics:
    """Returns the networks for the environment's observations and actions.

    Raises:
      ConfigError: the environment has no token observations, or no state vector for the critic;
        `partners` don't fit the agents; a pooled critic has agents with networks of their own.
    """
    if config.algorithm == "mappo" and config.critic == "pooled" and config.sharing == "per_agent":
        raise ConfigError(
            "critic=pooled averages over agents that share a network: "
            "set sharing=shared, or critic to observations or state"
        )
    planes = token_planes(env)
    joint_planes: Planes | None = None
    blank_joint: Array | None = None
    state_vector: Callable[[Any], Array] | None = None
    observation, state = reset_shapes(env)
    if config.critic_has_torso and config.critic == "state":
        if not hasattr(env, "state_vector"):
            raise ConfigError(
                f"`{env.name}` has no state_vector for a critic of the state; "
                'choose critic = "observations"'
            )
        joint_planes = ()
        state_vector = cast(ObservableEnvironment, env).state_vector
        blank_joint = jnp.zeros((1, 1, *jax.eval_shape(state_vector, state).shape), jnp.float32)
    elif config.critic_has_torso:
        joint_planes = planes * env.num_agents
        blank_joint = jnp.zeros((1, 1, len(joint_planes), *observation.shape[2:]), jnp.uint8)
    elif config.reward_horizons:
        shape = (1, 1, env.num_agents, len(config.reward_horizons))
        blank_joint = jnp.zeros(shape, jnp.float32)
    teams = make_teams(env, config)
    network = ActorCritic(
        num_actions=env.num_actions,
        num_agents=teams.shape[1],
        planes=planes,
        joint_planes=joint_planes,
        config=config,
        numbers=env.num_agents if config.agent_id else 0,
    )
    masks = wants_masks(env, config)
    return ActorCritics(teams, network, blank_joint, state_vector, packing_of(env), masks)


def token_planes(env: Environment) -> Planes:
    """Returns the environment's planes.

    Raises:
      ConfigError: it has no token observations.
    """
    observation, _ = reset_shapes(env)
    if observation.dtype != jnp.uint8 or observation.shape[1] != len(env.token_planes):
        raise ConfigError(
            f"trainers read token observations, uint8 with {len(env.token_planes)} planes, "
            f"but `{env.name}` gives {observation.dtype} {observation.shape}; "
            'make it with observation="tokens"'
        )
    return tuple(env.token_planes)


def packing_of(env: Environment) -> Packing:
    """Returns how rollouts store the environment's observations."""
    observation, _ = reset_shapes(env)
    return make_packing(token_planes(env), observation.shape[-2:])
