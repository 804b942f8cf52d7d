"""The counterexample to a check: its scenario as JSON, and the episode that the board shows."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from sjdsl.compiler import Build, ir
from sjdsl.compiler.ir.entity_types import IndexSet
from sjdsl.properties import GameFamily
from sjdsl.properties.trajectory import Scenario, draws_of_start, play
from sjdsl.studio.episode import LONGEST, Episode, TooLong, with_reward
from sjdsl.studio.opened import Opened
from sjdsl.studio.requests import Replay
from sjdsl.trace.episode import Moment


class NoReplay(Exception):
    """A counterexample doesn't fit the rules as they are now; the message says why."""


def as_json(scenario: Scenario, game: ir.Game) -> dict[str, Any]:
    """Returns a scenario with all its actions, as `Replay` reads it."""
    return {
        "rows": list(game.rows),
        "params": plain(scenario.params),
        "seed": scenario.seed,
        "episode": scenario.episode,
        "bias": plain(scenario.bias),
        "actions": plain(scenario.actions),
    }


def replay(opened: Opened, request: Replay) -> tuple[Opened, Episode]:
    """Returns the game on the counterexample's map, and the episode that leads to it.

    Raises:
      NoReplay: the rules have changed.
      TooLong: the studio doesn't keep as many moments.
      LeavesFloat32: a real leaves float32 at the very start.
    """
    if len(request.actions) >= LONGEST:
        raise TooLong(
            f"the studio keeps {LONGEST} moments of an episode, and this counterexample has more"
        )
    game = GameFamily(opened.source, opened.composition.chosen).own
    params = tuple((name, _as_tuples(value)) for name, value in request.params)
    _check_fits(request, params, game)
    scenario = Scenario(request.seed, request.episode, params, request.bias, request.actions)
    trajectory = play(game, scenario)
    if not trajectory.worlds:
        assert trajectory.overflow is not None
        raise trajectory.overflow
    draws = draws_of_start(scenario)
    key = (getattr(draws, "k0", 0), getattr(draws, "k1", 0))
    moments = [Moment(None, key, trajectory.worlds[0], ())]
    returns = [[0.0] * game.agents.number]
    # The last actions may have no outcome: a real left float32.
    steps = zip(pairwise(trajectory.worlds), trajectory.actions, trajectory.outcomes, strict=False)
    for (before, after), actions, outcome in steps:
        moments.append(Moment(before.step, (0, 0), after, (), actions, frozenset(), outcome))
        returns.append(with_reward(returns[-1], outcome))
    build = Build(game, opened.build.warnings, opened.build.sources)
    on_board = replace(opened, build=build, values=dict(trajectory.params))
    return on_board, Episode(game, 0, moments, returns, scenario=scenario, written=len(moments) - 1)


def _check_fits(request: Replay, params: Sequence[tuple[str, Any]], game: ir.Game) -> None:
    """Raises NoReplay if a counterexample doesn't fit a game."""
    types = {param.name: param.type for param in game.params}
    are_params = all(
        name in types and _fits(value, types[name].indexed_by) for name, value in params
    )
    if request.rows != game.rows or not are_params:
        raise NoReplay(
            "the rules have changed since: they do not take the map or the numbers of this "
            "counterexample; test the checks again"
        )
    if request.bias and len(request.bias) < len(request.actions):
        raise NoReplay("the counterexample is not whole: test the checks again")
    num_actions = len(game.agents.actions)
    for actions in request.actions:
        are_actions = all(0 <= action < num_actions for action in actions)
        if len(actions) != game.agents.number or not are_actions:
            raise NoReplay(
                "the rules have changed since: they do not take the actions of this "
                "counterexample; test the checks again"
            )


def plain(value: Any) -> Any:
    """Returns a value with lists in place of tuples, and Python's floats."""
    if isinstance(value, tuple | list):
        return [plain(entry) for entry in value]
    return float(value) if isinstance(value, np.floating) else value


def _fits(value: Any, by: Sequence[IndexSet]) -> bool:
    """Returns whether a value has an entry for each key of the indices of a param."""
    if not by:
        return True
    if not isinstance(value, tuple) or len(value) != len(by[0]):
        return False
    return all(_fits(entry, by[1:]) for entry in value)


def _as_tuples(value: Any) -> Any:
    """Returns a value with tuples in place of lists, as the interpreter has it."""
    if not isinstance(value, list):
        return value
    return tuple(_as_tuples(entry) for entry in value)
