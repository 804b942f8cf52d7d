"""An episode of the compiled game, converted to the interpreter's states for the screen."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from sjdsl.compiler.ir.queries import marking_phases
from sjdsl.interpreter.state import Value, World
from sjdsl.properties.state_conversion import world_of
from sjdsl.render.moment import Moment
from sjdsl.replay.episode_player import EpisodePlayer
from sjdsl.runtime.env import Environment
from sjdsl.screen.display import Display, make_display


class Compiled:
    """The episode of a seed.

    Attributes:
      display: of the moment; seen: what the agents see, `[N, ...]`, and the state.
    """

    def __init__(self, env: Environment, params: Mapping[str, Value], seed: int) -> None:
        """Begins the episode, with a step compiled. `params`: as the interpreter has them."""
        self._env, self._params, self._player = env, params, EpisodePlayer(env, seed)
        EpisodePlayer(env, seed).step([0] * env.num_agents)  # JAX compiles it now, not at the first key
        self.display = make_display(env.game, self._world(), self._player.returns.tolist())

    @property
    def seen(self) -> tuple[Any, Any]:
        return self._player.observation, self._player.state

    def step(self, actions: Sequence[int]) -> Display:
        """Takes one step. `actions`: a number of the game for each agent."""
        moment = self._player.step(actions)
        self.display = make_display(
            self._env.game, self._world(), self._player.returns.tolist(), actions, moment.reward.tolist(), _totals(moment), moment.done
        )
        return self.display

    def _world(self) -> World:
        return replace(marked_world(self._env, self._player.state), params=dict(self._params))


def marked_world(env: Environment, state: Any) -> World:
    """Returns a compiled state, with the marks of its step, as a world of the interpreter with the numbers of the file."""
    return replace(world_of(env, state), marks=_marks(env, state))


def _totals(moment: Moment) -> dict[str, int]:
    return {name: int(count.sum()) for name, count in moment.events.items()}


def _marks(env: Environment, state: Any) -> list[tuple[str, int, int]]:
    """Returns the cells of the map that phases have marked in this step, with the names of the phases."""
    (_, cols), pad, found = env.module.FRAME, env.module.PAD, []
    height, width = len(env.game.rows), len(env.game.rows[0])
    for phase in marking_phases(env.game):
        cells = np.unique(np.asarray(getattr(state, f"mark_{phase.name}")))
        places = ((int(cell) // cols - pad, int(cell) % cols - pad) for cell in cells if cell)
        found += [(phase.name, row, col) for row, col in places if 0 <= row < height and 0 <= col < width]
    return found
