"""Splits the time of a training update into environment steps, acting and learning, with a lower bound from its matrices."""

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.bench.machine import describe_machine
from sjdsl.bench.timing import race
from sjdsl.runtime.env import Environment
from sjdsl.trainers import PPOConfig

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
    from sjdsl.trainers import make_train

    config = PPOConfig(network=network, num_envs=num_envs, num_steps=num_steps, total_timesteps=num_envs * num_steps * 1000)
    program = make_train(env, config)
    state = jax.jit(program.init)(jax.random.key(0))
    began = time.perf_counter()
    update = jax.jit(program.update).lower(state).compile()
    compile_s = time.perf_counter() - began
    collect = jax.jit(program.collect)
    learn = jax.jit(program.learn)
    idle = jax.jit(lambda key: play_idle(env, config, state, key))
    _, played = collect(state)
    loops = [
        lambda key: _done(update(state.replace(key=key))),
        lambda key: _done(idle(key)),
        lambda key: _done(collect(state.replace(key=key))),
        lambda key: _done(learn(state.replace(key=key), played)),
    ]
    rates = race(loops, [1] * len(loops), repeats, lambda _: None)
    whole, idle_s, collect_s, learn_s = (tuple(1 / rate for rate in rounds) for rounds in rates)
    return Split(
        env.name, env.num_agents, network, num_envs, num_steps, compile_s, whole, idle_s, collect_s, learn_s, flops_of(env, state, config)
    )


def play_idle(env: Environment, config: Any, state: Any, key: Array) -> Any:
    """Returns the rollout of agents that act without a network: it costs what the environments cost."""
    from sjdsl.trainers.actor_critics import packing_of
    from sjdsl.trainers.ppo import Acting
    from sjdsl.trainers.rollout import Actor, collect_rollout
    from sjdsl.trainers.shaping import make_shaping

    shape = (config.num_envs, env.num_agents)

    def act(worlds: Any, joint: Any, key: Array) -> tuple[Any, Array, Acting]:
        del joint
        action = jax.random.randint(key, shape, 0, env.num_actions, jnp.int32)
        return worlds.memory, action, Acting(jnp.zeros(shape), jnp.zeros(shape))

    actor = Actor(act, packing_of(env).pack, lambda *_: jnp.zeros(shape))
    return collect_rollout(env, actor, state.worlds, key, config.num_steps, make_shaping(config, env.num_agents))[1]


def flops_of(env: Environment, state: Any, config: Any) -> float:
    """Returns the floating-point operations of an update: a forward pass each step and one at the end, then the gradient steps."""
    from sjdsl.trainers.actor_critics import make_actor_critics

    networks = make_actor_critics(env, config)
    params = tuple(learner.params for learner in state.learner)

    def forward(params: Any, steps: int) -> Array:
        """The networks on so many steps, of one environment or of several: that makes no difference here."""
        seen = jnp.zeros((1, steps, *env.observation_shape), jnp.uint8)
        _, logits, values = networks.apply(params, networks.start_memory(steps), seen, None, jnp.zeros((1, steps), bool))
        return logits.sum() + values.sum()

    minibatch = config.steps_per_update // config.num_minibatches
    acting = _flops(jax.jit(lambda p: forward(p, config.num_envs)).lower(params))
    learning = _flops(jax.jit(jax.grad(lambda p: forward(p, minibatch))).lower(params))
    return acting * (config.num_steps + 1) + learning * config.num_epochs * config.num_minibatches


def _flops(lowered: jax.stages.Lowered) -> float:
    analysis: Any = lowered.cost_analysis()
    return float(analysis["flops"])


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
