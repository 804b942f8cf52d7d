"""Evaluation: plays whole episodes with a policy, and estimates means with confidence intervals."""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import flax
import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.runtime.policy import MemoryPolicy, take_actions
from sjdsl.runtime.returns import collective_return, equality

from ..algorithms.episodes import EpisodeSums, add_step, zero_sums
from ..environment import Environment, where_env
from ..json_files import write_json
from .estimates import Estimate, estimate
from .loading import Policy, with_memory


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
        memory = memory_of(parameters) if memory_of else policy.starts(num_episodes)
        return _play_to_end(env, policy, memory, key, num_episodes).sums

    def evaluate_parameters(key: Array, parameters: Any) -> Evaluation:
        """Plays the episodes with some parameters."""
        sums = jax.device_get(play(key, parameters))
        return Evaluation(
            returns=sums.returns,
            lengths=sums.length,
            events=sums.events,
            metric_means=sums.metric_means,
            metric_finals=sums.metric_finals,
            by_trial={} if sums.trials is None else sums.trials.figures(),
        )

    return evaluate_parameters


@flax.struct.dataclass
class _Episodes:
    """The state of E running episodes."""

    state: Any  # [E, ...]
    observation: Array  # [E, N, P, V, V] uint8
    memory: Any  # [E, ...] of the policy
    sums: EpisodeSums  # [E, ...]
    over: Array  # [E] bool


def _play_to_end(
    env: Environment, policy: MemoryPolicy, memory: Any, key: Array, num_episodes: int
) -> _Episodes:
    """Steps all episodes until the last one is over; steps after an episode's end don't count."""
    reset_key, loop_key = jax.random.split(key)
    observation, state = jax.vmap(env.reset)(jax.random.split(reset_key, num_episodes))
    start = _Episodes(
        state=state,
        observation=observation,
        memory=memory,
        sums=zero_sums(env, num_episodes),
        over=jnp.zeros(num_episodes, bool),
    )

    def play_step(
        key: Array, state: Any, memory: Any, observation: Array
    ) -> tuple[Any, tuple[Array, Any, Array, Array, dict[str, Any]]]:
        """Plays one step of one episode; returns the policy's memory and what the step gave."""
        action_key, env_key = jax.random.split(key)
        memory, actions = take_actions(env, policy, memory, action_key, observation, state)
        stepped = env.step_env(env_key, state, actions)
        _, _, reward, _, info = stepped
        return policy.after_step(memory, actions, reward, info), stepped

    def advance(carry: tuple[Array, _Episodes]) -> tuple[Array, _Episodes]:
        """Plays one step of all episodes; those that are over stay as they are."""
        key, before = carry
        key, step_key = jax.random.split(key)
        keys = jax.random.split(step_key, num_episodes)
        memory, stepped = jax.vmap(play_step)(keys, before.state, before.memory, before.observation)
        observation, state, reward, done, info = stepped
        sums = add_step(before.sums, reward, reward, info)
        after = _Episodes(state, observation, memory, sums, done)
        return key, where_env(before.over, before, after)

    def is_running(carry: tuple[Array, _Episodes]) -> Array:
        _, episodes = carry
        return ~episodes.over.all()

    _, end = jax.lax.while_loop(is_running, advance, (loop_key, start))
    return end


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
