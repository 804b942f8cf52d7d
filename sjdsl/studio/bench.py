"""The bench: one game, its episode, and an answer to each request of the page.

How messages travel is the business of the server and the worker.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, assert_never

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.ir.hash import game_hash
from sjdsl.interpreter.overflow import LeavesFloat32
from sjdsl.interpreter.state import Cell
from sjdsl.render.episode_page import Artist, make_page
from sjdsl.render.look import make_look
from sjdsl.replay.recording import recording_text
from sjdsl.studio import requests as ask
from sjdsl.studio.carried import carry_over
from sjdsl.studio.counterexample import NoReplay, replay
from sjdsl.studio.episode import (
    Episode,
    TooLong,
    begin_episode,
    continue_from,
    metric_names,
    metric_values,
)
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
from sjdsl.studio.recorded import CannotRecord, recording_of
from sjdsl.studio.seats import CannotPlay, Seats
from sjdsl.trace.choices import chooser
from sjdsl.trace.rules import Rules

if TYPE_CHECKING:  # it loads JAX, which the browser doesn't have
    from sjdsl.studio.players import Players

Answer = dict[str, Any]
MAX_ERRORS = 50  # of a text that are sent to the page


class Refused(Exception):
    """A request can't be done; the message tells the user why."""


class Bench:
    """One game and its episode.

    folder: of its maps and bases.
    opened: the game of the last text that compiled; there is none before the first.
    on_board: the game that is played: `opened`, or the same on the map of a counterexample.
    others: the policy of the agents that the user doesn't control, without seats.
    """

    opened: Opened
    on_board: Opened
    episode: Episode
    _path: str  # of the text, in the page
    _artist: Artist

    def __init__(self, folder: Path, seats: Seats | None = None) -> None:
        self.folder = folder
        self._seats = seats
        self._players: Players | None = None
        self.seed = 0
        self.others = "random"
        self._is_empty = True  # no text has compiled yet
        self._num_sent = 0  # pictures that the page has

    def answer(self, request: ask.AnyRequest) -> Answer:
        """Returns the answer to a request; `refused` with the reason if it can't be done."""
        try:
            answer = self._perform(request)
        except (
            Refused,
            TooLong,
            CannotPaint,
            CannotPlay,
            CannotRecord,
            NoReplay,
            FileRefused,
        ) as reason:
            answer = {"refused": str(reason)}
        except LeavesFloat32 as overflow:
            answer = {"refused": Rules(self.opened.build.sources).overflow(overflow)}
        return {"id": request.id, "do": request.do, **answer}

    def _perform(self, request: ask.AnyRequest) -> Answer:
        """Does what a request asks for and returns the answer; raises if it can't be done."""
        if isinstance(request, ask.Text):
            return self._open(request)
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
                    raise Refused(
                        f"the game has no policy `{request.policy}`; trained agents and language "
                        "models take seats where sjdsl and JAX are installed: start the studio "
                        "with `sjdsl studio GAME --slots you,RUN@best,models.toml:NAME`, a name "
                        "for each agent"
                    )
                self.others = request.policy
            case ask.Number():
                self._set_number(request)
            case ask.Put():
                self._put_agent(request)
            case ask.Paint():
                if self._shows_counterexample:
                    raise Refused(
                        "this is the map of a counterexample: begin again to see the game's own, "
                        "and paint there"
                    )
                return {"change": vars(paint(self.opened, request.row, request.col, request.glyph))}
            case ask.Write():
                change = write_number(self.opened, request.name, request.entry, request.value)
                return {"change": vars(change)}
            case ask.Replay():
                on_board, episode = replay(self.opened, request)
                return self._put_on_board(on_board, episode)
            case ask.Panel():
                return {"panel": request.panel, **self._panel(request)}
            case ask.Share():
                return self._share()
            case ask.Record():
                return self._record()
            case _:
                assert_never(request)
        return self._scene()

    # ---- the text

    def _open(self, request: ask.Text) -> Answer:
        """Opens a text; the answer says whether the state was kept.

        A text with errors changes nothing.
        """
        folder, path = place_of(request.path, self.folder.resolve())
        file = Folder(folder).path_of(path)
        if file.suffix != ".sj":
            raise FileRefused(f"`{path}` is no game: its name does not end in .sj")
        unsaved = {(folder / name).resolve(): text for name, text in request.over.items()}
        source = Source(path, request.text, (folder / path).parent, unsaved.get, file)
        try:
            opened = open_text(source, request.variants, request.agents, request.params)
        except CompileError as error:
            return {"version": request.version, "compiles": False, **_describe_errors(error, path)}
        episode = None
        if not (request.fresh or self._is_empty or request.path != self._path):
            episode = self._continue_under(opened)
        is_kept = episode is not None
        if episode is None:
            try:
                episode = begin_episode(opened.game, opened.values, self.seed)
            except LeavesFloat32 as overflow:
                raise Refused(Rules(opened.build.sources).overflow(overflow)) from None
        self.opened = opened
        self._path = request.path
        self._is_empty = False
        return {
            "version": request.version,
            "compiles": True,
            "kept": is_kept,
            **self._put_on_board(opened, episode),
        }

    def _put_on_board(self, opened: Opened, episode: Episode) -> Answer:
        """Shows an episode of a game."""
        self.on_board = opened
        self.episode = episode
        if self.others not in _policies(opened.game):
            self.others = "random"
        self._artist = Artist(make_look(opened.game))
        self._num_sent = 0
        return {"game": self._describe_game(), **self._scene()}

    def _continue_under(self, opened: Opened) -> Episode | None:
        """Returns the episode under new rules, None if it can't go on.

        If the rules are the same, all its moments are kept, else only the state that is shown. A
        counterexample can't go on: it is one to the old rules.
        """
        episode = self.episode
        before = self.on_board
        if episode.scenario is not None:
            return None
        if game_hash(before.game) == game_hash(opened.game) and before.values == opened.values:
            return replace(episode, game=opened.game)
        world = carry_over(before.game, episode.now.world, opened.game, opened.values)
        if world is None:
            return None
        return continue_from(opened.game, world, episode.returns[episode.at], self.seed)

    def _describe_game(self) -> Answer:
        """Returns what the page has to know about the game."""
        opened = self.opened
        game = self.on_board.game
        return {
            "name": game.name,
            "title": game.title or game.name,
            "height": len(game.rows),
            "width": len(game.rows[0]),
            "agents": game.agents.number,
            "agents_are_free": opened.agents_are_free,
            "actions": list(game.agents.actions),
            "keys": action_keys(game.agents.actions, game.agents.relative),
            "policies": _policies(game),
            "others": self.others,
            "seats": list(self._names),
            "seed": self.seed,
            "variants": [
                [v.name.text, v.title.text if v.title else ""]
                for v in opened.composition.variants.values()
            ],
            "chosen": list(opened.composition.chosen),
            "numbers": knobs(game, self.on_board.values),
            "left": list(opened.left),
            "glyphs": glyphs(opened),
            "map_file": map_file(opened),
            "counterexample": self._shows_counterexample,
            "legend": self._artist.legend(),
            "metrics": metric_names(game),
        }

    # ---- the episode

    def _begin(self, seed: int) -> Answer:
        episode = begin_episode(self.opened.game, self.opened.values, seed)
        self.seed = seed
        return self._put_on_board(self.opened, episode)

    def _step(self, request: ask.Step) -> Answer:
        """Takes a step: the agents that the user controls as the request says, the others by their
        seats or, without any, by one policy."""
        game = self.on_board.game
        moment = self.episode.now
        if moment.is_over:
            raise Refused("the episode is over: go back, or begin it again")
        for agent, action in request.actions.items():
            self._check_agent(agent)
            if not 0 <= action < len(game.agents.actions):
                raise Refused("there is no such action")
        if self._names:
            self._seated_players().step(self.episode, self.on_board, request.actions)
            return self._scene()
        choose = chooser(game, self.others, self.seed)
        actions = list(choose(self.episode.steps_taken, moment.world))
        for agent, action in request.actions.items():
            actions[agent] = action
        self.episode.step(actions, self.on_board.values)
        return self._scene()

    @property
    def _names(self) -> tuple[str, ...]:
        """Who plays each agent of the game on the board; nobody in particular if it is empty."""
        if self._seats is None or self._seats.path != self._path or self._shows_counterexample:
            return ()
        return self._seats.names

    def _seated_players(self) -> "Players":
        """Returns who plays from the seats, loaded when they play for the first time."""
        if self._players is None:
            from sjdsl.studio.players import Players

            assert self._seats is not None
            self._players = Players(self._seats)
        return self._players

    def _set_number(self, request: ask.Number) -> None:
        """Sets a param of the game on the board; without a counterexample, also of `opened`."""
        game = self.on_board.game
        values = self.on_board.values
        try:
            value = with_entries(game, values, request.name, request.value)
            values = interpreted_values(game, {**values, request.name: value})
        except ValueError as error:
            raise Refused(str(error)) from None
        changed = replace(self.on_board, values=values)
        if not self._shows_counterexample:
            self.opened = changed
        self.on_board = changed

    def _put_agent(self, request: ask.Put) -> None:
        """Puts an agent on a cell: a new episode goes on from there."""
        episode = self.episode
        world = episode.now.world
        agent = self._check_agent(request.agent)
        cell = self._check_cell(request.row, request.col)
        if cell in world.position and world.position.index(cell) != agent:
            raise Refused("another agent stands there")
        if any(cell in herd.position for herd in world.movers.values()):
            raise Refused("a mover stands there")
        position = list(world.position)
        position[agent] = cell
        away = list(world.away)
        away[agent] = None
        world = replace(world, position=position, away=away)
        returns = episode.returns[episode.at]
        self.episode = continue_from(self.on_board.game, world, returns, self.seed)

    def _scene(self) -> Answer:
        """Returns the moment that is shown, with the pictures that the page doesn't have yet."""
        episode = self.episode
        scene = self._artist.moment(episode.drawn(episode.at))
        positions = episode.now.world.position
        scene["places"] = [None if cell is None else list(cell) for cell in positions]
        new_pictures = self._artist.pictures[self._num_sent :]
        self._num_sent = len(self._artist.pictures)
        return {
            "scene": scene,
            "pictures": new_pictures,
            "colours": self._artist.colours,
            "metrics": metric_values(self.on_board.game, episode.now.outcome),
            "at": episode.at,
            "moments": len(episode.moments),
        }

    # ---- beside the board

    def _panel(self, request: ask.Panel) -> Answer:
        """Returns what a panel beside the board shows. Raises Refused for a text with errors."""
        opened = self.opened
        on_board = self.on_board
        world = self.episode.now.world
        cell = None
        if request.row is not None and request.col is not None:
            cell = self._check_cell(request.row, request.col)
        panels: dict[str, Callable[[], Answer]] = {
            "rules": lambda: rules_panel(opened),
            "python": lambda: python_panel(opened),
            "state": lambda: state_panel(on_board, world, cell),
            "seen": lambda: seen_panel(on_board, world, self._check_agent(request.agent)),
            "trace": lambda: trace_panel(on_board, self.episode.traced()),
            "checks": lambda: checks_panel(opened),
            "diff": lambda: diff_panel(opened),
            "curves": lambda: curves_panel(self.episode),
        }
        try:
            return panels[request.panel]()
        except CompileError as error:
            raise Refused(error.diagnostics[0].message) from None

    def _share(self) -> Answer:
        """Returns the episode as an HTML page, and a name for its file."""
        game = self.on_board.game
        moments = [self.episode.drawn(number) for number in range(len(self.episode.moments))]
        page = make_page(game, moments, players=self._names, seed=self.episode.seed)
        return {"html": page.text, "name": f"{game.name}.html"}

    def _record(self) -> Answer:
        """Returns the episode as a file for `sjdsl replay`, and a name for it."""
        why = None if self._players is None else self._players.reasons(self.episode)
        recording = recording_of(self.episode, self.opened, self._names, why)
        return {"recording": recording_text(recording), "name": f"{self.opened.game.name}.json"}

    # ---- checks

    @property
    def _shows_counterexample(self) -> bool:
        return self.on_board is not self.opened

    def _check_agent(self, number: int) -> int:
        """Returns the number of an agent. Raises Refused if there is no such agent."""
        if not 0 <= number < self.on_board.game.agents.number:
            raise Refused(f"there is no agent {number}")
        return number

    def _check_cell(self, row: int, col: int) -> Cell:
        """Returns a cell of the map. Raises Refused if it isn't on the map."""
        rows = self.on_board.game.rows
        if not (0 <= row < len(rows) and 0 <= col < len(rows[0])):
            raise Refused("that is no cell of the map")
        return Cell(row, col)


def _policies(game: ir.Game) -> list[str]:
    """Returns the names of the policies that agents can follow."""
    return ["random", "stay", *(policy.name for policy in game.policies)]


def _describe_errors(error: CompileError, path: str) -> Answer:
    """Returns the number of a text's errors, and the first ones with their lines.

    The line is None for an error in another file.
    """
    errors = [d for d in error.diagnostics if d.severity == "error"]
    problems = []
    for d in errors[:MAX_ERRORS]:
        line = d.span.line if d.span.file == path else None
        help_ = f"\nhelp: {d.hint}" if d.hint else ""
        problems.append([line, d.message + help_])
    return {"errors": len(errors), "problems": problems}
