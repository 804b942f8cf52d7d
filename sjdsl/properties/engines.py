"""Plays episodes on the game's own map, compiled or, where there is little to play, on the interpreter; both play the same."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from sjdsl.compiler import ir
from sjdsl.interpreter.board import board_of, declared_world
from sjdsl.interpreter.evaluate import evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.overflow import LeavesFloat32
from sjdsl.interpreter.state import World, default_params
from sjdsl.interpreter.step import step
from sjdsl.properties.instances import GameFamily
from sjdsl.properties.monitors import STATES
from sjdsl.properties.statements import CountedGame, StatementId, count_statements, leaf_statements, statements_needed_by, statements_run
from sjdsl.properties.trajectory import Scenario, Trajectory, draws_of, params_of, play

NOTHING = ir.Check(sort="symmetric", words=("agents",))  # stands for a check that reads nothing in an episode
LITTLE = 60_000  # up to so many cells times steps, interpreting takes less time than compiling
Total = tuple[str, str | None]


@dataclass(frozen=True)
class Episode:
    """One episode: the values each check reads in the first state and after each step, the actions, the final totals of events.

    ran: which of the statements that an `expect` depends on ran in it. left: the step in which a real left float32; None if none did.
    `values` ends before it.
    """

    number: int
    values: list[list[tuple[Any, ...]]]
    actions: list[tuple[int, ...]]
    totals: dict[Total, int]
    ran: frozenset[StatementId]
    left: int | None = None


class EpisodeRunner:
    """Plays episodes of a game under scripted policies."""

    def __init__(self, family: GameFamily, seed: int):
        self.family, self.seed = family, seed
        self.checks = [check if check.sort in (*STATES, "expect") else NOTHING for check in family.own.checks]
        self._player: Any = None

    @cached_property
    def counted(self) -> CountedGame:
        """The game with counts of the statements that an `expect` depends on."""
        expects = [check for check in self.family.own.checks if check.sort == "expect"]
        return count_statements(self.family.own, {statement for check in expects for statement in self._needed_by(check)})

    def counted_for(self, number: int) -> frozenset[StatementId]:
        """Returns the statements that a check depends on, of those that are counted."""
        return self._needed_by(self.family.own.checks[number]) & frozenset(self.counted.events.values())

    def _needed_by(self, check: ir.Check) -> frozenset[StatementId]:
        return statements_needed_by(check, self.family.own, leaf_statements(self.family.own))

    @property
    def length(self) -> int:
        """Steps of an episode."""
        game = self.family.own
        world = declared_world(board_of(game), default_params(game))
        return int(evaluate(game.episode, Instance(board_of(game), world)))

    def play(self, policies: Sequence[ir.Policy], first: int, number: int) -> list[Episode]:
        """Returns episodes `first`, `first + 1`, …; raises NotSupported, TooLarge for what the compiled game cannot do."""
        game = self.family.own
        if self.length * number * len(game.rows) * len(game.rows[0]) <= LITTLE:
            return [self._interpreted(policies, first + i) for i in range(number)]
        return self._compiled(policies, first, number)

    def scenario(self, policies: Sequence[ir.Policy], episode: int) -> Scenario:
        """Returns an episode as a scenario for the interpreter."""
        game, agents = self.family.own, self.family.own.agents.number
        own = tuple(policies[agent % len(policies)] for agent in range(agents))
        return Scenario(game.rows, agents, (), self.seed, (), (), own, episode)

    def written_out(self, policies: Sequence[ir.Policy], episode: Episode, steps: int) -> Scenario:
        """Returns the first steps of an episode as a scenario in which every action is written out."""
        scenario = self.scenario(policies, episode.number)
        return replace(scenario, actions=tuple(episode.actions[:steps]), policies=(None,) * scenario.agents)

    def world_before(self, episode: Episode, policies: Sequence[ir.Policy], step: int) -> World:
        """Returns the state before a step of an episode."""
        if self._player is None:
            return play(self.family.own, self.scenario(policies, episode.number), step).worlds[step]
        import numpy as np

        from sjdsl.properties.state_conversion import world_of

        state = self._player.state_before(np.asarray(episode.actions), self.seed, episode.number, step)
        return world_of(self._player.env, state)

    def _interpreted(self, policies: Sequence[ir.Policy], number: int) -> Episode:
        trajectory = play(self.family.own, self.scenario(policies, number), self.length, self.checks)
        left = None if trajectory.left is None else len(trajectory.outcomes)
        values, totals = [trajectory.values(check) for check in self.checks], dict((trajectory.totals or [{}])[-1])
        ran = frozenset(statement for features in trajectory.features for statement in statements_run(features))
        return Episode(number, values, trajectory.actions, totals, ran & frozenset(self.counted.events.values()), left)

    def overflow(self, episode: Episode, policies: Sequence[ir.Policy]) -> Trajectory:
        """Returns the end of an episode in which a real leaves float32: the state before, and the step."""
        assert episode.left is not None
        scenario, game = self.scenario(policies, episode.number), self.family.own
        if self._player is None:
            return play(game, scenario, self.length, self.checks)
        trajectory = Trajectory(game, params_of(game, ()), [self.world_before(episode, policies, episode.left)], [dict(episode.totals)])
        trajectory.actions.append(episode.actions[episode.left])
        try:
            _, outcome = step(game, trajectory.worlds[-1], trajectory.actions[-1], trajectory.params, draws_of(scenario, episode.left))
            trajectory.outcomes.append(outcome)
        except LeavesFloat32 as left:
            trajectory.left = left
        trajectory.left = trajectory.left or LeavesFloat32(next((c for c in game.checks if c.origin is not None), game), episode.left)
        return trajectory

    def _compiled(self, policies: Sequence[ir.Policy], first: int, number: int) -> list[Episode]:
        if self._player is None:
            from sjdsl.properties.episodes import Player

            self._player = Player(self.family.compiled(self.counted.game), self.checks)
        trajectory = self._player.play(self._player.script(policies), self.seed, first, number)
        found = []
        for i in range(number):
            left = int(trajectory.left[i]) if trajectory.left[i] < trajectory.length[i] else None
            steps, values, at = int(trajectory.length[i]) if left is None else left, [], 0
            for check in self.checks:
                columns = trajectory.values[i, : steps + 1, at : at + len(check.values)]
                values.append([tuple(_value(x, e) for x, e in zip(row, check.values, strict=True)) for row in columns.tolist()])
                at += len(check.values)
            counts = {total: int(counted[i]) for total, counted in trajectory.totals.items()}
            totals = {total: count for total, count in counts.items() if total[0] not in self.counted.events}
            ran = frozenset(statement for event, statement in self.counted.events.items() if counts[event, None])
            actions = [tuple(a) for a in trajectory.actions[i, : steps + (left is not None)].tolist()]
            found.append(Episode(first + i, values, actions, totals, ran, left))
        return found


def _value(stored: float, e: ir.Expr) -> Any:
    return bool(stored) if e.type.kind == "condition" else stored
