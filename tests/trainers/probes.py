"""Probe games: environments small enough that values and best actions are known by hand."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal

import flax
import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.planes import TokenPlane
from sjdsl.trainers import Config, TrainState, make_train
from sjdsl.trainers.ppo import make_network


@flax.struct.dataclass
class ProbeState:
    """A probe game under way."""

    cue: Array  # [] int32, 0 or 1, drawn when the episode starts
    step: Array  # [] int32, steps done


@dataclass(frozen=True)
class Probe:
    """A game given by what it shows, what it pays and how its episodes end; the interface of a compiled game."""

    name: str
    reward: Callable[[ProbeState, Array], Array]  # state and actions [N] -> [N]
    show: Callable[[ProbeState], Array] = lambda _: jnp.int32(0)  # -> the one token seen, 0 .. 5
    length: Callable[[ProbeState], Array] = lambda _: jnp.int32(1)  # steps of the episode
    ends: Literal["terminated", "truncated"] = "terminated"
    num_agents: int = 1
    num_actions: int = 2
    episode_length: int = 100
    hash: str = "probe"
    params: tuple[float, ...] = ()
    token_planes: tuple[TokenPlane, ...] = (TokenPlane("shown", "word", tuple("abcdef")),)

    @property
    def action_names(self) -> tuple[str, ...]:
        """One name an action."""
        return tuple(f"action_{index}" for index in range(self.num_actions))

    def observe(self, state: ProbeState) -> Array:
        """Returns `[N, 1, 1, 1]` uint8: every agent sees the same token."""
        return jnp.full((self.num_agents, 1, 1, 1), self.show(state), jnp.uint8)

    def reset(self, key: Array, params: None = None) -> tuple[Array, ProbeState]:
        """Draws a cue."""
        del params
        state = ProbeState(cue=jax.random.randint(key, (), 0, 2, jnp.int32), step=jnp.int32(0))
        return self.observe(state), state

    def step_env(self, key: Array, state: ProbeState, actions: Array, params: None = None) -> tuple[Any, ...]:
        """Plays one step and resets nothing."""
        del key, params
        reward = jnp.asarray(self.reward(state, actions), jnp.float32)
        after = state.replace(step=state.step + 1)
        done = after.step >= self.length(state)
        info = {
            "truncated": done if self.ends == "truncated" else jnp.bool_(False),
            "terminal_observation": self.observe(after),
            "events": {"second_action": (actions == 1).astype(jnp.int32), "steps": jnp.int32(1)},
            "metrics": {"step": after.step.astype(jnp.float32)},
        }
        return self.observe(after), after, reward, done, info

    def step(self, key: Array, state: ProbeState, actions: Array, params: None = None) -> tuple[Any, ...]:
        """Plays one step and starts a new episode after the last."""
        step_key, reset_key = jax.random.split(key)
        _, after, reward, done, info = self.step_env(step_key, state, actions, params)
        _, fresh = self.reset(reset_key)
        state = jax.tree.map(lambda new, old: jnp.where(done, new, old), fresh, after)
        return self.observe(state), state, reward, done, info


@cache
def constant(amount: float) -> Probe:
    """One step that pays `amount` whatever is done."""
    return Probe("constant", reward=lambda _, __: jnp.full(1, amount))


@cache
def delayed() -> Probe:
    """Two steps; the second pays 1."""
    return Probe(
        "delayed",
        reward=lambda state, _: jnp.full(1, 1.0) * (state.step == 1),
        show=lambda state: state.step,
        length=lambda _: jnp.int32(2),
    )


@cache
def cued() -> Probe:
    """One step that pays 1 after cue 1 and -1 after cue 0."""
    return Probe("cued", reward=lambda state, _: jnp.full(1, 2.0 * state.cue - 1.0), show=lambda state: state.cue)


@cache
def matching() -> Probe:
    """One step that pays 1 to an agent whose action is the cue, else 0; two agents."""
    return Probe(
        "matching",
        reward=lambda state, actions: (actions == state.cue).astype(jnp.float32),
        show=lambda state: state.cue,
        num_agents=2,
    )


@cache
def stream(ends: Literal["terminated", "truncated"]) -> Probe:
    """Pays the cue, 0 or 1, at each of three steps. The token is cue + 2 x step; after the last step it starts over."""
    return Probe(
        f"stream {ends}",
        reward=lambda state, _: jnp.full(1, 1.0) * state.cue,
        show=lambda state: state.cue + 2 * (state.step % 3),
        length=lambda _: jnp.int32(3),
        ends=ends,
    )


@cache
def dilemma() -> Probe:
    """The prisoner's dilemma, once: action 0 cooperates, 1 defects; 3 each, 5 and 0, or 1 each."""
    payoffs = jnp.array([[3.0, 0.0], [5.0, 1.0]])
    return Probe("dilemma", reward=lambda _, actions: payoffs[actions, actions[::-1]], num_agents=2)


@cache
def uneven() -> Probe:
    """Pays agent 0 one a step and agent 1 nothing; two steps after cue 0, five after cue 1."""
    return Probe(
        "uneven",
        reward=lambda _, __: jnp.array([1.0, 0.0]),
        show=lambda state: state.cue,
        length=lambda state: 2 + 3 * state.cue,
        ends="truncated",
        num_agents=2,
    )


QUICK: dict[str, Any] = {
    "num_envs": 16,
    "num_steps": 16,
    "total_timesteps": 16 * 16 * 100,
    "num_epochs": 2,
    "num_minibatches": 2,
    "learning_rate": 1e-2,
    "network": "mlp",
    "network_width": 16,
    "gamma": 0.9,
    "reward": "individual",
}


@cache
def run_of(env: Probe, config: Config) -> Callable[[Array], tuple[TrainState, dict[str, Any]]]:
    """Returns a whole run as one jitted function of its key: to the last state and all updates' metrics."""
    program = make_train(env, config)

    def run(key: Array) -> tuple[TrainState, dict[str, Any]]:
        return jax.lax.scan(lambda state, _: program.update(state), program.init(key), length=config.num_updates)

    return jax.jit(run, compiler_options={"xla_backend_optimization_level": 0})  # compiling is what takes the time


def learn(env: Probe, seed: int = 0, **changes: Any) -> tuple[TrainState, dict[str, Any]]:
    """Trains on a probe with `QUICK` and `changes`."""
    return run_of(env, Config(**{**QUICK, **changes}))(jax.random.key(seed))


def judge(env: Probe, state: TrainState, shown: int) -> tuple[Array, float]:
    """Returns the action probabilities `[A]` and the value that a trained network gives to one token."""
    network = make_network(env, Config(**QUICK))
    logits, value = network.apply(state.learner.params, jnp.full((1, 1, 1), shown, jnp.uint8))
    return jax.nn.softmax(logits), float(value)
