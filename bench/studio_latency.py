"""Measures `sjdsl studio` in headless Chromium: the time from a keystroke to the new board, and the time
to the first page.

    python bench/studio_latency.py --keystrokes 40

It needs requirements-browser.txt and the system's Chromium. An answer is timed from the key going down
until the page has the new game and has drawn its board. The first page is timed from the request until
the board of its game is drawn; the server has started four seconds before.
"""

import argparse
import os
import re
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from paper.published import suite  # bench/paper, beside this script
from playwright.sync_api import Page, sync_playwright

LOADED = 4.0  # seconds that a server has before its first page
WATCH = """() => {
  window.answers = [];
  let pressed = null;
  document.addEventListener("keydown", () => { pressed = performance.now(); }, true);
  new MutationObserver(() => {
    if (pressed === null) return;
    const began = pressed;
    pressed = null;
    requestAnimationFrame(() => window.answers.push(performance.now() - began));
  }).observe(document.body, { attributes: true, attributeFilter: ["data-version"] });
}"""


@contextmanager
def served(game: str) -> Iterator[str]:
    """Yields the address of a studio with a bundled game."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "sjdsl", "studio", game, "--no-browser", "--port", "0"]
        environment = os.environ | {"XDG_CACHE_HOME": str(Path(folder) / "cache")}
        server = subprocess.Popen(
            command, cwd=folder, stdout=subprocess.PIPE, text=True, env=environment, process_group=0
        )
        try:
            assert server.stdout is not None
            yield re.findall(r"http\S+", server.stdout.readline())[0]
        finally:
            os.killpg(server.pid, signal.SIGKILL)
            server.wait()


def first_page(page: Page, address: str) -> float:
    """Returns the seconds until the board is drawn."""
    start = time.perf_counter()
    page.goto(address)
    page.locator("body[data-compiles=true]").wait_for(timeout=120_000)
    page.evaluate("() => new Promise(requestAnimationFrame)")
    return time.perf_counter() - start


def keystrokes(page: Page, count: int, pause: float) -> list[float]:
    """Returns the milliseconds until the response to each letter typed into a comment at the top."""
    page.locator(".cm-line").first.click()
    page.keyboard.press("End")
    page.keyboard.type("  # ", delay=300)
    page.wait_for_timeout(3000)
    page.evaluate(WATCH)
    for number in range(count):
        page.keyboard.press("abcdefghij"[number % 10])
        page.wait_for_function(
            "wanted => window.answers.length >= wanted", arg=number + 1, timeout=60_000
        )
        page.wait_for_timeout(1000 * pause)
    return list(page.evaluate("window.answers"))


def main() -> None:
    """Prints a row of a Markdown table for each game."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--games", default=",".join(suite()))
    parser.add_argument("--keystrokes", type=int, default=40)
    parser.add_argument(
        "--pause", type=float, default=0.25, help="seconds between an answer and the next key"
    )
    arguments = parser.parse_args()
    browsers = map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))
    path = next(browser for browser in browsers if browser)
    print(f"{os.cpu_count()} processors, load {os.getloadavg()[0]:.1f} at the start\n")
    print(
        "| game | keystroke to answer, median | fastest | 9 of 10 within | first page |\n"
        "|---|---|---|---|---|"
    )
    medians = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        for game in arguments.games.split(","):
            with served(game) as address:
                time.sleep(LOADED)
                page = browser.new_page(viewport={"width": 1400, "height": 900})
                seconds = first_page(page, address)
                answers = keystrokes(page, arguments.keystrokes, arguments.pause)
                page.close()
            medians.append(statistics.median(answers))
            ninth_decile = statistics.quantiles(answers, n=10)[-1]
            print(
                f"| {game} | {medians[-1]:.0f} ms | {min(answers):.0f} ms "
                f"| {ninth_decile:.0f} ms | {seconds:.1f} s |",
                flush=True,
            )
        browser.close()
    print(
        f"\nmedian of the games {statistics.median(medians):.0f} ms; "
        f"load {os.getloadavg()[0]:.1f} at the end"
    )


if __name__ == "__main__":
    main()
