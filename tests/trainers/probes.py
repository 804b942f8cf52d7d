"""Probe games: environments small enough that values and best actions are known by hand."""

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal

import flax
import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.planes import TokenPlane
from sjdsl.trainers import Config, TrainState, VDNConfig, make_config, make_train
from sjdsl.trainers.networks.action_values import make_action_values
from sjdsl.trainers.networks.actor_critics import make_actor_critics

MAX_STEPS = 5


@flax.struct.dataclass
class ProbeState:
    """A probe game under way."""

    cue: Array  # [] int32, 0 or 1, drawn when the episode starts
    step: Array  # [] int32, steps done


@dataclass(frozen=True)
class Probe:
    """A game given by what it shows, what it pays and how its episodes end; the interface of a compiled game."""

    name: str
    reward: Callable[
        [ProbeState, Array], Any
    ]  # state and actions [N] -> [N], or one number for all
    show: Callable[[ProbeState], Array] = lambda _: jnp.int32(
        0
    )  # -> the one token seen, 0 .. 5; or one for each agent
    length: Callable[[ProbeState], Array] = lambda _: jnp.int32(
        1
    )  # steps of the episode, at most MAX_STEPS
    truncates: bool | Array = False  # episodes end by the time limit
    num_agents: int = 2
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
        """Returns `[N, 1, 1, 1]` uint8: every agent sees one token."""
        return windows(self, self.show(state))

    def state_vector(self, state: ProbeState) -> Array:
        """Returns `[2]` float32: cue and step, counted as if the episode went on for ever."""
        return jnp.stack([state.cue, state.step % self.length(state)]).astype(jnp.float32)

    def reset(self, key: Array, params: None = None) -> tuple[Array, ProbeState]:
        """Draws a cue."""
        del params
        state = ProbeState(cue=jax.random.randint(key, (), 0, 2, jnp.int32), step=jnp.int32(0))
        return self.observe(state), state

    def step_env(
        self, key: Array, state: ProbeState, actions: Array, params: None = None
    ) -> tuple[Any, ...]:
        """Plays one step and resets nothing."""
        del key, params
        reward = jnp.broadcast_to(
            jnp.asarray(self.reward(state, actions), jnp.float32), self.num_agents
        )
        after = state.replace(step=state.step + 1)
        done = after.step >= self.length(state)
        info = {
            "truncated": done & self.truncates,
            "terminal_observation": self.observe(after),
            "terminal_state": after,
            "events": {"second_action": (actions == 1).astype(jnp.int32), "steps": jnp.int32(1)},
            "metrics": {"step": after.step.astype(jnp.float32)},
        }
        return self.observe(after), after, reward, done, info

    def step(
        self, key: Array, state: ProbeState, actions: Array, params: None = None
    ) -> tuple[Any, ...]:
        """Plays one step and starts a new episode after the last."""
        step_key, reset_key = jax.random.split(key)
        _, after, reward, done, info = self.step_env(step_key, state, actions, params)
        _, fresh = self.reset(reset_key)
        state = jax.tree.map(lambda new, old: jnp.where(done, new, old), fresh, after)
        return self.observe(state), state, reward, done, info


def windows(env: Probe, shown: int | Array | Sequence[int]) -> Array:
    """Returns the observations `[N, 1, 1, 1]` of agents that see one token, or one each."""
    return (
        jnp.broadcast_to(jnp.asarray(shown), env.num_agents).astype(jnp.uint8).reshape(-1, 1, 1, 1)
    )


@cache
def constant(amount: float, num_agents: int = 2) -> Probe:
    """One step that pays `amount` whatever is done."""
    return Probe("constant", reward=lambda _, __: amount, num_agents=num_agents)


@cache
def delayed() -> Probe:
    """Two steps; the second pays 1."""
    return Probe(
        "delayed",
        reward=lambda state, _: 1.0 * (state.step == 1),
        show=lambda state: state.step,
        length=lambda _: jnp.int32(2),
    )


@cache
def cued() -> Probe:
    """One step that pays 1 after cue 1 and -1 after cue 0."""
    return Probe(
        "cued", reward=lambda state, _: 2.0 * state.cue - 1.0, show=lambda state: state.cue
    )


@cache
def matching(num_agents: int = 2) -> Probe:
    """One step that pays 1 to an agent whose action is the cue, else 0."""
    return Probe(
        "matching",
        reward=lambda state, actions: actions == state.cue,
        show=lambda state: state.cue,
        num_agents=num_agents,
    )


@cache
def stream(ends: Literal["terminated", "truncated"]) -> Probe:
    """Pays the cue, 0 or 1, at each of three steps. The token is cue + 2 x step; after the last step it starts over."""
    return Probe(
        f"stream {ends}",
        reward=lambda state, _: state.cue,
        show=lambda state: state.cue + 2 * (state.step % 3),
        length=lambda _: jnp.int32(3),
        truncates=ends == "truncated",
    )


@cache
def dilemma() -> Probe:
    """The prisoner's dilemma, once: action 0 cooperates, 1 defects; 3 each, 5 and 0, or 1 each."""
    payoffs = jnp.array([[3.0, 0.0], [5.0, 1.0]])
    return Probe("dilemma", reward=lambda _, actions: payoffs[actions, actions[::-1]])


@cache
def uneven() -> Probe:
    """Pays agent 0 one a step and agent 1 nothing; two steps after cue 0, five after cue 1."""
    return Probe(
        "uneven",
        reward=lambda _, __: jnp.array([1.0, 0.0]),
        show=lambda state: state.cue,
        length=lambda state: 2 + 3 * state.cue,
        truncates=True,
    )


@cache
def opposite() -> Probe:
    """One step that pays agent 0 for action 0 and agent 1 for action 1, though both see the same."""
    return Probe("opposite", reward=lambda _, actions: actions == jnp.arange(2))


@cache
def hidden() -> Probe:
    """One step that pays 1 after cue 1 and -1 after cue 0; agent 1 sees the cue, agent 0 sees token 2."""
    return Probe(
        "hidden",
        reward=lambda state, _: 2.0 * state.cue - 1.0,
        show=lambda state: jnp.stack([jnp.full_like(state.cue, 2), state.cue]),
    )


@cache
def different() -> Probe:
    """One step that pays agent 0 one and agent 1 minus one, though both see the same."""
    return Probe("different", reward=lambda _, __: jnp.array([1.0, -1.0]))


@cache
def recalled() -> Probe:
    """Two steps: the first shows the cue, 1 or 2, the second nothing, and pays the action that was cued."""
    return Probe(
        "recalled",
        reward=lambda state, actions: (actions == state.cue) & (state.step == 1),
        show=lambda state: jnp.where(state.step == 0, 1 + state.cue, 0),
        length=lambda _: jnp.int32(2),
    )


@cache
def endless_riches() -> Probe:
    """One step that pays infinity."""
    return Probe("endless riches", reward=lambda _, __: jnp.inf)


@flax.struct.dataclass
class Tables:
    """All that a probe does, as arrays: probes of a form share what is compiled."""

    reward: (
        Array  # [2, MAX_STEPS, A, ..., A, N] float32, by cue, step and the actions of all agents
    )
    shown: Array  # [2, MAX_STEPS + 1, N] uint8
    length: Array  # [2] int32
    truncates: Array  # [] bool


@cache
def tables_of(env: Probe) -> Tables:
    """Returns what a probe does."""
    return jax.jit(lambda: _compute_tables(env), compiler_options=FAST_TO_COMPILE)()


def _compute_tables(env: Probe) -> Tables:
    joint = jnp.indices((env.num_actions,) * env.num_agents).reshape(env.num_agents, -1).T

    def pay(cue: Array, step: Array, actions: Array) -> Array:
        return jnp.broadcast_to(
            jnp.asarray(env.reward(ProbeState(cue, step), actions), jnp.float32), env.num_agents
        )

    def by_step(function: Callable[[Array, Array], Array], steps: int) -> Array:
        return jnp.stack(
            [
                jnp.stack([function(jnp.int32(cue), jnp.int32(step)) for step in range(steps)])
                for cue in (0, 1)
            ]
        )

    reward = by_step(
        lambda cue, step: jax.vmap(lambda actions: pay(cue, step, actions))(joint), MAX_STEPS
    )
    return Tables(
        reward=reward.reshape(2, MAX_STEPS, *[env.num_actions] * env.num_agents, env.num_agents),
        shown=by_step(lambda cue, step: env.observe(ProbeState(cue, step)).ravel(), MAX_STEPS + 1),
        length=by_step(lambda cue, step: env.length(ProbeState(cue, step)), 1)[:, 0],
        truncates=jnp.asarray(env.truncates),
    )


def tabled(form: Probe, tables: Tables) -> Probe:
    """Returns the probe that does what the tables say, which may be traced; agents and actions are those of `form`."""
    return dataclasses.replace(
        form,
        reward=lambda state, actions: tables.reward[(state.cue, state.step, *actions)],
        show=lambda state: tables.shown[state.cue, state.step],
        length=lambda state: tables.length[state.cue],
        truncates=tables.truncates,
    )


QUICK: dict[str, Any] = {
    "num_envs": 16,
    "num_steps": 16,
    "total_timesteps": 16 * 16 * 100,
    "num_epochs": 2,
    "num_minibatches": 2,
    "learning_rate": 1e-2,
    "clip_value_loss": False,
    "network": "mlp",
    "network_width": 16,
    "gamma": 0.8,
    "reward": "individual",
}

QUICK_VALUES: dict[str, Any] = {
    "algorithm": "vdn",
    "num_envs": 16,
    "num_steps": 4,
    "total_timesteps": 16 * 4 * 200,
    "buffer_size": 16 * 4 * 10,
    "batch_size": 32,
    "learning_starts": 0,
    "learning_rate": 1e-2,
    "target_update_every": 2,
    "epsilon_fraction": 0.5,
    "network": "mlp",
    "network_width": 16,
    "gamma": 0.8,
}

QUICK_ROLLOUTS: dict[str, Any] = {  # value decomposition without a replay buffer
    "algorithm": "vdn",
    "replay": "none",
    "layer_norm": True,
    "num_envs": 16,
    "num_steps": 16,
    "total_timesteps": 16 * 16 * 100,
    "num_epochs": 2,
    "num_minibatches": 2,
    "learning_rate": 1e-2,
    "epsilon_fraction": 0.5,
    "network": "mlp",
    "network_width": 16,
    "gamma": 0.8,
}

FAST_TO_COMPILE = {
    "xla_backend_optimization_level": 0,
    "xla_cpu_use_fusion_emitters": False,
}  # compiling is what takes the time

Run = tuple[TrainState, dict[str, Any]]


def quick(**changes: Any) -> Config:
    """Returns `QUICK` or, for vdn, `QUICK_VALUES` or `QUICK_ROLLOUTS`, with `changes`."""
    if changes.get("algorithm") != "vdn":
        return make_config(QUICK, **changes)
    return make_config(
        QUICK_ROLLOUTS if changes.get("replay") == "none" else QUICK_VALUES, **changes
    )


def run_of(env: Probe, config: Config, seeds: int = 1) -> Callable[[Array], Run]:
    """Returns a whole run as a function of its key: to the last state and all updates' metrics. With more seeds, of as many keys."""
    form = _form_of(env)
    return lambda key: _run_of_form(form, config, seeds)(key, tables_of(env))


def _form_of(env: Probe) -> Probe:
    """Returns the same probe for all of as many agents and actions."""
    return _form(env.num_agents, env.num_actions)


@cache
def _form(num_agents: int, num_actions: int) -> Probe:
    return Probe("form", reward=lambda _, __: 0.0, num_agents=num_agents, num_actions=num_actions)


@cache
def _run_of_form(form: Probe, config: Config, seeds: int) -> Callable[[Array, Tables], Run]:
    """Returns the jitted runs of all probes of a form."""

    def run(key: Array, tables: Tables) -> Run:
        program = make_train(tabled(form, tables), config)
        return jax.lax.scan(
            lambda state, _: program.update(state), program.init(key), length=config.num_updates
        )

    runs = jax.vmap(run, in_axes=(0, None)) if seeds > 1 else run
    return jax.jit(runs, compiler_options=FAST_TO_COMPILE)


@cache
def learn(env: Probe, seed: int = 0, **changes: Any) -> Run:
    """Trains on a probe with the settings of `quick`; once, however many tests ask."""
    return run_of(env, quick(**changes))(jax.random.key(seed))


def judge(
    env: Probe,
    state: TrainState,
    shown: int | Sequence[int],
    world: Sequence[float] | None = None,
    **changes: Any,
) -> tuple[Array, Array]:
    """Returns the action probabilities `[N, A]` and values `[N]` that trained networks give where agents see `shown`.

    `world` is the state's vector, for critics that see it; `changes` are those of the run.
    """
    vector = None if world is None else jnp.asarray(world, jnp.float32)
    read = _judge_of_form(_form_of(env), quick(**changes))
    return read(state.learner.params, windows(env, shown), vector)


@cache
def _judge_of_form(form: Probe, config: Config) -> Callable[..., tuple[Array, Array]]:
    """Returns the jitted networks of all probes of a form."""
    networks = make_actor_critics(form, config)

    def read(parameters: Any, shown: Array, vector: Array | None) -> tuple[Array, Array]:
        seen = shown[None, None]
        joint = networks.joint(seen, None) if vector is None else vector[None, None]
        _, logits, values = networks.apply(
            parameters, networks.start_memory(1), seen, joint, jnp.ones((1, 1), bool)
        )
        return jax.nn.softmax(logits[0, 0]), values[0, 0]

    return jax.jit(read, compiler_options=FAST_TO_COMPILE)


def judge_actions(
    env: Probe, state: TrainState, shown: int | Sequence[int], **changes: Any
) -> Array:
    """Returns the value `[N, A]` of each action that a trained network of value decomposition gives."""
    config = quick(algorithm="vdn", **changes)
    assert isinstance(config, VDNConfig)
    learner = state.learner.online
    return make_action_values(env, config).apply(learner.params, windows(env, shown))
