"""Plays episodes on the game's own map, compiled or, where there is little to play, on the interpreter; both play the same."""

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
from sjdsl.properties.trajectory import Scenario, Trajectory, draws_of, params_of, play

if TYPE_CHECKING:
    from sjdsl.properties.compiled_play import EpisodePlayer

LITTLE = 60_000  # up to so many cells times steps, interpreting takes less time than compiling
Total = tuple[str, str | None]  # an event, and its word or None


@dataclass(frozen=True)
class Episode:
    """One episode: the values each `expect` reads in the first state and after each step, the actions, the final totals of events.

    left: the step in which a real left float32; None if none did. `values` end before it.
    """

    number: int
    values: dict[int, list[tuple[Any, ...]]]
    actions: list[tuple[int, ...]]
    totals: dict[Total, int]
    left: int | None = None


class EpisodeRunner:
    """Plays episodes of a game under the policies of its `expect`s."""

    def __init__(self, family: GameFamily, seed: int):
        self.family, self.seed = family, seed
        self.checks = {
            number: check
            for number, check in enumerate(family.own.checks)
            if check.sort == "expect"
        }

    @cached_property
    def _player(self) -> "EpisodePlayer":
        from sjdsl.properties.compiled_play import EpisodePlayer

        return EpisodePlayer(self.family, list(self.checks.values()))

    @property
    def length(self) -> int:
        """Steps of an episode."""
        game = self.family.own
        world = declared_world(board_of(game), default_params(game))
        steps = int(evaluate(game.episode, Instance(board_of(game), world)))
        return steps if game.trials is None else steps * game.trials.number

    def play(self, policies: Sequence[ir.Policy], first: int, number: int) -> list[Episode]:
        """Returns episodes `first`, `first + 1`, …; raises NotSupported for what the compiled game cannot do."""
        if self.compiles(number):
            return self.compiled(policies, first, number)
        return [self.interpreted(policies, first + i) for i in range(number)]

    def compiles(self, number: int) -> bool:
        """Returns whether so many episodes are played by the compiled game, which needs JAX."""
        game = self.family.own
        return self.length * number * len(game.rows) * len(game.rows[0]) > LITTLE

    def scenario(self, policies: Sequence[ir.Policy], episode: int) -> Scenario:
        """Returns an episode as a scenario for the interpreter."""
        own = tuple(
            policies[agent % len(policies)] for agent in range(self.family.own.agents.number)
        )
        return Scenario(self.seed, episode, policies=own)

    def written_out(self, episode: Episode, steps: int) -> Scenario:
        """Returns the first steps of an episode as a scenario in which every action is written out."""
        return Scenario(self.seed, episode.number, actions=tuple(episode.actions[:steps]))

    def world_before(self, episode: Episode, step: int) -> World:
        """Returns the state before a step of an episode."""
        if "_player" not in vars(self):
            return play(self.family.own, self.written_out(episode, step)).worlds[step]
        from sjdsl.properties.state_conversion import world_of

        return world_of(
            self._player.env,
            self._player.state_before(episode.actions, self.seed, episode.number, step),
        )

    def interpreted(self, policies: Sequence[ir.Policy], number: int) -> Episode:
        """Plays one episode on the interpreter."""
        trajectory = play(
            self.family.own,
            self.scenario(policies, number),
            self.length,
            list(self.checks.values()),
        )
        left = None if trajectory.left is None else len(trajectory.outcomes)
        values = {number: trajectory.values(check) for number, check in self.checks.items()}
        return Episode(
            number, values, trajectory.actions, dict((trajectory.totals or [{}])[-1]), left
        )

    def overflow(self, episode: Episode) -> Trajectory:
        """Returns the end of an episode in which a real leaves float32: the state before, and the step."""
        assert episode.left is not None
        scenario, game = self.written_out(episode, episode.left + 1), self.family.own
        if "_player" not in vars(self):
            return play(game, scenario, checks=list(self.checks.values()))
        trajectory = Trajectory(
            game,
            params_of(game, ()),
            [self.world_before(episode, episode.left)],
            [dict(episode.totals)],
        )
        trajectory.actions.append(episode.actions[episode.left])
        try:
            _, outcome = step(
                game,
                trajectory.worlds[-1],
                trajectory.actions[-1],
                trajectory.params,
                draws_of(scenario, episode.left, game, trajectory.worlds[-1]),
            )
            trajectory.outcomes.append(outcome)
        except LeavesFloat32 as left:
            trajectory.left = left
        trajectory.left = trajectory.left or LeavesFloat32(
            next((c for c in game.checks if c.origin is not None), game), episode.left
        )
        return trajectory

    def compiled(self, policies: Sequence[ir.Policy], first: int, number: int) -> list[Episode]:
        """Plays episodes of the compiled game, side by side."""
        played, found, own = (
            self._player.play(policies, self.seed, first, number),
            [],
            {event.name for event in self.family.own.events},
        )
        for i in range(number):
            left = int(played.left[i]) if played.left[i] < played.length[i] else None
            steps, values, at = int(played.length[i]) if left is None else left, {}, 0
            for check_number, check in self.checks.items():
                columns = played.values[i, : steps + 1, at : at + len(check.values)]
                values[check_number] = [
                    tuple(
                        bool(x) if e.type.kind == "condition" else x
                        for x, e in zip(row, check.values, strict=True)
                    )
                    for row in columns.tolist()
                ]
                at += len(check.values)
            totals = {
                total: int(counted[i])
                for total, counted in played.totals.items()
                if total[0] in own
            }
            actions = [tuple(a) for a in played.actions[i, : steps + (left is not None)].tolist()]
            found.append(Episode(first + i, values, actions, totals, left))
        return found
