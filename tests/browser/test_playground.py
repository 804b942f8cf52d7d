"""The playground: the studio's page without its server. A mistake is seen and mended, the board plays, files stay in the browser."""

import runpy
import shutil
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.browser.studio_page import open_game, part

ROOT = Path(__file__).parents[2]
BUILT = ROOT / "build" / "playground"
LOADED = (
    180_000  # milliseconds that Python may take to load on a machine that does other things, too
)

pytestmark = pytest.mark.skipif(
    not (BUILT / "index.html").is_file(), reason="`make playground` builds it"
)


class Quiet(SimpleHTTPRequestHandler):
    """Gives files, and says nothing."""

    extensions_map = SimpleHTTPRequestHandler.extensions_map | {
        ".mjs": "text/javascript",
        ".wasm": "application/wasm",
    }

    def log_message(self, *_: object) -> None:
        """Keeps quiet."""


class Public(Quiet):
    """Gives files to pages of any server, as a network for files does."""

    def end_headers(self) -> None:
        """Adds what lets other pages have the files."""
        self.send_header("Access-Control-Allow-Origin", "*")
        super().end_headers()


@contextmanager
def served(folder: Path, handler: type[Quiet] = Quiet) -> Iterator[str]:
    """Gives the files of a folder; yields the address."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(handler, directory=str(folder)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}"
    server.shutdown()
    server.server_close()


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    with served(BUILT) as url:
        yield url


@pytest.fixture(scope="module")
def playground(browser: Browser, address: str) -> Iterator[Page]:
    """Returns the page with everything loaded. A request to another place, or an error of a script, fails the test."""
    context = browser.new_context(viewport={"width": 1400, "height": 900})
    page, wrong = context.new_page(), list[str]()
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on(
        "request",
        lambda request: (
            None
            if request.url.startswith((address, "data:", "blob:"))
            else wrong.append(request.url)
        ),
    )
    page.goto(address)
    page.locator("body[data-compiles=true]").wait_for(timeout=LOADED)
    yield page
    context.close()
    assert wrong == []


def write(page: Page, at: str, text: str) -> None:
    """Writes a text at the end of the first line that contains `at`."""
    page.locator(".cm-line", has_text=at).first.click()
    page.keyboard.press("End")
    page.keyboard.insert_text(text)


def test_the_tour_its_game_and_a_board_are_there_before_python(
    browser: Browser, address: str
) -> None:
    page = browser.new_page()
    page.route("**/worker.js", lambda _route: None)  # it never comes
    page.goto(address)
    expect(part(page, "title")).to_have_text("Berries")
    expect(part(page, "panel")).to_contain_text("A tour")
    expect(page.locator(".text .cm-content")).to_contain_text("kind bush")
    expect(part(page, "agents").locator("tr")).to_have_count(2)
    part(page, "forward").click()
    expect(part(page, "message")).to_have_text("Loading…")
    page.close()


def test_a_mistake_is_seen_and_mended(playground: Page) -> None:
    write(playground, "phase walk", " mistake")
    expect(part(playground, "verdict")).to_contain_text("error", timeout=30_000)
    playground.locator(".cm-lintRange-error").first.wait_for(
        timeout=LOADED
    )  # the language server comes after the board
    for _ in " mistake":
        playground.keyboard.press("Backspace")
    expect(part(playground, "verdict")).to_have_text("", timeout=30_000)


def test_what_an_agent_sees_is_read_as_a_model_reads_it(playground: Page) -> None:
    playground.locator('[data-panel="seen"]').click()
    part(playground, "panel").get_by_text("As a language model sees it").click()
    message = part(playground, "panel").locator("details pre")
    expect(message).to_contain_text("WHAT YOU SEE NOW:", timeout=30_000)


def test_it_offers_nobody_who_would_need_a_seat(playground: Page) -> None:
    names = part(playground, "others").locator("option")
    expect(names.first).to_have_attribute("value", "random")
    expect(part(playground, "others").locator('[value="RUN@best"]')).to_have_count(0)


def test_a_copy_is_kept_and_can_be_downloaded(playground: Page) -> None:
    open_game(playground, "example:coins.sj")
    expect(part(playground, "title")).to_have_text("Coins", timeout=LOADED)
    write(playground, "sj 1", "\n# mine")
    part(playground, "save").click()
    playground.locator("dialog").get_by_role("button", name="Save").click()
    expect(part(playground, "name")).to_have_text("coins.sj", timeout=30_000)
    expect(part(playground, "save")).to_be_disabled()
    with playground.expect_download() as download:
        playground.locator("#download").click()
    assert "# mine" in download.value.path().read_text(encoding="utf-8")
    playground.reload()
    expect(part(playground, "title")).to_have_text("Coins", timeout=LOADED)
    expect(playground.locator(".cm-line", has_text="# mine")).to_be_visible(timeout=30_000)


def test_what_takes_too_long_is_stopped_and_python_begins_again(playground: Page) -> None:
    playground.evaluate("studioTransport.seconds.step = 0")
    part(playground, "forward").click()
    expect(part(playground, "message")).to_contain_text("was stopped", timeout=30_000)
    playground.evaluate("studioTransport.seconds.step = 60")
    expect(playground.locator("body")).to_have_attribute("data-compiles", "true")
    part(playground, "forward").click(timeout=LOADED)
    expect(part(playground, "step")).to_have_text("step 1", timeout=LOADED)


def test_a_language_server_that_begins_again_ends_the_one_before(playground: Page) -> None:
    """Each has a Python: pages on a slow machine, which lose patience, must not collect them."""
    before = len(playground.workers)
    with playground.expect_event("worker"):
        playground.evaluate("void studioTransport.openSocket('/language')")
    for _ in range(100):
        if len(playground.workers) == before:
            break
        playground.wait_for_timeout(100)
    assert len(playground.workers) == before


@pytest.mark.parametrize("damaged", ["", "pyodide.mjs", "pyodide.asm.wasm"])
def test_pyodide_comes_from_another_server_and_is_checked(
    browser: Browser, tmp_path: Path, damaged: str
) -> None:
    """The build leaves Pyodide out. What that server gives is taken if it is what the build had, and refused by name if a byte differs."""
    build, package = (
        runpy.run_path(str(ROOT / "editors/playground/build.py")),
        ROOT / "editors/playground/node_modules/pyodide",
    )
    elsewhere, out = tmp_path / "elsewhere", tmp_path / "playground"
    elsewhere.mkdir()
    for name in build["PYODIDE"]:
        shutil.copy(package / name, elsewhere)
    shutil.copytree(BUILT, out, ignore=shutil.ignore_patterns("pyodide", "pyodide.js"))
    with served(elsewhere, Public) as place, served(out) as url:
        said = build["put_pyodide"](out, package, place)
        assert said.endswith("Its 5 files there are those of npm.")
        if damaged:
            content = bytearray((elsewhere / damaged).read_bytes())
            content[-1] ^= 1
            (elsewhere / damaged).write_bytes(content)
        page, asked = browser.new_page(), list[str]()
        page.on("request", lambda request: asked.append(request.url))
        page.goto(url)
        if damaged:
            refused = f"Python could not be started: {place}/{damaged} cannot be loaded, or is not the file"
            expect(part(page, "message")).to_contain_text(refused, timeout=LOADED)
        else:
            page.locator("body[data-compiles=true]").wait_for(timeout=LOADED)
            names = {name for name in asked if name.startswith(place)}
            assert names == {f"{place}/{path.name}" for path in elsewhere.iterdir()}
        page.close()
