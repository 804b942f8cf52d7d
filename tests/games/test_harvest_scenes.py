"""Harvest, scene by scene: apples that grow and are eaten, beams that send others home."""

import itertools

import numpy as np
import pytest

from sjdsl.testing import Scene

from .environments import stage_of

LOOKS = {"a": "soil fruit=none"}
GROVE = stage_of(
    "harvest_open",
    ("AAAAAA", "AAAAAA", "AAAAAA", "AAAAAA", "AAAAA#", "AAAA#A", "QQPP.."),
    2,
    looks=LOOKS,
)
SOIL = [(r, c) for r, row in enumerate(GROVE.map) for c, glyph in enumerate(row) if glyph == "A"]
HOME = "QQ^>.."  # two agents out of the way
RATES = ("regrow_1", "regrow_2", "regrow_3")  # chances with one, two, three or more apples near
FIELD = stage_of("harvest_open", ("QQPPPP", "....#.", "......", "......", "......", "......"), 4)
GATES = {(0, c) for c in range(2, 6)}
PATIENT = stage_of("harvest_open", ("QQPP", "....", "...."), 2, params={"respawn_delay": 2})

# Source: SocialJax, harvest_open: the cells of a zap as (ahead, right) of the agent
BEAM = {(1, 0), (2, 0), (1, 1), (1, -1)}


def grove(
    *picture: str,
    rates: tuple[float, float, float] = (0, 0, 0),
    seed: int = 0,
    under: dict[int, str] | None = None,
) -> Scene:
    return GROVE.put(*picture, seed=seed, under=under, params=dict(zip(RATES, rates, strict=True)))


def with_ripe(*ripe: tuple[int, int], rates: tuple[float, float, float]) -> Scene:
    """Returns a scene with apples on these cells alone."""
    rows = [
        "".join("A" if (r, c) in ripe else glyph.replace("A", "a") for c, glyph in enumerate(row))
        for r, row in enumerate(GROVE.map)
    ]
    return grove(*rows[:-1], HOME, rates=rates)


def ripe(scene: Scene) -> set[tuple[int, int]]:
    return {
        cell for cell, fruit in zip(SOIL, scene.value("soil.fruit"), strict=True) if fruit == "ripe"
    }


def near(cell: tuple[int, int]) -> set[tuple[int, int]]:
    """Returns the soil within a distance of 2, the cell itself left out: at most 12 cells."""
    return {(r, c) for r, c in SOIL if 0 < (r - cell[0]) ** 2 + (c - cell[1]) ** 2 <= 4}


# Growth


def test_each_number_of_apples_has_its_chance() -> None:
    """The chances set to certainty one after the other, over random patches."""
    random = np.random.default_rng(0)
    for trial in range(12):
        before = {cell for cell in SOIL if random.random() < 0.1 + 0.04 * trial}
        counts = {cell: len(near(cell) & before) for cell in SOIL}
        for rates, enough in (
            ((0, 0, 0), set()),
            ((0, 0, 1), {*range(3, 13)}),
            ((0, 1, 1), {*range(2, 13)}),
            ((1, 1, 1), {*range(1, 13)}),
        ):
            assert ripe(with_ripe(*before, rates=rates).step("stay")) == before | {
                c for c in SOIL if counts[c] in enough
            }
        assert ripe(with_ripe(*before, rates=(0, 1, 0)).step("stay")) == before | {
            c for c in SOIL if counts[c] == 2
        }


def test_nothing_grows_under_an_agent() -> None:
    scene = grove(
        "aaaaaa",
        "aA>aaa",
        "aaaaaa",
        "aaaaaa",
        "aaaaa#",
        "aaaa#a",
        "QQPP>.",
        rates=(1, 1, 1),
        under={0: "a"},
    ).step("stay")
    scene.shows("AAAaaa", "AA>Aaa", "AAAaaa", "aAaaaa", "aaaaa#", "aaaa#a", "QQPP>.")
    assert scene.reward == [0, 0]  # nor is it eaten as it comes


TWO_APPLES = ("aaaaaa", "a>Aaaa", "aaaAaa", "aaaaaa", "aaaaa#", "aaaa#a", "QQPP>.")


def test_an_apple_eaten_in_this_step_still_counts() -> None:
    scene = grove(*TWO_APPLES, rates=(0, 1, 0), under={0: "a"}).step("forward")
    assert scene.reward == [1, 0]
    assert ripe(scene) == {(2, 3)} | (near((1, 2)) & near((2, 3)))


def test_an_emptied_patch_is_dead() -> None:
    scene = grove(
        "aaaaaa", "aaaaaa", ">Aaaaa", "aaaaaa", "aaaaa#", "aaaa#a", "QQPP>.", under={0: "a"}
    ).step("forward")
    scene.shows("aaaaaa", "aaaaaa", "a>aaaa", "aaaaaa", "aaaaa#", "aaaa#a", "QQPP>.")
    scene.change(regrow_1=1, regrow_2=1, regrow_3=1)
    for _ in range(3):
        assert ripe(scene.step("backward, forward")) == set()


# Eating


def test_who_enters_a_cell_eats_its_apple() -> None:
    scene = grove(
        "AAAaaa", "A>AAaa", "AAAaaa", "aaaaaa", "aaaaa#", "aaaa#a", "QQPP>.", under={0: "a"}
    ).step("forward, stay")
    scene.shows("AAAaaa", "Aa>Aaa", "AAAaaa", "aaaaaa", "aaaaa#", "aaaa#a", "QQPP>.")
    assert (scene.reward, scene.events["eaten"]) == ([1, 0], [1, 0])
    assert scene.metrics["apples_left"] == 8
    scene.step("turn_left, stay")
    assert (scene.reward, scene.events["eaten"]) == ([0, 0], [0, 0])


# Zapping


def field(*picture: str, seed: int = 0) -> Scene:
    return FIELD.put(*picture, seed=seed)


def placed(poses: dict[int, tuple[int, int, str]], seed: int = 0) -> Scene:
    """Returns the field with agents by number at (row, column, arrow)."""
    rows = [list(row) for row in FIELD.map]
    for row, col, arrow in poses.values():
        rows[row][col] = arrow
    beside = [
        "".join(
            str(a)
            for a, (r, _, _) in sorted(poses.items(), key=lambda item: item[1][1])
            if r == row
        )
        for row in range(len(rows))
    ]
    return field(
        *("".join(row) + "  " + ids for row, ids in zip(rows, beside, strict=True)), seed=seed
    )


def home(scene: Scene, agent: int) -> bool:
    return scene.places()[agent] in GATES


@pytest.mark.parametrize(("heading", "arrow"), list(enumerate("^>v<")))
def test_the_four_cells_of_the_beam(heading: int, arrow: str) -> None:
    """The zapper in the middle, another on each cell around it in turn."""
    ahead_row, ahead_col = [(-1, 0), (0, 1), (1, 0), (0, -1)][heading]
    for ahead, right in itertools.product(range(-2, 3), repeat=2):
        row, col = (
            3 + ahead * ahead_row + right * ahead_col,
            2 + ahead * ahead_col - right * ahead_row,
        )
        if (row, col) in {(3, 2), (1, 4)}:  # the zapper itself, the wall
            continue
        scene = placed({0: (3, 2, arrow), 1: (row, col, "v"), 2: (0, 0, ">"), 3: (0, 1, ">")}).step(
            "zap"
        )
        hit = (ahead, right) in BEAM
        assert scene.events["hits"] == [int(hit), 0, 0, 0]
        assert home(scene, 1) == hit
        assert hit or scene.places()[1] == (row, col)
        assert scene.places()[0] == (3, 2)
        assert scene.reward == [0, 0, 0, 0]


def test_a_wall_ends_its_lane_and_no_other() -> None:
    """The wall is one ahead: who stands behind it is safe, who stands beside it is hit."""
    scene = field("QQPPvP  1", "...v#v  23", "....^.  0", "......", "......", "......").step("zap")
    assert scene.events["hits"] == [2, 0, 0, 0]
    assert scene.places()[1] == (0, 4)
    assert {scene.places()[2], scene.places()[3]} <= GATES - {(0, 4)}


def test_with_a_delay_who_is_hit_is_away_that_long() -> None:
    """Two ticks: it misses one whole step, comes back at the beginning of the next, and acts in it."""
    scene = PATIENT.put("QQPP", ".v..  1", ".^..  0").step("zap")
    assert (scene.places()[1], scene.events["hits"]) == (None, [1, 0])
    assert not scene.observation[1].any()
    assert scene.seen(0, "agent", ahead=1) == "none"
    scene.step("zap, forward")
    assert (scene.places()[1], scene.events["hits"]) == (None, [0, 0])
    scene.step("stay, stay")
    assert scene.places()[1] in {(0, 2), (0, 3)}
    assert scene.observation[1].any()
