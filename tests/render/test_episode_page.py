"""Pages of episodes: their data say what the snapshots do, and no text of a game gets out of its place."""

import json
import re
from base64 import b64decode
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from resvg_py import svg_to_bytes

import sjdsl
from sjdsl.cli import run
from sjdsl.render import make_page, make_painter, play_moments, random_policy
from sjdsl.render.board import draw_board
from sjdsl.render.episode_page import episode_data
from sjdsl.render.vector import SIZE
from sjdsl.runtime.env import Environment

STEPS = 12


@pytest.fixture(scope="module")
def env() -> Environment:
    return sjdsl.make("coins", params={"length": 8})


@pytest.fixture(scope="module")
def moments(env: Environment) -> list:
    return list(play_moments(env, random_policy(env), STEPS))


def read_data(text: str) -> dict:
    """Returns the data that a page holds."""
    found = re.findall(
        r'<script type="application/json" id="episode">(.*?)</script>', text, re.DOTALL
    )
    assert len(found) == 1
    return json.loads(found[0])


def image_of(url: str) -> Image.Image:
    svg = b64decode(url.removeprefix("data:image/svg+xml;base64,")).decode()
    return Image.open(BytesIO(bytes(svg_to_bytes(svg_string=svg)))).convert("RGBA")


def paint(data: dict, number: int) -> np.ndarray:
    """Returns the board of a moment as a browser puts it together, `[H * size, W * size, 3]`."""
    cells = [0] * (data["height"] * data["width"])
    for moment in data["moments"][: number + 1]:
        for cell, picture in zip(moment["cells"][::2], moment["cells"][1::2], strict=True):
            cells[cell] = picture
    pictures = [image_of(url) for url in data["pictures"]]
    board = Image.new("RGBA", (data["width"] * SIZE, data["height"] * SIZE))
    for at, picture in enumerate(cells):
        row, col = divmod(at, data["width"])
        board.paste(pictures[picture], (col * SIZE, row * SIZE))
    for picture, row, col in data["moments"][number]["figures"]:
        board.alpha_composite(pictures[picture], (col * SIZE, row * SIZE))
    return np.asarray(board.convert("RGB")).astype(int)


def test_a_page_shows_the_picture_of_every_moment(env: Environment, moments: list) -> None:
    data = episode_data(env.game, moments)
    look = make_painter(env).look
    for number in (0, 1, len(moments) - 1):
        drawn = draw_board(replace(look, tile=SIZE), moments[number].snapshot)
        apart = (
            np.abs(paint(data, number) - drawn)
            .reshape(len(env.game.rows), SIZE, -1, SIZE, 3)
            .mean(axis=(1, 3, 4))
        )
        assert apart.max() < 12, (
            "of 255 in each cell: two rasterisers, and two fonts of the numbers"
        )


def test_a_page_tells_what_every_step_did_and_paid(env: Environment, moments: list) -> None:
    data = episode_data(env.game, moments)
    assert len(data["moments"]) == STEPS + 2, "the second episode has a start of its own"
    returns = np.zeros(env.num_agents)
    for told in data["moments"]:
        returns = np.zeros(env.num_agents) if not told["actions"] else returns + told["rewards"]
        assert told["returns"] == pytest.approx(returns)
        assert all(0 <= action < len(data["actions"]) for action in told["actions"])
    assert [told["step"] for told in data["moments"]] == [*range(9), *range(5)]
    assert [told["done"] for told in data["moments"]].index(True) == 8


def test_a_page_tells_who_plays_who_is_away_and_the_seed(env: Environment, moments: list) -> None:
    gone = replace(moments[0].snapshot, row=np.array([3, -1]))
    page = make_page(env.game, [replace(moments[0], snapshot=gone)], players=["a", "b"], seed=7)
    data = read_data(page.text)
    assert (data["players"], data["seed"], data["moments"][0]["away"]) == (["a", "b"], 7, [1])


def test_texts_of_a_game_stay_texts(env: Environment, moments: list) -> None:
    sly = env.game.model_copy(update={"title": "</script><script>alert(1)</script>"})
    page = make_page(sly, moments).text
    assert "alert(1)" in page
    assert "<script>alert" not in page
    assert read_data(page)["title"] == sly.title


def test_a_page_needs_nothing_from_elsewhere(env: Environment, moments: list) -> None:
    page = make_page(env.game, moments)
    outside = set(re.findall(r"https?://[^\s\"'<]+", page.text))
    assert outside == {"http://www.w3.org/2000/svg"}, "a name, which no browser opens"
    assert "srcdoc=" in page._repr_html_()
    assert 'sandbox="allow-scripts"' in page._repr_html_()


def test_no_moment_is_refused(env: Environment) -> None:
    with pytest.raises(ValueError, match="at least its start"):
        make_page(env.game, [])


def test_the_command_writes_a_page(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    path = tmp_path / "episode.html"
    assert run(["render", "coins", "--steps", "3", "--speed", "5", "-o", str(path)]) == 0
    assert "4 moments to look at in a browser" in capsys.readouterr().out
    data = read_data(path.read_text(encoding="utf-8"))
    assert len(data["moments"]) == 4
    assert data["speed"] == 5
    assert (data["players"], data["seed"]) == (["cooperator", "defector"], 0)
