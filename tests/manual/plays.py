"""Plays an example of the manual in the reference interpreter, and beside it the compiled game on NumPy, which must come to the same."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from sjdsl.compiler import Build
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.observe import observe
from sjdsl.interpreter.state import Cell, Outcome, World, default_params
from sjdsl.interpreter.step import reset, step
from sjdsl.interpreter.threefry import Threefry
from sjdsl.library.parameters import build_params
from sjdsl.policies.interpreted import choose
from sjdsl.testing.differences import outcome_differences, state_differences
from sjdsl.testing.pictures import (
    draw_picture,
    put_picture,
    read_mover_cells,
    read_picture,
    read_poses,
)
from sjdsl.testing.signs import make_signs
from sjdsl.testing.states import compiled_state
from tests.fuzz.numpy_jax import as_array
from tests.fuzz.together import of_text

STEADY = (0, 2**32 - 1)  # with these random numbers no policy draws a move
Key = tuple[int, int]


class Play:
    """One run of a game. `params`: values by name, nested as the interpreter keeps them; `text`: the module that is run beside it."""

    world: World
    outcome: Outcome

    def __init__(self, built: Build, params: dict[str, Any], text: str = ""):
        self.game = built.game
        self.params = default_params(self.game) | params
        self.board, self.signs = board_of(self.game), make_signs(self.game, {}, "^>v<")
        self.env = of_text(self.game, text) if text else None
        if self.env is not None:
            self.env.params = _arrays(build_params(self.game, self.env.module, params))

    def reset(self, key: Key) -> None:
        self.world = reset(self.game, self.params, Threefry(*key))
        if self.env is not None:
            with np.errstate(all="ignore"):  # what a guard protects is computed and not used
                self.state = self.env.begin(key)
            self._compare()

    def arrange(self, picture: Sequence[str]) -> None:
        """Puts agents in reading order, movers and cells as a picture shows them."""
        rows = read_picture(picture, self.signs)
        poses = read_poses(rows, self.signs, self.board.agents, ())
        put_picture(rows, poses, {}, self.signs, self.board, self.world)
        self.world.position = [Cell(*poses[agent][:2]) for agent in range(self.board.agents)]
        self.world.heading = [poses[agent][2] for agent in range(self.board.agents)]
        for sort, cells in read_mover_cells(rows, self.signs, {}, {}).items():
            self.world.movers[sort].position = cells
        if self.env is not None:
            self.state = _arrays(compiled_state(self.env, self.state, self.world))

    def step(self, actions: Sequence[int], key: Key) -> None:
        self.world, self.outcome = step(self.game, self.world, actions, self.params, Threefry(*key))
        if self.env is not None:
            with np.errstate(all="ignore"):
                self.state, reward, _, told = self.env.advance(key, self.state, list(actions))
            self._compare(outcome_differences(self.env, reward, told, self.outcome))

    def drawn(self) -> list[str]:
        return [row.signs for row in draw_picture(self.signs, self.board, self.world)]

    def seen(self) -> np.ndarray:
        return observe(self.game, self.world)

    def chosen(self, name: str) -> list[str]:
        """Returns what each agent would do under a policy of the file, no move of it drawn."""
        policy = next(p for p in self.game.policies if p.name == name)
        return [
            self.game.agents.actions[choose(policy, self.game, self.world, agent, STEADY)]
            for agent in range(self.board.agents)
        ]

    def _compare(self, found: Sequence[str] = ()) -> None:
        assert self.env is not None
        with np.errstate(all="ignore"):
            seen, allowed = (
                self.env._observe(self.state),
                self.env.module.allowed_actions(self.state, self.env.params),
            )
        found = [*found, *state_differences(self.env, self.state, self.world, seen, allowed)]
        assert not found, found


def _arrays(values: Any) -> Any:
    """Returns a state or parameters with arrays that are indexed as JAX's are."""
    return values.replace(**{name: as_array(value) for name, value in vars(values).items()})
