"""Movers in pictures: each on its cell as its sort's sprite, facing its heading, changed by its `look`s."""

from pathlib import Path

import jax
import numpy as np
import pytest

import sjdsl
from sjdsl.compiler import check
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.render import make_painter, take_snapshot
from sjdsl.render.appearance import Figure, draw_figures
from sjdsl.render.board import draw_figure
from sjdsl.render.colours import SPRITES, read_colour
from sjdsl.render.legend import figure_entries
from sjdsl.render.usual import Picture
from sjdsl.runtime.env import Environment

GAME = """sj 1
game herd "Herd" {
  episode 4
  kind grass "."
  map { "....." }
  agents 1 { acts forward, stay  moves relative }
  movers deer 2 "d" { field fear : { calm, scared } = calm  timer rest }
  movers coin 1 "c"
  phase start {
    each agent { send agent to grass facing north }
    each deer { send deer to grass facing west }
    each coin { send coin to grass facing east }
  }
  schedule tick -> bolt
  phase bolt {
    each deer where deer.index == 1 { set deer.fear = scared  set deer.rest = 3 }
    each coin { remove coin }
  }
  observe { show deer.fear }
LOOKS
}
"""


def made(looks: str, folder: Path) -> Environment:
    file = folder / "herd.sj"
    file.write_text(GAME.replace("LOOKS", looks), encoding="utf-8")
    return sjdsl.make(file)


def test_movers_are_drawn_where_they_are(tmp_path: Path) -> None:
    env = made("", tmp_path)
    painter = make_painter(env)
    _, state = env.reset(jax.random.key(0))
    deer, coin = painter.look.herds
    assert (deer.sprite, coin.sprite) == ("animal", "coin")
    before = take_snapshot(env, state, np.zeros(1))
    picture, size = np.asarray(painter.draw(before)), painter.look.tile
    left = (painter.width - 5 * size) // 2
    cells = picture[:size, left : left + 5 * size].reshape(size, 5, size, 3).swapaxes(0, 1)
    _, (agent,) = env.cells(state)
    for herd, heading in ((deer, 3), (coin, 1)):
        body = draw_figure(Figure(None, herd.colour, herd.sprite, heading), size)
        full = body[..., 3] == 255
        rows, cols = before.movers[herd.name]
        assert len(cols) == len(set(cols)) == (2 if herd is deer else 1)
        assert (rows == 0).all()
        assert agent not in cols
        for col in cols:
            assert np.array_equal(cells[col][full], body[full][:, :3])
    _, state, *_ = env.step_env(jax.random.key(1), state, np.zeros(1, np.int32))
    after = take_snapshot(env, state, np.zeros(1))
    assert after.movers["coin"][1].tolist() == [-1], "it is removed, and not drawn"
    assert [figure.badges == () for figure in draw_figures(painter.look, after)["deer"]] == [
        True,
        False,
    ], "fear is a badge"


def test_looks_of_movers_apply(tmp_path: Path) -> None:
    looks = "  look deer as brown raft\n  look deer where deer.fear is scared as red with pot\n  look deer where deer.heading is west with gem"
    env = made(looks, tmp_path)
    look = make_painter(env).look
    _, state = env.reset(jax.random.key(0))
    _, state, *_ = env.step_env(jax.random.key(1), state, np.zeros(1, np.int32))
    calm, scared = draw_figures(look, take_snapshot(env, state, np.zeros(1)))["deer"]
    pot, gem = Picture("pot", SPRITES["pot"]), Picture("gem", SPRITES["gem"])
    assert calm == Figure(None, read_colour("brown"), "raft", 3, badges=(gem,))
    assert scared == Figure(None, read_colour("red"), "raft", 3, badges=(pot, gem))
    assert [text for _, text in figure_entries(look)] == [
        "deer",
        "deer: scared",
        "deer: west",
        "coin",
    ]


@pytest.mark.parametrize(
    ("looks", "said"),
    [
        ("look dear as red", "deer"),
        ("look deer where deer.row > 1 as red", "SJ510"),
        ("look deer as blu", "blue"),
    ],
)
def test_a_look_of_movers_that_cannot_be_is_refused(looks: str, said: str) -> None:
    (problem,) = [
        d for d in check(Source("herd.sj", GAME.replace("LOOKS", looks))) if d.severity == "error"
    ]
    assert said in f"{problem.code} {problem}"
