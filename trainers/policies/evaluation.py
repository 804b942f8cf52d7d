"""Evaluation: plays whole episodes with a policy, and estimates means with confidence intervals."""

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
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
from ..environment import Environment
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

    @property
    def collective_returns(self) -> np.ndarray:
        """`[E]` raw return summed over agents."""
        result: np.ndarray = collective_return(self.returns)
        return result

    @property
    def equalities(self) -> np.ndarray:
        """`[E]` one minus the Gini coefficient of the agents' returns; NaN if one is negative or all are 0."""
        result: np.ndarray = equality(self.returns)
        return result


EVALUATION = 0x6576616C  # "eval": distinct from the numbers that a run folds into its own keys


def evaluation_key(seed: int, update: int = 0) -> Array:
    """Returns the key of the episodes that evaluate a policy after an update; 0: outside a run.

    It differs from all keys that the run of the same seed learns with: `fold_in(key, i)` is `split(key, n)[i]`.
    """
    return jax.random.fold_in(jax.random.fold_in(jax.random.key(seed), EVALUATION), update)


def evaluate(env: Environment, policy: Policy, key: Array, num_episodes: int = 30) -> Evaluation:
    """Plays `num_episodes` episodes side by side, each to its end.

    Args:
      env: one environment.
      policy: `(key, observation [N, P, V, V]) -> actions [N]`; `random_policy(env)`, `load_policy(run_dir, env)`, or
        any function that can be jitted; or a `MemoryPolicy`.
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
      memory_of: returns the initial memories `[E, ...]` of the episodes; None: the policy's `start`.
    """

    def run(key: Array, parameters: Any) -> EpisodeSums:
        policy = with_memory(policy_of(parameters))
        if memory_of is None:
            memory = jax.tree.map(
                lambda leaf: jnp.broadcast_to(leaf, (num_episodes, *jnp.shape(leaf))), policy.start
            )
        else:
            memory = memory_of(parameters)
        return _play(env, policy, memory, key, num_episodes).sums

    play = jax.jit(run)

    def played(key: Array, parameters: Any) -> Evaluation:
        sums = jax.device_get(play(key, parameters))
        return Evaluation(
            sums.returns, sums.length, sums.events, sums.metric_means, sums.metric_finals
        )

    return played


@flax.struct.dataclass
class _Play:
    """The state of E running episodes."""

    state: Any  # [E, ...]
    observation: Array  # [E, N, P, V, V] uint8
    memory: Any  # [E, ...] of the policy
    sums: EpisodeSums  # [E, ...]
    over: Array  # [E] bool


def _play(
    env: Environment, policy: MemoryPolicy, memory: Any, key: Array, num_episodes: int
) -> _Play:
    """Steps all episodes until the last one is over; steps after an episode's end are not counted."""
    reset_key, loop_key = jax.random.split(key)
    observation, state = jax.vmap(env.reset)(jax.random.split(reset_key, num_episodes))
    start = _Play(
        state, observation, memory, zero_sums(env, num_episodes), jnp.zeros(num_episodes, bool)
    )

    def play_step(
        key: Array, state: Any, memory: Any, observation: Array
    ) -> tuple[Any, tuple[Array, Any, Array, Array, dict[str, Any]]]:
        action_key, env_key = jax.random.split(key)
        memory, actions = take_actions(env, policy, memory, action_key, observation, state)
        return memory, env.step_env(env_key, state, actions)

    def advance(carry: tuple[Array, _Play]) -> tuple[Array, _Play]:
        key, step_key = jax.random.split(carry[0])
        before = carry[1]
        keys = jax.random.split(step_key, num_episodes)
        memory, stepped = jax.vmap(play_step)(keys, before.state, before.memory, before.observation)
        observation, state, reward, done, info = stepped
        after = _Play(
            state=state,
            observation=observation,
            memory=memory,
            sums=add_step(before.sums, reward, reward, info),
            over=done,
        )

        def keep_if_over(new: Array, old: Array) -> Array:
            return jnp.where(before.over.reshape(-1, *[1] * (new.ndim - 1)), old, new)

        return key, jax.tree.map(keep_if_over, after, before)

    return jax.lax.while_loop(lambda carry: ~carry[1].over.all(), advance, (loop_key, start))[1]


def summarise(evaluation: Evaluation) -> dict[str, Estimate]:
    """Returns an estimate for each figure: collective return, each agent's return, lengths, events and metrics."""
    figures = {"collective return": evaluation.collective_returns}
    figures |= {
        f"return of agent {index}": column for index, column in enumerate(evaluation.returns.T)
    }
    figures["equality"] = evaluation.equalities
    figures["episode length"] = evaluation.lengths
    for name, counts in evaluation.events.items():
        figures[f"event {name}"] = counts if counts.ndim == 1 else counts.sum(axis=1)
        if counts.ndim == 2:
            figures |= {
                f"event {name} of agent {index}": column for index, column in enumerate(counts.T)
            }
    figures |= {f"mean {name}": values for name, values in evaluation.metric_means.items()}
    figures |= {f"final {name}": values for name, values in evaluation.metric_finals.items()}
    return {name: estimate(samples) for name, samples in figures.items()}


def save_evaluation(
    evaluation: Evaluation, path: Path | str, played: Mapping[str, Any] | None = None
) -> None:
    """Writes the estimates and all episodes to a JSON file; undefined figures are null. `played`: further entries, as JSON values."""
    groups = {
        "collective_returns": evaluation.collective_returns,
        "equalities": evaluation.equalities,
    }
    per_episode = dataclasses.asdict(evaluation) | groups
    summary = {name: dataclasses.asdict(figure) for name, figure in summarise(evaluation).items()}
    write_json(
        Path(path),
        {
            **(played or {}),
            "episodes": len(evaluation.lengths),
            "summary": summary,
            "per_episode": per_episode,
        },
    )
