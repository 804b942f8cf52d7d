"""Metadata: `about` lines are joined, replaced by name, said once, and do not touch the rules."""

from pathlib import Path

import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.ir.hash import game_hash
from sjdsl.compiler.syntax.read import read_source

GAME = """sj 1
game plain "Plain" {{
  {about}
  episode 3
  kind grass "."
  map {{ "." }}
  agents 1 {{ acts stay }}
  phase start {{ each agent {{ send agent to grass }} }}
  schedule rest
  phase rest {{ }}
  variant other {{ about paradigm "commons" }}
  variant silent {{ drop paradigm }}
}}
"""


def built(about: str, *variants: str) -> ir.Game:
    return build(Source("plain.sj", GAME.format(about=about)), variants).game


@pytest.mark.parametrize(
    ("about", "variants", "expected"),
    [
        ('about summary "one"\n "two"  about paradigm "none"', (), (("summary", "one two"), ("paradigm", "none"))),
        ('about paradigm "none"  about summary "s"', ("other",), (("paradigm", "commons"), ("summary", "s"))),
        ('about paradigm "none"  about summary "s"', ("silent",), (("summary", "s"),)),
    ],
)
def test_texts_are_joined_replaced_and_taken_away(about: str, variants: tuple[str, ...], expected: tuple[tuple[str, str], ...]) -> None:
    assert built(about, *variants).about == expected


def test_it_is_no_rule() -> None:
    assert game_hash(built('about paradigm "none"')) == game_hash(built('cite "somebody"'))


def test_each_name_once() -> None:
    with pytest.raises(CompileError, match="SJ115"):
        built('about paradigm "none" about paradigm "commons"')


def test_an_extending_game_inherits(tmp_path: Path) -> None:
    (tmp_path / "plain.sj").write_text(GAME.format(about='about summary "base"  about paradigm "none"'), encoding="utf-8")
    text = 'sj 1\ngame more "More" extends "plain.sj" { about summary "more" }\n'
    (tmp_path / "more.sj").write_text(text, encoding="utf-8")
    game = build(read_source(tmp_path / "more.sj")).game
    assert game.about == (("summary", "more"), ("paradigm", "none"))
