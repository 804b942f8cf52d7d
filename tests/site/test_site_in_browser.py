"""The built site in Chromium, where one is installed: search finds, a live board plays, and nothing is asked of any other server."""

import shutil
import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

playwright = pytest.importorskip("playwright.sync_api", reason="make test-browser installs it")
SITE = Path(__file__).parents[2] / "build" / "site"
CHROMIUM = next((path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), None)
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed")
WAIT = 60_000  # milliseconds, at most


class Quiet(SimpleHTTPRequestHandler):
    """Serves the site without a line for each request."""

    def log_message(self, *_said: object) -> None: ...


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(SITE)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}"
    server.shutdown()
    server.server_close()


@pytest.fixture(scope="module")
def page(address: str) -> Iterator[object]:
    """Yields a page; an error of its scripts, a file that is missing or a request to another server fails the module."""
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        opened, wrong = browser.new_page(), list[str]()
        opened.set_default_timeout(WAIT)
        opened.on("pageerror", lambda error: wrong.append(str(error)))
        opened.on("response", lambda answer: wrong.append(answer.url) if answer.status >= 400 else None)
        opened.on("request", lambda asked: wrong.append(asked.url) if not asked.url.startswith((address, "data:", "blob:")) else None)
        yield opened
        browser.close()
    assert wrong == []


def test_search_finds_a_chapter_of_the_manual(page: object, address: str) -> None:
    page.goto(f"{address}/index.html")
    page.get_by_role("textbox", name="Search").click()
    page.get_by_role("textbox", name="Search").fill("glyphs")
    page.locator('.md-search-result__link[href*="language/the-world.html"]').first.wait_for(timeout=WAIT)


def test_search_works_in_pages_opened_from_a_disk(page: object) -> None:
    opened = page.context.browser.new_page()
    opened.goto((SITE / "index.html").as_uri())
    opened.get_by_role("textbox", name="Search").click()
    opened.get_by_text("Type to start searching").wait_for(timeout=WAIT)
    opened.keyboard.type("glyphs")
    opened.locator('.md-search-result__link[href*="language/the-world.html"]').first.wait_for(timeout=WAIT)
    opened.close()


def test_a_live_board_is_stepped_through(page: object, address: str) -> None:
    page.goto(f"{address}/gallery/coins.html")
    board = page.frame_locator("iframe.board").first
    board.locator('[data-part="forward"]').click()
    playwright.expect(board.locator('[data-part="step"]')).to_have_text("step 1", timeout=WAIT)
    page.set_viewport_size({"width": 390, "height": 800})
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
