"""What agents are shown of the world and of themselves stands beside the board, in pictures, pages and the terminal."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import jax
import numpy as np

import sjdsl
from sjdsl.cli.play import moment_lines
from sjdsl.compiler import build, ir
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.step import reset, step
from sjdsl.interpreter.threefry import Threefry
from sjdsl.render import Moment, make_painter, take_snapshot
from sjdsl.render.episode_page import episode_data
from sjdsl.render.letters import make_letters
from sjdsl.render.moment import moment_of
from sjdsl.render.readings import agent_readings, join_readings, world_readings

GAME = """sj 1
game dell "A dell" {
  size folk : count = 3 in 1 .. 40
  episode 9
  kind moss "."
  kind well "w"
  map { "........" "........" "...w...." "........" "........" }
  field wind : { calm, storm } = calm
  field ruler : agent
  field stock by { hay, oats } : 0 .. 99 capped = 1
  field secret : 0 .. 9 = 4
  define dry = stock[hay] > 1
  define left = 9 - step
  agents folk {
    acts stay, drink
    field thirst : 0 .. 50 capped = 7  field purse by { gold, tin } : 0 .. 9 capped = 2  field owed by { gold, tin } : 0 .. 9 capped = 1
    field seen by 0 .. 2 : { no_, yes_ } = no_  field rival : agent  field friends : set of agent  field home : cell of well
    timer tired  field private : 0 .. 5 = 3  field worth : reward = 0.5
  }
  phase start { each agent { send agent to moss } }
  schedule tick -> rule
  phase rule {
    set wind = storm
    pick 1 agent where agent.index == 1 { set ruler = agent }
    add 1 to stock[hay]
    each agent as a where a.index == 1 {
      set a.tired = 3  add 5 to a.thirst  set a.rival = a  add a to a.friends  set a.seen = shift(a.seen, 1, yes_)  add 4 to a.owed[tin]
      pick 1 well { set a.home = well }
      add secret + a.private to a.purse[tin]
    }
  }
  observe {
    show wind  show ruler as { mine where ruler is agent, no_one }  show stock  show step  show dry  show left
    show agent.thirst  show agent.purse  show agent.owed  show other.seen  show agent.tired
    show agent.rival as { me where agent.rival is agent, others }  show agent.friends as { in_ where agent in agent.friends, out_ }
    show agent.home as { has where agent.home is not nowhere, none }  show agent.worth as { rich where agent.worth > 1, poor }
  }
}
"""
WORLD = ["wind storm", "ruler 1", "stock hay 2 oats 1", "dry yes", "left 8"]
ROWS = ["purse gold 2 tin 9", "owed gold 1 tin 5"]
OWN = [
    "thirst 12",
    *ROWS,
    "seen yes_ no_ no_",
    "rival 1",
    "friends 1",
    "home (2, 3)",
    "tired 3",
    "worth 0.5",
]


def rules(folk: int = 3) -> ir.Game:
    return build(Source("dell.sj", GAME.replace("folk : count = 3", f"folk : count = {folk}"))).game


def moments(game: ir.Game, returns: float = 0.0) -> list[Moment]:
    """Returns the start of an episode and the moment after one step, with returns so large."""
    number = game.agents.number
    world = reset(game, {}, Threefry(0, 1))
    later, outcome = step(game, world, [0] * number, {}, Threefry(2, 3))
    return [
        moment_of(game, world, [0.0] * number),
        moment_of(game, later, [returns] * number, [0] * number, outcome),
    ]


def test_what_agents_are_shown_is_read_alike_from_the_interpreter_and_the_compiled_state(
    tmp_path: Path,
) -> None:
    game, file = rules(), tmp_path / "dell.sj"
    file.write_text(GAME)
    shot = moments(game)[1].snapshot
    env = sjdsl.make(file)
    _, state = env.reset(jax.random.key(0))
    _, state, _, _, _ = env.step_env(jax.random.key(1), state, np.zeros(3, int))
    for snapshot in (shot, take_snapshot(env, state, np.zeros(3))):
        assert join_readings(world_readings(game), snapshot) == ", ".join(WORLD)
        assert join_readings(agent_readings(game), snapshot, 1) == ", ".join(OWN)
    assert "thirst 7" in join_readings(agent_readings(game), shot, 0)


def test_a_page_has_all_of_it() -> None:
    after = episode_data(rules(), moments(rules()))["moments"][1]
    assert [" ".join(pair) for pair in after["world"]] == WORLD
    own = [" ".join(pair) for pair in after["own"][1]]
    rows = [(row, amount) for row, _, amount in after["held"][1]]
    assert own == [reading for reading in OWN if reading not in ROWS]
    assert rows == [("purse", 2), ("purse", 9), ("owed", 1), ("owed", 5)]


def test_the_terminal_has_all_of_it() -> None:
    game = rules()
    lines = list(moment_lines(moments(game)[1], make_letters(game), board_of(game)))
    assert lines[0] == f"step 1  {', '.join(WORLD)}"
    assert any(line.endswith(", ".join(OWN)) for line in lines)
    lines = list(moment_lines(moments(game)[1], make_letters(game), board_of(game), player=2))
    assert [line.split()[:2] for line in lines if " you " in line] == [["2", "you"]]


def test_a_picture_shows_a_change_of_each() -> None:
    """Each value that is shown changes the picture, and one that isn't shown does not."""
    game = rules()
    shot = moments(game)[1].snapshot
    painter = make_painter(SimpleNamespace(game=game), [shot])  # type: ignore[arg-type]
    first = np.asarray(painter.draw(shot))
    for name in (
        "world_wind",
        "world_ruler",
        "world_stock",
        "agent_thirst",
        "agent_purse",
        "agent_owed",
        "agent_seen",
        "agent_tired",
    ):
        other = replace(shot, values={**shot.values, name: np.zeros_like(shot.values[name])})
        assert (np.asarray(painter.draw(other)) != first).any(), name
    for name in ("world_secret", "agent_private"):
        other = replace(shot, values={**shot.values, name: np.zeros_like(shot.values[name])})
        assert (np.asarray(painter.draw(other)) == first).all(), name
