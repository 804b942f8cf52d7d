"""The studio in a browser, with its real server: text, board, keys, panels, and what happens when the server is gone."""

import json
import re
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, WebSocketRoute, expect

from tests.browser.studio_page import (
    GAME,
    Studio,
    open_game,
    opened,
    part,
    studio,
    type_over,
)

__all__ = ["opened", "studio"]  # fixtures


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
    actions = [
        row.locator("td").nth(1).inner_text() for row in part(opened, "agents").locator("tr").all()
    ]
    assert actions == ["stay", "turn_left"]


def test_a_cell_is_asked_why_it_is_as_it_is(opened: Page) -> None:
    part(opened, "others").select_option("stay")
    box = part(opened, "board").bounding_box()
    assert box is not None
    side = box["width"] / 3
    state = opened.locator('[data-panel="state"]')
    state.click()
    expect(part(opened, "panel")).to_contain_text("Agent 1")
    places = [
        text.split("\t")[-1]
        for text in part(opened, "panel").locator("tr", has_text="place").all_inner_texts()
    ]
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
    opened.locator(".cm-line", has_text="phase eat").click()
    opened.locator('[data-panel="python"]').click()
    expect(part(opened, "panel").locator(".here", has_text="params.fine")).to_be_visible()
    type_over(opened, GAME.replace("fine", "bonus"))
    opened.locator(".text .cm-line", has_text="phase eat").click()
    expect(part(opened, "panel").locator(".here", has_text="params.bonus")).to_be_visible()
    opened.locator('[data-panel="checks"]').click()
    expect(part(opened, "panel")).to_contain_text("passed")


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


@pytest.mark.parametrize("studio", [("--slots", "stay,you")], indirect=True)
def test_a_person_plays_from_a_seat(opened: Page) -> None:
    """Who sits where stands at the board; the person's keys act at once, and the episode is recorded."""
    names = part(opened, "agents").locator("td:first-child")
    expect(names).to_have_text(["0 stay", "1 you"])
    expect(part(opened, "driven")).to_be_disabled()
    part(opened, "forward").click()
    expect(part(opened, "message")).to_contain_text("you play agent 1")
    part(opened, "board").focus()
    opened.keyboard.press("ArrowLeft")
    expect(part(opened, "step")).to_have_text("step 1")
    actions = part(opened, "agents").locator("td:nth-child(2)")
    expect(actions).to_have_text(["stay", "turn_left"])
    with opened.expect_download() as download:
        part(opened, "record").click()
    recorded = json.loads(download.value.path().read_text())
    assert (recorded["players"], recorded["actions"]) == (["stay", "you"], [[2, 0]])


def test_the_command_says_variant_and_number_of_agents(tmp_path: Path, browser: Browser) -> None:
    """They hold whenever its game is opened, and in no other."""
    text = GAME.replace("  param fine", "  size crew : count = 2 in 1 .. 3\n  param fine")
    text = text.replace("agents 2", "agents crew")
    text = text.replace("episode 50", "param length : steps = 50\n  episode length")
    variants = "  variant dear { set fine = 2 }\n  variant short { set length = 9 }\n"
    text = text.replace("  policy", f"{variants}  policy")
    for name in ("yard.sj", "other.sj"):
        (tmp_path / name).write_text(text, encoding="utf-8")
    options = ("--variant", "dear+short", "--agents", "3", "--slots", "stay,file,you")
    studio = Studio(tmp_path, options=options)
    page = browser.new_page()
    page.goto(studio.address)
    names = part(page, "agents").locator("td:first-child")
    expect(names).to_have_text(["0 stay", "1 idler", "2 you"], timeout=60_000)
    expect(part(page, "variant")).to_have_value("dear+short")
    expect(part(page, "crew")).to_have_value("3")
    open_game(page, "other.sj")
    expect(names).to_have_text(["0", "1"], timeout=60_000)
    expect(part(page, "variant")).to_have_value("")
    open_game(page, "yard.sj")
    expect(names).to_have_text(["0 stay", "1 idler", "2 you"], timeout=60_000)
    expect(part(page, "variant")).to_have_value("dear+short")
    page.close()
    studio.stop()


def test_a_trained_agent_is_not_offered_without_a_seat(opened: Page) -> None:
    part(opened, "others").select_option("RUN@best")
    expect(part(opened, "message")).to_contain_text("sjdsl studio GAME --slots you,RUN@best")
    expect(part(opened, "others")).to_have_value("random")


def test_a_draft_survives_a_reload_and_another_game(opened: Page) -> None:
    """The address names the game that is open; what is not saved of it is there again, until it is discarded."""
    type_over(opened, GAME.replace("Yard", "Draft"))
    expect(part(opened, "title")).to_have_text("Draft")
    opened.reload()
    expect(part(opened, "title")).to_have_text("Draft")
    expect(part(opened, "save")).to_be_enabled()
    open_game(opened, "tour:berries_1.sj")
    expect(part(opened, "title")).to_have_text("Berries")
    assert opened.url.endswith("#tour:berries_1.sj")
    opened.reload()
    expect(part(opened, "title")).to_have_text("Berries")
    open_game(opened, "yard.sj")
    expect(part(opened, "title")).to_have_text("Draft")
    opened.get_by_role("button", name="Discard them").click()
    expect(part(opened, "title")).to_have_text("Yard")
    opened.reload()
    expect(part(opened, "title")).to_have_text("Yard")
    expect(part(opened, "save")).to_be_disabled()


def test_a_draft_of_a_file_that_has_changed_asks(opened: Page, studio: Studio) -> None:
    type_over(opened, GAME.replace("Yard", "Mine"))
    expect(part(opened, "title")).to_have_text("Mine")
    opened.goto("about:blank")
    (studio.folder / "yard.sj").write_text(GAME.replace("Yard", "Theirs"), encoding="utf-8")
    opened.goto(studio.address)
    expect(part(opened, "title")).to_have_text("Mine")
    expect(part(opened, "message")).to_contain_text("changed by somebody else")
    opened.get_by_role("button", name="Open theirs, and lose mine").click()
    expect(part(opened, "title")).to_have_text("Theirs")


def test_what_an_agent_sees_is_drawn_and_keys_are_keycaps(opened: Page) -> None:
    part(opened, "driven").select_option("1")
    expect(part(opened, "keys").locator("kbd").first).to_be_visible()
    opened.locator('[data-panel="seen"]').click()
    window = opened.locator("canvas.window")
    expect(window).to_be_visible()
    filled = """canvas => [0, 1, 2].map((row) => [0, 1, 2].map((col) => canvas.getContext("2d").getImageData(
        (col + 0.5) * canvas.width / 3, (row + 0.1) * canvas.height / 3, 1, 1).data[3] > 0))"""
    expect(part(opened, "panel")).to_contain_text("plane by plane")
    opened.wait_for_timeout(500)
    drawn = window.evaluate(filled)
    assert drawn[1][1]
    assert sum(map(sum, drawn)) in (4, 6), "two rows of the map, in a corner or in the middle"


def test_what_an_agent_sees_is_read_as_a_model_reads_it(opened: Page) -> None:
    opened.locator('[data-panel="seen"]').click()
    message = part(opened, "panel").locator("details pre")
    expect(message).to_be_hidden()
    part(opened, "panel").get_by_text("As a language model sees it").click()
    expect(message).to_be_visible()
    expect(message).to_contain_text("You stand on: floor.")
    expect(message).to_contain_text("YOUR ACTIONS NOW:\nforward -> ")


def test_games_are_opened_by_title_and_picture(opened: Page) -> None:
    part(opened, "files").click()
    row = opened.locator('dialog [data-path="tour:berries_1.sj"]')
    expect(row).to_contain_text("Berries")
    row.scroll_into_view_if_needed()
    opened.wait_for_function(
        "document.querySelector('[data-path^=\"tour:\"] img').naturalWidth > 0"
    )
    own = opened.locator('dialog [data-path="yard.sj"] img')
    assert own.evaluate("image => image.naturalWidth") > 0


def test_a_panel_that_takes_long_shows_that_it_is_worked_on(opened: Page) -> None:
    expect(part(opened, "panel")).to_contain_text("The rules of the game yard")
    opened.route_web_socket("**/bench*", hold_panels)
    opened.reload()
    opened.locator("body[data-compiles=true]").wait_for()
    expect(opened.locator(".working")).to_be_visible()


def hold_panels(socket: WebSocketRoute) -> None:
    """Passes on all requests but those for panels."""
    server = socket.connect_to_server()
    socket.on_message(lambda text: None if '"panel"' in str(text) else server.send(text))


def test_words_between_backticks_are_code(opened: Page) -> None:
    type_over(opened, GAME.replace("kind floor", "kind flor"))
    row = part(opened, "problems").locator("li").first
    expect(row.locator("code").first).to_be_visible()
    expect(row).not_to_contain_text("`")
