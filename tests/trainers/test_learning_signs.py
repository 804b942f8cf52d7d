"""What a run says when it learns nothing."""

from typing import Any

import pytest

from sjdsl.trainers import make_config
from sjdsl.trainers.runs.learning_signs import Signs, is_due, said_once


def row(update: int, **changes: Any) -> dict[str, Any]:
    figures = {
        "update": update,
        "rewarded_steps": 0.5,
        "episodes": 4,
        "collective_return": 10.0 + update,
        "explained_variance": 0.4,
    }
    return (
        figures
        | {
            "event_given_agent_0": 0.0,
            "event_given_agent_1": 2.0,
            "event_received[raw]_agent_0": 0.0,
            "event_received[cut]_agent_0": 1.0,
            "event_met": 1.0,
        }
        | changes
    )


HEALTHY = [row(1), row(2)]
SAID: dict[str, tuple[list[dict[str, Any]], str]] = {
    "no reward": (
        [row(n, rewarded_steps=0.0, collective_return=0.0) for n in (1, 2)],
        "no agent has been rewarded yet",
    ),
    "not above the first policy": (
        [row(1), row(2, collective_return=11.0)],
        "11.0, is not above what it was before learning, 11.0",
    ),
    "a critic worse than none": (
        [row(1, explained_variance=0.2), row(2, explained_variance=-0.8)],
        "explained_variance is -0.30 on average",
    ),
    "an event that never happens": (
        [r | {"event_given_agent_1": 0.0} for r in HEALTHY],
        "these events have never happened: given.",
    ),
}


def warnings_of(rows: list[dict[str, Any]], **changes: Any) -> list[str]:
    signs = Signs()
    for one in rows:
        signs.count(one)
    return said_once({0: list(signs.warnings(make_config(**{"reward": "common"} | changes)))})


@pytest.mark.parametrize(("rows", "said"), SAID.values(), ids=list(SAID))
def test_each_sign_is_said_alone(rows: list[dict[str, Any]], said: str) -> None:
    (warning,) = warnings_of(rows)
    assert said in warning


def test_a_run_that_learns_is_not_warned_of() -> None:
    assert warnings_of(HEALTHY) == []


def test_agents_that_seek_their_own_reward_may_earn_less_together_than_before() -> None:
    rows, _ = SAID["not above the first policy"]
    assert warnings_of(rows, reward="individual") == []


def test_updates_in_which_no_episode_ended_say_nothing_of_returns() -> None:
    unended = row(1, episodes=0, collective_return=float("nan"), event_given_agent_1=float("nan"))
    assert warnings_of([unended, *HEALTHY]) == []


@pytest.mark.parametrize(("updates", "due"), [(1, []), (2, [1]), (10, [1]), (188, [19])])
def test_signs_are_judged_once_after_a_tenth(updates: int, due: list[int]) -> None:
    config = make_config(num_envs=8, num_steps=8, total_timesteps=64 * updates)
    assert [n for n in range(1, updates + 1) if is_due(n, config)] == due
