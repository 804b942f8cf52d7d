"""Pictures for browsers: SVG that looks as the pixels of films do."""

from io import BytesIO
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image
from resvg_py import svg_to_bytes

from sjdsl.compiler import build
from sjdsl.compiler.syntax.read import read_source
from sjdsl.games_folder import find_game
from sjdsl.render.agents import draw_figure
from sjdsl.render.drawings import Drawing, Figure
from sjdsl.render.entries import cell_entries, figure_entries
from sjdsl.render.look import make_look
from sjdsl.render.tiles import draw_tile
from sjdsl.render.usual import Picture
from sjdsl.render.vector import SIZE, vector_figure, vector_tile

RED, BLUE = (213, 94, 0), (0, 114, 178)
FIGURES = [
    *(Figure(None, RED, heading=heading) for heading in range(4)),
    Figure(None, BLUE, "animal", 3),
    Figure(None, RED, held=True),
    Figure(None, BLUE, badges=tuple(Picture(sprite, RED) for sprite in ("gem", "disc", "ore", "apple"))),
]


def pixels(svg: str) -> np.ndarray:
    """Returns SVG as pixels, `[SIZE, SIZE, 4]`, drawn by resvg."""
    return np.asarray(Image.open(BytesIO(bytes(svg_to_bytes(svg_string=svg, skip_system_fonts=True)))).convert("RGBA")).astype(int)


def apart(one: np.ndarray, other: np.ndarray) -> float:
    """Returns how much two pictures with opacity differ on white, on average, of 255."""
    on_white = [p[..., :3] * (p[..., 3:] / 255) + 255 - p[..., 3:] for p in (one, other)]
    return float(np.abs(on_white[0] - on_white[1]).mean())


@pytest.mark.parametrize("name", ["clean_up", "mushrooms", "coop_mining", "territory"])
def test_tiles_look_as_their_pixels_do(name: str) -> None:
    drawings = {drawing for drawing, _ in cell_entries(make_look(build(read_source(find_game(name))).game))}
    assert len(drawings) > 3
    for drawing in drawings:
        tile = draw_tile(drawing, SIZE)
        assert apart(pixels(vector_tile(drawing)), np.dstack([tile, np.full((SIZE, SIZE), 255)])) < 2, drawing


def test_edges_bars_and_many_objects_are_where_pixels_have_them() -> None:
    full = Drawing((200, 220, 200), edge=RED, bars=((0, 3), (1, 8), (2, 5), (3, 1)), objects=(Picture("gem", BLUE),) * 3)
    assert apart(pixels(vector_tile(full)), np.dstack([draw_tile(full, SIZE), np.full((SIZE, SIZE), 255)])) < 2
    bare = Drawing((200, 220, 200))
    assert apart(pixels(vector_tile(full)), pixels(vector_tile(bare))) > 20, "the measure tells them apart"


@pytest.mark.parametrize("figure", FIGURES)
def test_figures_look_as_their_pixels_do(figure: Figure) -> None:
    drawn = pixels(vector_figure(figure))
    assert apart(drawn, draw_figure(figure, SIZE).astype(int)) < 2.5
    others = [other for other in FIGURES if other != figure]
    assert min(apart(pixels(vector_figure(other)), drawn) for other in others) > 2.5


def test_an_agent_has_its_number() -> None:
    texts = [node.text for node in ElementTree.fromstring(vector_figure(Figure(12, RED))).iter("{http://www.w3.org/2000/svg}text")]
    assert texts == ["12"]
    assert "<text" not in vector_figure(Figure(None, RED))


def test_all_legends_are_well_formed() -> None:
    look = make_look(build(read_source(find_game("gift_refinement"))).game)
    pictures = [vector_tile(drawing) for drawing, _ in cell_entries(look)] + [
        vector_figure(figure, RED) for figure, _ in figure_entries(look)
    ]
    assert all(ElementTree.fromstring(svg).get("width") == str(SIZE) for svg in pictures)
