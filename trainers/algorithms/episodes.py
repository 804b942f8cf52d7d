"""Episode statistics inside a jitted loop: summed while an episode runs, recorded when it ends."""

import math
from dataclasses import replace
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
    trials: "EpisodeSums | None" = None  # of each of K trials, [B, K, ...]; None: no trials

    @property
    def metric_means(self) -> dict[str, Array]:
        """Name -> `[B]` mean over the episode's steps."""
        return {name: total / self.length for name, total in self.metric_sums.items()}

    @property
    def by_trial(self) -> dict[str, Array]:
        """Figure -> `[B, K]` of each trial, summed over agents; none in games without trials."""
        if self.trials is None:
            return {}
        shape = self.trials.length.shape
        trials = replace(self.trials, length=jnp.maximum(self.trials.length, 1))
        figures = {"collective_return": trials.returns.sum(axis=-1)}
        for name, counts in trials.events.items():
            figures[f"event_{name}"] = counts.reshape(*shape, -1).sum(axis=-1)
        figures |= {f"final_{name}": value for name, value in trials.metric_finals.items()}
        return figures | {f"mean_{name}": value for name, value in trials.metric_means.items()}


# Totals over the episodes that have ended, by the names of their metrics; divided by their number,
# `episodes`, the mean episode. `equality` is of those where it is defined, `equalities` in number.
FinishedEpisodes = dict[str, Any]


def zero_sums(env: Environment, num_envs: int) -> EpisodeSums:
    """Returns the sums of `num_envs` episodes before their first step."""
    info = info_shapes(env)

    def zeros(*shape: int) -> EpisodeSums:
        no_metrics = {name: jnp.zeros(shape, jnp.float32) for name in info["metrics"]}
        no_returns = jnp.zeros((*shape, env.num_agents), jnp.float32)
        no_events = {
            name: jnp.zeros((*shape, *count.shape), jnp.int32)
            for name, count in info["events"].items()
        }
        no_steps = jnp.zeros(shape, jnp.int32)
        return EpisodeSums(no_steps, no_returns, no_returns, no_events, no_metrics, no_metrics)

    trials = num_trials(env)
    sums = zeros(num_envs)
    return sums if trials == 1 else replace(sums, trials=zeros(num_envs, trials))


def add_step(
    sums: EpisodeSums, reward: Array, shaped_reward: Array, info: dict[str, Any]
) -> EpisodeSums:
    """Returns the sums after one more step of B episodes; `info` as the step gave it."""
    trials = sums.trials
    if trials is not None:
        step = (reward, shaped_reward, info["events"], info["metrics"])
        of_each = jax.tree.map(lambda leaf: leaf[:, None], step)  # the same for all trials
        is_now = jnp.arange(trials.length.shape[1]) == info["trial"][:, None]
        trials = where_env(is_now, _add(trials, *of_each), trials)
    after = _add(sums, reward, shaped_reward, info["events"], info["metrics"])
    return replace(after, trials=trials)


def _add(
    sums: EpisodeSums,
    reward: Array,
    shaped_reward: Array,
    events: dict[str, Array],
    metrics: dict[str, Array],
) -> EpisodeSums:
    """Returns the sums after one more step, without those of trials."""
    return EpisodeSums(
        length=sums.length + 1,
        returns=sums.returns + reward,
        shaped_returns=sums.shaped_returns + shaped_reward,
        events=jax.tree.map(jnp.add, sums.events, events),
        metric_sums=jax.tree.map(jnp.add, sums.metric_sums, metrics),
        metric_finals=metrics,
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
