"""Episode statistics inside a jitted loop: summed while an episode runs, recorded when it ends."""

import math
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
class TrialSums:
    """Sums over the K trials of B episodes so far, over agents too."""

    length: Array  # [B, K] int32, steps
    returns: Array  # [B, K] float32, raw rewards
    events: dict[str, Array]  # name -> [B, K] int32, counts
    metric_sums: dict[str, Array]  # name -> [B, K] float32, over steps
    metric_finals: dict[str, Array]  # name -> [B, K] float32, at the last step

    def figures(self) -> dict[str, Array]:
        """Returns `[B, K]` figures by the names of their metrics."""
        figures = {"collective_return": self.returns}
        for name, count in self.events.items():
            figures[f"event_{name}"] = count
        for name, total in self.metric_sums.items():
            figures[f"mean_{name}"] = total / jnp.maximum(self.length, 1)
        for name, value in self.metric_finals.items():
            figures[f"final_{name}"] = value
        return figures


@flax.struct.dataclass
class EpisodeSums:
    """Sums over B episodes so far."""

    length: Array  # [B] int32, steps
    returns: Array  # [B, N] float32, raw rewards
    shaped_returns: Array  # [B, N] float32, rewards learnt from
    events: dict[str, Array]  # name -> [B, N] or [B] int32, counts
    metric_sums: dict[str, Array]  # name -> [B] float32, over steps
    metric_finals: dict[str, Array]  # name -> [B] float32, at the last step
    trials: TrialSums | None = None  # None in games without trials

    @property
    def metric_means(self) -> dict[str, Array]:
        """Name -> `[B]` mean over the episode's steps."""
        return {name: total / self.length for name, total in self.metric_sums.items()}


@flax.struct.dataclass
class FinishedEpisodes:
    """Totals over the episodes that have ended; divided by their number, the mean episode."""

    episodes: Array  # [] int32, their number
    length: Array  # [] int32
    returns: Array  # [N] float32
    shaped_returns: Array  # [N] float32
    equality: Array  # [] float32, of those where it is defined
    equalities: Array  # [] int32, in how many it is
    events: dict[str, Array]  # name -> [N] or [] int32
    metric_means: dict[str, Array]  # name -> [] float32, of means over steps
    metric_finals: dict[str, Array]  # name -> [] float32
    by_trial: dict[str, Array]  # name -> [K] float32 or int32; none in games without trials


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


def _zero_trials(info: dict[str, Any], num_envs: int, trials: int) -> TrialSums | None:
    """Returns the sums before the first step; None in games without trials."""
    if trials == 1:
        return None
    no_counts = jnp.zeros((num_envs, trials), jnp.int32)
    no_values = jnp.zeros((num_envs, trials), jnp.float32)
    no_metrics = dict.fromkeys(info["metrics"], no_values)
    return TrialSums(
        length=no_counts,
        returns=no_values,
        events=dict.fromkeys(info["events"], no_counts),
        metric_sums=no_metrics,
        metric_finals=no_metrics,
    )


def _add_to_trials(sums: TrialSums, reward: Array, info: dict[str, Any]) -> TrialSums:
    """Returns the sums after one more step of each of B episodes, in the trial `info["trial"]`."""
    batch = jnp.arange(reward.shape[0])
    trial = info["trial"]

    def added(total: Array, amount: Array) -> Array:
        of_all_agents = amount.reshape(amount.shape[0], -1).sum(axis=-1, dtype=total.dtype)
        return total.at[batch, trial].add(of_all_agents)

    metrics = info["metrics"]
    return TrialSums(
        length=sums.length.at[batch, trial].add(1),
        returns=added(sums.returns, reward),
        events={name: added(count, info["events"][name]) for name, count in sums.events.items()},
        metric_sums={name: added(total, metrics[name]) for name, total in sums.metric_sums.items()},
        metric_finals={
            name: value.at[batch, trial].set(metrics[name])
            for name, value in sums.metric_finals.items()
        },
    )


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
        trials=None if sums.trials is None else _add_to_trials(sums.trials, reward, info),
    )


def split_finished(sums: EpisodeSums, done: Array) -> tuple[EpisodeSums, FinishedEpisodes]:
    """Splits sums of B episodes by whether they are done, `[B]` bool.

    Returns the sums of those that continue, zero where they ended, and the totals of the others.
    """
    equal = equality(sums.returns)
    ended = FinishedEpisodes(
        episodes=jnp.ones_like(sums.length),
        length=sums.length,
        returns=sums.returns,
        shaped_returns=sums.shaped_returns,
        equality=jnp.nan_to_num(equal),
        equalities=jnp.isfinite(equal).astype(jnp.int32),
        events=sums.events,
        metric_means=sums.metric_means,
        metric_finals=sums.metric_finals,
        by_trial={} if sums.trials is None else sums.trials.figures(),
    )
    counted = where_env(done, ended, jax.tree.map(jnp.zeros_like, ended))
    total = jax.tree.map(lambda leaf: leaf.sum(axis=0, dtype=leaf.dtype), counted)
    return where_env(done, jax.tree.map(jnp.zeros_like, sums), sums), total


def mean_episode(total: FinishedEpisodes) -> dict[str, Any]:
    """Returns the mean finished episode.

    Missing values are zeros, so that no program returns NaN: see `without_value`.
    """
    number = jnp.maximum(total.episodes, 1)
    mean = jax.tree.map(lambda leaf: leaf / number, total)
    return {
        "episodes": total.episodes,
        "equalities": total.equalities,
        "episode_length": mean.length,
        "collective_return": collective_return(mean.returns),
        "agent_return": mean.returns,
        "shaped_agent_return": mean.shaped_returns,
        "equality": mean.equality,
        "event": mean.events,
        "mean": mean.metric_means,
        "final": mean.metric_finals,
        "by_trial": mean.by_trial,
    }


def without_value(metrics: dict[str, Any]) -> set[str]:
    """Returns the metrics of a mean episode without a value.

    These are all but the counts if no episode finished; the equality if one of them lacks it.
    """
    if metrics["episodes"] == 0:
        return OF_EPISODES
    is_partial = metrics.get("equalities", math.inf) < metrics["episodes"]
    return {"equality"} if is_partial else set()
