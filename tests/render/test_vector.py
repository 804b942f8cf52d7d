"""Cells, agents and movers as SVG and as pixels: what is drawn where, in any size."""

import numpy as np
import pytest
from PIL import Image

from sjdsl.compiler import build
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import find_game
from sjdsl.render.appearance import Drawing
from sjdsl.render.board import draw_tile
from sjdsl.render.colours import BARS
from sjdsl.render.legend import legend_entries
from sjdsl.render.look import make_look
from sjdsl.render.usual import Picture
from sjdsl.render.vector import SIZE

RED, BLUE = (213, 94, 0), (0, 114, 178)


@pytest.mark.parametrize("name", ["clean_up", "mushrooms", "coop_mining", "territory"])
def test_tiles_look_alike_in_all_sizes(name: str) -> None:
    entries = legend_entries(make_look(build(read_source(find_game(name))).game))
    drawings = {drawing for drawing, _ in entries if isinstance(drawing, Drawing)}
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
