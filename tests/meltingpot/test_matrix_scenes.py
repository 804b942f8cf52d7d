"""The games of the matrix, scene by scene: what is gathered, destroyed and met, and what a meeting comes to."""

from functools import cache
from typing import Any

import numpy as np
import pytest

from sjdsl.testing import Scene, Stage

ROWS = ("PPP.12", "......", "......", "..PPP.")
FIXED = {"regrow": 0, "freeze": 2, "absence": 3, "ending": 0}


@cache
def stage(
    game: str, agents: int = 2, variant: str | None = None, rows: tuple[str, ...] = ROWS
) -> Stage:
    fixed = {"freeze": 2} if variant == "one_shot" else FIXED
    return Stage(
        f"{game}_in_the_matrix", rows, agents, variant=variant, params=fixed, interpreted=True
    )


def put(
    *picture: str,
    game: str = "prisoners_dilemma",
    agents: int = 2,
    variant: str | None = None,
    **facts: Any,
) -> Scene:
    return stage(game, agents, variant).put(*picture, **facts)


def test_what_is_gathered_adds_to_one_of_each() -> None:
    scene = put("PPP>12", "......", "......", "..PP<.").has(
        {"agent.bag[coop]": 1, "agent.bag[defect]": 1}
    )
    scene.step("forward").has(
        {"agent.bag[coop]": [2, 1], "agent.bag[defect]": [1, 1], "event collected[coop]": [1, 0]}
    )
    scene.step("forward").has({"agent.bag[defect]": [2, 1], "patch.stock": "none", "reward": 0})


def test_a_meeting_pays_the_mixtures_when_the_freeze_is_over() -> None:
    """Three of four against one of four: row = (3/4, 1/4), column = (1/3, 2/3), in the published matrix."""
    scene = put(
        "PPP.12",
        ".>.<..",
        "......",
        "..PPP.",
        fields={"agent.bag": {0: {"coop": 3}, 1: {"defect": 2}}},
    )
    payoff = np.array([[3, 0], [5, 1]])
    mine, theirs = np.array([3, 1]) / 4, np.array([1, 2]) / 3
    scene.step("interact").has(
        {"reward": 0, "event met": 1, "agent.frozen": 3, "allowed forward": False}
    )
    scene.step("forward, forward").has(
        {"reward": 0, "agent.away": False, "agent.bag[coop]": [3, 1]}
    )
    scene.step("forward, forward").has(
        {"agent.away": True, "agent.bag[coop]": 1, "agent.bag[defect]": 1}
    )
    assert scene.reward == pytest.approx([mine @ payoff @ theirs, theirs @ payoff @ mine])
    scene.step(times=2).has({"agent.away": True, "reward": 0}).step().has({"agent.away": False})


def test_who_has_gathered_nothing_is_not_met_but_ends_the_lane() -> None:
    bags = {"agent.bag": {0: {"coop": 3}, 2: {"coop": 3}}}
    put("PPP.12", "......", ">.<<..  012", "..PPP.", agents=3, fields=bags).step("interact").has(
        {"event met": 0}
    )
    put("PPP.12", "......", ">.<<..  021", "..PPP.", agents=3, fields=bags).step("interact").has(
        {"event met": [1, 0, 1]}
    )
    put("PPP.12", "......", ">..<..", "..PPP.", fields={"agent.bag": {1: {"coop": 3}}}).step(
        "interact"
    ).has({"event met": 0})


def test_the_third_hit_destroys_a_resource_and_goes_on() -> None:
    """A resource stops the beam until the hit that destroys it."""
    rows = ("PPP.12", "......", "......", "..1.P.")
    scene = stage("prisoners_dilemma", rows=rows).put(
        *("PPP.12", "......", "......", ">.1<P."), fields={"agent.bag[coop]": 3}
    )
    scene.step("interact").has({"event met": 0, "patch.damage": [0, 0, 1]}).step(times=2)
    scene.step("interact").has(
        {"event met": 0, "patch.damage": [0, 0, 2], "patch.stock": "ripe"}
    ).step(times=2)
    scene.step("interact").has(
        {
            "event met": 1,
            "patch.damage": 0,
            "patch.stock": ["ripe", "ripe", "none"],
            "event destroyed[coop]": 1,
        }
    )


def test_the_beam_is_three_lanes_of_three_and_rests_for_two_steps() -> None:
    scene = put("PPP.12", "......", ".>....", "..P<P.").step("interact")
    assert scene.value("marks aim") == {
        (r, c) for r in (1, 2, 3) for c in (1, 2, 3, 4) if (r, c) not in {(2, 1), (1, 4), (3, 4)}
    }
    scene.has({"allowed interact": [False, True]}).step("interact").has(
        {"allowed interact": [False, True]}
    )
    scene.step("interact").has({"allowed interact": True})


def test_others_see_who_is_ready_and_what_a_meeting_came_to() -> None:
    scene = put(
        "PPP.12",
        ".>.<..",
        "......",
        "..PPP.",
        fields={"agent.bag": {0: {"coop": 98}, 1: {"defect": 98}}},
    ).step()
    assert scene.seen(0, "other.sign", ahead=2) == "ready"
    scene.step("interact")
    assert (scene.seen(0, "agent.sign"), scene.seen(0, "other.sign", ahead=2)) == (
        "red",
        "violet",
    )  # near 0 and near 5
    assert (
        put("PPP.12", ".>.<..", "......", "..PPP.").step().seen(0, "other.sign", ahead=2)
        == "unready"
    )


def test_drawn_resources_are_of_any_class() -> None:
    many = Stage(
        "running_with_scissors_in_the_matrix", ("PP" + 30 * "a", "1" * 32), 2, interpreted=True
    )
    found = many.start(seed=1).value("patch.class")
    assert set(found[:30]) == {"rock", "paper", "scissors"} and set(found[30:]) == {"rock"}


def test_one_shot_ends_with_the_first_meeting() -> None:
    fields = {
        "agent.bag": {
            0: {"rock": 3, "paper": 1, "scissors": 1},
            1: {"rock": 1, "paper": 1, "scissors": 3},
        }
    }
    scene = put(
        "PPP.12",
        ".>.<..",
        "......",
        "..PPP.",
        game="running_with_scissors",
        variant="one_shot",
        fields=fields,
    )
    scene.step("interact").step().has({"reward": 0}).step().has(
        {"terminated": False, "agent.bag[rock]": 1}
    )
    assert scene.reward == pytest.approx(
        [10 * 4 / 25, -10 * 4 / 25]
    )  # (3, 1, 1) / 5 against (1, 1, 3) / 5
    scene.step().has({"terminated": True, "reward": 0})


def test_fans_meet_the_other_side_alone_and_each_gains_more_by_its_own() -> None:
    """Agents 0 and 1 are fans of Bach, 2 and 3 of Stravinsky."""
    bags = {"agent.bag[bach]": 9}
    put(
        "PPP.12",
        ".>.<..  01",
        "......",
        "..P<<.  23",
        game="bach_or_stravinsky",
        agents=4,
        fields=bags,
    ).step("interact").has({"event met": 0})
    for actions in ("interact", "stay, stay, interact"):  # whoever challenges
        scene = put(
            "PPP.12",
            ".>.<..  02",
            "......",
            "..P<<.  13",
            game="bach_or_stravinsky",
            agents=4,
            fields=bags,
        )
        scene.step(actions).has({"event met": [1, 0, 1, 0]}).step(times=2)
        assert scene.reward == pytest.approx([3 * 0.81 + 2 * 0.01, 0, 2 * 0.81 + 3 * 0.01, 0])
