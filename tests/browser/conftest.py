"""A headless Chromium for the tests of pages: the one that is installed, no download."""

import shutil
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

NAMES = ("chromium", "chromium-browser", "google-chrome")


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Returns the browser of all tests."""
    path = next((found for name in NAMES if (found := shutil.which(name))), None)
    assert path is not None, "these tests want Chromium: apt-get install chromium"
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(
            executable_path=path, args=["--no-sandbox"]
        )  # containers run tests as root
        yield started
        started.close()


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    """Returns an empty page without a network; an error of its scripts, or a request to anywhere, fails the test."""
    context = browser.new_context(viewport={"width": 1200, "height": 800}, offline=True)
    opened, wrong = context.new_page(), list[str]()
    opened.on("pageerror", lambda error: wrong.append(str(error)))
    opened.on(
        "console", lambda message: wrong.append(message.text) if message.type == "error" else None
    )
    opened.on(
        "request",
        lambda request: wrong.append(request.url) if request.url.startswith("http") else None,
    )
    yield opened
    context.close()
    assert wrong == []
