"""The text of a trace, and the pictures in it."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

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
from sjdsl.trace.wording import say_value

from .test_trace import SMALL

HERE = Path(__file__).parent


def text_of(game_text: str, actions: str, seed: int, everything: bool) -> str:
    made = build(Source("small.sj", game_text))
    choose, steps = read_actions(actions, made.game, None)
    teller = make_teller(board_of(made.game), Rules(made.sources), (), everything)
    moments = play(made.game, default_params(made.game), seed, steps or 1, choose)
    return "".join(f"{line}\n" for moment in moments for line in moment_lines(moment, teller))


def test_a_small_game(golden: Callable[[Path, str], None]) -> None:
    golden(HERE / "small.txt", text_of(SMALL, "shout; leave; stay; shout", 2, everything=False))


def test_a_small_game_with_all_that_did_not_happen(golden: Callable[[Path, str], None]) -> None:
    golden(HERE / "small_all.txt", text_of(SMALL, "shout; leave; stay; shout", 2, everything=True))


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


def test_a_row_is_told_entry_by_entry() -> None:
    assert say_value((np.float32(1), np.float32(0.5))) == "[1, 0.5]"
    assert say_value(((1, 2), (3, 4))) == "[[1, 2], [3, 4]]"
