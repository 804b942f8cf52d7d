"""The bench: one game, its episode, and an answer to each request of the page. Nothing here knows how messages travel."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, assert_never

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.ir.hash import game_hash
from sjdsl.interpreter.overflow import LeavesFloat32
from sjdsl.interpreter.state import Cell
from sjdsl.render.episode_page import Artist, make_page
from sjdsl.render.look import make_look
from sjdsl.studio import requests as ask
from sjdsl.studio.carried import carried
from sjdsl.studio.counterexample import NoReplay, replayed
from sjdsl.studio.episode import Episode, TooLong, begun, measured, metric_names, resumed
from sjdsl.studio.examples import place_of
from sjdsl.studio.folder import FileRefused, Folder
from sjdsl.studio.keys import action_keys
from sjdsl.studio.knobs import knobs, with_entries
from sjdsl.studio.opened import Opened, interpreted_values, open_text
from sjdsl.studio.painting import CannotPaint, glyphs, map_file, paint, write_number
from sjdsl.studio.panels import (
    checks_panel,
    curves_panel,
    diff_panel,
    python_panel,
    rules_panel,
    seen_panel,
    state_panel,
    trace_panel,
)
from sjdsl.trace.choices import chooser
from sjdsl.trace.rules import Rules

Answer = dict[str, Any]
MOST_TOLD = 50  # errors of a text that are told


class Refused(Exception):
    """A request cannot be done; the text says why, to the person who asked."""


class Bench:
    """One game and its episode. `folder`: where its maps and bases are.

    opened: the game of the text; on_board: the one that is played, on another map while a counterexample is shown. Before a text has compiled
    there is none; while a text does not compile, the last one that did is played on.
    """

    opened: Opened
    on_board: Opened
    episode: Episode
    _artist: Artist

    def __init__(self, folder: Path) -> None:
        self.folder, self.seed, self.others = folder, 0, "random"
        self._is_empty, self._sent = True, 0

    def answer(self, request: ask.AnyRequest) -> Answer:
        """Returns what a request leads to; `refused` with the reason if it cannot be done."""
        try:
            found = self._done(request)
        except (Refused, TooLong, CannotPaint, NoReplay, FileRefused) as reason:
            found = {"refused": str(reason)}
        except LeavesFloat32 as left:
            found = {"refused": Rules(self.opened.build.sources).overflow(left)}
        return {"id": request.id, "do": request.do, **found}

    def _done(self, request: ask.AnyRequest) -> Answer:
        if isinstance(request, ask.Text):
            return self._text(request)
        if self._is_empty:
            raise Refused("no text has compiled yet")
        match request:
            case ask.Step():
                return self._step(request)
            case ask.Go():
                self.episode.go(request.to)
            case ask.Begin():
                return self._begin(request.seed)
            case ask.Others():
                if request.policy not in _policies(self.on_board.game):
                    raise Refused(f"the game has no policy `{request.policy}`")
                self.others = request.policy
            case ask.Number():
                self._number(request)
            case ask.Put():
                self._put(request)
            case ask.Paint():
                if self._shows_counterexample:
                    raise Refused(
                        "this is the map of a counterexample: begin again to see the game's own, and paint there"
                    )
                return {"change": vars(paint(self.opened, request.row, request.col, request.glyph))}
            case ask.Write():
                return {
                    "change": vars(
                        write_number(self.opened, request.name, request.entry, request.value)
                    )
                }
            case ask.Replay():
                return self._put_on_board(*replayed(self.opened, request))
            case ask.Panel():
                return {"panel": request.panel, **self._panel(request)}
            case ask.Share():
                return self._share()
            case _:
                assert_never(request)
        return self._scene()

    # ---- the text

    def _text(self, request: ask.Text) -> Answer:
        """Opens a text; the answer says whether the state was kept. A text with errors leaves everything as it is."""
        folder, path = place_of(request.path, self.folder.resolve())
        file = Folder(folder).inside(path)
        if file.suffix != ".sj":
            raise FileRefused(f"`{path}` is no game: its name does not end in .sj")
        over = {(folder / name).resolve(): text for name, text in request.over.items()}
        source = Source(path, request.text, (folder / path).parent, over.get, file)
        try:
            opened = open_text(source, request.variants, request.agents, request.params)
        except CompileError as error:
            errors = [d for d in error.diagnostics if d.severity == "error"]
            told = [
                [
                    d.span.line if d.span.file == path else None,
                    d.message + (f"\nhelp: {d.hint}" if d.hint else ""),
                ]
                for d in errors[:MOST_TOLD]
            ]
            return {
                "version": request.version,
                "compiles": False,
                "errors": len(errors),
                "problems": told,
            }
        kept = None if request.fresh or self._is_empty else self._kept(opened)
        try:
            episode = kept or begun(opened.game, opened.values, self.seed)
        except LeavesFloat32 as left:
            raise Refused(Rules(opened.build.sources).overflow(left)) from None
        self.opened, self._is_empty = opened, False
        return {
            "version": request.version,
            "compiles": True,
            "kept": kept is not None,
            **self._put_on_board(opened, episode),
        }

    def _put_on_board(self, shown: Opened, episode: Episode) -> Answer:
        """Shows an episode of a game. Whoever drove the agents goes on if the game has such a policy."""
        self.on_board, self.episode = shown, episode
        if self.others not in _policies(shown.game):
            self.others = "random"
        self._artist, self._sent = Artist(make_look(shown.game)), 0
        return {"game": self._described(), **self._scene()}

    def _kept(self, now: Opened) -> Episode | None:
        """Returns the episode under the new rules: as it was if they are the same, else going on from the state that is shown.

        Not a counterexample: it was one to the old rules.
        """
        episode, before = self.episode, self.on_board
        if episode.scenario is not None:
            return None
        if game_hash(before.game) == game_hash(now.game) and before.values == now.values:
            return replace(episode, game=now.game)
        world = carried(before.game, episode.now.world, now.game, now.values)
        return (
            None
            if world is None
            else resumed(now.game, world, episode.returns[episode.at], self.seed)
        )

    def _described(self) -> Answer:
        """Returns what the page has to know of a game."""
        opened, shown = self.opened, self.on_board
        game = shown.game
        return {
            "name": game.name,
            "title": game.title or game.name,
            "height": len(game.rows),
            "width": len(game.rows[0]),
            "agents": game.agents.number,
            "agents_are_free": isinstance(
                opened.composition.number, ast.Path
            ),  # a `size` says how many
            "actions": list(game.agents.actions),
            "keys": action_keys(game.agents.actions, game.agents.relative),
            "policies": _policies(game),
            "others": self.others,
            "seed": self.seed,
            "variants": [
                [v.name.text, v.title.text if v.title else ""]
                for v in opened.composition.variants.values()
            ],
            "chosen": list(opened.composition.chosen),
            "numbers": knobs(game, shown.values),
            "left": list(opened.left),
            "glyphs": glyphs(opened),
            "map_file": map_file(opened),
            "counterexample": self._shows_counterexample,
            "legend": self._artist.legend(),
            "metrics": metric_names(game),
        }

    # ---- the episode

    def _begin(self, seed: int) -> Answer:
        episode = begun(self.opened.game, self.opened.values, seed)
        self.seed = seed
        return self._put_on_board(self.opened, episode)

    def _step(self, request: ask.Step) -> Answer:
        shown, episode = self.on_board, self.episode
        if episode.now.is_over:
            raise Refused("the episode is over: go back, or begin it again")
        driven = {self._agent(agent): action for agent, action in request.actions.items()}
        if any(not 0 <= action < len(shown.game.agents.actions) for action in driven.values()):
            raise Refused("there is no such action")
        actions = list(
            chooser(shown.game, self.others, self.seed)(episode.now.world.step, episode.now.world)
        )
        for agent, action in driven.items():
            actions[agent] = action
        episode.step(actions, shown.values)
        return self._scene()

    def _number(self, request: ask.Number) -> None:
        game, values = self.on_board.game, self.on_board.values
        try:
            given = with_entries(game, values, request.name, request.value)
            changed = replace(
                self.on_board, values=interpreted_values(game, {**values, request.name: given})
            )
        except ValueError as error:
            raise Refused(str(error)) from None
        if not self._shows_counterexample:
            self.opened = changed
        self.on_board = changed

    def _put(self, request: ask.Put) -> None:
        game, episode, agent = self.on_board.game, self.episode, self._agent(request.agent)
        cell, world = self._cell(request.row, request.col), episode.now.world
        if cell in world.position and world.position.index(cell) != agent:
            raise Refused("another agent stands there")
        if any(cell in herd.position for herd in world.movers.values()):
            raise Refused("a mover stands there")
        place = [cell if number == agent else at for number, at in enumerate(world.position)]
        away = [None if number == agent else waits for number, waits in enumerate(world.away)]
        self.episode = resumed(
            game, replace(world, position=place, away=away), episode.returns[episode.at], self.seed
        )

    def _scene(self) -> Answer:
        """Returns the moment that is shown, the pictures that the page does not have yet, and how many moments there are."""
        episode = self.episode
        scene = self._artist.moment(episode.drawn(episode.at))
        new, self._sent = self._artist.pictures[self._sent :], len(self._artist.pictures)
        game = self.on_board.game
        return {
            "scene": scene
            | {"places": [None if at is None else list(at) for at in episode.now.world.position]},
            "pictures": new,
            "colours": self._artist.colours,
            "metrics": measured(game, episode.now.outcome),
            "at": episode.at,
            "moments": len(episode.moments),
        }

    # ---- beside the board

    def _panel(self, request: ask.Panel) -> Answer:
        opened, shown, moment = self.opened, self.on_board, self.episode.now
        cell = (
            None
            if request.row is None or request.col is None
            else self._cell(request.row, request.col)
        )
        panels: dict[str, Callable[[], Answer]] = {
            "rules": lambda: rules_panel(opened),
            "python": lambda: python_panel(opened),
            "state": lambda: state_panel(shown, moment.world, cell),
            "seen": lambda: seen_panel(shown, moment.world, self._agent(request.agent)),
            "trace": lambda: trace_panel(shown, self.episode.traced()),
            "checks": lambda: checks_panel(opened),
            "diff": lambda: diff_panel(opened),
            "curves": lambda: curves_panel(self.episode),
        }
        try:
            return panels[request.panel]()
        except CompileError as error:
            raise Refused(error.diagnostics[0].message) from None

    def _share(self) -> Answer:
        episode, game = self.episode, self.on_board.game
        moments = [episode.drawn(number) for number in range(len(episode.moments))]
        return {"html": make_page(game, moments).text, "name": f"{game.name}.html"}

    # ---- what there is

    @property
    def _shows_counterexample(self) -> bool:
        return self.on_board is not self.opened

    def _agent(self, number: int) -> int:
        if not 0 <= number < self.on_board.game.agents.number:
            raise Refused(f"there is no agent {number}")
        return number

    def _cell(self, row: int, col: int) -> Cell:
        rows = self.on_board.game.rows
        if not (0 <= row < len(rows) and 0 <= col < len(rows[0])):
            raise Refused("that is no cell of the map")
        return Cell(row, col)


def _policies(game: ir.Game) -> list[str]:
    """Returns the names of the policies that agents can follow if nobody controls them."""
    return ["random", "stay", *(policy.name for policy in game.policies)]
