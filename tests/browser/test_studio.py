"""The studio in a browser, with its real server: text, board, keys, panels, files, and what happens when the server is gone."""

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
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
    """A server of a folder. `address`: of its page."""

    def __init__(self, folder: Path, port: int = 0) -> None:
        command = [sys.executable, "-m", "sjdsl", "studio", "yard.sj", "--no-browser", "--port", str(port)]
        environment = os.environ | {"XDG_CACHE_HOME": str(folder / ".cache")}
        self.folder = folder
        self.process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True, env=environment, start_new_session=True)
        assert self.process.stdout is not None
        self.address = re.findall(r"http\S+", self.process.stdout.readline())[0]
        self.port = int(re.findall(r":(\d+)/", self.address)[0])

    def stop(self) -> None:
        os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()


@pytest.fixture
def studio(tmp_path: Path) -> Iterator[Studio]:
    (tmp_path / "yard.sj").write_text(GAME, encoding="utf-8")
    started = Studio(tmp_path)
    yield started
    started.stop()


@pytest.fixture
def opened(browser: Browser, studio: Studio) -> Iterator[Page]:
    """Returns the studio's page once its board is there; an error of its scripts fails the test."""
    context = browser.new_context(viewport={"width": 1400, "height": 900}, accept_downloads=True)
    page, wrong = context.new_page(), list[str]()
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on(
        "request", lambda request: wrong.append(request.url) if "127.0.0.1" not in request.url and request.url.startswith("http") else None
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


def type_over(page: Page, text: str) -> None:
    """Replaces the whole text, as a person who pastes does."""
    page.locator(".cm-content").click()
    page.keyboard.press("Control+a")
    page.keyboard.insert_text(text)


def test_a_mistake_is_told_and_its_repair_changes_the_board(opened: Page) -> None:
    type_over(opened, GAME.replace("kind floor", "kind flor"))
    expect(part(opened, "verdict")).to_contain_text("error")
    expect(opened.locator(".cm-lintRange-error").first).to_be_visible()
    before = part(opened, "board").evaluate("board => board.height / board.width")
    type_over(opened, GAME.replace('"..." }', '"..." "..." "..." }'))
    expect(part(opened, "verdict")).to_have_text("")
    opened.wait_for_timeout(500)
    assert part(opened, "board").evaluate("board => board.height / board.width") > before


def test_the_board_plays_back_and_forth(opened: Page) -> None:
    for _ in range(3):
        part(opened, "forward").click()
    expect(part(opened, "step")).to_have_text("step 3")
    part(opened, "back").click()
    expect(part(opened, "step")).to_have_text("step 2")
    part(opened, "scrub").fill("0")
    expect(part(opened, "step")).to_have_text("step 0")
    part(opened, "run").click()
    expect(part(opened, "step")).to_contain_text("the episode is over")
    part(opened, "again").click()
    expect(part(opened, "step")).to_have_text("step 0")


def test_an_agent_is_driven_by_keys(opened: Page) -> None:
    part(opened, "others").select_option("stay")
    part(opened, "driven").select_option("1")
    part(opened, "board").focus()
    opened.keyboard.press("ArrowLeft")
    expect(part(opened, "step")).to_have_text("step 1")
    actions = [row.locator("td").nth(1).inner_text() for row in part(opened, "agents").locator("tr").all()]
    assert actions == ["stay", "turn_left"]


def test_a_cell_is_asked_why_it_is_as_it_is(opened: Page) -> None:
    part(opened, "others").select_option("stay")
    box = part(opened, "board").bounding_box()
    assert box is not None
    side = box["width"] / 3
    state = opened.locator('[data-panel="state"]')
    state.click()
    expect(part(opened, "panel")).to_contain_text("Agent 1")
    places = [text.split("\t")[-1] for text in part(opened, "panel").locator("tr", has_text="place").all_inner_texts()]
    row, col = map(int, re.findall(r"\d+", places[0]))
    opened.mouse.move(box["x"] + (col + 0.5) * side, box["y"] + (row + 0.5) * side)
    opened.mouse.down()
    opened.mouse.move(box["x"] + 2.5 * side, box["y"] + 0.5 * side, steps=3)
    opened.mouse.up()
    expect(part(opened, "panel")).to_contain_text("(0, 2)")
    part(opened, "forward").click()
    opened.mouse.click(box["x"] + 2.5 * side, box["y"] + 0.5 * side)
    opened.locator('[data-panel="why"]').click()
    expect(part(opened, "panel")).to_contain_text("fruit: ripe -> none")
    part(opened, "panel").locator(".rule", has_text="set soil.fruit = none").click()
    assert "phase eat" in opened.locator(".cm-activeLine").inner_text()


def test_a_painted_cell_changes_the_map_in_the_text(opened: Page) -> None:
    part(opened, "glyph").select_option("A")
    box = part(opened, "board").bounding_box()
    assert box is not None
    side = box["width"] / 3
    opened.mouse.move(box["x"] + 0.5 * side, box["y"] + 1.5 * side)
    opened.mouse.down()
    opened.mouse.move(box["x"] + 1.5 * side, box["y"] + 1.5 * side, steps=2)
    opened.mouse.up()
    expect(opened.locator(".cm-content")).to_contain_text('"AA."')
    expect(part(opened, "verdict")).to_have_text("")
    expect(part(opened, "save")).to_be_enabled()


def test_panels_are_of_the_text_as_it_is(opened: Page) -> None:
    expect(part(opened, "panel")).to_contain_text("The rules of the game yard")
    opened.locator('[data-panel="python"]').click()
    expect(part(opened, "panel")).to_contain_text("params.fine")
    type_over(opened, GAME.replace("fine", "bonus"))
    expect(part(opened, "panel")).to_contain_text("params.bonus")
    opened.locator('[data-panel="checks"]').click()
    expect(part(opened, "panel")).to_contain_text("passed")


def test_an_episode_is_exported_and_opened_without_the_studio(opened: Page, studio: Studio, browser: Browser) -> None:
    part(opened, "forward").click()
    expect(part(opened, "step")).to_have_text("step 1")
    with opened.expect_download() as download:
        part(opened, "share").click()
    path = studio.folder / "shared.html"
    download.value.save_as(path)
    studio.stop()
    alone = browser.new_page()
    alone.goto(path.as_uri())
    expect(part(alone, "step")).to_have_text("step 0")
    part(alone, "forward").click()
    expect(part(alone, "step")).to_have_text("step 1")
    alone.close()


def test_the_page_comes_back_with_the_server(opened: Page, studio: Studio) -> None:
    type_over(opened, GAME.replace("Yard", "Garden"))
    expect(part(opened, "title")).to_have_text("Garden")
    studio.stop()
    expect(part(opened, "lost")).to_be_visible()
    again = Studio(studio.folder, studio.port)
    try:
        expect(part(opened, "lost")).to_be_hidden()
        part(opened, "forward").click()
        expect(part(opened, "step")).to_have_text("step 1")
        expect(part(opened, "title")).to_have_text("Garden")
    finally:
        again.stop()
        studio.process = again.process


def test_saving_writes_the_file_and_nothing_of_others(opened: Page, studio: Studio) -> None:
    path = studio.folder / "yard.sj"
    expect(part(opened, "save")).to_be_disabled()
    type_over(opened, GAME.replace("Yard", "Mine"))
    part(opened, "save").click()
    expect(part(opened, "save")).to_be_disabled()
    assert '"Mine"' in path.read_text(encoding="utf-8")
    path.write_text(GAME.replace("Yard", "Theirs"), encoding="utf-8")
    type_over(opened, GAME.replace("Yard", "Mine again"))
    part(opened, "save").click()
    expect(part(opened, "message")).to_contain_text("changed by somebody else")
    assert '"Theirs"' in path.read_text(encoding="utf-8")
    opened.get_by_role("button", name="Write mine over it").click()
    expect(part(opened, "save")).to_be_disabled()
    assert '"Mine again"' in path.read_text(encoding="utf-8")


def test_an_example_is_opened_and_saved_as_a_copy(opened: Page, studio: Studio) -> None:
    part(opened, "files").select_option("example:harvest_closed.sj")
    expect(part(opened, "title")).to_have_text("Commons Harvest: Closed")
    expect(part(opened, "verdict")).to_have_text("")
    opened.locator(".cm-content").press("Control+End")
    opened.keyboard.insert_text("# mine\n")
    part(opened, "save").click()
    opened.get_by_label("Name of the copy").fill("closed.sj")
    opened.get_by_role("button", name="Save a copy").click()
    expect(part(opened, "files")).to_have_value("closed.sj")
    assert "# mine" in (studio.folder / "closed.sj").read_text(encoding="utf-8")
    expect(part(opened, "title")).to_have_text("Commons Harvest: Closed")


def test_of_two_hundred_fast_edits_the_last_is_shown(opened: Page) -> None:
    opened.locator(".cm-content").click()
    for number in range(200):
        title = f'game yard "Yard {number}" {{'
        type_over(opened, GAME.replace('game yard "Yard" {', title))
    expect(part(opened, "title")).to_have_text("Yard 199")
    opened.wait_for_timeout(1000)
    expect(part(opened, "title")).to_have_text("Yard 199")
    expect(part(opened, "verdict")).to_have_text("")
    assert opened.locator(".cm-lintRange-error").count() == 0


def test_texts_of_a_game_run_nothing(opened: Page) -> None:
    sly = '<img src=x onerror=\\"document.title=1\\"><script>document.title=2</script>'
    type_over(
        opened,
        GAME.replace("Yard", sly.replace('\\"', "'")).replace(
            "policy idler", 'about summary "' + sly.replace('\\"', "'") + '"\n  policy idler'
        ),
    )
    expect(part(opened, "verdict")).to_have_text("")
    expect(part(opened, "panel")).to_contain_text("The rules of the game yard")
    opened.wait_for_timeout(500)
    assert opened.title() == "yard.sj · sjdsl studio"
    assert part(opened, "panel").locator("img, script").count() == 0
