"""Splits the time of a training update into environment steps, acting and learning, with a lower bound from its matrices."""

import math
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, Literal, cast

import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.bench.machine import describe_machine
from sjdsl.bench.timing import race
from sjdsl.runtime.env import Environment
from sjdsl.trainers import make_train
from sjdsl.trainers.algorithms.ppo import Acting
from sjdsl.trainers.algorithms.rollout import Actor, Worlds, collect_rollout
from sjdsl.trainers.algorithms.shaping import make_shaping
from sjdsl.trainers.networks.action_values import make_action_values
from sjdsl.trainers.networks.actor_critics import make_actor_critics, packing_of
from sjdsl.trainers.networks.masks import allowed_in, pack_mask, wants_masks
from sjdsl.trainers.runs.compiled import NoMemoryError, compile_train
from sjdsl.trainers.settings.config import Config, ConfigError, PPOConfig, VDNConfig, make_config

Network = Literal["mlp", "cnn"]
Algorithm = Literal["ippo", "mappo", "vdn"]
Sharing = Literal["shared", "per_agent"]
SIDE = 2048  # of the square matrices whose product shows what the machine can do
TIMED = 2048  # environment steps of one timing, at least: an update of one short rollout is too short to time alone
UPDATES = 1000  # of the run whose update is measured: schedules of learning rates and of exploration need a length
ROLLOUT = {
    "ippo": (16, 128),
    "mappo": (16, 128),
    "vdn": (VDNConfig().num_envs, VDNConfig().num_steps),
}  # environments and steps by default


@dataclass(frozen=True)
class Setup:
    """An environment and the configuration to train it with."""

    name: str  # of the game, with its variant: `game+variant`
    env: Environment
    config: Config

    @property
    def network(self) -> Network:
        return cast(Network, self.config.network)

    @property
    def learning(self) -> tuple[Algorithm, Sharing]:
        """The algorithm, and which agents share a network; with vdn all do."""
        return cast(Algorithm, self.config.algorithm), getattr(self.config, "sharing", "shared")

    def __str__(self) -> str:
        return ", ".join((self.name, self.network, *self.learning))


@dataclass(frozen=True)
class Split:
    """One update: `num_envs` environments for `num_steps` steps, then learning from them. Seconds by round.

    `environments`: the same rollout under a policy that costs nothing; `rollout`: with the network; `learning`: the gradient
    steps alone; `update`: everything. `flops`: of one update's forward and backward passes, by XLA's count before it optimises.
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
    algorithm: Algorithm = "ippo"
    sharing: Sharing = "shared"  # which agents share a network

    @property
    def env_steps_per_s(self) -> float:
        """Of whole updates, in the median round."""
        return self.num_envs * self.num_steps / statistics.median(self.update)

    def hours_to(self, env_steps: int) -> tuple[float, float, float]:
        """Returns the hours to so many environment steps of one seed, without compiling and evaluating: at the speed of the median, the
        fastest and the slowest round."""
        updates = env_steps / (self.num_envs * self.num_steps)
        median, fastest, slowest = (
            updates * f(self.update) / 3600 for f in (statistics.median, min, max)
        )
        return median, fastest, slowest


@dataclass(frozen=True)
class Training:
    """The updates measured, and the floating-point operations a second of a large float32 matrix product on the same machine.

    `hours_to`: environment steps to which hours are extrapolated. `left_out`: what couldn't be measured, and why.
    """

    machine: dict[str, Any]
    flops_per_s: float
    splits: tuple[Split, ...]
    hours_to: int | None = None
    left_out: tuple[str, ...] = ()


def training_setups(
    envs: Sequence[tuple[str, Environment]],
    networks: Sequence[Network],
    algorithms: Sequence[Algorithm] = ("ippo",),
    sharings: Sequence[Sharing] = ("shared",),
    num_envs: int | None = None,
    num_steps: int | None = None,
) -> tuple[tuple[Setup, ...], tuple[str, ...]]:
    """Returns the setups that can be measured, and a line for each that its game or its sizes refuse.

    Args:
      envs: environments with tokens, by name; a game with different numbers of agents has the same name.
      networks, algorithms, sharings: all combinations; vdn has one network for all agents, and is left out unless `shared` is wanted.
      num_envs, num_steps: of a rollout; None: those of `ROLLOUT`.
    """
    setups, refused = [], []
    for (name, env), network, algorithm, sharing in product(envs, networks, algorithms, sharings):
        if algorithm == "vdn" and sharing != "shared":
            continue
        own = ROLLOUT[algorithm]
        values: dict[str, Any] = {"algorithm": algorithm, "network": network}
        values |= {"num_envs": num_envs or own[0], "num_steps": num_steps or own[1]}
        steps = values["num_envs"] * values["num_steps"]
        if algorithm == "vdn":
            values["buffer_size"] = math.ceil(VDNConfig().buffer_size / steps) * steps
        else:
            values["sharing"] = sharing
        try:
            setup = Setup(name, env, make_config(values, total_timesteps=steps * UPDATES))
            make_train(env, setup.config)
        except ConfigError as error:
            refused.append(f"{name}, {network}, {algorithm}, {sharing}: {error}")
        else:
            setups.append(setup)
    return tuple(setups), tuple(refused)


def measure_training(
    setups: Sequence[Setup],
    repeats: int = 5,
    tell: Callable[[str], object] = lambda _: None,
    env_steps: int | None = None,
    left_out: Sequence[str] = (),
    keep: Callable[[Training], object] = lambda _: None,
) -> Training:
    """Returns where updates spend their time; one that doesn't fit into memory is left out.

    Args:
      setups: what to train, from `training_setups`.
      repeats: rounds.
      tell: called with a line whenever something is compiled.
      env_steps: environment steps of the run whose hours are extrapolated; None: no hours.
      left_out: what can't be measured, a line each.
      keep: called with all figures so far whenever there are new ones.
    """
    found = Training(
        describe_machine(), matrix_flops_per_s(repeats), (), env_steps, tuple(left_out)
    )
    for setup in setups:
        tell(f"compiling {setup}")
        try:
            found = replace(found, splits=(*found.splits, measure_split(setup, repeats)))
        except NoMemoryError as error:
            found = replace(found, left_out=(*found.left_out, f"{setup}: {error}"))
        keep(found)
    return found


def measure_split(setup: Setup, repeats: int) -> Split:
    """Returns the parts of one update, as a run computes it; all are timed in turn, round by round."""
    env, config = setup.env, setup.config
    compiled = compile_train(make_train(env, config), config)
    idle = jax.jit(idle_rollout(env, config))
    first = compiled.start()
    flops, worlds = (
        flops_of(env, config, compiled.parameters(first)),
        jax.tree.map(jnp.copy, first.worlds),
    )
    state, played = compiled.collect(first)

    def collect() -> Any:
        nonlocal state
        state, found = compiled.collect(state)  # reuses the memory of its argument
        return found

    def learn(found: Any) -> Any:
        nonlocal state
        state, metrics = compiled.learn(state, found)
        return metrics

    updates = math.ceil(TIMED / config.steps_per_update)

    def repeated(part: Callable[[Array], Any]) -> Callable[[Array], Array]:
        """Returns a function that calls a part `updates` times and waits; its result is any array, as `race` needs one."""

        def run(key: Array) -> Array:
            found = [part(key) for _ in range(updates)][-1]
            result: Array = jax.tree.leaves(jax.block_until_ready(found))[0]
            return result

        return run

    parts = (
        lambda _: learn(collect()),
        lambda key: idle(worlds, key),
        lambda _: collect(),
        lambda _: learn(played),
    )
    rates = race(list(map(repeated, parts)), [updates] * len(parts), repeats, lambda _: None)
    whole, idle_s, collect_s, learn_s = (tuple(1 / rate for rate in rounds) for rounds in rates)
    sizes = (setup.network, config.num_envs, config.num_steps)
    return Split(
        setup.name,
        env.num_agents,
        *sizes,
        compiled.seconds,
        whole,
        idle_s,
        collect_s,
        learn_s,
        flops,
        *setup.learning,
    )


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


def idle_rollout(env: Environment, config: Config) -> Callable[[Worlds, Array], Any]:
    """Returns a function of worlds and a key that plays agents without a network: it costs what the environments cost."""
    shape = (config.num_envs, env.num_agents)
    packing = packing_of(env)
    masks = wants_masks(env, config)
    keeps: Any = (
        Acting(jnp.zeros(shape), jnp.zeros(shape)) if isinstance(config, PPOConfig) else None
    )

    def act(worlds: Worlds, key: Array) -> tuple[Any, Array, Any]:
        return worlds.memory, jax.random.randint(key, shape, 0, env.num_actions, jnp.int32), keeps

    def follow(memory: Any, info: dict[str, Any]) -> Any:
        del memory
        if isinstance(config, PPOConfig):
            return jnp.zeros(shape)
        return packing.pack(info["terminal_observation"]), pack_mask(
            allowed_in(env, masks, info.get("terminal_state"))
        )

    actor = Actor(act, packing.pack, follow)
    shaping = make_shaping(config, env.num_agents)
    return lambda worlds, key: collect_rollout(env, actor, worlds, key, config.num_steps, shaping)[
        1
    ]


def flops_of(env: Environment, config: Any, parameters: Any) -> float:
    """Returns the floating-point operations of the networks in an update, acting and learning."""

    def forward(parameters: Any, steps: int) -> Array:
        """The networks on so many steps, of one environment or of several: that makes no difference here."""
        seen = jnp.zeros((steps, *env.observation_shape), jnp.uint8)
        if isinstance(config, VDNConfig):
            values: Any = make_action_values(env, config).apply(parameters, seen)
            result: Array = values.sum()
            return result
        networks = make_actor_critics(env, config)
        memory, joint = networks.start_memory(steps), networks.joint(seen[None], None)
        _, logits, values = networks.apply(
            parameters, memory, seen[None], joint, jnp.zeros((1, steps), bool)
        )
        return logits.sum() + values.sum()

    def count(steps: int, gradient: bool = False) -> float:
        """Returns XLA's count for a GPU's program, whatever the device: a CPU's has loops, which count as one turn."""
        function = (jax.grad if gradient else lambda same: same)(lambda own: forward(own, steps))
        analysis: Any = (
            jax.jit(function).trace(parameters).lower(lowering_platforms=("cuda",)).cost_analysis()
        )
        return float(analysis["flops"])

    if isinstance(config, VDNConfig):
        # a forward pass each step; in each gradient step one with its gradient, and one of the target network; with `double_q` another
        learning = count(config.batch_size, gradient=True) + count(config.batch_size) * (
            1 + config.double_q
        )
        return count(config.num_envs) * config.num_steps + learning * config.gradient_steps
    # a forward pass each step and one at the end, then the gradient steps
    minibatches = config.num_epochs * config.num_minibatches
    learning = count(config.steps_per_update // config.num_minibatches, gradient=True) * minibatches
    return count(config.num_envs) * (config.num_steps + 1) + learning
