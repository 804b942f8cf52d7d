"""Gift Refinement, scene by scene: tokens given, refined and consumed."""

from typing import Any

import pytest

from sjdsl.testing import Scene, Stage

from .environments import stage_of

ROWS = ("TTTTTTTT", "TTTTTTTT", "TT#TTTTT", "TTTTTTTT", "PPPPPPPP")
EMPTY = "TTTTTTTT"
LOOKS = {"r": "ground token=raw"}
DEFAULT = stage_of("gift_refinement", ROWS, 5, looks=LOOKS)
RELEASED = stage_of("gift_refinement", ROWS, 5, variant="socialjax", looks=LOOKS)
BOTH = pytest.mark.parametrize("stage", [DEFAULT, RELEASED], ids=["default", "socialjax"])
LEVELS = ("raw", "cut", "fine")
Bag = tuple[int, int, int]


def put(
    stage: Stage,
    *picture: str,
    bags: dict[int, Bag] | None = None,
    seed: int = 0,
    step: int = 0,
    spawn: float = 0,
    **facts: Any,
) -> Scene:
    """Returns a scene in which no token comes by itself; `bags`: raw, cut and fine tokens by agent."""
    fields = {
        "agent.bag": {
            agent: dict(zip(LEVELS, bag, strict=True)) for agent, bag in (bags or {}).items()
        }
    }
    return stage.put(
        *picture, seed=seed, step=step, params={"spawn": spawn}, fields=fields, **facts
    )


def in_line(stage: Stage, line: str, **facts: Any) -> Scene:
    """Returns a scene with agents in row 1, numbered from the left; the others are out of the way."""
    others = 5 - sum(sign in "^>v<" for sign in line)
    told = "".join(map(str, range(5 - others)))
    return put(
        stage, EMPTY, f"{line}  {told}", *ROWS[2:-1], "v" * others + ROWS[-1][others:], **facts
    )


def bags(scene: Scene, *agents: int) -> list[Bag]:
    """Returns what agents hold: raw, cut, fine."""
    return [tuple(scene.value("agent.bag")[agent].values()) for agent in agents]


# Giving

# what the giver holds -> what it holds after one gift, what the receiver has of it
GIFTS = [
    ((2, 0, 0), (1, 0, 0), (0, 3, 0)),
    ((1, 0, 0), (0, 0, 0), (0, 3, 0)),
    ((1, 2, 3), (0, 2, 3), (0, 3, 0)),
    ((0, 2, 3), (0, 1, 3), (0, 0, 3)),
    ((0, 0, 3), (0, 0, 2), (0, 0, 1)),
    ((15, 15, 15), (14, 15, 15), (0, 3, 0)),
    ((0, 0, 0), (0, 0, 0), (0, 0, 0)),
]


@BOTH
@pytest.mark.parametrize(("before", "after", "arrives"), GIFTS)
def test_the_lowest_level_is_given_and_refined(
    stage: Stage, before: Bag, after: Bag, arrives: Bag
) -> None:
    scene = in_line(stage, "TT>>TTTT", bags={0: before}).step("gift")
    assert bags(scene, 0, 1) == [after, arrives]
    scene.has({"reward": 0, "event given": [int(before != after), 0, 0, 0, 0]})
    for level, number in zip(LEVELS, arrives, strict=True):
        scene.has({f"event received[{level}]": [0, number, 0, 0, 0]})
    scene.has(
        {
            "metric refined_held": sum(after[1:]) + sum(arrives[1:]),
            "agent.post": {n: dict.fromkeys(LEVELS, 0) for n in range(5)},
        }
    )


@BOTH
@pytest.mark.parametrize("line", ["TT>T>TTT", ">TTTTTT>", "T<>TTTTT", "TT<TTTTT"])
def test_without_a_neighbour_ahead_nothing_is_given(stage: Stage, line: str) -> None:
    giver = 1 if line == "T<>TTTTT" else 0
    scene = in_line(stage, line, bags={giver: (2, 1, 1)}).step("stay, gift" if giver else "gift")
    assert bags(scene, giver) == [(2, 1, 1)]
    scene.has({"event given": 0})
    assert (
        put(stage, "TTT^TTTT  0", *ROWS[1:-1], "vvvvPPPP", bags={0: (2, 1, 1)})
        .step("gift")
        .value("event given")
        == [0] * 5
    )


# what the receiver holds of level cut -> what it holds after a gift of one raw token, what is counted as received
ROOM = [(11, 14, 3), (12, 15, 3), (13, 15, 2), (14, 15, 1), (15, 15, 0)]


@pytest.mark.parametrize(("before", "after", "received"), ROOM)
def test_what_does_not_fit_is_lost_and_nothing_is_given_to_a_full_bag(
    before: int, after: int, received: int
) -> None:
    scene = in_line(DEFAULT, "TT>>TTTT", bags={0: (1, 0, 0), 1: (15, before, 15)}).step("gift")
    assert bags(scene, 0, 1) == [(int(received == 0), 0, 0), (15, after, 15)]
    scene.has(
        {
            "event received[cut]": [0, received, 0, 0, 0],
            "event given": [int(received > 0), 0, 0, 0, 0],
        }
    )


def test_only_the_level_that_would_arrive_needs_room() -> None:
    scene = in_line(DEFAULT, "TT>>TTTT", bags={0: (0, 1, 0), 1: (15, 15, 14)}).step("gift")
    assert bags(scene, 0, 1) == [(0, 0, 0), (15, 15, 15)]
    scene = in_line(DEFAULT, "TT>>TTTT", bags={0: (0, 0, 1), 1: (15, 14, 15)}).step("gift")
    assert bags(scene, 0, 1) == [(0, 0, 1), (15, 14, 15)]


def test_room_is_judged_before_all_gifts() -> None:
    """There is room for one token, so both givers pay; what is too much is lost."""
    picture = ("TTTTTvTT  0", "TTTT>^<T  142", "TT#TT^TT  3", *ROWS[3:])
    scene = put(DEFAULT, *picture, bags={0: (1, 0, 0), 1: (1, 0, 0), 4: (0, 14, 0)}).step(
        "gift, gift"
    )
    assert bags(scene, 0, 1, 4) == [(0, 0, 0), (0, 0, 0), (0, 15, 0)]
    scene.has({"event given": [1, 1, 0, 0, 0], "event received[cut]": {4: 1}})
    # agent 1 is full when gifts are judged, though it gives one away in this step
    scene = in_line(DEFAULT, "TT>>>TTT", bags={0: (0, 1, 0), 1: (0, 0, 15)}).step("gift, gift")
    assert bags(scene, 0, 1, 2) == [(0, 1, 0), (0, 0, 14), (0, 0, 1)]


@pytest.mark.parametrize("action", ["stay", "turn_right", "gift"])
def test_as_released_a_token_goes_ahead_unasked_to_who_faces_the_same_way(action: str) -> None:
    for line, gives in (("TT>>TTTT", action != "turn_right"), ("TT>^TTTT", False)):
        scene = in_line(RELEASED, line, bags={0: (2, 0, 0)}).step(f"{action}, stay")
        assert bags(scene, 0, 1) == ([(1, 0, 0), (0, 3, 0)] if gives else [(2, 0, 0), (0, 0, 0)])


def test_as_released_a_full_bag_loses_the_token() -> None:
    assert bags(
        in_line(RELEASED, "TT>>TTTT", bags={0: (1, 0, 0), 1: (0, 15, 0)}).step("stay"), 0, 1
    ) == [(0, 0, 0), (0, 15, 0)]


# Melting Pot's reach of five cells


# Consuming


@BOTH
@pytest.mark.parametrize(
    ("bag", "reward"), [((3, 4, 5), 12), ((1, 0, 0), 1), ((0, 0, 15), 15), ((0, 0, 0), 0)]
)
def test_consuming_pays_one_for_each_token(stage: Stage, bag: Bag, reward: float) -> None:
    scene = in_line(stage, "TT><TTTT", bags={0: bag, 1: (1, 1, 1)}).step("consume")
    scene.has({"reward": [reward, 0, 0, 0, 0], "event consumed": [reward, 0, 0, 0, 0]})
    assert bags(scene, 0, 1) == [(0, 0, 0), (1, 1, 1)]
    scene.step("consume").has({"reward": 0})


@pytest.mark.parametrize(
    ("stage", "bag", "reward", "received", "left"),
    [
        (DEFAULT, (1, 1, 0), 2, 3, (0, 3, 0)),
        (RELEASED, (1, 1, 0), 5, 3, (0, 0, 0)),
        (DEFAULT, (0, 15, 0), 15, 3, (0, 3, 0)),
        (RELEASED, (0, 15, 0), 15, 0, (0, 0, 0)),
    ],
)
def test_a_gift_that_meets_consumption(
    stage: Stage, bag: Bag, reward: float, received: int, left: Bag
) -> None:
    """Consumption first: it makes room, and what arrives stays. Gifts first: they are consumed, too, or lost where a bag is full."""
    scene = in_line(stage, "TT>>TTTT", bags={0: (1, 0, 0), 1: bag}).step("gift, consume")
    scene.has({"reward": [0, reward, 0, 0, 0], "event received[cut]": {1: received}})
    assert bags(scene, 0, 1) == [(0, 0, 0), left]


# Tokens on the ground


@BOTH
@pytest.mark.parametrize(("before", "after"), [(13, 14), (14, 15), (15, 15)])
def test_with_a_full_bag_the_token_is_lost(stage: Stage, before: int, after: int) -> None:
    scene = put(
        stage, "TTTTrTTT", "TTTT^TTT  0", *ROWS[2:-1], "vvvvPPPP", bags={0: (before, 15, 15)}
    ).step("forward")
    scene.shows("TTTT^TTT  0", *ROWS[1:-1], "vvvvPPPP", under={0: "T"})
    assert bags(scene, 0) == [(after, 15, 15)]


@BOTH
def test_tokens_come_on_bare_ground_where_nobody_stands(stage: Stage) -> None:
    """With certainty: not in camps, not in walls, not under agents; and what comes can be picked up in the same step."""
    scene = put(stage, *ROWS[:1], "TTTT^TTT  0", *ROWS[2:-1], "vvvvPPPP", spawn=1).step()
    scene.shows("rrrrrrrr", "rrrr^rrr", "rr#rrrrr", "rrrrrrrr", "vvvvPPPP", under={0: "T"})
    scene = put(stage, *ROWS[:1], "TTTT^TTT  0", *ROWS[2:-1], "vvvvPPPP", spawn=1).step("forward")
    scene.shows("rrrr^rrr", "rrrrTrrr", "rr#rrrrr", "rrrrrrrr", "vvvvPPPP", under={0: "T"})
    assert bags(scene, 0) == [(1, 0, 0)]


# Moves, starts, what is seen


def test_held_tokens_are_counted_as_released_before_they_are_consumed() -> None:
    """Released code: after gifts, before consumption; by default at the end of the step."""
    for stage, held in ((DEFAULT, 0), (RELEASED, 5)):
        put(stage, *ROWS[:4], "vvvvvPPP", bags={0: (1, 2, 3)}).step("consume").has(
            {"metric refined_held": held, "event consumed": {0: 6}}
        )
