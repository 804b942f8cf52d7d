"""`Stage`: a game on a small map, for scenes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from sjdsl.compiler import Build, ir
from sjdsl.compiler.ir.entity_types import EntityType
from sjdsl.interpreter.board import Board, board_of
from sjdsl.interpreter.state import Cell, World
from sjdsl.interpreter.step import play_starting, reset
from sjdsl.interpreter.threefry import Threefry
from sjdsl.library.checked_game import build_game
from sjdsl.library.factory import environment_of
from sjdsl.library.parameters import build_params
from sjdsl.near_names import meant
from sjdsl.runtime.env import Environment
from sjdsl.testing.engines import Compiled, Numbers, compile_quickly, interpreter_params, key_bits
from sjdsl.testing.paths import find_field, write_field
from sjdsl.testing.pictures import (
    Pose,
    put_picture,
    read_mover_cells,
    read_picture,
    read_poses,
)
from sjdsl.testing.scene import Scene
from sjdsl.testing.signs import Signs, make_signs
from sjdsl.testing.states import make_away
from sjdsl.testing.values import merged


@dataclass(frozen=True)
class Stage:
    """A game, usually on a small map.

    Attributes:
      game: a path to any `.sj` file, or the name of a bundled game.
      map: rows of the map's glyphs, or a file of them; None: the game's own. It needs no cells to
        start on.
      agents: how many; None: as the game says.
      variant: a variant of the file, several as `"a+b"`.
      params: numbers of the game for all scenes, with its sizes.
      looks: further signs for pictures: character -> the state of a cell it stands for, as
        `{"t": "tree fruit=none"}`. Glyphs that the game declares `with` a state are signs already.
      arrows: the signs of agents facing north, east, south, west; others where the map has a `v`,
        say.
      interpreted: only the interpreter takes the steps. A scene then costs milliseconds, and
        doesn't test the compiled game.

    Creating the environment raises the errors of `sjdsl.make`, and ValueError for impossible signs.
    """

    game: str | Path
    map: tuple[str, ...] | str | Path | None = None
    agents: int | None = None
    variant: str | None = field(default=None, kw_only=True)
    params: Mapping[str, Any] = field(default_factory=dict, kw_only=True)
    looks: Mapping[str, str] = field(default_factory=dict, kw_only=True)
    arrows: str = field(default="^>v<", kw_only=True)

    interpreted: bool = field(default=False, kw_only=True)

    @cached_property
    def env(self) -> Environment:
        """The environment, compiled once.

        Its map may lack cells to send agents to: `put` places the agents, and `start` raises
        CompileError.
        """
        return environment_of(*self._build(placed_by_hand=True))

    def _build(self, placed_by_hand: bool) -> tuple[Build, dict[str, Any]]:
        """Returns the game as built, and its run-time numbers."""
        return build_game(
            self.game, self.variant, self.agents, self.params, self.map, placed_by_hand
        )

    @cached_property
    def signs(self) -> Signs:
        return make_signs(self.env.game, self.looks, self.arrows)

    @cached_property
    def compiled(self) -> Compiled:
        return compile_quickly(self.env)

    @cached_property
    def _with_places(self) -> Build:
        """The game on a map that has the cells it sends agents to."""
        build, _ = self._build(placed_by_hand=False)
        return build

    @property
    def board(self) -> Board:
        return board_of(self.env.game)

    def numbers(self, params: Mapping[str, Any]) -> Numbers:
        """Returns the run-time numbers with some replaced.

        Their limits hold, but not what the game `require`s.
        """
        key = repr(sorted(params.items()))
        if key not in self._numbers:
            run_time = {param.name for param in self.env.game.params}
            fixed = {name: value for name, value in self.params.items() if name in run_time}
            compiled = build_params(
                self.env.game, self.env.module, merged(fixed, params), check_requires=False
            )
            self._numbers[key] = Numbers(compiled, interpreter_params(self.env, compiled))
        return self._numbers[key]

    @cached_property
    def _numbers(self) -> dict[str, Numbers]:
        return {}

    def put(
        self,
        *picture: str,
        under: Mapping[int, str] | None = None,
        fields: Mapping[str, Any] | None = None,
        away: Mapping[int, int | tuple[int, str]] | None = None,
        movers_away: Mapping[str, Mapping[int, int | tuple[int, str]]] | None = None,
        numbers: Mapping[str, Sequence[int]] | None = None,
        step: int = 0,
        seed: int = 0,
        params: Mapping[str, Any] | None = None,
    ) -> Scene:
        """Returns the scene of a picture; everything else is as at the start of an episode.

        Args:
          picture: the rows of the map in signs, agents as arrows. The numbers of the agents of a
            row may stand beside it, left to right; the other agents are numbered in reading order:
            `"..>.<  10"`. Movers are the glyph of their entity type, all of them, numbered in
            reading order; they face north unless `fields` has another `deer.heading`.
          under: agent -> the sign of the cell that it stands on; by default that is as on the map.
          fields: `agent.NAME`, `KIND.NAME`, `SORT.NAME` (of movers) or `NAME` (of the world),
            perhaps one entry `NAME[word]` -> a list over agents, movers or cells (in reading
            order), a mapping of some of them (cells by (row, column)), or one value for all.
            Timers are fields.
          away: agents that are not on the map -> ticks until they return, with the phase that has
            sent them if several can; 0: never.
          movers_away: entity type -> which of its movers are not on the map, as `away`.
          numbers: entity type -> numbers of its movers in the picture, in reading order.
          step: finished steps of the episode.
          seed: of the first step; each further step has the next.
          params: run-time numbers by name.

        Raises:
          ValueError: something does not fit the game.
        """
        under = under or {}
        away = away or {}
        movers_away = movers_away or {}
        numbers = numbers or {}
        params = params or {}
        game = self.env.game
        board = self.board
        interpreted = self.numbers(params).interpreted
        draws = Threefry(*key_bits(0))
        world = reset(game, interpreted, draws, sends=False)
        rows = read_picture(picture, self.signs)
        poses = read_poses(rows, self.signs, board.agents, away)
        unknown = [
            entity_type
            for entity_type in (*movers_away, *numbers)
            if entity_type not in world.movers
        ]
        if unknown:
            near = meant(unknown[0], world.movers)
            raise ValueError(f"the game has no movers `{unknown[0]}`{near}")
        mover_cells = read_mover_cells(rows, self.signs, numbers, movers_away)
        put_picture(rows, poses, under, self.signs, board, world)
        _put_bodies(poses, away, mover_cells, movers_away, game, world)
        if game.starting:  # they see the picture, and change nothing that it shows
            world = play_starting(game, world, draws)
            put_picture(rows, poses, under, self.signs, board, world)
            _put_bodies(poses, away, mover_cells, movers_away, game, world)
        for path, values in (fields or {}).items():
            write_field(find_field(game, path), values, board, world)
        world.step = step
        world.marks = []
        return Scene(self, world, params, seed)

    def start(self, seed: int = 0, params: Mapping[str, Any] | None = None) -> Scene:
        """Returns the scene that an episode starts with.

        The phase `start` runs on both engines (unless the stage is `interpreted`) with the same
        draws. Raises CompileError if the map lacks cells that the game sends agents or movers to.
        """
        _ = self._with_places  # raises CompileError
        params = params or {}
        interpreted = self.numbers(params).interpreted
        world = reset(self.env.game, interpreted, Threefry(*key_bits(seed)))
        scene = Scene(self, world, params, seed)
        if not self.interpreted:
            scene.compare_start(seed)
        return scene


def _put_bodies(
    poses: Mapping[int, Pose],
    away: Mapping[int, int | tuple[int, str]],
    mover_cells: Mapping[str, list[Cell | None]],
    movers_away: Mapping[str, Mapping[int, int | tuple[int, str]]],
    game: ir.Game,
    world: World,
) -> None:
    """Places all agents and movers in a world, those too that are away."""
    world.position = [None] * game.agents.number
    world.heading = [0] * game.agents.number
    world.moved = [False] * game.agents.number
    world.away = [None] * game.agents.number
    for agent, (row, col, heading) in poses.items():
        world.position[agent] = Cell(row, col)
        world.heading[agent] = heading
    for agent, absence in away.items():
        world.away[agent] = make_away(game, agent, *_ticks_and_phase(absence))
    for entity_type, cells in mover_cells.items():
        herd = world.movers[entity_type]
        herd.position = list(cells)
        herd.moved = [False] * len(cells)
        herd.fields["heading"] = ["north"] * len(cells)
        herd.away = [None] * len(cells)
        for number, absence in movers_away.get(entity_type, {}).items():
            ticks, phase = _ticks_and_phase(absence)
            herd.away[number] = make_away(
                game, number, ticks, phase, EntityType("mover", (entity_type,))
            )


def _ticks_and_phase(absence: int | tuple[int, str]) -> tuple[int, str | None]:
    return absence if isinstance(absence, tuple) else (absence, None)
