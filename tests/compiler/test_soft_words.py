"""Soft words are names wherever the grammar has no word, in right texts and in wrong ones."""

import pytest

from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.parse import automaton, parse, read_tree
from sjdsl.compiler.syntax.soft_words import SOFT
from sjdsl.format import format_source

# `zzz` stands for a name in every place that has one.
GAME = """sj 1
game small "A name in every place" {
  size zzz : count = 2
  episode zzz + 8
  kind zzz "." { field zzz : { none, zzz } = none  timer zzz  blocks zzz when zzz.zzz is zzz }
  group zzz = zzz, zzz
  map { ".." }
  agents zzz { acts stay, zzz, other  moves compass  field zzz by { zzz } : 0 .. zzz capped = zzz  forbid zzz when agent.zzz[zzz] > zzz }
  shape zzz = line(zzz)
  define zzz(zzz) = zzz.zzz[zzz] + zzz * zzz
  phase start { each agent as zzz { send zzz to zzz } }
  schedule zzz(zzz, zzz) -> tick
  phase zzz(zzz) {
    each agent as zzz on zzz as zzz in zzz of zzz where zzz chose zzz and zzz in { zzz, none } or zzz(zzz) > 0 {
      let zzz = zzz  draw zzz from { zzz, none }
      set zzz.zzz = case zzz { zzz: zzz, otherwise: zzz }
      add zzz to zzz.zzz[zzz]  give zzz to zzz  tally zzz[zzz] by zzz for zzz  mark zzz of zzz
    }
  }
  observe { window ahead zzz  show zzz.zzz as { zzz where zzz.zzz is zzz }  hide zzz on zzz when zzz.zzz is zzz }
  look zzz where zzz.zzz is zzz as green
  metrics { event zzz by { zzz }  mean zzz = count(zzz where zzz.zzz is zzz) }
  checks zzz { require zzz < zzz  expect zzz == zzz with never(zzz) over 3 episodes }
  policy zzz { when zzz.zzz > zzz choose zzz  seek zzz as zzz where zzz.zzz avoiding zzz  aim zzz at zzz choose zzz }
  scenario zzz "two" { slots zzz focal  slots zzz - 1 policy zzz }
  variant zzz { set zzz = zzz  drop zzz }
}
"""


def with_name(word: str) -> str:
    return GAME.replace("zzz", word)


@pytest.mark.parametrize("kind", sorted(SOFT))
def test_a_soft_word_is_a_name_wherever_a_name_can_stand(kind):
    word = automaton().words[kind]
    tokens, tree = read_tree(Source("game.sj", with_name(word)))
    others, other = read_tree(Source("game.sj", GAME))
    assert [t.type for t in tokens] == [t.type for t in others]
    assert [t.replace("zzz", word) for t in others] == list(tokens)
    assert tree.pretty() == other.pretty().replace("zzz", word)


@pytest.mark.parametrize("kind", sorted(SOFT))
def test_the_layout_of_a_name_does_not_depend_on_its_being_a_soft_word(kind):
    word = automaton().words[kind]
    short = "sj 1\ngame x {\n  define zzz=count( agent as zzz ) # why\n  param   zzz:reward=1\n}\n"
    wanted = format_source(Source("game.sj", short)).replace("zzz", word)
    assert format_source(Source("game.sj", short.replace("zzz", word))).split() == wanted.split()


def test_any_is_a_word_only_before_a_bracket():
    text = with_name("any").replace(
        "define any(any) = any.any[any] + any * any", "define zzz(any) = any.any[any] + any * any"
    )
    tokens, _ = read_tree(
        Source("game.sj", text.replace("any(any) > 0", "any(any where any > 1) and any > 0"))
    )
    assert [t.type for t in tokens if t == "any"].count("ANY") == 1
    assert [t.type for t in read_tree(Source("game.sj", with_name("any")))[0]].count("ANY") == 0, (
        "the game has a define of this name"
    )


def test_an_error_elsewhere_does_not_make_names_wrong():
    text = with_name("slots").replace("episode slots + 8", "episode slots +")
    with pytest.raises(CompileError) as found:
        parse(Source("game.sj", text))
    assert [d.span.line for d in found.value.diagnostics] == [5]


def test_a_soft_word_in_a_wrong_place_is_still_told_as_the_word():
    with pytest.raises(CompileError) as found:
        parse(Source("game.sj", "sj 1\ngame x {\n  phase p { slots 2 focal }\n}\n"))
    (problem,) = found.value.diagnostics
    assert "slots" in problem.message
