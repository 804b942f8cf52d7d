"""The screen, through textual's own pilot: one key is one step, however fast keys come, and what a person sees."""

import asyncio
import threading
from collections.abc import Awaitable, Callable, Coroutine
from typing import Any

import pytest
from textual import events
from textual.geometry import Size
from textual.pilot import Pilot
from textual.widgets import Static

from sjdsl.compiler import ir
from sjdsl.interpreter.state import default_params
from sjdsl.screen.app import Screen
from sjdsl.screen.keys import action_keys, describe_keys, pasted_keys
from sjdsl.screen.session import Interpreted, Prepared, Session, written_choice
from tests.screen.conftest import Begin

Steps = Callable[[Screen, Pilot[None]], Awaitable[None]]
UP = "\x1b[A"


class Compiler:
    """What is compiled in the background, done when a test says so; a player of the interpreter stands for the compiled game."""

    def __init__(self, game: ir.Game, fault: Exception | None = None, choose: Any = None) -> None:
        self._game, self._fault, self._choose = game, fault, choose
        self.done = threading.Event()

    def __call__(self) -> Prepared:
        assert self.done.wait(20)
        if self._fault is not None:
            raise self._fault
        return Prepared(Interpreted(self._game, default_params(self._game), 3), self._choose)


def played(screen: Screen, steps: Callable[[Pilot[None]], Coroutine[Any, Any, None]], size: tuple[int, int] = (100, 30)) -> None:
    """Runs a screen without a terminal and does something in it."""

    async def run() -> None:
        async with screen.run_test(size=size) as pilot:
            await pilot.pause()
            await steps(pilot)

    asyncio.run(run())


def text_of(pilot: Pilot[None], part: str) -> str:
    """Returns what a part of the screen says, as it is drawn."""
    widget = pilot.app.query_one(part, Static)
    return "\n".join(strip.text.rstrip() for strip in widget.render_lines(Size(widget.size.width, widget.size.height).region))


async def until(pilot: Pilot[None], holds: Callable[[], bool]) -> None:
    """Waits for the thread in the background, or for the screen."""
    for _ in range(200):
        await pilot.pause(0.02)
        if holds():
            return
    raise AssertionError("it never came")


def test_six_quick_keys_are_six_steps(begin: Begin, orchard: ir.Game) -> None:
    """As the reader of keys hands them over: all in one go, before any is answered."""
    session, compiler = begin(), Compiler(orchard)

    async def steps(pilot: Pilot[None]) -> None:
        assert "step 0 of 12" in text_of(pilot, "#title")
        for _ in range(6):
            pilot.app.post_message(events.Key("up", None))
        await pilot.pause()
        assert "step 6 of 12" in text_of(pilot, "#title")
        pilot.app.post_message(events.Paste(UP * 2 + "1z"))
        await pilot.pause()
        assert "step 9 of 12" in text_of(pilot, "#title"), "z is no key"
        compiler.done.set()

    played(Screen(orchard, session, compiler, 8.0), steps)
    assert [step[0] for step in session.actions] == [2] * 8 + [4]


def test_what_a_person_sees(begin: Begin, orchard: ir.Game) -> None:
    session, compiler = begin(), Compiler(orchard)

    async def steps(pilot: Pilot[None]) -> None:
        assert "Your turn: agent 0." in text_of(pilot, "#status")
        assert "compiling in the background" in text_of(pilot, "#status")
        assert len(text_of(pilot, "#map").splitlines()) == 4
        assert "▲0 you" in text_of(pilot, "#scores")
        assert "soil, ripe" in text_of(pilot, "#legend")
        for said in ("↑ forward", "space stay", "1 enter sing", "q quit"):
            assert said in text_of(pilot, "#keys Static")
        compiler.done.set()
        await until(pilot, lambda: "compiling" not in text_of(pilot, "#status"))
        await pilot.press("left", "up")  # agent 0 begins beside a tree and faces north
        assert "forward" in text_of(pilot, "#scores")
        assert "+1" in text_of(pilot, "#scores")
        assert "eaten 1" in text_of(pilot, "#events")
        await pilot.press("1")
        assert "It can only stay." in text_of(pilot, "#status")
        while not session.is_over:
            await pilot.press("space")
        await pilot.press("space")
        assert "The episode is over; q leaves." in text_of(pilot, "#status")
        await pilot.press("q")

    played(Screen(orchard, session, compiler, 8.0), steps)
    assert len(session.actions) == 12


def test_steps_go_on_where_the_compiled_game_takes_over(begin: Begin, orchard: ir.Game) -> None:
    session, compiler = begin(), Compiler(orchard)
    before = session.player

    async def steps(pilot: Pilot[None]) -> None:
        await pilot.press("up", "up")
        compiler.done.set()
        await until(pilot, lambda: session.player is not before)
        await pilot.press("up")
        assert "step 3" in text_of(pilot, "#title")

    played(Screen(orchard, session, compiler, 8.0), steps)
    assert session.moment.snapshot.step == 3


def test_with_a_trained_policy_keys_wait_for_it(begin: Begin, orchard: ir.Game) -> None:
    session, compiler = begin(), Compiler(orchard, choose=written_choice([[2, 0], [2, 1]]))

    async def steps(pilot: Pilot[None]) -> None:
        await pilot.press("up", "up")
        assert session.actions == []
        assert "as soon as the policy is loaded" in text_of(pilot, "#status")
        compiler.done.set()
        await until(pilot, lambda: len(session.actions) == 2)

    played(Screen(orchard, session, compiler, 8.0, waits=True), steps)
    assert session.actions == [(2, 0), (2, 1)]


def test_what_fails_in_the_background_closes_the_screen(begin: Begin, orchard: ir.Game) -> None:
    fault = ValueError("no such policy")
    compiler = Compiler(orchard, fault)
    screen = Screen(orchard, begin(), compiler, 8.0)

    async def steps(pilot: Pilot[None]) -> None:
        compiler.done.set()
        await until(pilot, lambda: screen.fault is fault and not screen.is_running)

    played(screen, steps)


def test_watching_can_be_paused(begin: Begin, orchard: ir.Game) -> None:
    session, compiler = begin(agent=None), Compiler(orchard)

    async def steps(pilot: Pilot[None]) -> None:
        await pilot.press("space")
        assert "Paused" in text_of(pilot, "#status")
        taken = len(session.actions)
        await pilot.press("right", "right")
        assert len(session.actions) == taken + 2
        await pilot.press("space")
        assert "All agents play" in text_of(pilot, "#status")
        compiler.done.set()

    played(Screen(orchard, session, compiler, 0.5), steps)


def test_what_is_watched_goes_on_by_itself(begin: Begin, orchard: ir.Game) -> None:
    session, compiler = begin(agent=None), Compiler(orchard)

    async def steps(pilot: Pilot[None]) -> None:
        await until(pilot, lambda: session.is_over)
        compiler.done.set()

    played(Screen(orchard, session, compiler, 100.0), steps)
    assert session.moment.done


def test_a_map_larger_than_the_screen_follows_the_agent(orchard: ir.Game) -> None:
    wide = orchard.model_copy(update={"rows": tuple(row[:-1] + row[1] * 60 + row[-1] for row in orchard.rows)})
    session = Session(Interpreted(wide, default_params(wide), 3), written_choice([[3, 3]]), 0, 12)
    compiler = Compiler(wide)

    async def steps(pilot: Pilot[None]) -> None:
        column, board = session.moment.snapshot.col[0], pilot.app.query_one("#board")
        # the map is laid out first, and then scrolled
        await until(pilot, lambda: board.scroll_offset.x <= 2 * column < board.scroll_offset.x + board.size.width)
        compiler.done.set()

    played(Screen(wide, session, compiler, 8.0), steps, size=(70, 20))


@pytest.mark.parametrize(
    ("relative", "names", "left", "comma"),
    [
        (True, ("turn_left", "step_left", "stay"), "turn_left", "step_left"),
        (False, ("turn_left", "step_left", "stay"), "step_left", "turn_left"),
        (True, ("step_left", "stay"), "step_left", None),
    ],
)
def test_arrows_go_where_they_point(relative: bool, names: tuple[str, ...], left: str, comma: str | None) -> None:
    keys = action_keys(names, relative)
    assert names[keys["left"]] == left
    assert (names[keys["comma"]] if comma else keys.get("comma")) == comma


def test_own_actions_have_digits_then_letters() -> None:
    names = ("stay", *(f"own{number}" for number in range(1, 28)))
    keys = action_keys(names, True)
    assert [names[keys[key]] for key in ("1", "9", "a", "enter", "r")] == ["own1", "own9", "own10", "own1", "own26"]
    assert "q" not in keys
    assert describe_keys(keys, names)[:2] == [("space", "stay"), ("1 enter", "own1")]


def test_a_pasted_text_is_its_keys() -> None:
    assert list(pasted_keys("\x1b[A\x1bOD,. 1\n")) == ["up", "left", "comma", "full_stop", "space", "1", "enter"]
