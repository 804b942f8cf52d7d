"""Episode statistics inside a jitted loop: summed while an episode runs, recorded when it ends."""

import math
from dataclasses import field
from typing import Any

import flax
import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.returns import collective_return, equality

from ..environment import Environment, info_shapes, num_trials, where_env

# metrics that have no value if no episode has finished
OF_EPISODES = {
    "episode_length",
    "collective_return",
    "agent_return",
    "shaped_agent_return",
    "equality",
    "event",
    "mean",
    "final",
    "by_trial",
}


@flax.struct.dataclass
class EpisodeSums:
    """Sums over B episodes so far."""

    length: Array  # [B] int32, steps
    returns: Array  # [B, N] float32, raw rewards
    shaped_returns: Array  # [B, N] float32, rewards learnt from
    events: dict[str, Array]  # name -> [B, N] or [B] int32, counts
    metric_sums: dict[str, Array]  # name -> [B] float32, over steps
    metric_finals: dict[str, Array]  # name -> [B] float32, at the last step
    # figure -> [B, K] of the K trials, summed over agents; `length` and the names of metrics, with
    # sums over steps in place of means; none in games without trials
    trials: dict[str, Array] = field(default_factory=dict)

    @property
    def metric_means(self) -> dict[str, Array]:
        """Name -> `[B]` mean over the episode's steps."""
        return {name: total / self.length for name, total in self.metric_sums.items()}

    @property
    def by_trial(self) -> dict[str, Array]:
        """Figure -> `[B, K]` of each trial; none in games without trials."""
        figures = dict(self.trials)
        if not figures:
            return figures
        length = figures.pop("length")
        for name, total in figures.items():
            if name.startswith("mean_"):
                figures[name] = total / jnp.maximum(length, 1)
        return figures


# Totals over the episodes that have ended, by the names of their metrics; divided by their number,
# `episodes`, the mean episode. `equality` is of those where it is defined, `equalities` in number.
FinishedEpisodes = dict[str, Any]


def zero_sums(env: Environment, num_envs: int) -> EpisodeSums:
    """Returns the sums of `num_envs` episodes before their first step."""
    info = info_shapes(env)
    no_metrics = {name: jnp.zeros(num_envs, jnp.float32) for name in info["metrics"]}
    no_returns = jnp.zeros((num_envs, env.num_agents), jnp.float32)
    no_events = {
        name: jnp.zeros((num_envs, *count.shape), jnp.int32)
        for name, count in info["events"].items()
    }
    return EpisodeSums(
        length=jnp.zeros(num_envs, jnp.int32),
        returns=no_returns,
        shaped_returns=jnp.zeros_like(no_returns),
        events=no_events,
        metric_sums=no_metrics,
        metric_finals=no_metrics,
        trials=_zero_trials(info, num_envs, num_trials(env)),
    )


def _zero_trials(info: dict[str, Any], num_envs: int, trials: int) -> dict[str, Array]:
    """Returns the sums of each trial before the first step; none in games without trials."""
    if trials == 1:
        return {}
    counts = ["length", *(f"event_{name}" for name in info["events"])]
    values = ["collective_return"]
    for name in info["metrics"]:
        values += [f"mean_{name}", f"final_{name}"]
    no_counts = jnp.zeros((num_envs, trials), jnp.int32)
    no_values = jnp.zeros((num_envs, trials), jnp.float32)
    return dict.fromkeys(counts, no_counts) | dict.fromkeys(values, no_values)


def _add_to_trials(sums: dict[str, Array], reward: Array, info: dict[str, Any]) -> dict[str, Array]:
    """Returns the sums after one more step of each of B episodes, in the trial `info["trial"]`."""
    step = {"length": jnp.ones(len(reward), jnp.int32), "collective_return": reward}
    step |= {f"event_{name}": count for name, count in info["events"].items()}
    for name, value in info["metrics"].items():
        step |= {f"mean_{name}": value, f"final_{name}": value}
    after = {}
    for name, total in sums.items():
        of_all_agents = step[name].reshape(len(reward), -1).sum(axis=-1, dtype=total.dtype)
        of_trial = total.at[jnp.arange(len(reward)), info["trial"]]
        is_last = name.startswith("final_")
        after[name] = of_trial.set(of_all_agents) if is_last else of_trial.add(of_all_agents)
    return after


def add_step(
    sums: EpisodeSums, reward: Array, shaped_reward: Array, info: dict[str, Any]
) -> EpisodeSums:
    """Returns the sums after one more step of B episodes; `info` as the step gave it."""
    return EpisodeSums(
        length=sums.length + 1,
        returns=sums.returns + reward,
        shaped_returns=sums.shaped_returns + shaped_reward,
        events={name: count + info["events"][name] for name, count in sums.events.items()},
        metric_sums={
            name: total + info["metrics"][name] for name, total in sums.metric_sums.items()
        },
        metric_finals=info["metrics"],
        trials=_add_to_trials(sums.trials, reward, info),
    )


def split_finished(sums: EpisodeSums, done: Array) -> tuple[EpisodeSums, FinishedEpisodes]:
    """Splits sums of B episodes by whether they are done, `[B]` bool.

    Returns the sums of those that continue, zero where they ended, and the totals of the others.
    """
    equal = equality(sums.returns)
    ended = {
        "episodes": jnp.ones_like(sums.length),
        "equalities": jnp.isfinite(equal).astype(jnp.int32),
        "episode_length": sums.length,
        "agent_return": sums.returns,
        "shaped_agent_return": sums.shaped_returns,
        "equality": jnp.nan_to_num(equal),
        "event": sums.events,
        "mean": sums.metric_means,
        "final": sums.metric_finals,
        "by_trial": sums.by_trial,
    }
    counted = where_env(done, ended, jax.tree.map(jnp.zeros_like, ended))
    total = jax.tree.map(lambda leaf: leaf.sum(axis=0, dtype=leaf.dtype), counted)
    return where_env(done, jax.tree.map(jnp.zeros_like, sums), sums), total


def mean_episode(total: FinishedEpisodes) -> dict[str, Any]:
    """Returns the mean finished episode.

    Missing values are zeros, so that no program returns NaN: see `without_value`.
    """
    number = jnp.maximum(total["episodes"], 1)
    mean: dict[str, Any] = jax.tree.map(lambda leaf: leaf / number, total)
    counts = {name: total[name] for name in ("episodes", "equalities")}
    return mean | counts | {"collective_return": collective_return(mean["agent_return"])}


def without_value(metrics: dict[str, Any]) -> set[str]:
    """Returns the metrics of a mean episode without a value.

    These are all but the counts if no episode finished; the equality if one of them lacks it.
    """
    if metrics["episodes"] == 0:
        return OF_EPISODES
    is_partial = metrics.get("equalities", math.inf) < metrics["episodes"]
    return {"equality"} if is_partial else set()
