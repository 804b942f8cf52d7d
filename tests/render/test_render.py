"""Pictures: what can be seen at known cells, not the pixels of a whole film."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from PIL import Image

import sjdsl
from sjdsl.cli import run
from sjdsl.render import Painter, Snapshot, make_painter, play, save_gif, save_png, stay_policy
from sjdsl.render.appearance import Beam, appearance_of
from sjdsl.render.board import draw_board
from sjdsl.render.colours import INK, WORDS, agent_colour, kind_colours, mark_colours, word_colours
from sjdsl.render.legend import legend_entries
from sjdsl.render.vector import BEAM_OPACITY
from sjdsl.runtime.env import Environment
from sjdsl.runtime.policy import MemoryPolicy

GAME = """sj 1
game yard "Yard" {
  episode 4
  kind floor "."
  kind wall  "#" { blocks agents, beam }
  kind soil  "A" {
    field class : { coop, defect } = coop  glyph "D" with class = defect
    field fruit : { none, ripe } = none    glyph "R" with fruit = ripe
    timer rest
  }
  kind gate "P"
  map { "....#.."
        "..A.#.."
        ".DRP..." }
  agents 1 {
    acts turn_right, forward, stay, zap
    moves relative
    timer tired
    forbid all when agent.tired > 0
  }
  shape beam { "x"
               "x"
               "^" }
  phase start { each agent { send agent to gate facing north } }
  schedule tick -> walk -> fire -> grow
  phase walk { move each agent }
  phase fire {
    each agent where agent chose zap { mark beam of agent  set agent.tired = 3 }
  }
  phase grow {
    each soil where soil.fruit is none { when step == 100 { set soil.fruit = ripe  set soil.rest = 5 } }
  }
  observe { window ahead 2, behind 0, left 1, right 1 }
}
"""
STAY, ZAP = 2, 3
GATE, RIPE, PLAIN, DEFECT = (2, 3), (2, 2), (1, 2), (2, 1)

Play = Callable[[int, int], Snapshot]


@pytest.fixture(scope="module")
def env(tmp_path_factory: pytest.TempPathFactory) -> Environment:
    file = tmp_path_factory.mktemp("games") / "yard.sj"
    file.write_text(GAME)
    return sjdsl.make(file)


@pytest.fixture(scope="module")
def painter(env: Environment) -> Painter:
    return make_painter(env)


@pytest.fixture(scope="module")
def after(env: Environment) -> Play:
    """Returns the state after some steps of one action."""

    def shoot(action: int, num_steps: int) -> Snapshot:
        *_, last = play(env, lambda _key, _observation: np.full(1, action, np.int32), num_steps)
        return last

    return shoot


def _cell(board: np.ndarray, painter: Painter, place: tuple[int, int]) -> np.ndarray:
    """Returns the pixels of a cell, `[tile, tile, 3]`."""
    size = painter.look.tile
    row, col = place
    return board[row * size : (row + 1) * size, col * size : (col + 1) * size]


def _board(painter: Painter, shot: Snapshot) -> np.ndarray:
    return draw_board(painter.look, shot)


def _near(pixel: np.ndarray, colour: tuple[int, int, int], by: int = 12) -> bool:
    return bool((np.abs(pixel.astype(int) - colour) <= by).all())


def test_each_kind_has_its_tile(env: Environment, painter: Painter, after: Play) -> None:
    board = _board(painter, after(STAY, 0))
    colours = kind_colours(env.game)
    assert len(set(colours.values())) == 4
    for kind, place in (("floor", (0, 0)), ("wall", (0, 4)), ("wall", (1, 4))):
        assert _near(np.median(_cell(board, painter, place), axis=(0, 1)), colours[kind])


def test_an_agent_points_where_it_looks(painter: Painter, after: Play) -> None:
    size = painter.look.tile
    cell = _cell(_board(painter, after(STAY, 0)), painter, GATE)
    drawn = np.abs(cell.astype(int) - kind_corner(cell)).sum(axis=2) > 60
    top, bottom = drawn[: size // 3].sum(), drawn[-size // 3 :].sum()
    assert 0 < top < bottom, "facing north: the tip is above"
    turned = _cell(_board(painter, after(0, 1)), painter, GATE)
    drawn = np.abs(turned.astype(int) - kind_corner(turned)).sum(axis=2) > 60
    assert drawn[:, : size // 3].sum() > drawn[:, -size // 3 :].sum() > 0, (
        "facing east: the tip is on the right"
    )


def kind_corner(cell: np.ndarray) -> np.ndarray:
    """Returns the colour of the tile under an agent, which leaves its corners free."""
    return cell[1, 1].astype(int)


def test_a_beam_has_the_colour_of_who_fires_and_an_edge_for_one_step(
    painter: Painter, after: Play
) -> None:
    before, during, later = (
        _board(painter, shot) for shot in (after(STAY, 1), after(ZAP, 1), after(ZAP, 2))
    )
    middle, edge = painter.look.tile // 2, np.array(mark_colours(("fire",))[0])
    for place in ((1, 3), (0, 3)):
        plain, lit, gone = (_cell(board, painter, place) for board in (before, during, later))
        expected = (
            plain[middle, middle]
            + (np.array(agent_colour(0)) - plain[middle, middle]) * BEAM_OPACITY
        )
        assert np.abs(lit[middle, middle] - expected).max() <= 1
        assert (gone == plain).all()
        assert (lit[middle, 0] == edge).all() and (lit[middle, -1] == edge).all()
    near, far = (_cell(during, painter, place) for place in ((1, 3), (0, 3)))
    assert (
        (far[0, middle] == edge).all()
        and not (far[-1, middle] == edge).all()
        and (near[-1, middle] == edge).all()
    ), "around the beam"
    outside = _cell(during, painter, (0, 0))
    assert (outside == _cell(before, painter, (0, 0))).all()
    assert [text for _, text in legend_entries(painter.look)][-2:] == [
        "zap",
        "pale: can only stay",
    ], "the action, not the phase"


def test_whose_beam_it_is_follows_from_the_actions(painter: Painter, after: Play) -> None:
    """Two agents stand in a line; without their actions it is the nearer one's."""
    one, marks = after(STAY, 1), np.zeros((3, 7), bool)
    marks[0, 2:4] = True
    look = replace(painter.look, num_agents=2)
    where = {
        "row": np.array([1, 2]),
        "col": np.array([3, 3]),
        "heading": np.zeros(2, int),
        "held": np.zeros(2, bool),
        "returns": np.zeros(2),
    }
    shot = replace(one, marks={"fire": marks}, **where)
    for actions, agent in (((), 0), ((STAY, ZAP), 1), ((ZAP, STAY), 0), ((STAY, STAY), None)):
        beams = [
            (beam, row, col)
            for beam, row, col in appearance_of(look, shot, actions).figures
            if isinstance(beam, Beam)
        ]
        assert [(row, col) for _, row, col in beams] == [(0, 2), (0, 3)]
        fill = mark_colours(("fire",))[0] if agent is None else agent_colour(agent)
        assert {beam.fill for beam, _, _ in beams} == {fill}
        assert [beam.sides for beam, _, _ in beams] == [
            (True, False, True, True),
            (True, True, True, False),
        ]


def test_all_frames_have_one_size_and_a_legend(env: Environment, painter: Painter) -> None:
    frames = [painter.draw(shot) for shot in play(env, stay_policy(env), 4)]
    assert len({frame.size for frame in frames}) == 1
    assert frames[0].width <= 800
    assert frames[0].height > painter.look.height * painter.look.tile + 40
    pixels = np.asarray(frames[0])[painter.look.height * painter.look.tile :]
    assert (np.abs(pixels.astype(int) - INK).sum(axis=2) < 30).sum() > 200, (
        "something is written there"
    )


def test_an_agent_that_is_away_is_grey_below_the_board(painter: Painter, after: Play) -> None:
    def colours(row: int) -> np.ndarray:
        snapshot = replace(after(STAY, 1), row=np.array([row]))
        below = np.asarray(painter.status.draw(snapshot)).astype(int)
        return below.max(axis=2) - below.min(axis=2)

    assert colours(row=2).max() > 100
    assert colours(row=-1).max() < 20


def test_a_policy_with_memory_starts_each_episode_afresh(env: Environment) -> None:
    """One that zaps in the second step of what it remembers: so it does in both episodes."""

    def act(
        memory: jax.Array, key: jax.Array, observation: jax.Array
    ) -> tuple[jax.Array, jax.Array]:
        del key, observation
        return memory + 1, jnp.where(memory == 1, ZAP, STAY)[None].astype(jnp.int32)

    shots = list(play(env, MemoryPolicy(jnp.int32(0), act), 8))
    assert [shot.step for shot in shots] == [0, 1, 2, 3, 4] * 2
    assert [bool(shot.held.all()) for shot in shots] == [False, False, True, True, True] * 2


def test_files(env: Environment, painter: Painter, tmp_path: Path) -> None:
    frames = [painter.draw(shot) for shot in play(env, stay_policy(env), 3)]
    save_gif(frames, tmp_path / "film.gif")
    with Image.open(tmp_path / "film.gif") as film:
        assert film.n_frames == 4
        assert film.size == frames[0].size
        film.seek(3)
        shown = np.asarray(film.convert("RGB")).astype(int)
    assert np.abs(shown - np.asarray(frames[3])).mean() < 3
    save_png(frames[0], tmp_path / "one.png")
    with Image.open(tmp_path / "one.png") as picture:
        assert (np.asarray(picture.convert("RGB")) == np.asarray(frames[0])).all()


OWNED = """sj 1
game owned "Owned" {
  episode 4
  kind floor "."
  kind plot  "r" { field colour : { red, blue } = red  field owner : agent }
  map { ".r.." "...." }
  agents 2 { acts stay, zap  field role : { guest, host } = guest }
  phase start { each agent { when agent.index == 1 { set agent.role = host }  send agent to floor } }
  schedule claim
  observe { show plot.owner }
  phase claim {
    pick 1 agent where agent.index == 1 and agent chose zap { each plot { set plot.owner = agent  set plot.colour = blue } }
  }
}
"""


def test_what_belongs_to_an_agent_has_an_edge_of_its_colour(tmp_path: Path) -> None:
    """And colours are seen, the first one too; agents are coloured by a role that no phase changes."""
    file = tmp_path / "owned.sj"
    file.write_text(OWNED)
    env = sjdsl.make(file)
    painter = make_painter(env)
    first, *_, last = play(env, lambda _key, _observation: np.ones(2, np.int32), 2)
    before, after = (_cell(_board(painter, shot), painter, (0, 1)) for shot in (first, last))
    middle = painter.look.tile // 2
    assert _near(before[middle, middle], WORDS["red"])
    assert _near(after[middle, middle], WORDS["blue"])
    assert not _near(before[2, middle], agent_colour(1), by=40)
    assert _near(after[2, middle], agent_colour(1))
    assert painter.look.agent_colours(last.values) == list(word_colours(("guest", "host")))
    assert painter.look.roles == ("guest", "host")


def test_the_command_writes_a_film(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("yard.sj").write_text(GAME)
    Path("below").mkdir()
    assert (
        run(["render", "yard.sj", "--steps", "2", "--policy", "stay", "-o", "below/yard.gif"]) == 0
    )
    assert "3 frames" in capsys.readouterr().out
    assert run(["render", "yard.sj", "--steps", "2", "-o", "yard.png"]) == 0
    assert Path("yard.png").stat().st_size > 0
    assert "step 2" in capsys.readouterr().out
