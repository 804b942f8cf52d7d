"""The studio's page in use: mistakes and their repairs, numbers and the text, dark, keys, and screen readers."""

from collections.abc import Iterator

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, Page, expect

from tests.browser.studio_page import GAME, Studio, opened, part, studio, type_over

__all__ = ["opened", "studio"]  # fixtures


def test_a_mistake_has_its_line_its_mark_and_its_repair(opened: Page) -> None:
    line = GAME[: GAME.index("phase eat")].count("\n") + 1
    type_over(opened, GAME.replace("where soil.fruit is ripe {", "where soil.fruit is ripee {"))
    row = part(opened, "problems").locator("li", has_text="ripee").first
    expect(row).to_contain_text(f"line {line}")
    expect(opened.locator(".cm-gutter-lint .cm-lint-marker-error")).to_be_visible()
    message = opened.locator(".cm-tooltip-hover .cm-tooltip-section", has_text="ripee")
    for _ in range(
        60
    ):  # the editor closes it whenever problems arrive, as they do several times while the game compiles
        opened.mouse.move(5, 5)
        opened.locator(".cm-lintRange-error", has_text="ripee").hover()
        opened.wait_for_timeout(1000)
        if message.is_visible():
            break
    expect(message).to_be_visible()
    opened.mouse.move(5, 5)
    row.locator(".go").click()
    expect(opened.locator(".cm-activeLine")).to_contain_text("phase eat")
    row.locator(".fix").first.click()
    expect(part(opened, "verdict")).to_have_text("")
    expect(part(opened, "warned")).to_have_text("No problems")
    expect(opened.locator(".cm-activeLine")).to_contain_text("is ripe {")


def test_a_mistake_beside_the_text_is_told_too(opened: Page) -> None:
    """The language server knows nothing of a number of agents that was chosen in the studio."""
    type_over(
        opened,
        GAME.replace("param fine", "size players : count = 2 in 2 .. 64\n  param fine").replace(
            "agents 2", "agents players"
        ),
    )
    expect(part(opened, "crew")).to_be_enabled()
    part(opened, "crew").fill("40")
    part(opened, "crew").press("Enter")
    expect(part(opened, "problems").locator("li").first).to_contain_text("40")
    part(opened, "crew").fill("3")
    part(opened, "crew").press("Enter")
    expect(part(opened, "agents").locator("tr")).to_have_count(3)
    expect(part(opened, "warned")).to_have_text("No problems")


def test_a_number_is_refused_put_back_and_written(opened: Page) -> None:
    type_over(opened, GAME.replace("checks {", "checks { require fine < 4 "))
    expect(part(opened, "verdict")).to_have_text("")
    fine = opened.get_by_label("fine", exact=True)
    fine.fill("3")
    part(opened, "forward").click()
    expect(part(opened, "message")).to_have_text("")
    fine.fill("4.5")
    expect(part(opened, "message")).to_contain_text("require (fine < 4)")
    expect(fine).to_have_value("3")
    opened.get_by_role("button", name="Write fine into the text").click()
    expect(opened.locator(".cm-content")).to_contain_text("param fine : reward = 3 in 0 .. 5")
    expect(opened.get_by_role("button", name="Write fine into the text")).to_be_hidden()
    fine.fill("2")
    opened.get_by_role("button", name="Reset fine").click()
    expect(fine).to_have_value("3")
    expect(opened.locator(".cm-content")).to_contain_text("= 3 in")


def test_tabs_cells_and_panes_by_keys(opened: Page) -> None:
    opened.get_by_role("tab", name="Rules").focus()
    opened.keyboard.press("ArrowRight")
    opened.keyboard.press("ArrowRight")
    expect(opened.get_by_role("tab", name="State")).to_have_attribute("aria-selected", "true")
    expect(part(opened, "panel")).to_contain_text("World")
    part(opened, "board").focus()
    for key in ("ArrowUp", "ArrowUp", "ArrowRight", "ArrowRight", "ArrowRight", "ArrowUp"):
        opened.keyboard.press(key)
    expect(part(opened, "said")).to_contain_text("Row 0, column 2: soil, fruit ripe")
    expect(part(opened, "panel")).to_contain_text("soil (0, 2)")
    part(opened, "forward").click()
    expect(part(opened, "said")).to_contain_text("Step 1")
    bar = opened.get_by_role("separator", name="Width of the text")
    width = opened.locator("section.text").bounding_box()
    bar.focus()
    opened.keyboard.press("ArrowRight")
    wider = opened.locator("section.text").bounding_box()
    assert width is not None
    assert wider is not None
    assert wider["width"] > width["width"] + 10


@pytest.fixture(params=[("light", 1400), ("dark", 1400), ("dark", 390)], ids=str)
def shaded(browser: Browser, studio: Studio, request: pytest.FixtureRequest) -> Iterator[Page]:
    scheme, width = request.param
    page = browser.new_page(
        viewport={"width": width, "height": 850}, color_scheme=scheme, reduced_motion="reduce"
    )
    page.goto(studio.address)
    page.locator("body[data-compiles=true]").wait_for(timeout=60_000)
    yield page
    page.close()


def test_axe_finds_nothing(shaded: Page) -> None:
    """In every panel, with mistakes in the text, a window, and what stands where the pointer rests; contrasts in light and dark among it."""
    page, axe = shaded, Axe()

    def look() -> None:
        found = [
            f"{v['id']}: {node['html'][:150]} {node['failureSummary'][:300]}"
            for v in axe.run(page).response["violations"]
            for node in v["nodes"]
        ]
        assert found == []

    page.locator(".tok-keyword").first.wait_for(state="attached", timeout=60_000)
    look()
    narrow = page.viewport_size is not None and page.viewport_size["width"] < 800
    if narrow:
        page.get_by_role("button", name="Panels").click()
    for name, text in (
        ("state", "World"),
        ("seen", "plane by plane"),
        ("python", "import"),
        ("tour", "tour"),
    ):
        page.locator(f'[data-panel="{name}"]').click()
        expect(part(page, "panel")).to_contain_text(text, timeout=60_000)
        look()
    if narrow:
        page.get_by_role("button", name="Text").click()
    type_over(page, GAME.replace("is ripe {", "is ripee {") + "# a comment\n")
    part(page, "problems").locator(".fix").first.wait_for(timeout=60_000)
    page.locator(".cm-lintRange-error").first.hover()
    page.locator(".cm-tooltip-hover").wait_for()
    look()
    part(page, "files").click()
    look()
