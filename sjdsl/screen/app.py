"""The terminal screen of `sjdsl play` and `sjdsl replay`: one key is one step, and nothing waits for a compiler."""

import asyncio
import signal
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import ClassVar

from rich.text import Text
from textual import events
from textual.app import App, ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Container, Horizontal, ScrollableContainer, VerticalScroll
from textual.geometry import Region
from textual.widgets import Static

from sjdsl.compiler import ir
from sjdsl.screen import COMPILING, sidebar
from sjdsl.screen.board import WIDTH, board_text, make_screen_looks
from sjdsl.screen.keys import action_keys, pasted_keys
from sjdsl.screen.session import Prepared, Session

SIDE = 38  # letters of the column beside the map
AROUND = 3  # cells around the steered agent that stay in view where the map is larger than the screen


Compile = Callable[[], Prepared]


class Screen(App[None]):
    """Shows a session and plays it.

    Attributes:
      fault: what went wrong in the background, after the screen has closed.
    """

    CSS = f"""
    Screen {{ background: $background; }}
    #title {{ height: auto; text-style: bold; padding: 0 1; }}
    #status {{ height: auto; padding: 0 1; }}
    #keys {{ height: auto; padding: 0 1; color: $text-muted; }}
    #board {{ width: 1fr; height: 100%; padding: 0 1; }}
    #map {{ width: auto; height: auto; }}
    #side {{ width: {SIDE}; height: 100%; }}
    .part {{ height: auto; margin-bottom: 1; }}
    """
    ENABLE_COMMAND_PALETTE = False
    BINDINGS: ClassVar[list[BindingType]] = [Binding("q,Q,ctrl+c,ctrl+d,ctrl+q,escape", "leave", priority=True, show=False)]

    def __init__(self, game: ir.Game, session: Session, compiling: Compile, speed: float, waits: bool = False) -> None:
        """`compiling`: run in the background. `speed`: steps a second where nobody is steered. `waits`: no step before it is done."""
        super().__init__()
        self._game, self._session, self._compiling, self._speed = game, session, compiling, speed
        self._looks = make_screen_looks(game)
        self._keys = None if session.agent is None else action_keys(game.agents.actions, game.agents.relative)
        self._pressed: deque[str] = deque()
        self._waits, self._is_ready, self._is_paused = waits, False, False
        self._began = time.monotonic()
        self._made: tuple[Prepared, int] | None = None
        self.fault: Exception | None = None

    def compose(self) -> ComposeResult:
        """Yields the parts of the screen."""
        yield Static(id="title")
        yield Static(id="status")
        with Horizontal():
            with ScrollableContainer(id="board", can_focus=False):
                yield Static(id="map")
            with VerticalScroll(id="side", can_focus=False):
                yield Static(id="scores", classes="part")
                yield Static(id="events", classes="part")
                yield Static(sidebar.legend(self._looks, self._session.agent), id="legend", classes="part")
        yield Container(Static(sidebar.key_line(self._keys, self._game.agents.actions)), id="keys")

    def on_mount(self) -> None:
        """Shows the first picture, and starts compiling behind it."""
        self._show()
        threading.Thread(target=self._compile, name=COMPILING, daemon=True).start()
        self.set_interval(0.2, self._look_after)
        if self._session.agent is None:
            self.set_interval(1 / self._speed, self._tick)
        for name in (signal.SIGTERM, signal.SIGHUP):
            with suppress(ValueError, RuntimeError, NotImplementedError):  # not in the main thread, or not on this system
                asyncio.get_running_loop().add_signal_handler(name, self.exit)

    def action_leave(self) -> None:
        """Ends the session where it is."""
        self.exit()

    def on_key(self, event: events.Key) -> None:
        """Takes a step for each key that stands for an action."""
        event.stop()
        self._pressed.append(event.key)
        self._take_steps()

    def on_paste(self, event: events.Paste) -> None:
        """Takes the steps that a pasted text would be, were it typed."""
        event.stop()
        self._pressed.extend(pasted_keys(event.text))
        self._take_steps()

    def _take_steps(self) -> None:
        """Takes what has been pressed, in order; where steps wait for a policy, it stays pressed until there is one."""
        while self._pressed and (self._is_ready or not self._waits):
            key = self._pressed.popleft()
            if self._session.is_over:
                continue
            if self._keys is None:
                self._is_paused ^= key == "space"
                if key == "right":
                    self._session.step()
            elif key in self._keys:
                self._session.step(self._keys[key])
        self._show()

    def _tick(self) -> None:
        if self._is_shown and not self._is_paused and not self._session.is_over and (self._is_ready or not self._waits):
            self._session.step()
            self._show()

    @property
    def _is_shown(self) -> bool:
        """Whether the screen is there: timers may come once more while it is being taken down."""
        return bool(self.query("#status"))

    def _compile(self) -> None:
        """Runs beside the screen: compiles, and catches up with what has been played meanwhile; `_look_after` finds the outcome."""
        try:
            made = self._compiling()
            taken = 0
            for actions in list(self._session.actions):
                made.player.step(actions)
                taken += 1
            self._made = made, taken
        except Exception as error:
            self.fault = error

    def _look_after(self) -> None:
        """Goes on with the compiled game once there is one, and says until then how long it has been waited for."""
        if not self._is_shown:
            return
        if self.fault is not None:
            self.exit()
        elif self._made is not None and not self._is_ready:
            made, taken = self._made
            self._session.hand_over(made.player, taken, made.choose)
            self._is_ready = True
            self._take_steps()
        self._show_status()

    def _show(self) -> None:
        game, session, moment = self._game, self._session, self._session.moment
        self.query_one("#title", Static).update(Text(f"{game.title or game.name}   step {moment.snapshot.step} of {session.length}"))
        self.query_one("#map", Static).update(board_text(self._looks, moment.snapshot, session.agent))
        self.query_one("#scores", Static).update(sidebar.score_table(game.agents.actions, self._looks, moment, session.agent))
        self.query_one("#events", Static).update(Text(sidebar.event_line(moment)))
        self._show_status()
        self.call_after_refresh(self._follow)

    def _follow(self) -> None:
        """Scrolls a map that is larger than the screen to where the steered agent is."""
        agent, snapshot = self._session.agent, self._session.moment.snapshot
        if agent is not None and snapshot.row[agent] >= 0:
            size = 2 * AROUND + 1
            region = Region(WIDTH * (int(snapshot.col[agent]) - AROUND), int(snapshot.row[agent]) - AROUND, WIDTH * size, size)
            self.query_one("#board", ScrollableContainer).scroll_to_region(region, animate=False)

    def _show_status(self) -> None:
        """Says whose turn it is, and how long the compiled game has been waited for."""
        session, snapshot = self._session, self._session.moment.snapshot
        if session.is_over:
            why = "The episode is over" if session.moment.done else "That was the last step asked for"
            turn = f"{why}; q leaves."
        elif self._waits and not self._is_ready:
            turn = "Steps are taken as soon as the policy is loaded."
        elif session.agent is None:
            turn = "Paused; space goes on." if self._is_paused else f"All agents play, {self._speed:g} steps a second."
        else:
            turn = f"Your turn: agent {session.agent}."
            if snapshot.row[session.agent] < 0:
                turn += " It is away: any key is a step."
            elif snapshot.held[session.agent]:
                turn += " It can only stay."
        waited = "" if self._is_ready else f"  (compiling in the background: {time.monotonic() - self._began:.0f} s)"
        self.query_one("#status", Static).update(Text(turn).append(waited, "dim"))
