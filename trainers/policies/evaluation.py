"""Evaluation: plays whole episodes with a policy, and estimates means with confidence intervals."""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Protocol

import flax
import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.runtime.policy import take_actions
from sjdsl.runtime.returns import collective_return, equality

from ..algorithms.episodes import EpisodeSums, add_step, zero_sums
from ..environment import Environment, trial_ended, where_env
from ..json_files import write_json
from .estimates import Estimate, estimate
from .loading import MemoryPolicy, Policy, with_memory


@dataclass(frozen=True)
class Evaluation:
    """The results of E episodes, one by one."""

    returns: np.ndarray  # [E, N] raw return of each agent
    lengths: np.ndarray  # [E] steps
    events: Mapping[str, np.ndarray]  # name -> [E, N] or [E] count
    metric_means: Mapping[str, np.ndarray]  # name -> [E] mean over the episode's steps
    metric_finals: Mapping[str, np.ndarray]  # name -> [E] value at its last step
    # name -> [E, K] figure of each trial, summed over agents: `collective_return`, `event_eaten`,
    # `mean_apples`, ...; none in games without trials
    by_trial: Mapping[str, np.ndarray] = field(default_factory=dict)

    @property
    def collective_returns(self) -> np.ndarray:
        """`[E]` raw return summed over agents."""
        result: np.ndarray = collective_return(self.returns)
        return result

    @property
    def equalities(self) -> np.ndarray:
        """`[E]` one minus the Gini coefficient of the agents' returns.

        It is NaN if one is negative or all are 0.
        """
        result: np.ndarray = equality(self.returns)
        return result


EVALUATION = 0x6576616C  # "eval": distinct from the numbers that a run folds into its own keys


def evaluation_key(seed: int, update: int = 0) -> Array:
    """Returns the key of the episodes that evaluate a policy after an update; 0: outside a run.

    It differs from all keys that the run of the same seed learns with: `fold_in(key, i)` is
    `split(key, n)[i]`.
    """
    return jax.random.fold_in(jax.random.fold_in(jax.random.key(seed), EVALUATION), update)


def evaluate(env: Environment, policy: Policy, key: Array, num_episodes: int = 30) -> Evaluation:
    """Plays `num_episodes` episodes side by side, each to its end.

    Args:
      env: one environment.
      policy: `(key, observation [N, P, V, V]) -> actions [N]`; `random_policy(env)`,
        `load_policy(run_dir, env)`, or any function that can be jitted; or a `MemoryPolicy`.
      key: typed key, consumed; the same key gives the same episodes.
      num_episodes: E.
    """
    return make_evaluator(env, lambda _: policy, num_episodes)(key, ())


class Chooser(Protocol):
    """Chooses actions outside of compiled code, in E episodes side by side."""

    def choose(self, observation: np.ndarray, allowed: np.ndarray, over: np.ndarray) -> np.ndarray:
        """Returns actions `[E, N]` int32 before a step; -1 for agents that it leaves to a policy.

        Args:
          observation: `[E, N, P, V, V]` uint8; allowed: `[E, N, A]` bool; over: `[E]` bool.
        """
        ...

    def learn(self, reward: np.ndarray, trial_ended: np.ndarray, over: np.ndarray) -> None:
        """Gets what a step gave: `[E, N]` float32, `[E]` bool and `[E]` bool."""
        ...


@dataclass
class Tape:
    """What replays E episodes, step by step; nothing is cut off after an episode's end.

    keys: `[E, 2]` uint32 of the resets, then of each step; actions: `[E, N]` int32 of each step.
    """

    keys: list[np.ndarray] = field(default_factory=list)
    actions: list[np.ndarray] = field(default_factory=list)


def make_evaluator(
    env: Environment,
    policy_of: Callable[[Any], Policy],
    num_episodes: int,
    memory_of: Callable[[Any], Any] | None = None,
) -> Callable[[Array, Any], Evaluation]:
    """Returns `evaluate` as a function of key and parameters, which is compiled once.

    Args:
      policy_of: returns the policy with the given parameters.
      memory_of: returns the initial memories `[E, ...]` of the episodes; None: the policy's
        `start`.
    """

    @jax.jit
    def play(key: Array, parameters: Any) -> EpisodeSums:
        """Returns the sums over each episode, arrays `[E, ...]`."""
        policy = with_memory(policy_of(parameters))

        def is_running(carry: tuple[Array, _Episodes]) -> Array:
            _, episodes = carry
            return ~episodes.over.all()

        def advance(carry: tuple[Array, _Episodes]) -> tuple[Array, _Episodes]:
            key, episodes = carry
            key, step_key = jax.random.split(key)
            return key, _advance(env, policy, step_key, episodes, None)[0]

        reset_key, key = jax.random.split(key)
        start, _ = _start(env, policy, reset_key, num_episodes, memory_of and memory_of(parameters))
        _, end = jax.lax.while_loop(is_running, advance, (key, start))
        return end.sums

    return lambda key, parameters: _evaluation(play(key, parameters))


def make_host_evaluator(
    env: Environment,
    policy_of: Callable[[Any], Policy],
    num_episodes: int,
    memory_of: Callable[[Any], Any] | None = None,
) -> Callable[[Array, Any, Chooser], tuple[Evaluation, Tape]]:
    """Returns `make_evaluator` as a loop in Python, which asks a chooser before each step.

    With a chooser that leaves all agents to the policy, it plays the same actions and states.
    """

    @jax.jit
    def start(key: Array, parameters: Any) -> tuple[_Episodes, Array]:
        policy = with_memory(policy_of(parameters))
        return _start(env, policy, key, num_episodes, memory_of and memory_of(parameters))

    @jax.jit
    def advance(
        parameters: Any, key: Array, episodes: _Episodes, chosen: Array
    ) -> tuple[_Episodes, tuple[Array, Array, Array, Array]]:
        return _advance(env, with_memory(policy_of(parameters)), key, episodes, chosen)

    @jax.jit
    def allowed_in(state: Any) -> Array:
        """Returns which actions each agent may take, `[E, N, A]` bool."""
        if hasattr(env, "allowed_actions"):
            allowed: Array = jax.vmap(env.allowed_actions)(state)
            return allowed
        return jnp.ones((num_episodes, env.num_agents, env.num_actions), bool)

    def evaluate_parameters(
        key: Array, parameters: Any, chooser: Chooser
    ) -> tuple[Evaluation, Tape]:
        reset_key, key = jax.random.split(key)
        episodes, reset_keys = start(reset_key, parameters)
        tape = Tape([np.asarray(reset_keys)])
        over = np.zeros(num_episodes, bool)
        while not over.all():
            seen = np.asarray(episodes.observation)
            chosen = chooser.choose(seen, np.asarray(allowed_in(episodes.state)), over)
            key, step_key = jax.random.split(key)
            episodes, (reward, ended, actions, keys) = advance(
                parameters, step_key, episodes, chosen
            )
            over = np.asarray(episodes.over)
            chooser.learn(np.asarray(reward), np.asarray(ended), over)
            tape.actions.append(np.asarray(actions))
            tape.keys.append(np.asarray(keys))
        return _evaluation(episodes.sums), tape

    return evaluate_parameters


def _evaluation(sums_on_device: EpisodeSums) -> Evaluation:
    sums: Any = jax.device_get(sums_on_device)
    return Evaluation(
        returns=sums.returns,
        lengths=sums.length,
        events=sums.events,
        metric_means=sums.metric_means,
        metric_finals=sums.metric_finals,
        by_trial=sums.by_trial,
    )


@flax.struct.dataclass
class _Episodes:
    """The state of E running episodes."""

    state: Any  # [E, ...]
    observation: Array  # [E, N, P, V, V] uint8
    memory: Any  # [E, ...] of the policy
    sums: EpisodeSums  # [E, ...]
    over: Array  # [E] bool


def _start(
    env: Environment, policy: MemoryPolicy, key: Array, num_episodes: int, memory: Any
) -> tuple[_Episodes, Array]:
    """Returns the episodes before their first step, and the data `[E, 2]` of their resets' keys.

    Args:
      memory: None: as the policy starts.
    """
    reset_keys = jax.random.split(key, num_episodes)
    words = jax.random.key_data(reset_keys)
    observation, state = jax.vmap(env.reset)(reset_keys)
    episodes = _Episodes(
        state=state,
        observation=observation,
        memory=policy.starts(num_episodes) if memory is None else memory,
        sums=zero_sums(env, num_episodes),
        over=jnp.zeros(num_episodes, bool),
    )
    return episodes, words


def _advance(
    env: Environment, policy: MemoryPolicy, key: Array, before: _Episodes, chosen: Array | None
) -> tuple[_Episodes, tuple[Array, Array, Array, Array]]:
    """Plays one step of all episodes; those that are over stay as they are.

    Args:
      chosen: `[E, N]` int32, actions that replace the policy's where they aren't negative.
    Returns:
      the episodes afterwards, and of the step the rewards `[E, N]`, whether it ended a trial,
      `[E]` bool, the actions `[E, N]` int32 and the data of the keys, `[E, 2]`.
    """

    def play_step(
        key: Array, state: Any, memory: Any, observation: Array, chosen: Array | None
    ) -> tuple[Any, Array, Array, tuple[Array, Any, Array, Array, dict[str, Any]]]:
        """Plays one step of one episode.

        Returns the policy's memory, the actions, the data of the step's key and what it gave.
        """
        action_key, env_key = jax.random.split(key)
        memory, actions = take_actions(env, policy, memory, action_key, observation, state)
        if chosen is not None:
            actions = jnp.where(chosen >= 0, chosen, actions)
        words = jax.random.key_data(env_key)
        stepped = env.step_env(env_key, state, actions)
        _, _, reward, _, info = stepped
        return policy.after_step(memory, actions, reward, info), actions, words, stepped

    keys = jax.random.split(key, len(before.over))
    memory, actions, words, stepped = jax.vmap(play_step)(
        keys, before.state, before.memory, before.observation, chosen
    )
    observation, state, reward, done, info = stepped
    sums = add_step(before.sums, reward, reward, info)
    after = _Episodes(state, observation, memory, sums, done)
    step = (reward, trial_ended(info), actions, words)
    return where_env(before.over, before, after), step


def summarise(evaluation: Evaluation) -> dict[str, Estimate]:
    """Returns an estimate for each figure: returns, equality, lengths, events and metrics."""
    figures = {"collective return": evaluation.collective_returns}
    figures |= _by_agent("return", evaluation.returns)
    figures["equality"] = evaluation.equalities
    figures["episode length"] = evaluation.lengths
    for name, counts in evaluation.events.items():
        if counts.ndim == 1:
            figures[f"event {name}"] = counts
        else:
            figures[f"event {name}"] = counts.sum(axis=1)
            figures |= _by_agent(f"event {name}", counts)
    figures |= {f"mean {name}": values for name, values in evaluation.metric_means.items()}
    figures |= {f"final {name}": values for name, values in evaluation.metric_finals.items()}
    for name, of_trials in evaluation.by_trial.items():
        for trial, values in enumerate(np.asarray(of_trials).T):
            figures[f"{name.replace('_', ' ', 1)} of trial {trial}"] = values
    return {name: estimate(samples) for name, samples in figures.items()}


def _by_agent(name: str, figures: np.ndarray) -> dict[str, np.ndarray]:
    """Returns the columns of figures `[E, N]`."""
    return {f"{name} of agent {agent}": column for agent, column in enumerate(figures.T)}


def save_evaluation(
    evaluation: Evaluation, path: Path | str, played: Mapping[str, Any] | None = None
) -> None:
    """Writes the estimates and all episodes to a JSON file; undefined figures are null.

    Args:
      played: further entries, as JSON values.
    """
    content = {
        **(played or {}),
        "episodes": len(evaluation.lengths),
        "summary": {name: asdict(figure) for name, figure in summarise(evaluation).items()},
        "per_episode": {
            **asdict(evaluation),
            "collective_returns": evaluation.collective_returns,
            "equalities": evaluation.equalities,
        },
    }
    write_json(Path(path), content)
