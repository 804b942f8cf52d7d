"""Splits the time of a training update into environment steps, acting and learning, with a lower
bound from its matrices."""

import math
import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, Literal, cast

import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.bench.machine import describe_machine
from sjdsl.bench.timing import median_seconds, race
from sjdsl.runtime.env import Environment
from sjdsl.trainers import make_train
from sjdsl.trainers.algorithms.ppo import Acting
from sjdsl.trainers.algorithms.rollout import Actor, Worlds, collect_rollout
from sjdsl.trainers.algorithms.shaping import make_shaping
from sjdsl.trainers.networks.action_values import make_action_values
from sjdsl.trainers.networks.actor_critics import make_actor_critics, packing_of
from sjdsl.trainers.networks.masks import allowed_in, wants_masks
from sjdsl.trainers.runs.compiled import NoMemoryError, compile_train
from sjdsl.trainers.settings.config import Config, ConfigError, PPOConfig, VDNConfig, make_config

Network = Literal["mlp", "cnn"]
Algorithm = Literal["ippo", "mappo", "vdn"]
Sharing = Literal["shared", "per_agent"]
SIDE = 2048  # of the square matrices whose product gives the machine's speed
# Environment steps of one timing, at least: an update of one short rollout is too short to time
# alone.
TIMED = 2048
# Of the run whose update is measured: schedules of learning rates and of exploration need a length.
UPDATES = 1000
# Environments and steps by default.
ROLLOUT = {
    "ippo": (16, 128),
    "mappo": (16, 128),
    "vdn": (VDNConfig().num_envs, VDNConfig().num_steps),
}


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
    """One update: `num_envs` environments for `num_steps` steps, then learning from them. Seconds
    by round.

    `environments`: the same rollout under a policy that costs nothing; `rollout`: with the network;
    `learning`: the gradient steps alone; `update`: everything. `flops`: of one update's forward and
    backward passes, by XLA's count before it optimises.
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
        """Returns the hours to so many environment steps of one seed, without compiling and
        evaluating, at the speed of the median, the fastest and the slowest round."""
        updates = env_steps / (self.num_envs * self.num_steps)
        median = statistics.median(self.update)
        fastest = min(self.update)
        slowest = max(self.update)
        return updates * median / 3600, updates * fastest / 3600, updates * slowest / 3600


@dataclass(frozen=True)
class Training:
    """The updates measured."""

    machine: dict[str, Any]
    flops_per_s: float  # of a large float32 matrix product on the same machine
    splits: tuple[Split, ...]
    hours_to: int | None = None  # environment steps to which hours are extrapolated
    left_out: tuple[str, ...] = ()  # notes on setups that couldn't be measured


def training_setups(
    envs: Sequence[tuple[str, Environment]],
    networks: Sequence[Network],
    algorithms: Sequence[Algorithm] = ("ippo",),
    sharings: Sequence[Sharing] = ("shared",),
    num_envs: int | None = None,
    num_steps: int | None = None,
) -> tuple[tuple[Setup, ...], tuple[str, ...]]:
    """Returns the setups that can be measured, and a line for each that its game or its sizes
    refuse.

    Args:
      envs: environments with tokens, by name; a game with different numbers of agents has the same
        name.
      networks, algorithms, sharings: all combinations; vdn has one network for all agents, and is
        left out unless `shared` is wanted.
      num_envs, num_steps: of a rollout; None: those of `ROLLOUT`.
    """
    setups = []
    refused = []
    for (name, env), network, algorithm, sharing in product(envs, networks, algorithms, sharings):
        if algorithm == "vdn" and sharing != "shared":
            continue
        default_envs, default_steps = ROLLOUT[algorithm]
        values: dict[str, Any] = {
            "algorithm": algorithm,
            "network": network,
            "num_envs": num_envs or default_envs,
            "num_steps": num_steps or default_steps,
        }
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
    """Returns the parts of updates; one that doesn't fit into memory is left out.

    Args:
      setups: those of `training_setups`.
      repeats: rounds.
      tell: called with a line at the start of each compilation.
      env_steps: environment steps of the run whose hours are extrapolated; None: no hours.
      left_out: a line for each setup that can't be measured.
      keep: called with all figures so far whenever there are new ones.
    """
    training = Training(
        describe_machine(), matrix_flops_per_s(repeats), (), env_steps, tuple(left_out)
    )
    for setup in setups:
        tell(f"compiling {setup}")
        try:
            split = measure_split(setup, repeats)
        except NoMemoryError as error:
            training = replace(training, left_out=(*training.left_out, f"{setup}: {error}"))
        else:
            training = replace(training, splits=(*training.splits, split))
        keep(training)
    return training


def measure_split(setup: Setup, repeats: int) -> Split:
    """Returns the parts of one update, as a run computes it; all are timed in turn, round by
    round.
    """
    env = setup.env
    config = setup.config
    compiled = compile_train(make_train(env, config), config)
    idle = jax.jit(idle_rollout(env, config))
    state = compiled.start()
    flops = flops_of(env, config, compiled.parameters(state))
    worlds = jax.tree.map(jnp.copy, state.worlds)
    state, first_rollout = compiled.collect(state)

    def collect() -> Any:
        nonlocal state
        state, rollout = compiled.collect(state)  # reuses the memory of its argument
        return rollout

    def learn(rollout: Any) -> Any:
        nonlocal state
        state, metrics = compiled.learn(state, rollout)
        return metrics

    updates = math.ceil(TIMED / config.steps_per_update)

    def repeated(part: Callable[[Array], Any]) -> Callable[[Array], Array]:
        """Returns a function that calls a part `updates` times and waits.

        It returns some array of the result, because `race` needs one.
        """

        def run(key: Array) -> Array:
            for _ in range(updates):
                last = part(key)
            result: Array = jax.tree.leaves(jax.block_until_ready(last))[0]
            return result

        return run

    parts: dict[str, Callable[[Array], Any]] = {
        "update": lambda _: learn(collect()),
        "environments": lambda key: idle(worlds, key),
        "rollout": lambda _: collect(),
        "learning": lambda _: learn(first_rollout),
    }
    rates = race(
        list(map(repeated, parts.values())), [updates] * len(parts), repeats, lambda _: None
    )
    seconds = {
        part: tuple(1 / rate for rate in rounds) for part, rounds in zip(parts, rates, strict=True)
    }
    algorithm, sharing = setup.learning
    return Split(
        name=setup.name,
        num_agents=env.num_agents,
        network=setup.network,
        num_envs=config.num_envs,
        num_steps=config.num_steps,
        compile_s=compiled.seconds,
        update=seconds["update"],
        environments=seconds["environments"],
        rollout=seconds["rollout"],
        learning=seconds["learning"],
        flops=flops,
        algorithm=algorithm,
        sharing=sharing,
    )


def matrix_flops_per_s(repeats: int) -> float:
    """Returns the floating-point operations a second of a large matrix product in float32, the
    median of the rounds."""
    matrix = jnp.ones((SIDE, SIDE), jnp.float32)
    product = jax.jit(jnp.matmul)
    return 2 * SIDE**3 / median_seconds(lambda: product(matrix, matrix), repeats)


def idle_rollout(env: Environment, config: Config) -> Callable[[Worlds, Array], Any]:
    """Returns a function of worlds and a key that plays agents without a network, at the cost of
    the environments alone."""
    shape = (config.num_envs, env.num_agents)
    packing = packing_of(env)
    masks = wants_masks(env, config)
    kept: Any = None  # what PPO keeps of acting
    if isinstance(config, PPOConfig):
        kept = Acting(jnp.zeros(shape), jnp.zeros(shape))

    def act(worlds: Worlds, key: Array) -> tuple[Any, Array, Any]:
        actions = jax.random.randint(key, shape, 0, env.num_actions, jnp.int32)
        return worlds.memory, actions, kept

    def follow(memory: Any, info: dict[str, Any]) -> Any:
        """Returns what is kept of the observation after a step: for PPO its values, here 0."""
        del memory
        if isinstance(config, PPOConfig):
            return jnp.zeros(shape)
        mask = allowed_in(env, masks, info.get("terminal_state"))
        return packing.pack(info["terminal_observation"]), mask

    actor = Actor(act, packing.pack, follow)
    shaping = make_shaping(config, env.num_agents)

    def play(worlds: Worlds, key: Array) -> Any:
        _, rollout, *_ = collect_rollout(env, actor, worlds, key, config.num_steps, shaping)
        return rollout

    return play


def flops_of(env: Environment, config: Any, parameters: Any) -> float:
    """Returns the floating-point operations of the networks in an update, acting and learning."""

    def forward(parameters: Any, steps: int) -> Array:
        """The sum of the networks' outputs for so many steps, of one environment or of several."""
        observation = jnp.zeros((steps, *env.observation_shape), jnp.uint8)
        if isinstance(config, VDNConfig):
            values: Any = make_action_values(env, config).apply(parameters, observation)
            result: Array = values.sum()
            return result
        networks = make_actor_critics(env, config)
        memory = networks.start_memory(steps)
        joint = networks.joint(observation[None], None)
        _, logits, values = networks.apply(
            parameters, memory, observation[None], joint, jnp.zeros((1, steps), bool)
        )
        return logits.sum() + values.sum()

    def count(steps: int, gradient: bool = False) -> float:
        """Returns XLA's count for a program of a GPU, on any device.

        A CPU's program has loops, whose bodies count once.
        """

        def function(parameters: Any) -> Array:
            return forward(parameters, steps)

        program = jax.jit(jax.grad(function) if gradient else function).trace(parameters)
        analysis: Any = program.lower(lowering_platforms=("cuda",)).cost_analysis()
        return float(analysis["flops"])

    if isinstance(config, VDNConfig):
        # In each gradient step, the target network computes one forward pass; with `double_q`, the
        # network itself computes another.
        forward_passes = 2 if config.double_q else 1
        gradient_step = count(config.batch_size, gradient=True)
        gradient_step += count(config.batch_size) * forward_passes
        acting = count(config.num_envs) * config.num_steps
        return acting + gradient_step * config.gradient_steps
    minibatches = config.num_epochs * config.num_minibatches
    gradient_step = count(config.steps_per_update // config.num_minibatches, gradient=True)
    acting = count(config.num_envs) * (config.num_steps + 1)  # with the value of the last state
    return acting + gradient_step * minibatches
