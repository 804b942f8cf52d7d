"""Territory as Melting Pot has it, scene by scene: claims, payments and zaps."""

from typing import Any

from sjdsl.testing import Scene, Stage

ROWS = ("P.....#.", ".RR..R..", "........", "P.R.R..P")
STAGE = Stage("territory_open", ROWS, 3, interpreted=True)
LEFT, SECOND, RIGHT, LOW, CORNER = (1, 1), (1, 2), (1, 5), (3, 2), (3, 4)
FIXED = {"drying": 3, "rate": 1, "mend": 0, "ending": 0}


def put(*picture: str, **facts: Any) -> Scene:
    return STAGE.put(*picture, params={**FIXED, **facts.pop("params", {})}, **facts)


def test_what_one_faces_is_claimed_and_looks_dry_when_it_has_paid() -> None:
    scene = put("<.....#.  2", ".RR.>R..  1", ".^......  0", "P.R.R..P").step()
    scene.has(
        {
            "brick.owner": {LEFT: 0, RIGHT: 1, SECOND: None},
            "brick.paint": {LEFT: "wet"},
            "event claimed": [1, 1, 0],
        }
    )
    scene.step(times=2).has({"reward": 0, "brick.paint": {LEFT: "wet"}})
    scene.step().has({"reward": [1, 1, 0], "brick.paint": {LEFT: "dry"}})
    put("<.....#.  2", ".RR.>R..  1", ".^......  0", "P.R.R..P", params={"rate": 0}).step(
        times=5
    ).has({"brick.paint": {LEFT: "wet"}})


def test_paint_goes_through_one_brick_to_the_next_and_through_nobody_elses_wall() -> None:
    scene = put("P.....#.", ">RR..R..  0", "..>.....  1", "P.R.R<.P  2").step("paint, paint, paint")
    scene.has({"brick.owner": [0, 0, None, None, 2]})


def test_the_zap_that_breaks_a_brick_goes_on() -> None:
    """The first hit stops at the near brick; the second breaks it, and hits the next one and whoever stands there."""
    scene = put(
        "P....>#.  2", ".RR<.R..  0", "........", "P.R.R..<  1", params={"cooling": 0}
    ).step("zap")
    scene.has({"brick.damage": {SECOND: 1, LEFT: 0}}).step("zap").has(
        {"brick.damage": {SECOND: 2, LEFT: 1}, "event blows": [2, 0, 0]}
    )
    behind = put(
        "P....>#.  2",
        ".^R<.R..  10",
        "........",
        "P.R.R..P",
        fields={"brick.damage": {LEFT: 2, SECOND: 1}},
    ).step("zap")
    behind.has({"agent.hits": [0, 1, 0], "brick.damage": {SECOND: 2}})


def test_who_is_hit_shields_the_brick_behind() -> None:
    scene = put(
        "P....>#.  2", ".R^<.R..  10", "........", "P.R.R..P", fields={"brick.damage": {SECOND: 2}}
    ).step("zap")
    scene.has({"agent.hits": [0, 1, 0], "brick.damage": {LEFT: 0, SECOND: 2}, "event blows": 0})


def test_who_is_stunned_paints_and_does_nothing_else() -> None:
    """For 24 steps; its own zap is cool five steps later."""
    scene = put(
        "P.....#.", ".RR<.R..  1", "...^....  0", "P.R.R..<  2", params={"frozen": 3, "cooling": 2}
    ).step("zap")
    scene.has(
        {
            "allowed forward": [True, False, True],
            "allowed turn_left": {1: False},
            "allowed paint": True,
        }
    )
    scene.has({"allowed zap": [False, False, True]}).step("stay, paint").has(
        {"brick.owner": {LEFT: 1}}
    )
    scene.step(times=2).has({"allowed forward": True, "allowed zap": {1: False}}).step(times=2).has(
        {"allowed zap": {1: False}}
    ).step().has({"allowed zap": {1: True}})


def test_a_second_hit_throws_out_and_frees_what_was_owned() -> None:
    facts = {
        "fields": {"brick.owner": {LOW: 1}, "brick.paint": {LOW: "dry"}},
        "params": {"cooling": 0, "rate": 0},
    }
    scene = (
        put("P....^#.  2", ".RR..R..", "......><  01", "P.R.R..P", **facts).step("zap").step("zap")
    )
    scene.has(
        {
            "agent.away": [False, True, False],
            "brick.owner": None,
            "brick.paint": "none",
            "event gone": [0, 1, 0],
        }
    )


def test_owners_are_seen() -> None:
    scene = put(
        "P.....#.",
        ".RR.^R..  0",
        "......<.  1",
        "^.R.R..P  2",
        fields={"brick.owner": {LEFT: 0, SECOND: 1}},
        under={2: "P"},
    )
    assert [
        scene.seen(0, "content", right=n).split("owner=")[1].split()[0] for n in (-3, -2, 1)
    ] == ["of_1", "of_2", "free"]
    assert (scene.seen(0, "agent.badge"), scene.seen(1, "other.badge", ahead=2, right=1)) == (1, 1)


def test_rooms_at_opposite_edges_are_neighbours() -> None:
    """The map of rooms wraps: paint, zaps and players go on at the other side. The open map ends at its edges."""
    rows, scenes = ("P...R.", "......", "P....P"), {}
    for variant in (None, "rooms"):
        stage = Stage("territory_open", rows, 3, variant=variant, interpreted=True)
        scenes[variant] = stage.put(
            "<...R.  0", ".^....  1", "P..v.P  2", params=FIXED | {"cooling": 0}
        ).step("paint, stay, forward")
    scenes["rooms"].has({"brick.owner": [0], "agent.row": [0, 1, 0]})
    scenes[None].has({"brick.owner": [None], "agent.row": [0, 1, 2]})
    hit = Stage(
        "territory_open", rows, 3, variant="rooms", interpreted=True
    )  # a zap reaches who is beside as well
    hit.put("P...R^  1", "......", "^....v  02", params=FIXED).step("stay, stay, zap").has(
        {"agent.hits": [1, 1, 0]}
    )
