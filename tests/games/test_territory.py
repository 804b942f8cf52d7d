"""Territory, scene by scene and counted: claims, drying, what pays whom, broken bricks, players thrown out."""

from typing import Any

import jax.numpy as jnp
import pytest

from sjdsl.testing import Scene

from .chance import BATCH, assert_share, assert_uniform, many
from .environments import placed, stage_of

ROWS = ("P.....#.", ".RR..R..", "........", "P.R.R..P")
STAGE = stage_of("territory", ROWS, 3)
# bricks in reading order
LEFT, SECOND, RIGHT, LOW, CORNER = (1, 1), (1, 2), (1, 5), (3, 2), (3, 4)
STAY, ZAP, PAINT = 6, 7, 8


def put(*picture: str, **facts: Any) -> Scene:
    """Returns a scene in which paint dries in three steps, dry bricks pay for certain and nothing mends, unless told."""
    return STAGE.put(
        *picture, params={"drying": 3, "rate": 1, "mend": 0, **facts.pop("params", {})}, **facts
    )


def owned(*owners: tuple[tuple[int, int], int], paint: str = "dry") -> dict[str, Any]:
    """Returns the fields of bricks that belong to agents."""
    return {"brick.owner": dict(owners), "brick.paint": {place: paint for place, _ in owners}}


# Claims


def test_what_one_faces_is_claimed_and_pays_when_dry() -> None:
    """From the end of the third step after the claim on; agent 1 faces the brick's side, agent 2 nothing."""
    scene = put("<.....#.  2", ".RR.>R..  1", ".^......  0", "P.R.R..P")
    scene.step().has(
        {
            "brick.owner": {LEFT: 0, RIGHT: 1, SECOND: None},
            "brick.paint": {LEFT: "wet", RIGHT: "wet", SECOND: "none"},
        }
    )
    scene.has({"event claimed": [1, 1, 0], "brick.wetness": {LEFT: 3, RIGHT: 3}, "reward": 0})
    scene.step(times=2).has({"reward": 0, "event claimed": 0, "brick.paint": {LEFT: "wet"}})
    scene.step().has(
        {"reward": [1, 1, 0], "event paid": [1, 1, 0], "brick.paint": {LEFT: "dry", RIGHT: "dry"}}
    )
    scene.step("turn_left, turn_left").has({"reward": [1, 1, 0], "metric owned": 2})


def test_bricks_block_and_are_claimed_by_who_walks_at_them() -> None:
    scene = (
        put("<.....#.", ".RR..R..", "v^......", "P.R.R..P")
        .step("stay, stay, forward")
        .shows("<.....#.  0", ".RR..R..", "v^......  12", "P.R.R..P")
    )
    scene.has({"brick.owner": {LEFT: 2}})


def test_paint_reaches_two_bricks_and_no_third_cell() -> None:
    scene = put("P.....#.", ">RR..R..  0", "..>.....  1", "P.R.R<.P  2").step("paint, paint, paint")
    scene.has({"brick.owner": [0, 0, None, None, 2], "event claimed": [2, 0, 1]})
    put("P.....#.", ".RR>.R..  0", "v.....v.", "P.R.R..P").step("paint").has(
        {"brick.owner": {RIGHT: 0}}
    )


def test_a_new_claim_begins_anew() -> None:
    """Paint over paint: it has to dry again, and the new owner is paid; who has it already changes nothing."""
    fields = owned((SECOND, 0), (CORNER, 2))
    scene = put("P^....#.  0", ".RR..R..", "..^.....  1", "P.R.R<.P  2", fields=fields).step()
    scene.has(
        {"brick.owner": {SECOND: 1, CORNER: 2}, "brick.paint": {SECOND: "wet", CORNER: "dry"}}
    )
    scene.has({"reward": [0, 0, 1], "event claimed": [0, 1, 0]})


def test_one_of_several_rivals_has_it() -> None:
    """Its owner too, who then loses nothing; nobody is a rival any longer afterwards."""
    owners = []
    for seed in range(30):
        scene = put(
            "<.....#.  2",
            ".RR.>R<.  01",
            "........",
            "P.R.R..P",
            fields=owned((RIGHT, 0)),
            seed=seed,
        ).step()
        (owner,) = set(scene.value("brick.owner")) - {None}
        scene.has(
            {
                "brick.paint": {RIGHT: "wet" if owner else "dry"},
                "reward": [0 if owner else 1, 0, 0],
                "brick.rivals": [set()] * 5,
            }
        )
        owners.append(owner)
    assert 5 < owners.count(0) < 25
    assert set(owners) == {0, 1}


# Bricks break


def test_two_zaps_break_a_brick() -> None:
    """Then one can walk there, nobody owns it any more, and nobody can claim it again."""
    scene = put("P....>#.  2", ".RR<.R..  0", "........", "P.R.R..<  1", params={"cooling": 0})
    scene.step("zap").has(
        {"brick.damage": {SECOND: 1}, "brick.owner": {SECOND: 0}, "event blows": [1, 0, 0]}
    )
    scene.step("zap").has(
        {
            "brick.damage": [0, 2, 0, 0, 0],
            "brick.owner": {SECOND: None},
            "brick.paint": {SECOND: "none"},
        }
    )
    scene.step("forward").shows("P....>#.", ".R<..R..", "........", "P.R.R..<")
    scene.has({"brick.owner": {SECOND: None, LEFT: 0}, "brick.rivals": [set()] * 5})
    scene.step("backward").step().has({"brick.owner": {SECOND: None}, "event claimed": 0})


def test_two_who_zap_at_once_break_it_at_once() -> None:
    scene = (
        put("P.....#.", ".RR.>R<.", "<.......", "P.R.R..P")
        .step("zap, zap")
        .has({"brick.damage": {RIGHT: 2}, "event blows": [1, 1, 0]})
    )
    scene.has({"brick.owner": {RIGHT: None}})


def test_the_zap_is_three_lanes_of_two() -> None:
    """The middle one begins ahead, the others beside the agent. Source: Melting Pot."""
    scene = put("P..^..#.  1", ".RR..R..", "...^....  0", "P.R.R..^  2").step("zap")
    scene.has(
        {
            "agent.hits": [0, 1, 0],
            "brick.damage": {SECOND: 1, LEFT: 0, RIGHT: 0, LOW: 0, CORNER: 0},
            "event blows": [1, 0, 0],
        }
    )
    put("P.^...#.  1", ".RR<.R..  0", "...^....  2", "P.R.R..P").step("zap").has(
        {"agent.hits": [0, 1, 1]}
    )


@pytest.mark.parametrize("damage", [0, 1, 2])
def test_bricks_stop_zaps_until_they_are_broken(damage: int) -> None:
    """Agent 1 stands where another brick was, behind the one that is hit."""
    scene = put(
        "P....>#.  2",
        ".^R<.R..  10",
        "........",
        "P.R.R..P",
        fields={"brick.damage": {LEFT: 2, SECOND: damage}},
    ).step("zap")
    scene.has(
        {
            "agent.hits": [0, int(damage == 2), 0],
            "brick.damage": {SECOND: min(damage + 1, 2), LEFT: 2},
        }
    )


def test_damage_mends_after_a_while() -> None:
    scene = (
        put("P.....#.", ".RR<.R..", "....<...", "P.R.R..<", params={"mending": 3, "mend": 1})
        .step("zap")
        .has({"brick.damage": {SECOND: 1}})
    )
    scene.step(times=2).has({"brick.damage": {SECOND: 1}})
    scene.step().has({"brick.damage": {SECOND: 0}})
    gone = put(
        "P.....#.",
        ".RR<.R..",
        "....<...",
        "P.R.R..<",
        fields={"brick.damage": {LOW: 2}},
        params={"mending": 0, "mend": 1},
    )
    gone.step(times=3).has({"brick.damage": {LOW: 2}})


# Players are thrown out


def test_the_first_in_a_lane_is_hit_and_stunned() -> None:
    """The one behind is not. It cannot act in the 25 steps that follow."""
    scene = (
        put("P.....#.", ".RR..R..", ".>><....  012", "P.R.R..P")
        .step("zap")
        .has({"agent.hits": [0, 1, 0], "agent.stunned": [0, 25, 0]})
    )
    scene.has(
        {
            "allowed forward": [True, False, True],
            "allowed zap": [False, False, True],
            "allowed paint": [True, False, True],
        }
    )
    scene.step("stay, turn_left, stay", times=25).has({"agent.heading": {1: "east"}})
    scene.step("stay, turn_left, stay").has({"agent.heading": {1: "north"}})


@pytest.mark.parametrize(("wait", "thrown_out"), [(0, True), (49, True), (50, False)])
def test_a_second_hit_within_fifty_steps_throws_out(wait: int, thrown_out: bool) -> None:
    """For ever, and all that was its own is free again at once."""
    fields = owned((LEFT, 1), (LOW, 0))
    scene = put(
        "P....^#.  2",
        ".RR..R..",
        "......^<  10",
        "P.R.R..P",
        fields=fields,
        params={"cooling": 0, "frozen": 0},
    ).step("zap")
    for _ in range(wait):
        scene.step()
    scene.step("zap").has(
        {
            "agent.away": [False, thrown_out, False],
            "event gone": [0, int(thrown_out), 0],
            "agent.hits": {0: 0, 2: 0},
        }
    )
    scene.has(
        {
            "brick.owner": {LEFT: None if thrown_out else 1, LOW: 0},
            "reward": [1, int(not thrown_out), 0],
        }
    )
    scene.step("stay, forward").has(
        {"agent.away": [False, thrown_out, False], "reward": [1, int(not thrown_out), 0]}
    )


# What is seen


# Chances


@pytest.mark.thorough
def test_chances() -> None:
    """Each dry brick pays with 0.01, each damaged one mends with 0.1, and of two rivals each wins as often. Source: Melting Pot."""
    env, steps = STAGE.env, 8 * BATCH
    none, wet, dry = 0, 1, 2
    state = placed(
        env,
        [(1, 4), (1, 6), (2, 0)],
        [1, 3, 0],
        brick_owner=[0, 0, -1, 1, 1],
        brick_paint=[dry, dry, none, dry, wet],
        brick_damage=[0, 1, 0, 1, 0],
        brick_dust=[0, 0, 0, 1, 0],
        brick_wetness=[0, 0, 0, 0, 5],
    )

    def look(_: Any, after: Any, reward: Any) -> Any:
        owner = after.brick_owner[2]
        both = (reward[0] == 2, reward[0] == 1, reward[1] == 1)
        return {
            "paid": jnp.stack(both),
            "mended": after.brick_damage == 0,
            "winner": jnp.stack([owner == 0, owner == 1]),
            "other": reward[2],
        }

    count = many(env, look)
    seen = count(0, state, [STAY] * 3, env.params, 8)
    assert_share(seen["paid"][1], steps, 2 * 0.01 * 0.99, 0.25)
    assert_share(seen["paid"][2], steps, 0.01, 0.35)  # what is wet does not pay
    assert_share(seen["mended"][1], steps, 0.1, 0.1)
    assert_share(seen["mended"][3], steps, 0.1, 0.1)  # its time of rest ends in this step
    assert_uniform(seen["winner"], 0.05)
    assert seen["other"] == 0
    often = count(1, state, [STAY] * 3, env.params.replace(rate=jnp.float32(0.4)), 1)
    assert_share(often["paid"][0], BATCH, 0.16, 0.25)  # two bricks of one owner: each for itself


# The map
