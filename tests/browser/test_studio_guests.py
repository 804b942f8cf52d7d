"""The studio in a browser: counterexamples, the tour, and work that is not to be lost."""

from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.browser.studio_page import GAME, Studio, opened, part, studio, type_over

__all__ = ["opened", "studio"]  # fixtures


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
