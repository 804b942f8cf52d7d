"""What means something else looks different, also to the colour-blind: measured on the tiles as they are drawn."""

from collections.abc import Iterator
from itertools import combinations, product

import numpy as np
import pytest

import sjdsl
from sjdsl.library.games_folder import main_games
from sjdsl.render.appearance import Drawing, cell_keys, draw_cell
from sjdsl.render.board import draw_tile
from sjdsl.render.colours import KINDS, TILES, Colour
from sjdsl.render.look import KindLook, Look, make_look
from tests.render.colour_vision import VISIONS, distance

SIZE = 28  # pixels, as in the pictures of the games
CLEAR = 15.0  # CIE76; what is just noticeable is about 2.3
PART = 0.04  # of the tile's pixels
UNSEEN = {("water", "clean"): "hue"}  # kind, a word of a cell: a field that agents don't see then


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
            unlike = [name for name in first if first[name] != second[name]]
            unseen = {UNSEEN.get((kind.name, word)) for word in first.values()}
            if len(unlike) == 1 and unlike[0] not in unseen:
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
