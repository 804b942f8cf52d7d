"""Whatever plays an episode tells policies what came of each step: one that repeats what paid well gets the returns computed by hand."""

from collections.abc import Callable, Mapping
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from small_games import MATRIX, STAY, matrix_game

from sjdsl.cli.play import play_compiled
from sjdsl.experiments import cross_play
from sjdsl.experiments.players import program_digest
from sjdsl.render.playing import play_moments
from sjdsl.replay.episodes import play_episodes
from sjdsl.runtime.policy import MemoryPolicy, mixed_policy
from sjdsl.trainers import evaluate, make_config, make_train, register

PAYOFF = np.array([[3, 0], [5, 1]])  # by one's own action and the other's: stay, betray
START = (0, 1)


def _act(memory: Any, key: Any, observation: Any) -> tuple[Any, Any]:
    del key, observation
    return memory, memory


def _repeat_what_paid(memory: Any, actions: Any, reward: Any, info: Mapping[str, Any]) -> Any:
    del memory, info
    return jnp.where(reward >= 3, actions, 1 - actions).astype(jnp.int32)


REPEATING = MemoryPolicy(jnp.array(START, jnp.int32), _act, after_step=_repeat_what_paid)


def by_hand(chosen: Callable[[list[int]], list[int]] = lambda actions: actions) -> np.ndarray:
    """Returns the actions `[4, 2]` and rewards `[4, 2]` of an episode, stacked; `chosen` may replace what the policy does."""
    actions = list(START)
    rows = []
    for _ in range(4):
        actions = chosen(actions)
        reward = [PAYOFF[actions[0], actions[1]], PAYOFF[actions[1], actions[0]]]
        rows.append((list(actions), reward))
        actions = [
            action if paid >= 3 else 1 - action
            for action, paid in zip(actions, reward, strict=True)
        ]
    return np.moveaxis(np.array(rows), 1, 0)


def other_stays(actions: list[int]) -> list[int]:
    return [actions[0], 0]


def test_evaluations_films_and_recordings() -> None:
    actions, rewards = by_hand()
    np.testing.assert_array_equal(rewards.sum(axis=0), [7, 12])
    env = matrix_game()
    for policy in (REPEATING, mixed_policy(2, [((0,), REPEATING), ((1,), REPEATING)])):
        evaluation = evaluate(env, policy, jax.random.key(0), 3)
        np.testing.assert_array_equal(evaluation.returns, [[7, 12]] * 3)
        moments = list(play_moments(env, policy, 4))[1:]
        np.testing.assert_array_equal([moment.actions for moment in moments], actions)
        (episode,) = play_episodes(env, policy, 0, 1)
        np.testing.assert_array_equal(episode.actions, actions)
        np.testing.assert_array_equal(episode.rewards, rewards)


def test_line_ups() -> None:
    env = matrix_game()
    both = cross_play(env, slots=[REPEATING, REPEATING], episodes=2)
    np.testing.assert_array_equal(both.parts[0].played.returns, [[7, 12]] * 2)
    one = cross_play(env, slots=[REPEATING, STAY], episodes=2)
    returns = by_hand(other_stays)[1].sum(axis=0)
    np.testing.assert_array_equal(one.parts[0].played.returns, [returns] * 2)


def test_a_person_among_them() -> None:
    """The policy is told of what was done, not of what it would have done."""
    env = matrix_game()
    moments = list(play_compiled(env, REPEATING, 0, [{1: 0}] * 4))[1:]
    actions, _ = by_hand(other_stays)
    np.testing.assert_array_equal([moment.actions for moment in moments], actions)


def test_the_others_in_gymnasium() -> None:
    pytest.importorskip("gymnasium")
    from sjdsl.interop.gymnasium_agent import AgentGame

    game = AgentGame(str(MATRIX), agent=1, others=REPEATING)
    game.reset(seed=0)
    rewards = [game.step(0)[4]["rewards"] for _ in range(4)]
    np.testing.assert_array_equal(rewards, by_hand(other_stays)[1])


def test_partners_in_training() -> None:
    """Agent 0 repeats what paid, whatever agent 1 does, which learns; an episode has four steps."""
    register("policy", "repeating", REPEATING)
    config = make_config(
        partners={0: "repeating"},
        network="mlp",
        network_width=8,
        num_envs=2,
        num_steps=8,
        num_minibatches=2,
    )
    program = make_train(matrix_game(), config)
    _, played = jax.jit(lambda key: program.collect(program.init(key)))(jax.random.key(0))
    action = np.asarray(played.rollout.action)[..., 0]
    paid = np.asarray(played.rollout.reward)[..., 0] >= 3
    repeated = np.where(paid, action, 1 - action)
    np.testing.assert_array_equal(action[::4], START[0])
    for step in (1, 2, 3, 5, 6, 7):
        np.testing.assert_array_equal(action[step], repeated[step - 1])


def test_what_a_policy_is_told_is_part_of_its_program() -> None:
    env = matrix_game()
    deaf = MemoryPolicy(REPEATING.start, _act)
    assert program_digest(deaf, env) != program_digest(REPEATING, env)
