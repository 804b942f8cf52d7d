"""Melting Pot's variants, scene by scene: lanes that end at what they hit, pauses between shots, time away. Source: Melting Pot's components."""

import pytest

from sjdsl.testing import Stage

from .environments import stage_of

OPEN = (".......", ".......", ".......", ".......", ".......", "QQPPPPP")
SHOOTER = (4, 3)  # looks north
HARVEST = stage_of("harvest_open", OPEN, 2, variant="meltingpot")
CROWDED = stage_of("harvest_open", OPEN, 5, variant="meltingpot")
ROOM = stage_of("harvest_closed", (".......", *OPEN), 2, variant="meltingpot")
RIVER = stage_of(
    "clean_up",
    ("HHHHH", "HHHHH", "HHHHH", "SSSSS", "BPPPP"),
    2,
    variant="meltingpot",
)
MINE = stage_of(
    "coop_mining",
    ("OOOOOO", "PPPPPP"),
    2,
    variant="meltingpot",
    looks={"i": "rock ore=iron"},
)
FOREST = Stage(
    "mushrooms", ("........", "........", "........"), 3, variant="meltingpot", interpreted=True
)
NEVER = dict.fromkeys(("red", "green", "blue", "orange"), 0)
FIELDS = [
    Stage(f"harvest_{form}", ("AAAA.", "QQPPP"), 2, variant="meltingpot", interpreted=True)
    for form in ("open", "closed", "partnership")
]
ORCHARD = Stage("clean_up", ("HHHHS", "BPPPP"), 2, variant="meltingpot", interpreted=True)
COINS = Stage("coins", ("PCCCC", "CCCCP"), 2, variant="meltingpot", interpreted=True)
GIFT = stage_of("gift_refinement", ("TTTTTTT", "PPPPPPP"), 3, variant="meltingpot")


def nine(length: int) -> set[tuple[int, int]]:
    """Returns the cells (ahead, right) of three lanes, the outer two of which begin beside the shooter."""
    return {(ahead, 0) for ahead in range(1, length + 1)} | {
        (ahead, side) for ahead in range(length) for side in (-1, 1)
    }


def drawn(rows: tuple[str, ...], arrows: dict[tuple[int, int], str]) -> list[str]:
    return [
        "".join(arrows.get((r, c), glyph) for c, glyph in enumerate(row))
        for r, row in enumerate(rows)
    ]


@pytest.mark.parametrize(("stage", "length"), [(HARVEST, 3), (ROOM, 4)], ids=["open", "rooms"])
def test_cells_of_the_beam(stage: Stage, length: int) -> None:
    rows, below = stage.map, len(stage.map) - 2
    hit = set()
    for row in range(below + 1):
        for col in range(7):
            if (row, col) != (below, SHOOTER[1]):
                first = (row, col) < (below, SHOOTER[1])  # agents count in reading order
                picture = drawn(rows, {(below, SHOOTER[1]): "^", (row, col): "v"})
                scene = stage.put(*picture).step("stay, zap" if first else "zap")
                if scene.places()[0 if first else 1] is None:
                    hit.add((below - row, col - SHOOTER[1]))
    assert hit == nine(length)


def test_a_lane_ends_at_the_first_agent() -> None:
    """Agents 0 and 2 stand behind 1 and 3 of their lanes."""
    scene = CROWDED.put(
        ".......", "...v...", "..vv...", "..v....", "...^...", "QQPPPPP", fields={}
    ).step("stay, stay, stay, stay, zap")
    scene.has({"agent.away": [False, False, True, True, False], "event hits": [0, 0, 0, 0, 2]})


@pytest.mark.parametrize(
    ("stage", "away", "pause"), [(HARVEST, 4, 2), (ROOM, 100, 1)], ids=["open", "rooms"]
)
def test_time_away_and_between_shots(stage: Stage, away: int, pause: int) -> None:
    """Who is hit misses so many whole steps; the shooter cannot fire for so many."""
    picture = drawn(stage.map, {(len(stage.map) - 2, 3): "^", (len(stage.map) - 3, 3): "v"})
    scene = stage.put(*picture).step("stay, zap")
    for step in range(max(away, pause + 1)):
        scene.has({"agent.away": [step < away, False], "allowed zap": {1: step >= pause}})
        scene.step("forward, zap") if step == 0 else scene.step()
    scene.has({"agent.away": [False, False]})
    assert scene.places()[0] in {(len(stage.map) - 1, col) for col in range(2, 7)}, (
        "back at a gate, its own move void"
    )


def test_a_lane_cleans_the_first_dirt_only() -> None:
    scene = RIVER.put("HHHHF", "HHFFH", "FHHFH", "S^SSS", "BPP>P").step("clean")
    scene.shows("HHHHF", "HHHFH", "HHHFH", "S^SSS", "BPP>P")
    scene.has({"event cleaned": [2, 0]})


def test_what_grows_under_a_player_is_taken_at_once() -> None:
    """An apple in the field and beside the river, and a coin. Source: a change of state on a player's cell calls `onEnter`, as in the engine's code."""
    for stage in FIELDS:
        field = stage.put(
            "^AAA.",
            "QQPP^",
            params={"regrow_2": 1.0},
            fields={"soil.fruit": {(0, 0): "none"}},
            under={0: "A"},
        )
        field.step().has({"reward": [1, 0], "soil.fruit": {(0, 0): "none"}})
    ORCHARD.put("HHHHS", "^PPP^", params={"best_rate": 1.0, "pollution": 0.0}).step().has(
        {"reward": [1, 0], "orchard.fruit": "none"}
    )
    coins = COINS.put("P^CCC", "CCC^P", params={"spawn": 0.5}, fields={"tile.coin": "none"}).step()
    taken = [sum(coins.value(f"event {whose}_coins")) for whose in ("own", "other")]
    assert sum(taken) == 2 and coins.value("tile.coin").count("none") == 2


def test_pauses_of_the_two_beams() -> None:
    """Each has its own: two steps without cleaning, ten without zapping."""
    scene = RIVER.put("HHHHH", "HHHHH", "HHHHH", "S^SSS", "BPP>P").step("clean").step("zap")
    for step in range(1, 12):  # steps since the cleaning
        scene.has({"allowed clean": {0: step >= 2}, "allowed zap": {0: step >= 11}})
        scene.step()


@pytest.mark.parametrize(("dirty", "grows"), [(5, True), (6, False)])
def test_the_channel_does_not_count(dirty: int, grows: bool) -> None:
    """15 cells can be dirty: growth ends at 40% of these, that is 6, though 6 of 20 river cells are less. Below, 1 in 50,000 runs grows none."""
    river = "F" * dirty + "H" * (15 - dirty)
    before = [river[:5], river[5:10], river[10:], "S^SSS", "BPP>P"]
    scene = RIVER.put(
        *before, params={"best_rate": 1.0, "spoiled_at": 0.4, "pollution": 0.0}, seed=1
    )
    for _ in range(60):
        scene.step()
    assert (scene.value("orchard.fruit") == ["ripe"]) is grows


def test_one_shot_of_the_mining_ray_in_three_steps() -> None:
    scene = MINE.put(">iOOO<", "PPPPPP", params={"spawn_iron": 0.0, "spawn_gold": 0.0}).step("mine")
    scene.has({"reward": [1, 0], "allowed mine": [False, True]})
    scene.step("mine").has({"allowed mine": [False, True]})
    scene.step("mine").has({"allowed mine": [True, True]})


def test_all_who_reach_iron_in_one_step_are_paid() -> None:
    scene = MINE.put(">i<OOO", "PPPPPP", params={"spawn_iron": 0.0, "spawn_gold": 0.0}).step(
        "mine, mine"
    )
    scene.has({"reward": 1, "event iron_mined": 1, "rock.ore": "none"})


def test_gifts_reach_five_cells_and_are_of_the_finest_level() -> None:
    """Agent 0 holds all levels, agent 2 raw ones; agent 1 is five cells from the one and beside the other. Cut and raw become five."""
    bags = {"agent.bag[raw]": [1, 0, 1], "agent.bag[cut]": [1, 0, 0], "agent.bag[fine]": [1, 0, 0]}
    scene = GIFT.put(">TTTT>T", "PPPPP^P", fields=bags, params={"spawn": 0.0}).step(
        "gift, stay, gift"
    )
    scene.has(
        {"agent.bag[fine]": [0, 1, 0], "agent.bag[cut]": [1, 5, 0], "agent.bag[raw]": [1, 0, 0]}
    )
    scene.has({"allowed gift": [False, True, False]})
    scene.step("gift").has({"allowed gift": [False, True, False], "agent.bag[cut]": [1, 5, 0]})
    scene.step().has({"allowed gift": [True, True, True]})
    scene.step("gift").has({"agent.bag[cut]": [0, 5, 0], "agent.bag[fine]": [0, 6, 0]})


@pytest.mark.thorough
def test_mushrooms_spoil_each_after_its_time() -> None:
    """Red ones after 200 steps, green after 100, blue after 75, orange never; so do those that have grown in the meantime."""
    scene = FOREST.put(
        "R.G.B.O.",
        "........",
        "vvv.....",
        fields={"ground.fresh": {(0, 0): 200, (0, 2): 100, (0, 4): 75}},
    ).step(times=74)
    scene.shows("R.G.B.O.", "........", "vvv.....").step().shows(
        "R.G...O.", "........", "vvv....."
    ).step(times=25)
    scene.shows("R.....O.", "........", "vvv.....").step(times=99).shows(
        "R.....O.", "........", "vvv....."
    ).step()
    scene.shows("......O.", "........", "vvv.....").step(times=200).shows(
        "......O.", "........", "vvv....."
    )
    sown = FOREST.put(
        "R.......",
        "^.......",
        "vv......  12",
        fields={"ground.fresh": 9},
        params={"regrow": dict.fromkeys(NEVER, 1.0)},
    ).step("forward")
    fresh, grows = sown.value("ground.fresh"), sown.value("ground.grows")
    assert [left for left, what in zip(fresh, grows, strict=True) if what == "red"] == [200] * 3


def test_the_beam_destroys_mushrooms_up_to_the_first_agent() -> None:
    """Three lanes of three cells; what is behind an agent stays."""
    scene = FOREST.put("RRRRRR..", ">RvRRR..  01", "RRRRRRv.  2", fields={"ground.fresh": 9}).step(
        "zap"
    )
    scene.shows("...RRR..", ">.vRRR..", "...RRRv.").has(
        {"event hits": [1, 0, 0], "agent.hits": [0, 1, 0]}
    )
    assert scene.under(1) == "."


def test_a_first_hit_freezes_and_a_second_one_sends_away() -> None:
    """For 24 steps nothing can be done, and no zap for 28; the shooter waits for three. After 49 steps without a hit it is forgotten."""
    scene = FOREST.put(">v......", "........", "......v.").step("zap")
    scene.has(
        {
            "allowed zap": [False, False, True],
            "allowed forward": [True, False, True],
            "agent.hits": [0, 1, 0],
        }
    )
    scene.step("zap, forward", times=3).has({"agent.hits": [0, 1, 0], "allowed zap": {0: True}})
    gone = FOREST.put(
        ">v......",
        "........",
        "......v.",
        fields={"agent.hits": {1: 1}, "agent.recovering": {1: 9}},
    ).step("zap")
    gone.has({"agent.away": [False, True, False], "agent.hits": 0}).step(times=51).has(
        {"agent.away": {1: True}}
    )
    gone.step().has({"agent.away": False})
    scene.step("zap, forward").has({"agent.away": [False, True, False]})
    scene = (
        FOREST.put(">v......", "........", "......v.")
        .step("zap")
        .step("turn_left", times=24)
        .has({"allowed forward": True, "allowed zap": {1: False}})
    )
    scene.step("turn_left", times=4).has({"allowed zap": {1: True}})
    scene.step("turn_left", times=20).has({"agent.hits": [0, 1, 0]}).step().has({"agent.hits": 0})


def test_who_digests_cannot_walk_and_can_zap() -> None:
    """Nine steps for a green meal, fourteen for blue and orange ones, none for red."""
    for sign, steps in (("R", 0), ("G", 9), ("B", 14), ("O", 14)):
        scene = FOREST.put(
            f"{sign}.......",
            "^......v",
            "......v.",
            fields={"ground.fresh": 9},
            params={"regrow": NEVER},
        ).step("forward")
        scene.has(
            {
                "agent.digesting": [steps, 0, 0],
                "allowed zap": True,
                "allowed forward": {0: steps == 0},
            }
        )


def test_who_is_away_is_not_paid() -> None:
    """Of three players: green pays two thirds to each who is there, blue three halves to each other one. Source: Melting Pot."""
    for sign, paid in (("G", [2 / 3, 2 / 3, 0]), ("B", [0, 1.5, 0])):
        scene = FOREST.put(
            f"{sign}.......",
            "^......v",
            "........",
            away={2: 9},
            fields={"ground.fresh": 9},
            params={"regrow": NEVER},
        ).step("forward")
        assert scene.reward == pytest.approx(paid)
