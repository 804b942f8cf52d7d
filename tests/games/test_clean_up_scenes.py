"""Clean Up, scene by scene: cleaning, growth and its measure of dirt, and new dirt."""

import pytest

from sjdsl.testing import Scene

from .environments import stage_of

LOOKS = {"b": "orchard fruit=ripe"}
# 18 cells of water and 2 of channel: 8 dirty cells are a fraction of 0.4
STAGE = stage_of(
    "clean_up",
    ("HHHHHHS", "HHHHHHS", "HHHH#HH", ".......", "PPP.#..", "BBBBBBB", "BBBBBBB"),
    3,
    looks=LOOKS,
)
DIRTY = ("FFFFFFS", "FFFFFFS", "FFFF#FF")
CLEAN = ("HHHHHHS", "HHHHHHS", "HHHH#HH")
BARE = ("BBBBBBB", "BBBBBBB")


def put(
    *picture: str,
    step: int = 0,
    seed: int = 0,
    under: dict[int, str] | None = None,
    **params: float,
) -> Scene:
    """Returns a scene in which nothing grows and no dirt comes, unless `best_rate` and `pollution` say so."""
    return STAGE.put(
        *picture,
        step=step,
        seed=seed,
        under=under,
        params={"best_rate": 0, "pollution": 0} | params,
    )


def count(scene: Scene, kind: str, name: str, word: str) -> int:
    return scene.value(f"{kind}.{name}").count(word)


# Cleaning


def test_the_four_cells_of_the_beam_become_clean() -> None:
    scene = put(*DIRTY, "..^....  0", "PPP^#..  1", "BB>BBBB  2", BARE[1]).step("clean")
    scene.shows("FFFFFFS", "FFHFFFS", "FHHH#FF", "..^....  0", "PPP^#..  1", "BB>BBBB  2", BARE[1])
    assert scene.events == {"cleaned": [4, 0, 0], "eaten": [0, 0, 0], "hits": [0, 0, 0]}
    assert scene.reward == [0, 0, 0]
    assert scene.metrics["clean_water"] == 4


def test_cleaners_clean_the_union_of_their_beams() -> None:
    """Each counts what it cleans alone; each of the two cells that both clean counts for one of them."""
    scene = put(*DIRTY, ".^^....  01", "PPP^#..  2", *BARE).step("clean, clean")
    scene.shows("FFFFFFS", "FHHFFFS", "HHHH#FF", ".^^....", "PPP^#..", *BARE)
    first, second, third = scene.events["cleaned"]
    assert (first + second, third) == (6, 0)
    assert 2 <= first <= 4
    assert scene.metrics["clean_water"] == 6


@pytest.mark.parametrize(
    "bystander",
    [
        ("FFFFFFS", "FFFFFFS", "FFFF#FF", ".^^....  01"),  # beside it, looking the same way
        ("FFFFFFS", "FFFFFFS", "FFFF#FF", "^^.....  10"),
    ],
)
def test_those_who_stand_beside_undo_nothing(bystander: tuple[str, ...]) -> None:
    scene = put(*bystander, "PPP^#..  2", *BARE).step("clean")
    assert scene.events["cleaned"] == [4, 0, 0]
    assert count(scene, "water", "state", "clean") == 4


def test_dirt_under_agents_is_cleaned() -> None:
    """Agent 1 one ahead and agent 2 two ahead shield nothing, and are not hit."""
    scene = put(
        "FFFFFFS",
        "FFvFFFS  2",
        "FFvF#FF  1",
        "..^....  0",
        "PPP.#..",
        *BARE,
        under={1: "F", 2: "F"},
    ).step("clean")
    scene.shows("FFFFFFS", "FFvFFFS  2", "FHvH#FF  1", "..^....  0", "PPP.#..", *BARE)
    assert scene.events["cleaned"] == [4, 0, 0]
    assert count(scene, "water", "state", "clean") == 4
    assert scene.seen(1, "content") == "water state=clean"


def test_a_wall_ends_its_lane_and_no_other() -> None:
    scene = put(*DIRTY, "....^..  0", "PPP^#..", "BB>BBBB", BARE[1]).step("clean")
    scene.shows("FFFFFFS", "FFFFFFS", "FFFH#HF", "....^..", "PPP^#..", "BB>BBBB", BARE[1])
    assert scene.events["cleaned"] == [2, 0, 0]


def test_a_cleaner_who_is_zapped_has_cleaned() -> None:
    scene = put(*DIRTY, ".^<....  01", "PPP^#..  2", *BARE).step("clean, zap")
    assert scene.events == {"cleaned": [4, 0, 0], "eaten": [0, 0, 0], "hits": [0, 1, 0]}
    assert scene.places()[0] in {(4, 0), (4, 1), (4, 2)}
    assert count(scene, "water", "state", "clean") == 4


# Zapping


def test_a_zap_sends_home_who_stands_in_its_four_cells() -> None:
    """At once, to a gate of the other two; nobody pays, and it acts from there in the next step."""
    for row, col in ((2, 2), (1, 2), (2, 1), (2, 3), (2, 0), (0, 2), (1, 1), (3, 3)):
        rows = [list(line) for line in (*CLEAN, ".......")]
        rows[row][col], rows[3][2] = "v", "^"
        told = {row: "1", 3: "0"} if row != 3 else {3: "01"}
        picture = [
            f"{''.join(line)}  {told[r]}" if r in told else "".join(line)
            for r, line in enumerate(rows)
        ]
        scene = put(*picture, "P^P.#..  2", *BARE).step("zap").has({"reward": 0})
        hit = (row, col) in {(2, 2), (1, 2), (2, 1), (2, 3)}
        scene.has({"event hits": [int(hit), 0, 0], "event cleaned": 0})
        assert (scene.places()[1] in {(4, 0), (4, 2)}) is hit
    heading = scene.headings()[1]
    assert scene.step("stay, turn_left").headings()[1] != heading


# Growth


def test_in_a_clean_river_every_free_orchard_cell_may_grow() -> None:
    """With certainty for the best rate: all but those under agents."""
    scene = put(*CLEAN, ".......", "PPP^#..", "BB>BBBB", "<BBBBBB", best_rate=1).step("stay")
    scene.shows(*CLEAN, ".......", "PPP^#..", "bb>bbbb", "<bbbbbb")
    assert scene.reward == [0, 0, 0]


@pytest.mark.parametrize("dirty", [8, 9, 18])
def test_nothing_grows_from_four_tenths_of_dirt_on(dirty: int) -> None:
    """8 of 20 river cells, the channel's among them: with 18 as the divisor 8 would still be more."""
    water = ("F" * dirty).ljust(18, "H")
    for seed in range(5):
        scene = put(
            water[:6] + "S",
            water[6:12] + "S",
            f"{water[12:16]}#{water[16:]}",
            "^......",
            "PPP^#..",
            ">BBBBBB",
            BARE[1],
            best_rate=1,
            seed=seed,
        )
        assert count(scene.step("stay"), "orchard", "fruit", "ripe") == 0


def test_a_little_less_dirt_lets_some_grow() -> None:
    """7 of 20: a chance of 1/8 for each of 13 cells; none in ten steps happens with 3e-8."""
    ripe = 0
    for seed in range(10):
        scene = put(
            "FFFFFFS",
            "FHHHHHS",
            "HHHH#HH",
            "^......",
            "PPP^#..",
            ">BBBBBB",
            BARE[1],
            best_rate=1,
            seed=seed,
        )
        ripe += count(scene.step("stay"), "orchard", "fruit", "ripe")
    assert 0 < ripe < 65


def test_growth_sees_the_dirt_before_this_steps_cleaning() -> None:
    scene = put(
        "HHHHHHS",
        "HHHHHHS",
        "HHFH#HH",
        "..^....",
        "PPP^#..",
        ">BBBBBB",
        BARE[1],
        best_rate=1,
        spoiled_at=0.05,
    )
    assert count(scene.step("clean"), "orchard", "fruit", "ripe") == 0
    assert count(scene.step("clean"), "orchard", "fruit", "ripe") == 13


def test_apples_are_eaten_as_they_are_entered_and_as_they_come() -> None:
    scene = put(*CLEAN, "^......", "PPP^#..", ">bBBBBB  2", BARE[1]).step("stay, stay, forward")
    assert (scene.reward, scene.events["eaten"]) == ([0, 0, 1], [0, 0, 1])
    scene.shows(*CLEAN, "^......", "PPP^#..", "B>BBBBB  2", BARE[1])
    scene.change(best_rate=1).step("stay, stay, forward")
    assert scene.reward == [0, 0, 1]


# New dirt


@pytest.mark.parametrize(("step", "dirty"), [(0, 0), (48, 0), (49, 0), (50, 1), (51, 1), (999, 1)])
def test_no_new_dirt_in_the_first_fifty_steps(step: int, dirty: int) -> None:
    """Then one cell in a step, for certain if the chance is 1."""
    scene = put(*CLEAN, ".......", "PPP^#..", "BB>BBBB", "<BBBBBB", step=step, pollution=1).step(
        "stay"
    )
    assert count(scene, "water", "state", "dirty") == dirty


def test_dirt_can_be_cleaned_in_the_step_it_comes() -> None:
    """The only clean cell is in front of a cleaner."""
    scene = put(
        "FFFFFFS",
        "FFFFFFS",
        "FFFF#FH",
        "......^  0",
        "PPP^#..",
        "BB>BBBB",
        BARE[1],
        step=50,
        pollution=1,
    ).step("clean")
    assert scene.events["cleaned"] == [2, 0, 0]
    scene.shows("FFFFFFS", "FFFFFFS", "FFFF#HH", "......^  0", "PPP^#..", "BB>BBBB", BARE[1])


# What agents see
