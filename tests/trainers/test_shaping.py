"""Shaped rewards against their closed forms, and against loops written from the papers' definitions."""

import math
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from probes import tabled, tables_of, uneven

from sjdsl.trainers import ConfigError, load_preset, make_config
from sjdsl.trainers.algorithms.rollout import Actor, Rollout, Worlds, collect_rollout, start_worlds
from sjdsl.trainers.algorithms.shaping import (
    Shaping,
    exchanged,
    kept_share,
    make_shaping,
    svo_deviation,
)
from sjdsl.trainers.runs.checkpoints import Checkpoints

REWARD = jnp.array([[[1.0, -2.0, 4.0]], [[0.0, 0.5, 0.0]]])  # [T=2, B=1, N=3]
MODES = ("individual", "common", "svo", "exchange", "inequity")


def shaped(raw: jax.Array, trace: jax.Array | None = None, **values: object) -> np.ndarray:
    """Returns rewards `[..., N]` as a configuration shapes them; traces are the rewards unless given."""
    shaping = make_shaping(make_config(values), raw.shape[-1])
    step = SimpleNamespace(reward=raw, trace=raw if trace is None else trace)
    return np.asarray(shaping.shape(step))


MEAN = [[[1.0] * 3], [[0.5 / 3] * 3]]


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"reward": "individual"}, REWARD),
        ({"reward": "common"}, [[[3.0] * 3], [[0.5] * 3]]),
        ({"reward": "common", "common_reward": "mean"}, MEAN),
        ({"reward": "exchange", "exchange_ratio": 0}, REWARD),
        ({"reward": "exchange", "exchange_ratio": 1}, MEAN),
    ],
)
def test_own_rewards_and_those_of_all(values: dict[str, Any], expected: Any) -> None:
    np.testing.assert_allclose(shaped(REWARD, **values), expected, rtol=1e-6)


@pytest.mark.parametrize("mode", MODES)
def test_one_agent_alone_has_its_own_reward(mode: str) -> None:
    """Alone at 0 degrees it deviates from nothing, exchanges with nobody and envies nobody."""
    alone = jnp.array([[1.0], [0.0], [2.5]])
    np.testing.assert_allclose(
        shaped(alone, reward=mode, **({"svo_angle": 0} if mode == "svo" else {})), alone, rtol=1e-6
    )


# social value orientation


def deviation(
    own: float, others: float, sought: float, at_rest: str = "selfish", quadrant: bool = True
) -> float:
    """Returns agent 0's deviation in degrees, where the others have `others` on average."""
    trace = jnp.array([own, others - 1.0, others + 1.0] if others else [own, 0.0, 0.0])
    return math.degrees(
        svo_deviation(trace, jnp.full(3, math.radians(sought)), at_rest, quadrant)[0]
    )


@pytest.mark.parametrize(
    ("own", "others", "angle"),
    [
        (1.0, 0.0, 0.0),
        (2.0, 2.0, 45.0),
        (0.0, 3.0, 90.0),
        (1.0, 3.0**0.5, 60.0),
        (3.0**0.5, 1.0, 30.0),
    ],
)
@pytest.mark.parametrize("sought", [0.0, 45.0, 90.0])
def test_the_orientation_is_the_angle_of_own_and_others_rewards(
    own: float, others: float, angle: float, sought: float
) -> None:
    assert deviation(own, others, sought) == pytest.approx(abs(angle - sought), abs=1e-3)


@pytest.mark.parametrize(("at_rest", "degrees"), [("content", 0.0), ("selfish", 90.0)])
def test_where_nobody_is_rewarded(at_rest: str, degrees: float) -> None:
    assert deviation(0.0, 0.0, 90.0, at_rest) == pytest.approx(degrees, abs=1e-3)


@pytest.mark.parametrize(
    ("own", "others", "angle", "cut"),
    [
        (-2.0, 2.0, 135.0, 90.0),
        (2.0, -2.0, -45.0, 0.0),
        (-2.0, -2.0, -135.0, 0.0),
        (-1.0, 0.0, 180.0, 90.0),
    ],
)
def test_the_quadrant_cuts_what_negative_rewards_lead_to(
    own: float, others: float, angle: float, cut: float
) -> None:
    assert deviation(own, others, 0.0) == pytest.approx(cut, abs=1e-3)
    assert deviation(own, others, 0.0, quadrant=False) == pytest.approx(abs(angle), abs=1e-3)


@pytest.mark.parametrize("own", [-2.0, -1.0, 0.0, 1.0])
@pytest.mark.parametrize("other", [-2.0, -1.0, 0.0, 1.0])
def test_the_released_preset_penalises_as_the_released_code(own: float, other: float) -> None:
    """Each pair of rewards that Coins pays two agents: the plain difference of arctan2, counted from where nobody is rewarded."""
    config = load_preset("released", {"reward": "svo"}, "coins").config
    angle = math.atan2(other, own) if own or other else 0.0
    expected = 2 * (own - config.svo_weight * (abs(angle - math.pi / 2) - math.pi / 2))
    paid = jnp.array([own, other])
    found = make_shaping(config, 2).shape(SimpleNamespace(reward=paid, trace=paid))
    assert found[0] == pytest.approx(expected, rel=1e-5)


def test_svo_deducts_the_weighted_deviation_in_radians_beyond_that_at_rest() -> None:
    """Three agents; the mean of the others is 1, 2.5 and -0.5: 45 degrees, 90 cut from 128.7, and 0 cut from -7.1."""
    angles = np.radians([45.0, 90.0, 0.0])
    expected = np.asarray(REWARD[0, 0]) - 0.2 * (
        np.abs(angles - np.radians(90.0)) - np.radians(90.0)
    )
    np.testing.assert_allclose(
        shaped(REWARD[0, 0], reward="svo", svo_weight=0.2), expected, rtol=1e-5
    )


def test_each_agent_may_seek_an_angle_of_its_own() -> None:
    found = shaped(jnp.array([1.0, 1.0, 1.0]), reward="svo", svo_weight=1.0, svo_angle=(0, 45, 90))
    np.testing.assert_allclose(
        found, [1 - math.pi / 4, 1 + math.pi / 4, 1 + math.pi / 4], rtol=1e-5
    )


def test_there_must_be_one_angle_or_one_for_each() -> None:
    with pytest.raises(
        ConfigError, match="`svo_angle` must be one angle, or one for each of the 3 agents, not 2"
    ):
        make_shaping(make_config(reward="svo", svo_angle=(0, 45)), 3)


def test_svo_compares_traces_and_pays_rewards() -> None:
    found = shaped(
        jnp.array([2.0, 0.0]), jnp.array([0.0, 5.0]), reward="svo", svo_weight=1.0, svo_angle=90
    )
    np.testing.assert_allclose(found, [2.0 + math.pi / 2, 0.0], rtol=1e-6)


@pytest.mark.parametrize("at_rest", ["selfish", "content"])
def test_svo_deducts_nothing_while_nobody_is_rewarded(at_rest: str) -> None:
    """A loss in each step of an episode would hide from the critic what agents do."""
    np.testing.assert_array_equal(
        shaped(
            jnp.zeros(3), reward="svo", svo_weight=1.0, svo_angle=(0, 45, 90), svo_at_rest=at_rest
        ),
        jnp.zeros(3),
    )


# reward exchange


@pytest.mark.parametrize(
    ("ratio", "number", "share"),
    [(0.0, 5, 1.0), (1.0, 4, 0.25), (0.5, 2, 2 / 3), (0.5, 7, 0.25), (0.3, 1, 1.0)],
)
def test_kept_share(ratio: float, number: int, share: float) -> None:
    """The shares of ratio 1/2 are those of SocialJax's configurations: .6667 of two agents, .25 of seven."""
    assert kept_share(ratio, number) == pytest.approx(share)


def test_exchange_counts_others_rewards_by_the_ratio() -> None:
    """u_i is proportional to r_i + ratio * the sum of the others', and sums to what is paid."""
    reward = np.array([1.0, -2.0, 4.0, 0.5])
    wanted = np.array([reward[i] + 0.3 * (reward.sum() - reward[i]) for i in range(4)])
    wanted *= reward.sum() / wanted.sum()
    np.testing.assert_allclose(
        exchanged(jnp.asarray(reward), kept_share(0.3, 4)), wanted, rtol=1e-5
    )


# inequity aversion


def test_inequity_aversion_is_the_double_sum() -> None:
    draw = np.random.default_rng(0)
    reward, trace = draw.normal(size=(2, 6, 5)).astype(np.float32)
    expected = reward.copy()
    for row in range(6):
        for i in range(5):
            for j in range(5):
                expected[row, i] -= 3.0 / 4 * max(trace[row, j] - trace[row, i], 0)
                expected[row, i] -= 0.7 / 4 * max(trace[row, i] - trace[row, j], 0)
    found = shaped(
        jnp.asarray(reward),
        jnp.asarray(trace),
        reward="inequity",
        inequity_envy=3.0,
        inequity_guilt=0.7,
    )
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-5)


# scaling


@pytest.mark.parametrize("mode", [mode for mode in MODES if mode != "common"])
def test_socialjax_scales_what_is_each_agents_own(mode: str) -> None:
    """Rewards of an agent are times their number there; the common sum is the sum, and reads no scale."""
    plain, scaled = (shaped(REWARD, reward=mode, match_socialjax=match) for match in (False, True))
    np.testing.assert_allclose(scaled, 3.0 * plain, rtol=1e-6)


def test_socialjax_sums_the_common_sum_again_for_vdn() -> None:
    plain, scaled = (
        shaped(REWARD, algorithm="vdn", match_socialjax=match) for match in (False, True)
    )
    np.testing.assert_array_equal(plain[0, 0], [3.0, 3.0, 3.0])
    np.testing.assert_allclose(scaled, 3.0 * plain)


# traces


def player(
    shaping: Shaping, num_steps: int = 3, horizons: Sequence[float] = ()
) -> tuple[Worlds, Callable[[Worlds, jax.Array], tuple[Worlds, Rollout]]]:
    """Returns eight worlds of `uneven`, and what plays a rollout in them. Episodes of two and five steps are cut anywhere."""
    env = tabled(uneven(), tables_of(uneven()))

    def act(worlds: Worlds, key: jax.Array) -> tuple[tuple[()], jax.Array, None]:
        del key
        return (), jnp.zeros((worlds.fresh.shape[0], 2), jnp.int32), None

    actor = Actor(
        act,
        pack=lambda observation: observation,
        follow=lambda *_: (),
        for_critic=lambda _, recent: recent,
        horizons=horizons,
    )
    play = jax.jit(partial(collect_rollout, env, actor, num_steps=num_steps, shaping=shaping))
    worlds = start_worlds(env, 8, (), jax.random.key(7), horizons=horizons)
    return worlds, lambda worlds, key: play(worlds=worlds, key=key)[:2]


def played(shaping: Shaping, rollouts: int) -> dict[str, np.ndarray]:
    """Returns what was paid, learnt from and ended in some rollouts, one after the other: `[T, B, ...]`."""
    worlds, play = player(shaping)
    pieces = []
    for key in jax.random.split(jax.random.key(0), rollouts):
        worlds, rollout = play(worlds, key)
        pieces.append(rollout)
    return {
        name: np.concatenate([getattr(piece, name) for piece in pieces])
        for name in ("reward", "done", "shaped_reward")
    }


@pytest.mark.parametrize("smoothing", [pytest.param(0.0, marks=pytest.mark.slow), 0.5])
def test_traces_decay_and_end_with_the_episode(smoothing: float) -> None:
    """Agent 0 is paid 1 a step, agent 1 nothing."""
    found = played(Shaping(lambda step: step.trace, smoothing), 6)
    assert found["done"].any(axis=0).all()
    for env in range(8):
        trace = np.zeros(2)
        for step in range(18):
            trace = smoothing * trace + found["reward"][step, env]
            np.testing.assert_allclose(found["shaped_reward"][step, env], trace, rtol=1e-6)
            if found["done"][step, env]:
                trace = np.zeros(2)


def test_critics_may_read_averages_of_what_was_learnt_from() -> None:
    """Agent 0 is paid 1 a step, agent 1 nothing; each learns from the sum."""
    worlds, play = player(make_shaping(make_config(reward="common"), 2), 18, (1.0, 4.0))
    _, rollout = play(worlds, jax.random.key(0))
    assert rollout.done.any(axis=0).all()
    for env in range(8):
        average = np.zeros(2)  # over 1 step and over 4, the same for both agents
        for step in range(18):
            np.testing.assert_allclose(rollout.for_critic[step, env], [average, average], rtol=1e-6)
            average = np.array([1.0, 0.75 * average[1] + 0.25])
            if rollout.done[step, env]:
                average = np.zeros(2)


def test_svo_compares_single_steps_unless_smoothed() -> None:
    assert [
        make_shaping(make_config(reward="svo", **given), 2).smoothing
        for given in ({}, {"reward_smoothing": 0.5})
    ] == [0.0, 0.5]


def test_inequity_compares_what_agents_had_lately() -> None:
    """The paper's loop over whole episodes, written out: e = gamma * lambda * e + r, alpha 5 and beta 0.05."""
    found = played(make_shaping(make_config(reward="inequity"), 2), 6)
    for env in range(8):
        smoothed = np.zeros(2)
        for step in range(18):
            paid = found["reward"][step, env]
            smoothed = 0.99 * 0.975 * smoothed + paid
            behind, ahead = (
                np.maximum(smoothed[::-1] - smoothed, 0),
                np.maximum(smoothed - smoothed[::-1], 0),
            )
            np.testing.assert_allclose(
                found["shaped_reward"][step, env], paid - 5 * behind - 0.05 * ahead, rtol=1e-5
            )
            if found["done"][step, env]:
                smoothed = np.zeros(2)


def test_inequity_may_compare_single_steps() -> None:
    """Every step pays 1 and 0, so that every step deducts the same."""
    found = played(make_shaping(make_config(reward="inequity", inequity_smoothing=0), 2), 2)
    np.testing.assert_allclose(
        found["shaped_reward"], np.broadcast_to([1 - 0.05, -5.0], (6, 8, 2)), rtol=1e-6
    )


def test_traces_are_in_checkpoints(tmp_path: Path) -> None:
    """What is played after a checkpoint in the middle of episodes is what would have been played without it."""
    worlds, play = player(make_shaping(make_config(reward="inequity"), 2), horizons=(4.0,))
    between, _ = play(worlds, jax.random.key(1))
    checkpoints = Checkpoints(tmp_path)
    checkpoints.save(1, between)
    restored = checkpoints.restore(1, worlds)
    assert np.asarray(restored.trace[:, 0] > 0).any()
    on, again = (play(state, jax.random.key(2))[1] for state in (between, restored))
    np.testing.assert_array_equal(on.shaped_reward, again.shaped_reward)
    np.testing.assert_array_equal(on.for_critic, again.for_critic)
    assert np.asarray(on.for_critic[0, :, 0] != 0).any()
