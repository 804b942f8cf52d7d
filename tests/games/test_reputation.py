"""Reputation, scene by scene: who is healed at what cost, and what neighbours think of who helps and who looks away."""

import pytest

from sjdsl.testing import Scene

from .environments import stage_of

STAGE = stage_of("reputation", None, 4, params={"illness": 0.0})
NEAR = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]


def put(ill: int, thought: int = 3) -> Scene:
    health = ["ill" if agent == ill else "well" for agent in range(4)]
    fields = {
        "agent.health": health,
        "agent.fever": {ill: 5},
        "agent.relief": {ill: 4.0},
        "agent.neighbours": NEAR,
        "agent.opinion": [dict.fromkeys(range(4), thought)] * 4,
    }
    return STAGE.put("^^^^hh", fields=fields, step=5)


@pytest.mark.parametrize(("actions", "rewards"), [
    ("stay, nurse(0), stay, stay", [4, -1, 0, 0]),
    ("stay, nurse(0), nurse(0), stay", [4, -0.5, -0.5, 0]),
    ("stay, stay, stay, stay", [0, 0, 0, 0]),
])  # fmt: skip
def test_help_heals_and_who_help_share_the_work(actions: str, rewards: list[float]) -> None:
    scene = put(ill=0).step(actions)
    scene.has({"reward": rewards, "event healed": [int(rewards[0] > 0), 0, 0, 0]})
    assert scene.value("agent.health")[0] == ("well" if rewards[0] else "ill")


def test_who_helps_rises_and_who_looks_away_falls_in_the_eyes_of_all_neighbours() -> None:
    opinions = put(ill=0).step("stay, nurse(0), stay, stay").value("agent.opinion")
    assert [row[1] for row in opinions] == [4, 3, 4, 4]
    assert [row[2] for row in opinions] == [2, 2, 3, 2]


def test_to_look_away_from_somebody_who_has_lost_it_is_not_blamed() -> None:
    scene = put(ill=0, thought=1).step()
    scene.has({"event blamed": 0})
    assert [row[1] for row in scene.value("agent.opinion")] == [1, 1, 1, 1]


def test_pain_costs_more_the_longer_it_lasts_and_ends_by_itself() -> None:
    scene = put(ill=0)
    paid = [scene.step().value("reward")[0] for _ in range(7)]
    assert paid == pytest.approx([0, -0.1, -0.1, -0.2, -0.2, -0.2, 0])
