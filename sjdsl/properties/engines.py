"""Plays episodes on the game's own map.

Compiled or, where there is little to play, on the interpreter; both play the same.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from sjdsl.compiler import ir
from sjdsl.interpreter.board import board_of, declared_world
from sjdsl.interpreter.evaluate import evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.overflow import LeavesFloat32
from sjdsl.interpreter.state import World, default_params
from sjdsl.interpreter.step import step
from sjdsl.properties.instances import GameFamily
from sjdsl.properties.monitors import Total
from sjdsl.properties.trajectory import Scenario, Trajectory, draws_of, params_of, play

if TYPE_CHECKING:
    from sjdsl.properties.compiled_play import EpisodePlayer, Episodes

LITTLE = 60_000  # up to so many cells times steps, interpreting takes less time than compiling


@dataclass(frozen=True)
class Episode:
    """One episode.

    values: number of an `expect` -> what it reads in the first state and after each step.
    totals: the final ones. overflow: the step in which a real left float32, None if none did;
    `values` end before it.
    """

    number: int
    values: dict[int, list[tuple[Any, ...]]]
    actions: list[tuple[int, ...]]
    totals: dict[Total, int]
    overflow: int | None = None


class EpisodeRunner:
    """Plays episodes of a game under the policies of its `expect`s. checks: those, by number."""

    def __init__(self, family: GameFamily, seed: int):
        self.family = family
        self.seed = seed
        self.checks = {
            number: check
            for number, check in enumerate(family.own.checks)
            if check.kind == "expect"
        }

    @cached_property
    def _player(self) -> "EpisodePlayer":
        from sjdsl.properties.compiled_play import EpisodePlayer

        return EpisodePlayer(self.family, list(self.checks.values()))

    @property
    def _has_compiled(self) -> bool:
        return "_player" in vars(self)

    @property
    def length(self) -> int:
        """Steps of an episode."""
        game = self.family.own
        board = board_of(game)
        world = declared_world(board, default_params(game))
        steps = int(evaluate(game.episode, Instance(board, world)))
        return steps if game.trials is None else steps * game.trials.number

    def play(self, policies: Sequence[ir.Policy], first: int, number: int) -> list[Episode]:
        """Returns episodes `first`, `first + 1`, …

        Raises:
          NotSupported: the compiled game can't play them.
        """
        if self.compiles(number):
            return self.play_compiled(policies, first, number)
        return [self.play_interpreted(policies, first + i) for i in range(number)]

    def compiles(self, number: int) -> bool:
        """Returns whether so many episodes are played by the compiled game, which needs JAX."""
        game = self.family.own
        return self.length * number * len(game.rows) * len(game.rows[0]) > LITTLE

    def scenario(self, policies: Sequence[ir.Policy], episode: int) -> Scenario:
        """Returns an episode as a scenario for the interpreter."""
        of_agents = tuple(
            policies[agent % len(policies)] for agent in range(self.family.own.agents.number)
        )
        return Scenario(self.seed, episode, policies=of_agents)

    def written_out(self, episode: Episode, steps: int) -> Scenario:
        """Returns the first steps of an episode as a scenario with every action written out."""
        return Scenario(self.seed, episode.number, actions=tuple(episode.actions[:steps]))

    def world_before(self, episode: Episode, step: int) -> World:
        """Returns the state before a step of an episode."""
        if not self._has_compiled:
            return play(self.family.own, self.written_out(episode, step)).worlds[step]
        from sjdsl.properties.state_conversion import world_of

        state = self._player.state_before(episode.actions, self.seed, episode.number, step)
        return world_of(self._player.env, state)

    def play_interpreted(self, policies: Sequence[ir.Policy], number: int) -> Episode:
        """Plays one episode on the interpreter."""
        scenario = self.scenario(policies, number)
        checks = list(self.checks.values())
        trajectory = play(self.family.own, scenario, self.length, checks)
        return Episode(
            number=number,
            values={i: trajectory.values(check) for i, check in self.checks.items()},
            actions=trajectory.actions,
            totals=dict(trajectory.totals[-1]) if trajectory.totals else {},
            overflow=None if trajectory.overflow is None else len(trajectory.outcomes),
        )

    def play_overflow(self, episode: Episode) -> Trajectory:
        """Returns the step of an episode in which a real leaves float32, and the state before."""
        assert episode.overflow is not None
        game = self.family.own
        scenario = self.written_out(episode, episode.overflow + 1)
        if not self._has_compiled:
            return play(game, scenario, checks=list(self.checks.values()))
        world = self.world_before(episode, episode.overflow)
        params = params_of(game, ())
        trajectory = Trajectory(game, params, [world], [dict(episode.totals)])
        actions = episode.actions[episode.overflow]
        trajectory.actions.append(actions)
        try:
            draws = draws_of(scenario, episode.overflow, game, world)
            _, outcome = step(game, world, actions, params, draws)
            trajectory.outcomes.append(outcome)
            # No rule computed the real, so an expression of a check did.
            node = next((check for check in game.checks if check.origin is not None), game)
            trajectory.overflow = LeavesFloat32(node, episode.overflow)
        except LeavesFloat32 as overflow:
            trajectory.overflow = overflow
        return trajectory

    def play_compiled(
        self, policies: Sequence[ir.Policy], first: int, number: int
    ) -> list[Episode]:
        """Plays episodes of the compiled game, side by side."""
        played = self._player.play(policies, self.seed, first, number)
        return [self._episode(played, i, first + i) for i in range(number)]

    def _episode(self, played: "Episodes", row: int, number: int) -> Episode:
        """Returns one of the episodes that the compiled game has played."""
        length = int(played.length[row])
        overflow = int(played.overflow[row]) if played.overflow[row] < length else None
        steps = length if overflow is None else overflow
        values: dict[int, list[tuple[Any, ...]]] = {}
        first = 0
        for check_number, check in self.checks.items():
            after = first + len(check.values)
            of_states = played.values[row, : steps + 1, first:after].tolist()
            values[check_number] = [_as_interpreted(entries, check) for entries in of_states]
            first = after
        # The compiled game has further events, which count its statements.
        names = {event.name for event in self.family.own.events}
        totals = {
            (name, word): int(counts[row])
            for (name, word), counts in played.totals.items()
            if name in names
        }
        num_actions = steps if overflow is None else steps + 1
        actions = [tuple(chosen) for chosen in played.actions[row, :num_actions].tolist()]
        return Episode(number, values, actions, totals, overflow)


def _as_interpreted(entries: Sequence[Any], check: ir.Check) -> tuple[Any, ...]:
    """Returns the compiled values of a check in one state; conditions are numbers there."""
    values = []
    for value, expression in zip(entries, check.values, strict=True):
        values.append(bool(value) if expression.type.kind == "condition" else value)
    return tuple(values)
