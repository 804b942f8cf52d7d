"""The built site in Chromium, where one is installed: search finds, live boards play and fit, axe finds nothing, and no other server is asked."""

import shutil
import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

playwright = pytest.importorskip("playwright.sync_api", reason="make test-browser installs it")
SITE = Path(__file__).parents[2] / "build" / "site"
CHROMIUM = next(
    (
        path
        for name in ("chromium", "chromium-browser", "google-chrome")
        if (path := shutil.which(name))
    ),
    None,
)
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
        opened.on(
            "response", lambda answer: wrong.append(answer.url) if answer.status >= 400 else None
        )
        opened.on(
            "request",
            lambda asked: (
                wrong.append(asked.url)
                if not asked.url.startswith((address, "data:", "blob:"))
                else None
            ),
        )
        yield opened
        browser.close()
    assert wrong == []


def test_search_finds_a_chapter_of_the_manual(page: object, address: str) -> None:
    page.goto(f"{address}/index.html")
    page.get_by_role("textbox", name="Search").click()
    page.get_by_role("textbox", name="Search").fill("glyphs")
    page.locator('.md-search-result__link[href*="language/the-world.html"]').first.wait_for(
        timeout=WAIT
    )


def test_a_live_board_is_stepped_through_and_fits(page: object, address: str) -> None:
    page.goto(f"{address}/gallery/coins.html")
    board = page.frame_locator("iframe.board").first
    board.locator('[data-part="forward"]').click()
    playwright.expect(board.locator('[data-part="step"]')).to_have_text("step 1", timeout=WAIT)
    for width in (390, 1440):
        page.set_viewport_size({"width": width, "height": 800})
        page.wait_for_timeout(500)
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        sizes = [
            board.locator(f'[data-part="{name}"]').bounding_box() for name in ("stage", "board")
        ]
        assert sizes[1]["width"] > 0.8 * min(sizes[0]["width"], 11 * 48), (
            "the board fills its pane, or its pictures are as large as they get"
        )
        frame = page.locator("iframe.board").first.bounding_box()
        assert (
            abs(frame["height"] - board.locator("html").evaluate("page => page.offsetHeight")) <= 4
        ), "no empty space, nothing hidden"


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", ["index.html", "gallery/index.html", "gallery/coins.html"])
def test_axe_finds_nothing(name: str, scheme: str, page: object, address: str) -> None:
    axe = pytest.importorskip(
        "axe_playwright_python.sync_playwright", reason="make test-browser installs it"
    ).Axe()
    page.set_viewport_size({"width": 1100, "height": 900})
    page.emulate_media(color_scheme=scheme)
    page.goto(f"{address}/{name}")
    page.locator(".md-code__nav[aria-label]").first.wait_for(
        state="attached"
    ) if name == "index.html" else None
    found = axe.run(page).response["violations"]
    page.emulate_media(color_scheme="light")
    assert [
        (violation["id"], [node["target"] for node in violation["nodes"]]) for violation in found
    ] == []
