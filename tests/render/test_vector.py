"""Cells, agents and movers as SVG and as pixels: what is drawn where, in any size."""

from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from sjdsl.compiler import build
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import find_game
from sjdsl.render.appearance import Drawing, Figure
from sjdsl.render.board import draw_figure, draw_tile
from sjdsl.render.colours import BARS
from sjdsl.render.legend import cell_entries, legend_entries
from sjdsl.render.look import make_look
from sjdsl.render.usual import Picture
from sjdsl.render.vector import SIZE, vector_figure, vector_tile

RED, BLUE = (213, 94, 0), (0, 114, 178)
FIGURES = [
    *(Figure(None, RED, heading=heading) for heading in range(4)),
    Figure(None, BLUE, "animal", 3),
    Figure(None, RED, held=True),
    *(
        Figure(
            None,
            BLUE,
            heading=heading,
            badges=tuple(Picture(sprite, RED) for sprite in ("gem", "disc", "ore")),
        )
        for heading in range(4)
    ),
]


def apart(one: np.ndarray, other: np.ndarray) -> float:
    """Returns how much two pictures with opacity differ on white, on average, of 255."""
    on_white = [
        p[..., :3] * (p[..., 3:] / 255) + 255 - p[..., 3:]
        for p in (one.astype(int), other.astype(int))
    ]
    return float(np.abs(on_white[0] - on_white[1]).mean())


@pytest.mark.parametrize("name", ["clean_up", "mushrooms", "coop_mining", "territory"])
def test_tiles_look_alike_in_all_sizes(name: str) -> None:
    drawings = {
        drawing for drawing, _ in cell_entries(make_look(build(read_source(find_game(name))).game))
    }
    assert len(drawings) > 3
    small = {drawing: draw_tile(drawing, 24).astype(int) for drawing in drawings}
    for drawing in drawings:
        shrunk = np.asarray(
            Image.fromarray(draw_tile(drawing, 96)).resize((24, 24), Image.Resampling.BOX)
        )
        assert min(drawings, key=lambda other: np.abs(small[other] - shrunk).mean()) == drawing
        assert np.abs(small[drawing] - shrunk).mean() < 15


def test_edges_bars_and_objects_are_in_their_places() -> None:
    ground = (200, 220, 200)
    tile = draw_tile(Drawing(ground, bars=((0, 4), (1, 8), (2, 2), (3, 6))), SIZE)
    foot, head, left, right = tile[-1, 15], tile[0, SIZE // 2], tile[-10, 0], tile[SIZE // 2, -1]
    assert [tuple(pixel) for pixel in (foot, head, left, right)] == [*BARS]
    assert tuple(tile[-3, SIZE // 2 + 4]) == tuple(tile[SIZE // 2, 2]) == ground, (
        "they are as long as they count"
    )
    three = draw_tile(Drawing(ground, edge=RED, objects=(Picture("disc", BLUE),) * 3), SIZE)
    quarters = [tuple(three[row, col]) for row in (12, 36) for col in (12, 36)]
    assert quarters == [BLUE, BLUE, BLUE, ground]
    assert all(
        tuple(pixel) == RED for pixel in (three[0, 20], three[-1, 20], three[20, 0], three[20, -1])
    )


@pytest.mark.parametrize("figure", FIGURES)
def test_figures_turn_pale_and_carry(figure: Figure) -> None:
    drawn = draw_figure(figure, SIZE)
    upright = draw_figure(replace(figure, heading=0), SIZE)
    if not figure.badges:
        assert apart(np.rot90(upright, -figure.heading), drawn) < 0.5
    if figure.held:
        assert (
            drawn[..., :3][drawn[..., 3] == 255].mean()
            > 40 + draw_figure(replace(figure, held=False), SIZE)[..., :3].mean()
        )
    plain = draw_figure(replace(figure, badges=()), SIZE)
    corners = [slice(SIZE // 2, None), slice(0, SIZE // 2)]
    behind = np.rot90(drawn, figure.heading), np.rot90(plain, figure.heading)  # as if it looked up
    changed = [
        apart(behind[0][rows, cols], behind[1][rows, cols]) > 5
        for rows in corners
        for cols in corners
    ]
    assert changed == [place < min(2, len(figure.badges)) for place in range(4)], (
        "two behind it at most, none over its eyes"
    )
    assert min(apart(draw_figure(other, SIZE), drawn) for other in FIGURES if other != figure) > 2.5


def test_an_agent_has_its_number() -> None:
    texts = [
        node.text
        for node in ElementTree.fromstring(vector_figure(Figure(12, RED))).iter(
            "{http://www.w3.org/2000/svg}text"
        )
    ]
    assert texts == ["12"]
    assert "<text" not in vector_figure(Figure(None, RED))


def test_all_legends_are_well_formed() -> None:
    look = make_look(build(read_source(find_game("gift_refinement"))).game)
    pictures = [
        vector_tile(seen) if isinstance(seen, Drawing) else vector_figure(seen, RED)
        for seen, _ in legend_entries(look)
    ]
    assert all(ElementTree.fromstring(svg).get("width") == str(SIZE) for svg in pictures)
