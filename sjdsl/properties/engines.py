"""Episodes on the game's own map: on the compiled game, or, where there is little to play, on the interpreter; both play the same."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sjdsl.compiler import ir
from sjdsl.interpreter.board import board_of, declared_world
from sjdsl.interpreter.evaluate import evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.overflow import LeavesFloat32
from sjdsl.interpreter.state import World, default_params
from sjdsl.interpreter.step import step
from sjdsl.properties.instances import Ground
from sjdsl.properties.monitors import STATES
from sjdsl.properties.trajectory import Course, Played, params_of, play, words_of

NOTHING = ir.Check(sort="symmetric", words=("agents",))  # stands for a promise of which nothing is read in an episode
LITTLE = 60_000  # cells times steps that the interpreter plays sooner than the compiled game is compiled
Total = tuple[str, str | None]


@dataclass(frozen=True)
class Episode:
    """One episode: what each promise reads in the first state and after each step, the actions of each step, the final totals.

    left: the step in which a real left float32; None if none did. What promises read from then on is not there.
    """

    number: int
    values: list[list[tuple[Any, ...]]]
    actions: list[tuple[int, ...]]
    totals: dict[Total, int]
    left: int | None = None


class Stretch:
    """Plays episodes of a game under policies."""

    def __init__(self, ground: Ground, seed: int):
        self.ground, self.seed = ground, seed
        self.checks = [check if check.sort in (*STATES, "expect") else NOTHING for check in ground.own.checks]
        self._player: Any = None

    @property
    def length(self) -> int:
        """Steps of an episode."""
        game = self.ground.own
        world = declared_world(board_of(game), default_params(game))
        return int(evaluate(game.episode, Instance(board_of(game), world)))

    def play(self, policies: Sequence[ir.Policy], first: int, number: int) -> list[Episode]:
        """Returns episodes `first`, `first + 1`, …; raises NotSupported, TooLarge for what the compiled game cannot do."""
        game = self.ground.own
        if self.length * number * len(game.rows) * len(game.rows[0]) <= LITTLE:
            return [self._interpreted(policies, first + i) for i in range(number)]
        return self._compiled(policies, first, number)

    def course(self, policies: Sequence[ir.Policy], episode: int) -> Course:
        """Returns an episode as a course of the interpreter."""
        game, agents = self.ground.own, self.ground.own.agents.number
        own = tuple(policies[agent % len(policies)] for agent in range(agents))
        return Course(game.rows, agents, (), self.seed, (), (), own, episode)

    def world_before(self, episode: Episode, policies: Sequence[ir.Policy], step: int) -> World:
        """Returns the state before a step of an episode."""
        if self._player is None:
            return play(self.ground.own, self.course(policies, episode.number), step).worlds[step]
        import numpy as np

        from sjdsl.properties.state_conversion import world_of

        state = self._player.state_before(np.asarray(episode.actions), self.seed, episode.number, step)
        return world_of(self._player.env, state)

    def _interpreted(self, policies: Sequence[ir.Policy], number: int) -> Episode:
        played = play(self.ground.own, self.course(policies, number), self.length, self.checks)
        left = None if played.left is None else len(played.outcomes)
        return Episode(number, [played.values(check) for check in self.checks], played.actions, dict((played.totals or [{}])[-1]), left)

    def overflow(self, episode: Episode, policies: Sequence[ir.Policy]) -> Played:
        """Returns the end of an episode in which a real leaves float32: the state before, and the step."""
        assert episode.left is not None
        course, game = self.course(policies, episode.number), self.ground.own
        if self._player is None:
            return play(game, course, self.length, self.checks)
        played = Played(game, params_of(game, ()), [self.world_before(episode, policies, episode.left)], [dict(episode.totals)])
        played.actions.append(episode.actions[episode.left])
        try:
            _, outcome = step(game, played.worlds[-1], played.actions[-1], played.params, words_of(course, episode.left))
            played.outcomes.append(outcome)
        except LeavesFloat32 as left:
            played.left = left
        played.left = played.left or LeavesFloat32(next((c for c in game.checks if c.origin is not None), game), episode.left)
        return played

    def _compiled(self, policies: Sequence[ir.Policy], first: int, number: int) -> list[Episode]:
        if self._player is None:
            from sjdsl.properties.episodes import Player

            self._player = Player(self.ground.environment, self.checks)
        played = self._player.play(self._player.script(policies), self.seed, first, number)
        found = []
        for i in range(number):
            left = int(played.left[i]) if played.left[i] < played.length[i] else None
            steps, values, at = int(played.length[i]) if left is None else left, [], 0
            for check in self.checks:
                columns = played.values[i, : steps + 1, at : at + len(check.values)]
                values.append([tuple(_value(x, e) for x, e in zip(row, check.values, strict=True)) for row in columns.tolist()])
                at += len(check.values)
            totals = {total: int(counts[i]) for total, counts in played.totals.items()}
            actions = [tuple(a) for a in played.actions[i, : steps + (left is not None)].tolist()]
            found.append(Episode(first + i, values, actions, totals, left))
        return found


def _value(stored: float, e: ir.Expr) -> Any:
    return bool(stored) if e.type.kind == "condition" else stored
