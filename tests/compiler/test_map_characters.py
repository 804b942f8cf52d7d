"""What a character of the map says of its cell at the start: words, numbers, and agents, of whom there is none yet."""

from sjdsl.compiler import build, compile_source
from sjdsl.compiler.diagnostics.source import Source

GAME = """sj 1
game frame "Characters" {
  episode 9
  kind grass "." {
    field owner : agent = nobody
    field height : 0 .. 9 = 1
    glyph "q" with owner = nobody
    glyph "h" with height = 3
  }
  map { "..qh" }
  agents 2 { acts stay }
  phase start { each agent { send agent to grass } }
  schedule rule
  phase rule { each agent on grass as g where g.owner is nobody and g.height > 2 { set g.owner = agent } }
}
"""


def test_a_character_can_say_that_nobody_is_held():
    game = build(Source("frame.sj", GAME)).game
    assert {meaning.glyph: meaning.starts for meaning in game.glyphs} == {
        ".": (),
        "q": (("owner", None),),
        "h": (("height", 3),),
    }
    assert "grass_owner" in compile_source(Source("frame.sj", GAME))
