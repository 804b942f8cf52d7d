"""A kind without cells on the map, whose field has rows: its state is empty, and keeps its form."""

from sjdsl.compiler import build
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.interpreter.state import default_params
from sjdsl.interpreter.step import reset
from sjdsl.interpreter.threefry import Threefry
from sjdsl.testing.states import compiled_state
from tests.fuzz.together import on_numpy

GAME = """sj 1
game bare "A kind that is not on the map" {
  episode 9
  kind grass "."
  kind crate "c" { field held by { red, green } : 0 .. 9 = 3 }
  map { ".." }
  agents 1 { acts stay }
  phase start { each agent { send agent to grass } }
  schedule empty
  phase empty { each crate { set crate.held = 0 } }
}
"""


def test_rows_of_no_cells() -> None:
    game = build(Source("bare.sj", GAME)).game
    env = on_numpy(game)
    blank = env.module.initial_state()
    state = compiled_state(env, blank, reset(game, default_params(game), Threefry(0, 1)))
    assert state.crate_held.shape == blank.crate_held.shape == (0, 2)
