"""PD Arena, scene by scene: who meets whom, what a meeting pays, who is sent off and held."""

from typing import Any

import pytest

from sjdsl.testing import Scene, Stage

from .environments import stage_of

ROWS = ("........", "..CD....", "........", "......#.", "........", "PPPPPPPP")
EMPTY = "........"
GATES = ROWS[-1]
LOOKS = {"c": "patch class=coop stock=none", "d": "patch class=defect stock=none"}
DEFAULT = stage_of("pd_arena", ROWS, 4, looks=LOOKS)
RELEASED = stage_of("pd_arena", ROWS, 4, variant="socialjax", looks=LOOKS)
STAGES = [DEFAULT, RELEASED]
BOTH = pytest.mark.parametrize("stage", STAGES, ids=["default", "socialjax"])
Bag = tuple[int, int]


def put(
    stage: Stage,
    *picture: str,
    bags: dict[int, Bag] | None = None,
    held: dict[int, int] | None = None,
    rest: int = 20,
    **facts: Any,
) -> Scene:
    """Returns a scene in which nothing grows and who meets is held so many steps; `bags`: coop and defect resources by agent."""
    fields = {
        "agent.bag": {
            agent: {"coop": coop, "defect": defect}
            for agent, (coop, defect) in (bags or {}).items()
        }
    }
    params = {"regrow": 0, "rest_lo": rest, "rest_hi": rest, **facts.pop("params", {})}
    return stage.put(
        *picture, fields=fields | {"agent.resting": held or {}}, params=params, **facts
    )


def in_line(stage: Stage, line: str, **facts: Any) -> Scene:
    """Returns a scene with agents in row 2, numbered from the left; the others look out of the map at the bottom."""
    here = sum(sign in "^>v<" for sign in line)
    told = "".join(map(str, range(here)))
    return put(
        stage,
        *ROWS[:2],
        f"{line}  {told}",
        *ROWS[3:5],
        "v" * (4 - here) + GATES[4 - here :],
        **facts,
    )


def unlike(stage: Stage, **facts: Any) -> Scene:
    """Returns a scene in which agent 0, who would cooperate, and agent 1, who would defect, face each other."""
    return in_line(stage, "..><....", bags={0: (1, 0), 1: (0, 1)}, **facts)


def bags(scene: Scene, *agents: int) -> list[Bag]:
    """Returns the coop and defect resources of agents."""
    return [tuple(scene.value("agent.bag")[agent].values()) for agent in agents]


def sent(scene: Scene, *agents: int) -> bool:
    """Returns whether these agents stand on gates and are held."""
    return all(
        scene.value("agent.row")[agent] == 5 and scene.value("agent.resting")[agent] > 0
        for agent in agents
    )


# Meetings

# what the two hold -> what the one who fires and the other are paid
PAYOFFS = [
    ((1, 0), (1, 0), (3, 3)),
    ((1, 0), (0, 1), (-1, 5)),
    ((0, 1), (1, 0), (5, -1)),
    ((0, 1), (0, 1), (1, 1)),
    ((3, 1), (1, 1), (1.5, 3)),
    ((7, 0), (0, 100), (-1, 5)),
    ((50, 50), (2, 2), (2, 2)),
]


@BOTH
@pytest.mark.parametrize(("mine", "theirs", "payoff"), PAYOFFS)
def test_payoffs(stage: Stage, mine: Bag, theirs: Bag, payoff: tuple[float, float]) -> None:
    scene = in_line(stage, "..><....", bags={0: mine, 1: theirs}).step("interact")
    scene.has({"reward": [*payoff, 0, 0], "event met": [1, 1, 0, 0]})
    assert bags(scene, 0, 1) == [(0, 0), (0, 0)]


@BOTH
@pytest.mark.parametrize("line", ["..>.<...", "..<>....", "..^<....", ">......<"])
def test_only_the_next_cell_ahead_is_reached(stage: Stage, line: str) -> None:
    scene = in_line(stage, line, bags={0: (1, 0), 1: (0, 1)})
    places = scene.places()
    scene.step("interact").has({"reward": 0, "event met": 0, "agent.resting": 0})
    assert (scene.places(), bags(scene, 0, 1)) == (places, [(1, 0), (0, 1)])


def test_both_are_sent_off_and_held() -> None:
    scene = unlike(DEFAULT).step("interact").has({"agent.resting": [20, 20, 0, 0]})
    assert sent(scene, 0, 1)
    assert len(set(scene.places())) == 4


def test_in_the_released_rules_only_the_target_is() -> None:
    scene = unlike(RELEASED).step("interact").has({"agent.resting": {0: 0}})
    assert scene.places()[0] == (2, 2)
    assert sent(scene, 1)
    scene.step("forward").has({"agent.row": {0: 1}})


@BOTH
@pytest.mark.parametrize("rest", [1, 2, 10])
def test_who_is_held_may_not_act_for_so_many_steps(stage: Stage, rest: int) -> None:
    """Exactly as many as drawn; in the released code one less."""
    scene = unlike(stage, rest=rest).step("interact")
    place, heading = scene.places()[1], scene.headings()[1]
    for _ in range(rest if stage is DEFAULT else rest - 1):
        scene.has({"allowed interact": {1: False}, "allowed turn_left": {1: False}}).step(
            "stay, turn_left"
        )
        assert (scene.places()[1], scene.headings()[1]) == (place, heading)
    scene.has({"allowed interact": {1: True}}).step("stay, turn_left")
    assert scene.headings()[1] != heading


@BOTH
def test_each_has_a_draw_of_its_own(stage: Stage) -> None:
    """From 10 to 100 steps, both ends included in what is possible."""
    rests = []
    for seed in range(12):
        scene = unlike(
            stage,
            params={"rest_lo": 10, "rest_hi": 100},
            seed=seed,
        )
        rests.append(scene.step("interact").value("agent.resting")[:2])
    assert all(10 - (stage is RELEASED) <= rest <= 100 for _, rest in rests)
    assert len({rest for _, rest in rests}) > 6
    assert stage is RELEASED or (
        all(10 <= rest <= 100 for rest, _ in rests) and any(a != b for a, b in rests)
    )


@BOTH
@pytest.mark.parametrize(("mine", "theirs"), [((0, 0), (0, 1)), ((1, 0), (0, 0)), ((0, 0), (0, 0))])
def test_only_the_ready_meet(stage: Stage, mine: Bag, theirs: Bag) -> None:
    """Both must hold something, else nothing happens to either; in the released rules they meet for nothing."""
    scene = in_line(stage, "..><....", bags={0: mine, 1: theirs}).step("interact")
    assert scene.places()[0] == (2, 2)
    if stage is DEFAULT:
        scene.has({"reward": 0, "event met": 0, "agent.resting": 0})
        assert (scene.places()[1], bags(scene, 0, 1)) == ((2, 3), [mine, theirs])
    else:
        scene.has({"reward": 0, "event met": [1, 1, 0, 0]})
        assert bags(scene, 0, 1) == [(0, 0), (0, 0)]
        assert sent(scene, 1)


def test_who_is_held_is_not_met() -> None:
    """Neither by one who is free, nor does it fire itself."""
    for actions in ("interact, stay", "stay, interact"):
        scene = unlike(DEFAULT, held={1: 9}).step(actions).has({"reward": 0, "event met": 0})
        assert (scene.places()[:2], bags(scene, 0, 1)) == ([(2, 2), (2, 3)], [(1, 0), (0, 1)])
        scene.has({"agent.resting": [0, 8, 0, 0]})


def test_in_the_released_rules_who_is_held_is_sent_off_anew() -> None:
    scene = (
        in_line(RELEASED, "..><....", bags={0: (1, 0)}, held={1: 5})
        .step("interact")
        .has({"reward": 0, "agent.resting": {1: 19}})
    )
    assert (bags(scene, 0, 1), scene.places()[0]) == ([(0, 0), (0, 0)], (2, 2))
    assert sent(scene, 1)
    unlike(RELEASED, held={1: 5}).step("stay, interact").has({"reward": 0, "event met": 0})


# Several at once


def test_in_the_released_rules_they_meet_twice() -> None:
    scene = unlike(RELEASED).step("interact, interact")
    scene.has({"reward": [-2, 10, 0, 0], "event met": [2, 2, 0, 0]})
    assert sent(scene, 0, 1)


def test_of_two_who_fire_at_one_one_meets_it() -> None:
    """By chance (one of them never in 20 runs: 2e-6); the other keeps its place, its bag and its freedom."""
    winners = set()
    for seed in range(20):
        scene = in_line(
            DEFAULT, "..>v<...", bags={0: (1, 0), 1: (0, 1), 2: (2, 0)}, seed=seed
        ).step("interact, stay, interact")
        winner = 0 if scene.reward[0] else 2
        other = 2 - winner
        scene.has(
            {"reward": {winner: -1, 1: 5, other: 0}, "event met": {winner: 1, 1: 1, other: 0}}
        )
        assert (bags(scene, other), scene.places()[other]) == (
            [(2, 0) if other else (1, 0)],
            (2, 2 + other),
        )
        assert sent(scene, winner, 1)
        winners.add(winner)
    assert winners == {0, 2}


def test_in_the_released_rules_both_meet_it() -> None:
    scene = in_line(RELEASED, "..>v<...", bags={0: (1, 0), 1: (0, 1), 2: (2, 0)}).step(
        "interact, stay, interact"
    )
    scene.has(
        {"reward": [-1, 10, -1, 0], "event met": [1, 2, 1, 0], "agent.resting": [0, 19, 0, 0]}
    )
    assert (bags(scene, 0, 1, 2), scene.places()[0], scene.places()[2]) == (
        [(0, 0)] * 3,
        (2, 2),
        (2, 4),
    )


@BOTH
def test_meetings_come_after_moves_and_collecting(stage: Stage) -> None:
    """Agent 1 walks in front of agent 0, out of its reach, or onto a resource there; it faces north, so that both frames agree."""
    scene = put(
        stage,
        *ROWS[:2],
        "...^....  1",
        "....^.#.  0",
        ROWS[4],
        "vvPPPPPP",
        bags={0: (1, 0), 1: (0, 1)},
    )
    scene.step("interact, step_right").has({"reward": [-1, 5, 0, 0]})
    scene = put(
        stage,
        *ROWS[:2],
        "....^...  1",
        "....^.#.  0",
        ROWS[4],
        "vvPPPPPP",
        bags={0: (1, 0), 1: (0, 1)},
    )
    scene.step("interact, forward").has({"reward": 0, "event met": 0})
    scene = put(
        stage, "..v.....  0", ROWS[1], "..^.....  1", *ROWS[3:5], "vvPPPPPP", bags={0: (0, 1)}
    )
    scene.step("interact, forward").has(
        {"reward": [5, -1, 0, 0], "event collected[coop]": [0, 1, 0, 0]}
    )


# Resources


@BOTH
@pytest.mark.parametrize(("before", "after"), [((99, 100), (100, 100)), ((100, 7), (100, 7))])
def test_a_bag_holds_a_hundred_of_each(stage: Stage, before: Bag, after: Bag) -> None:
    scene = put(stage, EMPTY, ROWS[1], "..^.....", *ROWS[3:5], "vvvPPPPP", bags={0: before}).step(
        "forward"
    )
    scene.shows(EMPTY, "..^D....", EMPTY, *ROWS[3:5], "vvvPPPPP", under={0: "c"})
    assert bags(scene, 0) == [after]


# Moves, starts, what is seen


def test_as_released_everybody_sees_every_bag_and_nobody_who_is_held() -> None:
    """In every cell of everybody's window, also of agents far away: all that can be taken to cooperate, then all to defect."""
    bags = {0: (2, 3), 1: (4, 100), 2: (0, 0), 3: (7, 1)}
    scene = put(RELEASED, "......^.  0", *ROWS[1:5], "v>PPPP^P  123", bags=bags, held={1: 50})
    wanted = [
        (f"everyone[{agent}].bag[{word}]", bags[agent][n])
        for n, word in enumerate(("coop", "defect"))
        for agent in range(4)
    ]
    assert [p.name for p in RELEASED.env.token_planes if p.name.startswith("everyone")] == [
        name for name, _ in wanted
    ]
    for observer in range(4):
        assert [
            (name, scene.seen(observer, name, ahead, right))
            for name, _ in wanted
            for ahead in (-1, 9)
            for right in (-5, 5)
        ] == [pair for pair in wanted for _ in range(4)]
    assert own_planes(RELEASED) == {"agent.heading", *(name for name, _ in wanted)}


def own_planes(stage: Stage) -> set[str]:
    """Returns the planes of what agents have."""
    return {plane.name for plane in stage.env.token_planes} - {"content", "agent", "marks"}
