"""Factory of the Commons, scene by scene, on the interpreter: what machines make and when, stamina, holding and shoving.

Source of the rules and times: Melting Pot's components of the factory, of grasping, grappling and stamina.
"""

import pytest

from sjdsl.testing import Scene, Stage

ROWS = ("#######", "#S=.G=#", "#.m..m#", "#.n..n#", "#.....#", "#######")
LOOKS = {"o": "floor apple=here"}
STAGE = Stage("factory_commons", ROWS, 2, looks=LOOKS, interpreted=True)
OPEN = Stage(
    "factory_commons",
    ("#########", "#.......#", "#.......#", "#.......#", "#########"),
    2,
    looks=LOOKS,
    interpreted=True,
)


def at_machine(sort: str, hand: str = "cube") -> Scene:
    """Returns a scene of agent 0 under the mouth of a machine, agent 1 out of the way."""
    upper = {"S": ("#S=.G=#", "#^m..m#"), "G": ("#S=.G=#", "#.m.^m#")}[sort]
    return STAGE.put(
        "#######", *upper, "#.n..n#", "#..<..#", "#######", fields={"agent.hand": [hand, "none"]}
    )


@pytest.mark.parametrize("sort", ["S", "G"])
def test_a_cube_over_a_mouth_is_taken_in_and_turned_into_apples(sort: str) -> None:
    """Eleven steps later a cube, or two apples; with a cube, an apple after thirteen. The mouth takes the next cube in the eighteenth."""
    made = {"S": "cube_and_apple", "G": "two_apples"}[sort]
    scene = at_machine(sort).step().has({"agent.hand": "none", f"event fed[{made}]": 1})
    scene.step("", 10)
    assert "here" not in scene.value("floor.cube") + scene.value("floor.apple")
    scene.step()
    assert (scene.value("floor.cube").count("here"), scene.value("floor.apple").count("here")) == (
        (1, 0) if sort == "S" else (0, 2)
    )
    scene.step("", 2)
    assert (scene.value("floor.cube").count("here"), scene.value("floor.apple").count("here")) == (
        (1, 1) if sort == "S" else (0, 2)
    )
    for step in range(14, 18):
        assert max(scene.value("mouth.clock")) == 18 - step
        scene.step()
    scene.has({"mouth.clock": 0})


@pytest.mark.parametrize(("sign", "hand"), [("C", "cube"), ("o", "apple")])
def test_things_are_grasped_and_let_go(sign: str, hand: str) -> None:
    scene = (
        OPEN.put("#########", f"#>{sign}....<#", "#.......#", "#.......#", "#########")
        .step("grasp")
        .has({"agent.hand": [hand, "none"]})
    )
    scene.step("step_right").step("grasp").has({"agent.hand": "none"})
    where = scene.value("floor.cube" if hand == "cube" else "floor.apple").index("here")
    assert where == 7 + 1


def test_walking_tires() -> None:
    """Of 18, twelve steps are free; then each costs a rest of two steps, and at none of six. Standing gives one back."""
    scene = OPEN.put("#########", "#>......#", "#.......#", "#......<#", "#########").step(
        "backward", 11
    )
    scene.has({"agent.stamina": [7, 18], "allowed forward": True})
    scene.step("backward").has(
        {
            "agent.stamina": [6, 18],
            "allowed forward": [False, True],
            "allowed turn_left": [False, True],
        }
    )
    scene.step("forward").has({"agent.stamina": [6, 18], "allowed forward": [False, True]})
    scene.step("forward").has({"agent.stamina": [6, 18], "allowed forward": True})
    scene.step().has({"agent.stamina": [7, 18]})
    scene = OPEN.put(
        "#########",
        "#>......#",
        "#.......#",
        "#......<#",
        "#########",
        fields={"agent.stamina": [1, 18]},
    ).step("forward")
    for _ in range(6):
        scene.has({"agent.stamina": [0, 18], "allowed forward": [False, True]}).step("forward")
    scene.has({"allowed forward": True})


@pytest.mark.parametrize("gap", [1, 2, 3])
def test_holding(gap: int) -> None:
    """Up to two cells away; both miss one step of walking, and who is held cannot hold."""
    line = "#>" + "." * (gap - 1) + "v" + "." * (6 - gap) + "#"
    scene = OPEN.put("#########", line, "#.......#", "#.......#", "#########").step("hold")
    held = gap <= 2
    scene.has({"allowed hold": [True, not held], "marks take_hold": {(1, 2), (1, 3)}})
    scene.step("turn_left, forward")
    assert scene.places() == [(1, 1), (1 + (not held), 1 + gap)]
    scene.has({"agent.heading": ["east" if held else "north", "south"]})
    scene.step("stay, forward")
    assert scene.places()[1] == (2 + (not held), 1 + gap)


@pytest.mark.parametrize(
    ("action", "gap", "after"),
    [("shove", 1, 3), ("shove", 2, 4), ("pull", 2, 2), ("pull", 1, 2), ("hold", 2, 3)],
)
def test_shoving_and_pulling(action: str, gap: int, after: int) -> None:
    line = "#>" + "." * (gap - 1) + "v" + "." * (6 - gap) + "#"
    scene = OPEN.put("#########", line, "#.......#", "#.......#", "#########").step(action)
    assert scene.places() == [(1, 1), (1, after)]
    scene.has({"agent.heading": ["east", "south"]})


def test_the_start() -> None:
    """Some cubes are always there, of the others each with probability one half (four standard deviations). Nobody starts on a marked cell."""
    stage, counts = Stage("factory_commons", interpreted=True), []
    for seed in range(20):
        scene = stage.start(seed)
        counts.append(scene.value("floor.cube").count("here"))
        assert all(scene.under(agent) == "." for agent in range(3))
    always, perhaps = (sum(row.count(glyph) for row in stage.env.game.rows) for glyph in "Cc")
    assert min(counts) >= always
    assert abs(sum(counts) / 20 - always - perhaps / 2) <= 4 * (perhaps / 4 / 20) ** 0.5
