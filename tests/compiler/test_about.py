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


def test_texts_in_a_row_are_one() -> None:
    assert built('about summary "one"\n "two"  about paradigm "none"').about == (
        ("summary", "one two"),
        ("paradigm", "none"),
    )


def test_a_variant_says_it_anew() -> None:
    assert built('about paradigm "none"  about summary "s"', "other").about == (
        ("paradigm", "commons"),
        ("summary", "s"),
    )


def test_a_variant_takes_it_away() -> None:
    assert built('about paradigm "none"  about summary "s"', "silent").about == (("summary", "s"),)


def test_it_is_no_rule() -> None:
    assert game_hash(built('about paradigm "none"')) == game_hash(built('cite "somebody"'))


def test_each_name_once() -> None:
    with pytest.raises(CompileError) as error:
        built('about paradigm "none" about paradigm "commons"')
    assert [d.code for d in error.value.diagnostics] == ["SJ115"]


def test_an_extending_game_inherits(tmp_path: Path) -> None:
    (tmp_path / "plain.sj").write_text(
        GAME.format(about='about summary "base"  about paradigm "none"'), encoding="utf-8"
    )
    text = 'sj 1\ngame more "More" extends "plain.sj" { about summary "more" }\n'
    (tmp_path / "more.sj").write_text(text, encoding="utf-8")
    game = build(read_source(tmp_path / "more.sj")).game
    assert game.about == (("summary", "more"), ("paradigm", "none"))
