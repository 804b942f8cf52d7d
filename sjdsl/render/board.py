"""Draws the board: tiles of cells, beams over them, agents and movers on top."""

import numpy as np

from sjdsl.render.drawings import cell_keys, draw_cell, draw_figures, draw_movers
from sjdsl.render.look import Look
from sjdsl.render.snapshot import Snapshot
from sjdsl.render.tiles import draw_tile, put_figure, tinted

TINT = 0.5
Tiles = dict[tuple[str, tuple[int, ...]], np.ndarray]


def draw_board(look: Look, snapshot: Snapshot, tiles: Tiles) -> np.ndarray:
    """Returns the board of one moment, `[H * tile, W * tile, 3]` uint8.

    Args:
      tiles: those drawn so far, by kind and state; new ones are added.
    """
    size = look.tile
    board = np.zeros((look.height, size, look.width, size, 3), np.uint8)
    for kind in look.kinds:
        keys, tile_of = cell_keys(kind, snapshot.values)
        for key in keys:
            if (kind.name, key) not in tiles:
                tiles[kind.name, key] = draw_tile(draw_cell(kind, key), size)
        board[kind.rows, :, kind.cols] = np.stack([tiles[kind.name, key] for key in keys])[tile_of]
    for label, colour in look.marks:
        rows, cols = np.nonzero(snapshot.marks[label])
        board[rows, :, cols] = tinted(board[rows, :, cols], colour, TINT)
    standing = [*zip(draw_figures(look, snapshot.values, snapshot.heading, snapshot.held), snapshot.row, snapshot.col, strict=True)]
    for herd in look.herds:
        standing += zip(draw_movers(herd, snapshot.values), *snapshot.movers[herd.name], strict=True)
    for figure, row, col in standing:
        if 0 <= row < look.height and 0 <= col < look.width:
            put_figure(board[row, :, col], figure)
    return board.reshape(look.height * size, look.width * size, 3)
