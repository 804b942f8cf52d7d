"""The page of an episode in a browser: it plays, steps, is dragged and is driven by keys, and draws the board that a picture shows."""

from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from axe_playwright_python.sync_playwright import Axe
from PIL import Image
from playwright.sync_api import Locator, Page, expect

import sjdsl
from sjdsl.render import Moment, make_page, make_painter, play_moments, random_policy
from sjdsl.render.board import draw_board

STEPS = 20


@pytest.fixture(scope="module")
def env() -> sjdsl.Environment:
    return sjdsl.make("coins", params={"length": STEPS})


@pytest.fixture(scope="module")
def moments(env: sjdsl.Environment) -> list[Moment]:
    return list(play_moments(env, random_policy(env), STEPS))


@pytest.fixture(scope="module")
def file(
    env: sjdsl.Environment, moments: list[Moment], tmp_path_factory: pytest.TempPathFactory
) -> Path:
    path = tmp_path_factory.mktemp("pages") / "episode.html"
    make_page(env.game, moments, speed=32.0).save(path)
    return path


@pytest.fixture
def opened(page: Page, file: Path) -> Page:
    page.goto(file.as_uri())
    expect(part(page, "step")).to_have_text("step 0")
    return page


def part(page: Page, name: str) -> Locator:
    return page.locator(f'[data-part="{name}"]')


def test_buttons_keys_and_the_slider_lead_to_any_moment(opened: Page) -> None:
    part(opened, "forward").click()
    expect(part(opened, "step")).to_have_text("step 1")
    opened.locator("h1").click()
    opened.keyboard.press("ArrowRight")
    expect(part(opened, "step")).to_have_text("step 2")
    opened.keyboard.press("ArrowLeft")
    part(opened, "back").click()
    part(opened, "back").click()
    expect(part(opened, "step")).to_have_text("step 0")
    part(opened, "scrub").fill("7")
    expect(part(opened, "step")).to_have_text("step 7")
    opened.locator("h1").click()
    opened.keyboard.press("End")
    expect(part(opened, "step")).to_have_text(f"step {STEPS}, the episode is over")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing(opened: Page, scheme: str) -> None:
    opened.emulate_media(color_scheme=scheme)
    found = Axe().run(opened).response["violations"]
    assert [
        (violation["id"], [node["target"] for node in violation["nodes"]]) for violation in found
    ] == []


def test_the_board_fits_a_frame_that_gets_wider(page: Page, file: Path) -> None:
    """As in a page that loads it before it has a place for it."""
    page.set_content('<iframe style="width: 0; height: 600px"></iframe>')
    page.locator("iframe").evaluate(
        "(frame, text) => { frame.srcdoc = text; }", file.read_text("utf-8")
    )
    board = page.frame_locator("iframe").locator('[data-part="board"]')
    expect(board).to_be_attached()
    page.locator("iframe").evaluate("frame => { frame.style.width = '900px'; }")
    stage = page.frame_locator("iframe").locator('[data-part="stage"]')
    page.wait_for_timeout(300)
    sizes = [part.bounding_box() for part in (stage, board)]
    assert all(sizes)
    assert sizes[1]["width"] > 0.8 * min(sizes[0]["width"], 11 * 48)


def test_it_plays_to_the_end_and_again(opened: Page) -> None:
    part(opened, "play").click()
    expect(part(opened, "play")).to_have_accessible_name("Pause")
    expect(part(opened, "step")).to_have_text(f"step {STEPS}, the episode is over")
    expect(part(opened, "play")).to_have_accessible_name("Play")
    part(opened, "play").click()
    expect(part(opened, "step")).not_to_have_text(f"step {STEPS}, the episode is over")


def test_each_agent_has_its_action_reward_and_return(
    opened: Page, env: sjdsl.Environment, moments: list[Moment]
) -> None:
    for number in (0, 1, STEPS // 2, STEPS):
        part(opened, "scrub").fill(str(number))
        moment = moments[number]
        for agent in range(env.num_agents):
            cells = (
                part(opened, "agents")
                .locator("tbody tr")
                .nth(agent)
                .locator("td")
                .all_inner_texts()
            )
            assert cells[0] == str(agent)
            assert cells[1] == (env.action_names[moment.actions[agent]] if moment.actions else "")
            assert float(cells[2].replace("−", "-") or 0) == pytest.approx(
                float(moment.reward[agent])
            )
            assert float(cells[3]) == pytest.approx(float(moment.snapshot.returns[agent]))


def test_who_plays_who_is_away_and_the_axes_are_named(
    page: Page, env: sjdsl.Environment, moments: list[Moment], tmp_path: Path
) -> None:
    gone = replace(moments[0].snapshot, row=np.array([3, -1]))
    told = make_page(env.game, [replace(moments[0], snapshot=gone)], players=["a", "a"], seed=7)
    told.save(tmp_path / "told.html")
    page.goto((tmp_path / "told.html").as_uri())
    expect(part(page, "played")).to_have_text("Agents 0, 1: a · seed 7")
    expect(part(page, "agents").locator("tbody td:first-child")).to_have_text(["0", "1, away"])
    expect(part(page, "plot")).to_contain_text("step")


def test_the_board_is_the_picture(
    opened: Page, env: sjdsl.Environment, moments: list[Moment]
) -> None:
    look = make_painter(env).look
    for number in (0, STEPS // 2):
        part(opened, "scrub").fill(str(number))
        drawn = Image.open(BytesIO(part(opened, "board").screenshot())).convert("RGB")
        wanted = Image.fromarray(draw_board(look, moments[number].snapshot)).resize(drawn.size)
        difference = np.abs(np.asarray(drawn).astype(int) - np.asarray(wanted))
        assert difference.mean() < 6, (
            "of 255: edges are blended otherwise, cells and agents are in the same places"
        )


def test_a_click_on_the_plot_leads_there(opened: Page) -> None:
    box = part(opened, "plot").bounding_box()
    assert box is not None
    opened.mouse.click(
        box["x"] + box["width"] - 21 * box["width"] / 420, box["y"] + box["height"] / 2
    )
    expect(part(opened, "step")).to_contain_text(f"step {STEPS}")
