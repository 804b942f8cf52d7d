"""What means something else looks different, also to the colour-blind: measured on the tiles as they are drawn."""

from collections.abc import Iterator
from itertools import combinations, product

import numpy as np
import pytest

import sjdsl
from sjdsl.library.games_folder import main_games
from sjdsl.render.appearance import Drawing, cell_keys, draw_cell
from sjdsl.render.board import draw_tile
from sjdsl.render.colours import AGENTS, BARS, KINDS, TILES, Colour
from sjdsl.render.look import KindLook, Look, make_look
from tests.render.colour_vision import VISIONS, distance, lab

SIZE = 28  # pixels, as in the pictures of the games
CLEAR = 15.0  # CIE76; what is just noticeable is about 2.3
PART = 0.04  # of the tile's pixels


def states_of(kind: KindLook) -> Iterator[tuple[dict[str, str], Drawing]]:
    """Yields what a cell looks like for all words of its fields; numbers are 0, nobody owns anything."""
    words = [range(len(f.words)) if f.holds == "word" else (0,) for f in kind.fields]
    states = np.array(list(product(*words)), int)
    values = {
        f.attribute: (column - (f.holds == "agent"))
        for f, column in zip(kind.fields, states.T, strict=True)
    }
    others = {
        f"{kind.name}_{name}": np.zeros(len(states), int)
        for rule in kind.rules
        for name in rule.reads
    }
    one_place = {"rows": np.zeros(len(states), int), "cols": np.zeros(len(states), int)}
    keys, number = cell_keys(KindLook(**{**vars(kind), **one_place}), others | values)
    for state, n in zip(states, number, strict=True):
        yield (
            {
                f.name: f.words[v]
                for f, v in zip(kind.fields, state, strict=True)
                if f.holds == "word"
            },
            draw_cell(kind, keys[n]),
        )


def unlike_words(look: Look) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Yields the tiles of two states of a cell that differ in the word of one field, with what they are."""
    for kind in look.kinds:
        for (first, one), (second, other) in combinations(states_of(kind), 2):
            if sum(first[name] != second[name] for name in first) == 1:
                yield (
                    f"{kind.name}: {first} and {second}",
                    draw_tile(one, SIZE),
                    draw_tile(other, SIZE),
                )


@pytest.mark.parametrize("name", main_games())
def test_words_of_one_field_are_told_apart(name: str) -> None:
    look = make_look(sjdsl.make(name).game)
    for what, first, second in unlike_words(look):
        for vision in VISIONS:
            seen = float((distance(first, second, vision) >= CLEAR).mean())
            assert seen >= PART, f"{what}: {seen:.3f} of the tile differs with {vision}"


@pytest.mark.parametrize("name", main_games())
def test_objects_stand_out_more_than_starting_places(name: str) -> None:
    """Of all kinds: whatever can be taken or stands there differs more from its ground than the mark where agents appear."""
    look = make_look(sjdsl.make(name).game)
    marks, things = [], []
    for kind in look.kinds:
        for _, drawing in states_of(kind):
            bare = draw_tile(Drawing(drawing.ground), SIZE)
            apart = distance(draw_tile(drawing, SIZE), bare, "normal").mean()
            if drawing.body is not None and drawing.body.sprite == "floor":
                marks.append(apart)
            elif drawing.objects or (
                drawing.body is not None and drawing.body.sprite not in ("water", "wall")
            ):
                things.append(apart)
    assert max(marks, default=0.0) < 0.5 * min(things, default=100.0)


def apart(first: Colour, second: Colour) -> float:
    """Returns the least distance of two colours to people with any kind of colour vision."""
    return min(float(distance(np.array(first), np.array(second), vision)) for vision in VISIONS)


@pytest.mark.parametrize(
    ("grounds", "least"), [(KINDS, 6.5), (dict(enumerate(TILES)), 5)], ids=["named", "spare"]
)
def test_grounds_are_told_apart_by_the_colour_blind(grounds: dict, least: float) -> None:
    alike = {
        frozenset(pair)
        for pair in (("water", "river"), ("channel", "sea"), ("floor", "tile"), ("wall", "brick"))
    }
    for first, second in combinations(grounds, 2):
        assert apart(grounds[first], grounds[second]) >= least or {first, second} in alike, (
            f"{first} and {second}"
        )
    assert apart(KINDS["grass"], KINDS["orchard"]) >= 10
    land = [
        colour
        for name, colour in grounds.items()
        if name not in ("water", "river", "channel", "sea", "wall")
    ]
    assert min(apart(KINDS["water"], colour) for colour in land) >= 12


def test_agents_have_colours_of_their_own() -> None:
    assert len(set(AGENTS)) == 64
    for vision in VISIONS:
        seen = lab(np.array(AGENTS), vision)
        apart = np.linalg.norm(seen[:, None] - seen[None], axis=-1) + 1000 * np.eye(64)
        assert apart.min() >= 8
        assert vision != "normal" or apart[:20, :20].min() >= 19
    assert lab(np.array(AGENTS))[:, 0].max() < 90, "none is as pale as the ground"


def test_the_simulation_is_the_published_one() -> None:
    """Greys stay grey (the rows sum to 1); red and green of equal lightness come close; white and black have the known values."""
    for matrix in VISIONS.values():
        assert np.allclose(matrix.sum(axis=1), 1, atol=1e-5)
    assert np.allclose(lab(np.array([255, 255, 255])), [100, 0, 0], atol=0.02)
    assert np.allclose(lab(np.array([255, 0, 0])), [53.24, 80.09, 67.20], atol=0.05), (
        "Lindbloom's calculator"
    )
    red, green = np.array([200, 90, 60]), np.array([110, 130, 60])
    assert distance(red, green, "deuteranopia") < 0.4 * distance(red, green, "normal")


def test_the_numbers_of_a_cell_have_bars_of_their_own() -> None:
    """Each at its own side, in its own colour, as long as its number is large."""
    ground = (238, 236, 231)
    bare = draw_tile(Drawing(ground), SIZE)
    tiles = [draw_tile(Drawing(ground, bars=((place, 6),)), SIZE) for place in range(4)]
    for vision in VISIONS:
        for first, second in combinations(BARS, 2):
            assert distance(np.array(first), np.array(second), vision) >= CLEAR
    for first, second in combinations(tiles, 2):
        both = (first != bare).any(axis=-1) & (second != bare).any(axis=-1)
        assert both.sum() < 0.03 * SIZE**2, "they hardly meet"
    areas = [
        (draw_tile(Drawing(ground, bars=((0, eighths),)), SIZE) != bare).any(axis=-1).sum()
        for eighths in range(1, 9)
    ]
    assert areas == sorted(set(areas))
