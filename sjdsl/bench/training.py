"""Where an update of training spends its time: in the environments, in acting, in learning; and the least its matrices take."""

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.bench.machine import describe_machine
from sjdsl.bench.timing import race
from sjdsl.runtime.env import Environment

Network = Literal["mlp", "cnn"]
SIDE = 2048  # of the square matrices whose product shows what the machine can do


@dataclass(frozen=True)
class Split:
    """One update of IPPO: `num_envs` environments for `num_steps` steps, then its epochs. Seconds by round.

    `environments`: the same rollout under a policy that costs nothing; `rollout`: with the network; `learning`: the gradient
    steps alone; `update`: everything. `flops`: what one update's forward and backward passes need, by XLA's count before it optimises.
    """

    name: str
    num_agents: int
    network: Network
    num_envs: int
    num_steps: int
    compile_s: float
    update: tuple[float, ...]
    environments: tuple[float, ...]
    rollout: tuple[float, ...]
    learning: tuple[float, ...]
    flops: float


@dataclass(frozen=True)
class Training:
    """The updates measured, and the floating-point operations a second of a large float32 matrix product on the same machine."""

    machine: dict[str, Any]
    flops_per_s: float
    splits: tuple[Split, ...]

    def to_json(self) -> dict[str, Any]:
        return asdict(self)


def measure_training(
    envs: Sequence[Environment],
    networks: Sequence[Network],
    num_envs: int,
    num_steps: int,
    repeats: int = 5,
    tell: Callable[[str], object] = lambda _: None,
) -> Training:
    """Returns where updates of the environments' training spend their time, network by network."""
    splits = []
    for env in envs:
        for network in networks:
            tell(f"compiling {env.name}, {network}")
            splits.append(measure_split(env, network, num_envs, num_steps, repeats))
    return Training(describe_machine(), matrix_flops_per_s(repeats), tuple(splits))


def measure_split(env: Environment, network: Network, num_envs: int, num_steps: int, repeats: int) -> Split:
    """Returns the parts of one update; all are timed in turn, round by round."""
    from sjdsl.trainers import Config, make_train
    from sjdsl.trainers.ppo import flatten_rollout, take_epochs
    from sjdsl.trainers.rollout import collect_rollout

    config = Config(network=network, num_envs=num_envs, num_steps=num_steps, total_timesteps=num_envs * num_steps * 1000)
    program = make_train(env, config)
    state = jax.jit(program.init)(jax.random.key(0))
    began = time.perf_counter()
    update = jax.jit(program.update).lower(state).compile()
    compile_s = time.perf_counter() - began
    apply = state.learner.apply_fn

    def rollout_of(key: Array, network: Callable[..., Any]) -> Any:
        return collect_rollout(env, network, state.worlds, key, num_steps, config.reward)[1]

    def idle(observation: Array) -> tuple[Array, Array]:
        lead = observation.shape[:2]
        return jnp.zeros((*lead, env.num_actions)), jnp.zeros(lead)

    def act(observation: Array) -> tuple[Array, Array]:
        return apply(state.learner.params, observation)

    environments = jax.jit(lambda key: rollout_of(key, idle))
    rollout = jax.jit(lambda key: rollout_of(key, act))
    batch = jax.jit(lambda key: flatten_rollout(rollout_of(key, act), jnp.zeros((num_envs, env.num_agents)), config))(jax.random.key(1))
    learning = jax.jit(lambda learner, batch, key: take_epochs(learner, batch, key, config)[0].params)
    loops = [
        lambda key: _done(update(state.replace(key=key))),
        lambda key: _done(environments(key)),
        lambda key: _done(rollout(key)),
        lambda key: _done(learning(state.learner, batch, key)),
    ]
    rates = race(loops, [1] * len(loops), repeats, lambda _: None)
    seconds = [tuple(1 / rate for rate in rounds) for rounds in rates]
    return Split(env.name, env.num_agents, network, num_envs, num_steps, compile_s, *seconds, flops_of(state, batch, config))


def flops_of(state: Any, batch: Any, config: Any) -> float:
    """Returns the floating-point operations of an update: a forward pass each step and one at the end, then the gradient steps."""
    from sjdsl.trainers.ppo import ppo_loss

    minibatch = jax.tree.map(lambda leaf: leaf[: leaf.shape[0] // config.num_minibatches], batch)
    apply, params = state.learner.apply_fn, state.learner.params
    forward = jax.jit(apply).lower(params, state.worlds.observation).cost_analysis()["flops"]
    backward = jax.jit(jax.grad(lambda p: ppo_loss(p, apply, minibatch, config)[0])).lower(params).cost_analysis()["flops"]
    return forward * (config.num_steps + 1) + backward * config.num_epochs * config.num_minibatches


def matrix_flops_per_s(repeats: int) -> float:
    """Returns the floating-point operations a second of a large matrix product in float32, the median of the rounds."""
    matrix = jnp.ones((SIDE, SIDE), jnp.float32)
    product = jax.jit(jnp.matmul)
    product(matrix, matrix).block_until_ready()
    rates = []
    for _ in range(repeats):
        began = time.perf_counter()
        product(matrix, matrix).block_until_ready()
        rates.append(2 * SIDE**3 / (time.perf_counter() - began))
    return statistics.median(rates)


def _done(tree: Any) -> Array:
    """Returns the first leaf when all are computed."""
    return jax.tree.leaves(jax.block_until_ready(tree))[0]
