"""The board: tiles by cell, beams over them, agents on top."""

import numpy as np

from sjdsl.render.agents import draw_agent, paste
from sjdsl.render.colours import Colour
from sjdsl.render.look import KindLook, Look
from sjdsl.render.snapshot import Snapshot
from sjdsl.render.tiles import draw_tile, shown_values

TINT = 0.5
Tiles = dict[tuple[str, tuple[int, ...]], np.ndarray]


def draw_board(look: Look, snapshot: Snapshot, tiles: Tiles) -> np.ndarray:
    """Returns the board of one moment, `[H * tile, W * tile, 3]` uint8.

    Args:
      tiles: those drawn so far, by kind and values; new ones are added.
    """
    size = look.tile
    board = np.zeros((look.height, size, look.width, size, 3), np.uint8)
    for kind in look.kinds:
        numbers, tile_of = kind_tiles(kind, snapshot.values)
        pictures = np.stack([_tile(kind, values, size, tiles) for values in numbers])
        board[kind.rows, :, kind.cols] = pictures[tile_of]
    for _, attribute, colour in look.marks:
        _tint(board, snapshot.marked(attribute, look), colour)
    colours = look.agent_colours(snapshot.values)
    for number in range(look.num_agents):
        row, col = int(snapshot.row[number]), int(snapshot.col[number])
        if 0 <= row < look.height and 0 <= col < look.width:
            heading, held = int(snapshot.heading[number]), bool(snapshot.held[number])
            paste(board, draw_agent(number, colours[number], heading, size, held), row, col)
    return board.reshape(look.height * size, look.width * size, 3)


def kind_tiles(kind: KindLook, values: dict[str, np.ndarray]) -> tuple[list[tuple[int, ...]], np.ndarray]:
    """Returns the combinations of field values that cells of a kind have, and the number of each cell's, `[S]`."""
    if not kind.fields:
        return [()], np.zeros(len(kind.rows), int)
    shown = np.stack([shown_values(field, values[field.attribute]) for field in kind.fields], axis=1)
    found, number = np.unique(shown, axis=0, return_inverse=True)
    return [tuple(map(int, row)) for row in found], number.reshape(-1)


def _tile(kind: KindLook, values: tuple[int, ...], size: int, tiles: Tiles) -> np.ndarray:
    key = (kind.name, values)
    if key not in tiles:
        tiles[key] = draw_tile(kind, values, size)
    return tiles[key]


def _tint(board: np.ndarray, mask: np.ndarray, colour: Colour) -> None:
    """Colours the marked cells so that what is under the beam can still be seen."""
    row, col = np.nonzero(mask)
    under = board[row, :, col].astype(np.float32)
    board[row, :, col] = np.round(under + (np.array(colour) - under) * TINT).astype(np.uint8)
