"""The text of a trace, and the pictures in it."""

from collections.abc import Callable
from pathlib import Path

from sjdsl.compiler import build
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.read import read_source
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.state import default_params
from sjdsl.render.letters import make_letters
from sjdsl.trace.actions import read_actions
from sjdsl.trace.episode import play
from sjdsl.trace.lines import make_teller, moment_lines
from sjdsl.trace.rules import Rules

from .test_trace import SMALL

HERE = Path(__file__).parent


def text_of(game_text: str, actions: str, seed: int) -> str:
    made = build(Source("small.sj", game_text))
    choices, steps = read_actions(actions, made.game, None)
    teller = make_teller(board_of(made.game), Rules(made.sources))
    moments = play(made.game, default_params(made.game), seed, steps or 1, choices)
    return "".join(f"{line}\n" for moment in moments for line in moment_lines(moment, teller))


def test_a_small_game(golden: Callable[[Path, str], None]) -> None:
    golden(HERE / "small.txt", text_of(SMALL, "shout; leave; stay; shout", 33))


def test_every_state_has_a_character_of_its_own() -> None:
    for path in sorted((HERE.parents[1] / "games").glob("*.sj")):
        letters = make_letters(build(read_source(path)).game)
        characters = list(letters.characters.values())
        assert len(set(characters)) == len(characters), path
        assert not set(characters) & set("^>v<?"), path


def test_rules_are_told_as_they_are_written() -> None:
    text = SMALL.replace("chance luck {", "chance   # a comment\n luck {")
    made = build(Source("small.sj", text))
    rules = Rules(made.sources)
    chance = made.game.schedule[1].body[0].body[0]
    assert rules.text(chance) == "chance luck"
    assert rules.branch(chance, 1) == "otherwise chance 0.5"
    assert rules.place(chance) == "small.sj:17"
    assert rules.text(chance.branches[0].body[0]) == "set tree.fruit = ripe"


POND = """sj 1
game pond "A pond" {
  param best : probability = 1
  param worst : fraction = 0.5 in 0.1 .. 1
  episode 9
  kind reed  "R" { field fruit : { none, ripe } = none }
  kind water "w" { field state : { clean, dirty } = clean }
  kind mud   "m"
  map { "Rwmm" }
  agents 1 { acts stay }
  define dirt = count(water where water.state is dirty) / count(mud)
  define growth = best * ramp(dirt, worst, 0)
  phase start { each agent { send agent to mud } }
  schedule spoil -> grow
  phase spoil { each water { when step >= 1 { set water.state = dirty } } }
  phase grow { each reed where reed.fruit is none and growth > 0 { chance growth { set reed.fruit = ripe } } }
}
"""


def test_a_change_has_the_values_its_rule_read_and_their_formulas() -> None:
    """In step 0 no water is dirty, so that growth is 1 * ramp(0 / 2, 0.5, 0) = 1; in step 1 the water is spoilt, for 1 >= 1."""
    text = text_of(POND, "stay; stay", 0)
    assert (
        """      reed (0, 0)  fruit: none -> ripe
        because reed.fruit is none and growth > 0, with growth = 1
          growth = best * ramp(dirt, worst, 0) = 1, with best = 1, dirt = 0, worst = 0.5
            dirt = count(water where water.state is dirty) / count(mud) = 0, with count(water where water.state is dirty) = 0, count(mud) = 2
        and chance growth drew """
        in text
    )
    assert "random bits" not in text
    assert (
        """      water (0, 1)  state: clean -> dirty
        because step >= 1, with step = 1
"""
        in text
    )
