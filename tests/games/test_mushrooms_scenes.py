"""Mushrooms, scene by scene: who is paid for a meal, how long one digests, what grows after it, whom a beam sends off."""

from typing import Any

import pytest

from sjdsl.testing import Scene, Stage

from .environments import stage_of

ROWS = ("R.......", "........", "........", "........", "........", "........")
EMPTY = "........"
DEFAULT = stage_of("mushrooms", ROWS, 5)
RELEASED = stage_of("mushrooms", ROWS, 5, variant="socialjax")
STAGES = [DEFAULT, RELEASED]
BOTH = pytest.mark.parametrize("stage", STAGES, ids=["default", "socialjax"])
KINDS = ("red", "green", "blue", "orange")
SIGNS = dict(zip(KINDS, "RGBO", strict=True))
CERTAIN, NEVER = dict.fromkeys(KINDS, 1), dict.fromkeys(KINDS, 0)


def put(
    stage: Stage,
    *picture: str,
    regrow: dict[str, float] = NEVER,
    seed: int = 0,
    step: int = 0,
    **facts: Any,
) -> Scene:
    """Returns a scene in which nothing grows unless `regrow` says so; facts: `fields` and numbers of the game."""
    fields = facts.pop("fields", {})
    return stage.put(
        *picture, seed=seed, step=step, fields=fields, params={"regrow": regrow, **facts}
    )


def meal(stage: Stage, *signs: str, **facts: Any) -> Scene:
    """Returns a scene in which agents 0, 1, … have a mushroom each before them, to the north."""
    above, below = "".join(signs).ljust(8, "."), ("^" * len(signs)).ljust(8, ".")
    others = ("v" * (5 - len(signs))).rjust(8, ".")
    return put(
        stage, EMPTY, EMPTY, above, below + "  " + "01234"[: len(signs)], EMPTY, others, **facts
    )


def eat(number: int = 1) -> str:
    return ", ".join(["forward"] * number)


def grown(scene: Scene) -> dict[str, int]:
    """Returns how many mushrooms there are, kind by kind."""
    return {kind: scene.value("ground.grows").count(kind) for kind in KINDS}


def counts(red: int = 0, green: int = 0, blue: int = 0, orange: int = 0) -> dict[str, int]:
    return {"red": red, "green": green, "blue": blue, "orange": orange}


# What a meal pays. Five agents: green 2 / 5 for each, blue 3 / 4 for each other, orange -0.2 for each
PAYMENTS = [
    ("R", [1, 0, 0, 0, 0]),
    ("G", [0.4, 0.4, 0.4, 0.4, 0.4]),
    ("B", [0, 0.75, 0.75, 0.75, 0.75]),
    ("O", [-0.2, -0.2, -0.2, -0.2, -0.2]),
    ("GBOR", [0.95, 0.2, 0.95, 1.95, 0.95]),
    ("BBR", [0.75, 0.75, 2.5, 1.5, 1.5]),
]


@BOTH
@pytest.mark.parametrize(("eaten", "reward"), PAYMENTS)
def test_payments(stage: Stage, eaten: str, reward: list[float]) -> None:
    scene = (
        meal(stage, *eaten)
        .step(eat(len(eaten)))
        .has({"reward": reward, "ground.grows": "none", "event hits": 0})
    )
    for kind, sign in SIGNS.items():
        scene.has(
            {
                f"event eaten[{kind}]": [
                    int(agent < len(eaten) and eaten[agent] == sign) for agent in range(5)
                ]
            }
        )
    scene.step().has({"reward": 0})


@pytest.mark.parametrize(
    ("agents", "green", "blue"), [(2, 1, 3), (3, 2 / 3, 1.5), (5, 0.4, 0.75), (20, 0.1, 3 / 19)]
)
def test_what_is_shared_is_split(agents: int, green: float, blue: float) -> None:
    """The prices themselves, by the number of agents: red 1, green 2 and blue 3 in all, orange -0.2 for each."""
    for stage in (
        stage_of("mushrooms", agents=agents),
        stage_of("mushrooms", agents=agents, variant="socialjax"),
    ):
        params = stage.env.params
        assert params.eater.tolist() == [1, 0, 0, 0]
        assert params.everyone.tolist() == pytest.approx([0, green, 0, -0.2])
        assert params.others.tolist() == pytest.approx([0, 0, blue, 0])


# Digestion

# kind -> steps whose actions are void: as the paper says, and one less in the released code
DIGESTION = {"red": (10, 9), "green": (15, 14), "blue": (20, 19), "orange": (0, 0)}


@BOTH
@pytest.mark.parametrize("kind", KINDS)
def test_digestion(stage: Stage, kind: str) -> None:
    """Nothing one does has an effect for so many steps: one neither moves nor turns nor zaps. Then one acts."""
    steps = DIGESTION[kind][STAGES.index(stage)]
    scene = meal(stage, SIGNS[kind]).step("forward")
    scene.has({"allowed forward": {0: steps == 0}, "allowed stay": True})
    if steps:
        scene.step("turn_left", times=steps - 2).step("forward").has({"allowed zap": {0: False}})
        scene.step("forward").has({"agent.row": {0: 2}, "agent.heading": {0: "north"}})
    scene.step("forward").has({"agent.row": {0: 1}})


@BOTH
def test_who_is_zapped_goes_on_digesting(stage: Stage) -> None:
    """Agent 1 walks into the beam and onto a red mushroom: it has its reward, is sent off, and waits as long as ever."""
    steps = DIGESTION["red"][STAGES.index(stage)]
    scene = put(stage, EMPTY, EMPTY, "..R.....", "..^.....  1", "..^.....  0", ".....vvv")
    scene.step("zap, forward").has({"reward": [0, 1, 0, 0, 0], "event hits": [1, 0, 0, 0, 0]})
    assert scene.places()[1] != (2, 2)
    for _ in range(steps):
        scene.has({"allowed forward": {1: False}}).step()
    scene.has({"allowed forward": True})


# Growth

# what is eaten -> what two certain trials (orange: one) make of it
SPORES = [
    ("R", counts(red=2)),
    ("G", counts(red=2, green=2)),
    ("B", counts(red=2, green=2, blue=2)),
    ("O", counts(red=2, orange=1)),
    ("RR", counts(red=4)),
    ("GB", counts(red=4, green=4, blue=2)),
    ("OO", counts(red=4, orange=2)),
]


@BOTH
@pytest.mark.parametrize(("eaten", "after"), SPORES)
def test_what_grows_after_a_meal(stage: Stage, eaten: str, after: dict[str, int]) -> None:
    """In its step; in the released rules a step later; then no more."""
    scene = meal(stage, *eaten, regrow=CERTAIN).step(eat(len(eaten)))
    if stage is RELEASED:
        assert grown(scene) == counts()
        scene.step()
        after = {**after, "orange": min(after["orange"], 1)}
    assert grown(scene) == after
    assert grown(scene.step()) == after


# The values of the four tests below are those of the released code, commit 9df972d, played from the same states.
@pytest.mark.parametrize(
    ("eaten", "after"),
    [
        ("BBBBB", counts(red=5, green=5, blue=5)),
        ("BBB", counts(red=5, green=5, blue=5)),
        ("RRR", counts(red=5)),
        ("OO", counts(red=4, orange=1)),
        ("OOO", counts(red=5, orange=1)),
    ],
)
def test_as_released_no_more_than_five_of_a_kind_grow_in_a_step(
    eaten: str, after: dict[str, int]
) -> None:
    """All trials succeed."""
    scene = meal(RELEASED, *eaten, regrow=CERTAIN).step(eat(len(eaten)))
    assert grown(scene.step()) == after


def test_as_released_nothing_grows_where_the_first_mushrooms_stood() -> None:
    scene = put(RELEASED, *full((0, 0), (1, 5), eaten="R"), regrow=CERTAIN).step("forward").step()
    scene.has({"ground.grows": {(0, 0): "none", (1, 5): "red", (3, 0): "red"}})


def test_as_released_who_is_hit_comes_to_any_cell_but_those_of_the_first_mushrooms() -> None:
    rows = [".OOOOOOO", "O" * 8, "OOvOOOOO  1", "OO^OOOOO  0", "O" * 8, "OOOOOvvv  234"]
    places = {put(RELEASED, *rows, seed=seed).step("zap").places()[1] for seed in range(20)}
    assert len(places) > 5
    assert (0, 0) not in places


def test_as_released_who_is_sent_onto_a_mushroom_crushes_it() -> None:
    """In the next step, uneaten."""
    rows = ["R" * 8, "R" * 8, "RRvRRRRR  1", "RR^RRRRR  0", "R" * 8, "RRRRRvvv  234"]
    scene = put(RELEASED, *rows).step("zap")
    before = grown(scene)
    scene.step().has({"reward": 0, "event eaten[red]": 0})
    assert grown(scene) == counts(red=before["red"] - 1)


@BOTH
@pytest.mark.parametrize(
    ("kind", "eaten"), [("red", "R"), ("green", "G"), ("blue", "B"), ("red", "B"), ("green", "B")]
)
@pytest.mark.parametrize("left", [5, 6])
def test_no_kind_grows_while_more_than_five_are_left(
    stage: Stage, kind: str, eaten: str, left: int
) -> None:
    """Five left after the meal grow to seven, six stay six; the other kinds grow as ever."""
    others = "vvvv".rjust(8, ".")
    row = (SIGNS[kind] * left).rjust(8, ".")
    scene = put(
        stage, EMPTY, row, f"{eaten}.......", "^.......  0", EMPTY, others, regrow=CERTAIN
    ).step("forward")
    if stage is RELEASED:
        scene.step()
    expected = dict(next(after for sign, after in SPORES if sign == eaten))
    expected[kind] = 7 if left == 5 else 6
    assert grown(scene) == expected


def full(*bare: tuple[int, int], eaten: str) -> list[str]:
    """Returns a map full of orange but for some cells and what is eaten, at (2, 0), by agent 0 from the south."""
    rows = [["O"] * 8 for _ in range(6)]
    for row, column in bare:
        rows[row][column] = "."
    rows[2][0], rows[3][0], rows[5][4:] = eaten, "^", "vvvv"
    return ["".join(row) for row in rows]


# Zapping


# Agent 0 at an edge, facing out, and whom its beam hits as released. Source: the released code, commit 9df972d, in these states
EDGES = [
    (("..^.....  0", EMPTY, EMPTY, EMPTY, "..v.....  1", ".vvv....  234"), {1, 3}),
    ((".^^^....  123", "..^.....  4", EMPTY, EMPTY, EMPTY, "..v.....  0"), {0}),
    ((EMPTY, ".......^  1", "<.....<^  042", ".......^  3", EMPTY, EMPTY), {2, 4}),
    ((EMPTY, "^.......  1", "^>.....>  240", "^.......  3", EMPTY, EMPTY), {0}),
]


@pytest.mark.parametrize(("picture", "hit"), EDGES)
def test_beams_leave_the_map_only_as_released(picture: tuple[str, ...], hit: set[int]) -> None:
    """By default nobody is hit on the other side, nor itself."""
    for stage, gone in ((DEFAULT, set()), (RELEASED, hit)):
        scene = put(stage, *picture)
        before = scene.places()
        scene.step("zap").has({"event hits": {0: len(gone)}})
        assert {agent for agent in range(5) if scene.places()[agent] != before[agent]} == gone


# Episodes, moves, what is seen
