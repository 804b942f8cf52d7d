"""The studio in a browser: counterexamples, the tour, variants, tables of numbers, and work that is not to be lost."""

from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.browser.studio_page import GAME, Studio, open_game, opened, part, studio, type_over

__all__ = ["opened", "studio"]  # fixtures
TABLES = GAME.replace(
    "param fine : reward = 1 in 0 .. 5",
    "param fine : reward = 1 in 0 .. 5\n  param pay : reward = { none: { none: 1, ripe: 2 }, ripe: { none: 3, ripe: 4 } }\n"
    "  param wage : reward = { none: 0, ripe: 1 } in 0 .. 9",
).replace("give fine", "give fine + pay[ripe][none] + wage[ripe]")


def choose_panel(page: Page, name: str) -> None:
    page.locator(f'[data-panel="{name}"]').click()


def test_a_failed_check_is_shown_on_the_board(opened: Page) -> None:
    type_over(opened, GAME.replace("is ripe) <= count(soil)", "is none) == 0"))
    expect(part(opened, "verdict")).to_have_text("")
    choose_panel(opened, "checks")
    opened.get_by_role("button", name="Show it on the board").click()
    expect(part(opened, "counterexample")).to_contain_text("it fails after step")
    expect(part(opened, "step")).to_have_text("step 0")
    moments = int(part(opened, "scrub").get_attribute("max") or 0)
    assert moments >= 1
    part(opened, "scrub").fill(str(moments))
    expect(part(opened, "step")).to_contain_text(f"step {moments}")
    choose_panel(opened, "why")
    expect(part(opened, "panel")).to_contain_text("fruit: ripe -> none")
    opened.get_by_role("button", name="Back to the game").click()
    expect(part(opened, "counterexample")).to_be_hidden()
    assert (
        part(opened, "board").evaluate("board => Math.round(100 * board.width / board.height)")
        == 150
    )


def test_the_tour_is_read_and_its_games_are_opened(opened: Page) -> None:
    choose_panel(opened, "tour")
    panel = part(opened, "panel")
    panel.get_by_role("button", name="Next step").first.click()
    panel.get_by_role("button", name="Next step").first.click()
    expect(panel).to_contain_text("The one rule to remember")
    panel.get_by_role("button", name="Open the game of this step").first.click()
    expect(part(opened, "title")).to_have_text("Berries")
    expect(part(opened, "name")).to_have_text("berries_2.sj")
    expect(opened.locator(".cm-content")).to_contain_text("tally eaten for agent")
    expect(part(opened, "verdict")).to_have_text("")
    expect(panel).to_contain_text("The one rule to remember")


def test_what_a_variant_changes_stands_beside(opened: Page) -> None:
    expect(part(opened, "diff")).to_be_hidden()
    type_over(
        opened,
        GAME.replace(
            "  policy idler", '  variant poor "pays less" { set fine = 0 }\n  policy idler'
        ),
    )
    expect(part(opened, "variant").locator("option")).to_have_count(2)
    part(opened, "variant").select_option("poor")
    part(opened, "diff").click()
    expect(part(opened, "panel")).to_contain_text("fine: 1 -> 0")


def test_tables_act_at_once(opened: Page) -> None:
    type_over(opened, TABLES)
    cell = opened.get_by_label("pay ripe none", exact=True)
    expect(cell).to_have_value("3")
    part(opened, "others").select_option("stay")
    drag_agent_to_soil(opened)
    cell.fill("10")
    opened.get_by_label("wage ripe", exact=True).fill("5")
    cell.fill("")  # no number: nothing is set
    part(opened, "forward").click()
    rewards = part(opened, "agents").locator("tr td:nth-child(3)")
    expect(rewards.filter(has_text="16")).to_have_count(1)
    type_over(opened, TABLES + "# mine\n")
    expect(opened.get_by_label("pay ripe none", exact=True)).to_have_value("10")


def drag_agent_to_soil(page: Page) -> None:
    choose_panel(page, "state")
    place = part(page, "panel").locator("tr", has_text="place").first
    expect(place).to_be_visible()
    row, col = (int(part) for part in place.inner_text().split("(")[1].rstrip(")").split(","))
    box = part(page, "board").bounding_box()
    assert box is not None
    side = box["width"] / 3
    page.mouse.move(box["x"] + (col + 0.5) * side, box["y"] + (row + 0.5) * side)
    page.mouse.down()
    page.mouse.move(box["x"] + 2.5 * side, box["y"] + 0.5 * side, steps=3)
    page.mouse.up()
    expect(place).to_contain_text("(0, 2)")


def test_another_game_is_not_opened_over_unsaved_work(opened: Page) -> None:
    type_over(opened, GAME.replace("Yard", "Mine"))
    open_game(opened, "example:clean_up.sj")
    expect(part(opened, "message")).to_contain_text("changes that are not saved")
    expect(part(opened, "name")).to_have_text("yard.sj")
    opened.get_by_role("button", name="Stay here").click()
    expect(part(opened, "title")).to_have_text("Mine")
    open_game(opened, "example:clean_up.sj")
    opened.get_by_role("button", name="and lose them").click()
    expect(part(opened, "title")).to_have_text("Clean Up")


@pytest.mark.parametrize("edited", [False, True], ids=["as it was", "edited"])
def test_a_file_that_another_window_wrote_is_noticed(
    opened: Page, studio: Studio, edited: bool
) -> None:
    path = Path(studio.folder / "yard.sj")
    if edited:
        type_over(opened, GAME.replace("Yard", "Mine"))
        expect(part(opened, "title")).to_have_text("Mine")
    path.write_text(GAME.replace("Yard", "Theirs"), encoding="utf-8")
    opened.evaluate("window.dispatchEvent(new Event('focus'))")
    expect(part(opened, "message")).to_contain_text("changed by somebody else")
    expect(part(opened, "title")).to_have_text("Mine" if edited else "Theirs")


def test_whoever_types_early_keeps_the_cursor(studio: Studio, browser: Browser) -> None:
    """The language server comes a while after the text; the editor is not made anew for it, nor are keys lost or changes forgotten."""
    (studio.folder / "yard.sj").write_text(
        GAME.replace("  policy", "  define spare = 1\n  policy"), encoding="utf-8"
    )
    page = browser.new_page()
    page.goto(studio.address)
    page.locator(".cm-line").first.click(timeout=60_000)
    page.keyboard.press("End")
    page.keyboard.type("  # early", delay=20)
    page.locator(".cm-lintRange-warning").first.wait_for(
        timeout=60_000
    )  # it has found what is unused
    page.keyboard.type(" and late", delay=20)
    expect(page.locator(".cm-line").first).to_have_text("sj 1  # early and late")
    for _ in range(6):
        page.keyboard.press("Control+z")
    expect(page.locator(".cm-line").first).to_have_text("sj 1")
    page.close()
