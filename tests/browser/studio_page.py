"""The studio's page in a browser, with its real server, for the tests of the studio."""

import contextlib
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Locator, Page, expect

GAME = """sj 1
game yard "Yard" {
  param fine : reward = 1 in 0 .. 5
  episode 50
  kind floor "."
  kind soil "A" { field fruit : { none, ripe } = ripe }
  map { "..A"
        "..." }
  agents 2 {
    acts turn_left, forward, stay
    moves relative
  }
  phase start { each agent { send agent to floor facing north } }
  schedule walk -> eat
  phase walk { move each agent }
  phase eat { each agent on soil where soil.fruit is ripe { give fine to agent  set soil.fruit = none } }
  observe { window ahead 1, behind 1, left 1, right 1 }
  checks { always count(soil where soil.fruit is ripe) <= count(soil) }
  policy idler { when 1 > 0 choose stay }
}
"""


class Studio:
    """A server of a folder. `address`: of its page; options: further ones of the command."""

    def __init__(self, folder: Path, port: int = 0, options: Sequence[str] = ()) -> None:
        command = [
            sys.executable,
            "-m",
            "sjdsl",
            "studio",
            "yard.sj",
            "--no-browser",
            "--port",
            str(port),
            *options,
        ]
        environment = os.environ | {"XDG_CACHE_HOME": str(folder / ".cache")}
        self.folder = folder
        self.process = subprocess.Popen(
            command,
            cwd=folder,
            stdout=subprocess.PIPE,
            text=True,
            env=environment,
            start_new_session=True,
        )
        assert self.process.stdout is not None
        self.address = re.findall(r"http\S+", self.process.stdout.readline())[0]
        self.port = int(re.findall(r":(\d+)/", self.address)[0])

    def stop(self) -> None:
        with contextlib.suppress(ProcessLookupError):  # a test may have stopped it before
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()


@pytest.fixture
def studio(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[Studio]:
    """Returns a server of a folder with a game; a test's parameters are options of the command."""
    (tmp_path / "yard.sj").write_text(GAME, encoding="utf-8")
    started = Studio(tmp_path, options=getattr(request, "param", ()))
    yield started
    started.stop()


@pytest.fixture
def opened(browser: Browser, studio: Studio) -> Iterator[Page]:
    """Returns the studio's page once its board is there; an error of its scripts fails the test."""
    context = browser.new_context(viewport={"width": 1400, "height": 900}, accept_downloads=True)
    page, wrong = context.new_page(), list[str]()
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on(
        "request",
        lambda request: (
            wrong.append(request.url)
            if "127.0.0.1" not in request.url and request.url.startswith("http")
            else None
        ),
    )
    page.set_default_timeout(60_000)
    expect.set_options(timeout=60_000)
    page.goto(studio.address)
    page.locator("body[data-compiles=true]").wait_for()
    yield page
    context.close()
    assert wrong == []


def part(page: Page, name: str) -> Locator:
    return page.locator(f'[data-part="{name}"]')


def open_game(page: Page, path: str) -> None:
    """Opens a game in the window that lists them."""
    part(page, "files").click()
    page.locator(f'dialog [data-path="{path}"]').click()


def type_over(page: Page, text: str) -> None:
    """Replaces the whole text, as a person who pastes does, and waits until the studio has read it."""
    before = page.evaluate("Number(document.body.dataset.version)")
    page.locator(".text .cm-content").click()
    page.keyboard.press("Control+a")
    page.keyboard.insert_text(text)
    page.wait_for_function("before => Number(document.body.dataset.version) > before", arg=before)
