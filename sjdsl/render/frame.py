"""Draws one frame of a film: the board with its legend below."""

from dataclasses import dataclass, field

from sjdsl.extras import needs
from sjdsl.render.board import Tiles, draw_board
from sjdsl.render.colours import OUTSIDE
from sjdsl.render.legend import MIN_WIDTH, draw_legend, draw_status
from sjdsl.render.look import Look, make_look
from sjdsl.render.snapshot import Snapshot
from sjdsl.runtime.env import Environment

with needs("pictures"):
    from PIL import Image


@dataclass(frozen=True)
class Painter:
    """Draws the frames of one game: tiles and legend are drawn once."""

    look: Look
    width: int
    legend: Image.Image
    tiles: Tiles = field(default_factory=dict)

    def draw(self, snapshot: Snapshot) -> Image.Image:
        """Returns the picture of one moment; all pictures of a game have the same size."""
        board = Image.fromarray(draw_board(self.look, snapshot, self.tiles))
        status = draw_status(self.look, snapshot, self.width)
        picture = Image.new("RGB", (self.width, board.height + status.height + self.legend.height), OUTSIDE)
        picture.paste(board, ((self.width - board.width) // 2, 0))
        picture.paste(status, (0, board.height))
        picture.paste(self.legend, (0, board.height + status.height))
        return picture


def make_painter(env: Environment) -> Painter:
    """Returns what draws the states of an environment."""
    look = make_look(env.game)
    width = max(look.width * look.tile, MIN_WIDTH)
    return Painter(look, width, draw_legend(look, width))
