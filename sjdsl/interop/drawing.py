"""Pictures and texts of states for the `render` methods of other libraries."""

from typing import Any

import numpy as np

from sjdsl.interpreter.board import board_of
from sjdsl.render import make_painter, take_snapshot
from sjdsl.render.letters import board_rows, make_letters
from sjdsl.runtime.env import Environment

RENDER_MODES = ("human", "ansi", "rgb_array")


class Drawing:
    """Draws states of one environment; what that takes is made when it is first drawn."""

    def __init__(self, env: Environment, mode: str | None) -> None:
        """`mode`: one of `RENDER_MODES`, or None; another raises ValueError."""
        if mode not in (None, *RENDER_MODES):
            raise ValueError(f"render_mode is None, {', '.join(RENDER_MODES)}, not {mode!r}")
        self._env, self._mode = env, mode
        self._painter: Any = None
        self._letters: Any = None

    def draw(self, state: Any, returns: np.ndarray) -> np.ndarray | str | None:
        """Returns a picture `[height, width, 3]` uint8 or a text; in mode `human` shows it and returns None.

        Raises:
          RuntimeError: there is no state yet.
        """
        if self._mode is None:
            return None
        if state is None:
            raise RuntimeError("call reset before render")
        snapshot = take_snapshot(self._env, state, returns)
        if self._mode == "rgb_array":
            self._painter = self._painter or make_painter(self._env)
            return np.asarray(self._painter.draw(snapshot))
        self._letters = self._letters or make_letters(self._env.game)
        text = "".join(
            f"{row}\n" for row in board_rows(self._letters, board_of(self._env.game), snapshot)
        )
        if self._mode == "ansi":
            return text
        print(text, flush=True)
        return None
