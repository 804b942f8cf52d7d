"""Pictures and texts of states for the `render` methods of other libraries."""

from functools import cached_property
from typing import Any

import numpy as np

from sjdsl.interpreter.board import board_of
from sjdsl.render import Painter, make_painter, take_snapshot
from sjdsl.render.letters import Letters, board_rows, make_letters
from sjdsl.runtime.env import Environment

RENDER_MODES = ("human", "ansi", "rgb_array")


class Drawing:
    """Draws states of one environment.

    The painter or the letters are created at the first drawing.
    """

    def __init__(self, env: Environment, mode: str | None) -> None:
        """Raises ValueError for a mode that is neither None nor one of `RENDER_MODES`."""
        if mode not in (None, *RENDER_MODES):
            raise ValueError(f"render_mode is None, {', '.join(RENDER_MODES)}, not {mode!r}")
        self._env = env
        self._mode = mode

    @cached_property
    def _painter(self) -> Painter:
        return make_painter(self._env)

    @cached_property
    def _letters(self) -> Letters:
        return make_letters(self._env.game)

    def draw(self, state: Any, returns: np.ndarray) -> np.ndarray | str | None:
        """Returns a picture `[height, width, 3]` uint8 or a text.

        Prints the text and returns None in mode `human`.

        Raises:
          RuntimeError: there is no state yet.
        """
        if self._mode is None:
            return None
        if state is None:
            raise RuntimeError("call reset before render")
        snapshot = take_snapshot(self._env, state, returns)
        if self._mode == "rgb_array":
            return np.asarray(self._painter.draw(snapshot))
        lines = board_rows(self._letters, board_of(self._env.game), snapshot)
        text = "".join(f"{line}\n" for line in lines)
        if self._mode == "ansi":
            return text
        print(text, flush=True)
        return None
