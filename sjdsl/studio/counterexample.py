"""The counterexample to a check on the board: what leads to it as JSON has it, and the episode that comes of it."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from sjdsl.compiler import Build, ir
from sjdsl.compiler.ir.sorts import Level
from sjdsl.properties import GameFamily
from sjdsl.properties.trajectory import Scenario, draws_of, play
from sjdsl.studio.episode import LONGEST, Episode, TooLong
from sjdsl.studio.opened import Opened
from sjdsl.studio.requests import Replay
from sjdsl.trace.episode import Moment


class NoReplay(Exception):
    """The rules as they are now do not take a counterexample; the text says why."""


def as_json(scenario: Scenario, game: ir.Game) -> dict[str, Any]:
    """Returns a scenario of a game whose actions are written out, as `Replay` reads it."""
    names = ("params", "seed", "episode", "bias", "actions")
    return {"rows": list(game.rows)} | {name: _plain(getattr(scenario, name)) for name in names}


def replayed(opened: Opened, request: Replay) -> tuple[Opened, Episode]:
    """Returns the game as its file describes it, and the episode that leads to a counterexample, at its start.

    Raises NoReplay, TooLong, and LeavesFloat32 if a real leaves float32 at the very start.
    """
    if len(request.actions) >= LONGEST:
        raise TooLong(
            f"the studio keeps {LONGEST} moments of an episode, and this counterexample has more"
        )
    game = GameFamily(opened.source, opened.composition.chosen).own
    params = tuple((name, _held(value)) for name, value in request.params)
    types = {param.name: param.type for param in game.params}
    if request.rows != game.rows or not all(
        name in types and _fits(value, types[name].by) for name, value in params
    ):
        raise NoReplay(
            "the rules have changed since: they do not take the map or the numbers of this counterexample; test the checks again"
        )
    count = len(game.agents.actions)
    if request.bias and len(request.bias) < len(request.actions):
        raise NoReplay("the counterexample is not whole: test the checks again")
    if any(
        len(step) != game.agents.number or not all(0 <= action < count for action in step)
        for step in request.actions
    ):
        raise NoReplay(
            "the rules have changed since: they do not take the actions of this counterexample; test the checks again"
        )
    scenario = Scenario(request.seed, request.episode, params, request.bias, request.actions)
    trajectory = play(game, scenario)
    if not trajectory.worlds:
        assert trajectory.left is not None
        raise trajectory.left
    start = draws_of(scenario, -1)
    moments = [
        Moment(None, (getattr(start, "k0", 0), getattr(start, "k1", 0)), trajectory.worlds[0], ())
    ]
    returns = [[0.0] * game.agents.number]
    for before, after, actions, outcome in zip(
        trajectory.worlds,
        trajectory.worlds[1:],
        trajectory.actions,
        trajectory.outcomes,
        strict=False,
    ):
        moments.append(Moment(before.step, (0, 0), after, (), actions, frozenset(), outcome))
        returns.append(
            [
                so_far + float(reward)
                for so_far, reward in zip(returns[-1], outcome.reward, strict=True)
            ]
        )
    on_board = replace(
        opened,
        build=Build(game, opened.build.warnings, opened.build.sources),
        values=dict(trajectory.params),
    )
    return on_board, Episode(game, 0, moments, returns, scenario=scenario, written=len(moments) - 1)


def _plain(value: Any) -> Any:
    if isinstance(value, tuple | list):
        return [_plain(entry) for entry in value]
    return float(value) if isinstance(value, np.floating) else value


def _fits(value: Any, by: Sequence[Level]) -> bool:
    """Returns whether a value has an entry for each of the levels of a table."""
    return not by or (
        isinstance(value, tuple)
        and len(value) == len(by[0])
        and all(_fits(entry, by[1:]) for entry in value)
    )


def _held(value: Any) -> Any:
    """Returns a value with its tables as tuples, as the interpreter has them."""
    return tuple(_held(entry) for entry in value) if isinstance(value, list) else value
