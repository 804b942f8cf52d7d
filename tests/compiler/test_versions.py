"""Versions of the language: a file says the one it needs, and `sjdsl fmt --upgrade` writes it."""

from pathlib import Path

import pytest

from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.parse import parse, read_tree
from sjdsl.compiler.syntax.versions import NEWEST, VERSIONS, needed
from sjdsl.format.upgrade import upgrade
from sjdsl.games_folder import games_folder

GAME = """# ours
sj {version}  # the first line
game pond "Pond" {{
  {number}
  episode 3
  kind shore "." {{ field fruit : {{ none, ripe }} = none  field depth {row} : 0 .. 3 }}
  kind bank  "b"
  map {wraps} {{ "..b" }}
  agents 2 {{ acts {acts}, stay  moves relative  field home : {home}  {blocks} }}
  {movers}
  phase start {{ each agent {{ send agent to shore }} }}
  schedule walk
  phase walk {{ move each agent {course}  each agent on shore as s {{ set s.fruit = ripe {lot}  when agent chose {chose} {{ }} {sent} }} }}
  observe {{ window ahead 1, behind 0, left 1, right 1 {seen} }}
  define late = {late}
  checks {{ always {always} }}
}}
"""
PLAIN = {
    "number": "param apple : reward = 1",
    **dict.fromkeys(("wraps", "row", "movers", "lot", "course", "blocks", "sent", "seen"), ""),
    "acts": "zap",
    "home": "0 .. 3",
    "chose": "zap",
    "late": "step > 5",
    "always": "late",
}
LATER = {
    "wraps": "wraps",
    "row": "by 0 .. 2",
    "movers": 'movers deer 1 "d"',
    "lot": "by lot",
    "course": "at random",
    "acts": "vote(agent)",
    "home": "cell of shore",
    "chose": "zap(1)",
    "blocks": "blocks agents",
    "seen": "when step > 1",
    "number": "param apple by agent : reward = 1",
}
LATEST = {
    "late": "any(agent on bank)",
    "always": "all(agent where agent.home > 1)",
    "number": "param apple : number = 1",
    "lot": "draw n from { 1: 0.5, 3: 0.5 }",
    "seen": "show late",
    "sent": "give quotient(agent.home, 2) to agent",
    "course": "each agent { give round(apple) to agent }",
}


def pond(version: str = "1", **parts: str) -> Source:
    return Source("pond.sj", GAME.format(version=version, **PLAIN | parts))


def test_a_game_of_the_first_language_stays() -> None:
    assert needed(parse(pond()))[0] == "1"
    assert upgrade(pond()) is None


@pytest.mark.parametrize("part", LATER)
def test_what_came_later_is_raised_for(part: str) -> None:
    source = pond(**{part: LATER[part]})
    raised = upgrade(source)
    assert raised is not None
    assert raised.version == "1.1"
    assert raised.source.text == pond("1.1", **{part: LATER[part]}).text, "nothing else is changed"
    assert raised.line == next(i for i, line in enumerate(source.text.splitlines(), 1) if LATER[part] in line)
    assert upgrade(raised.source) is None, "doing it again changes nothing"


@pytest.mark.parametrize("part", LATEST)
def test_what_came_last_is_raised_for(part: str) -> None:
    assert needed(parse(pond(**{part: LATEST[part]})))[0] == "1.2"
    assert needed(parse(pond(**LATER | {part: LATEST[part]})))[0] == "1.2", "whatever else a file needs"


def test_before_came_last_and_show_step_too() -> None:
    assert needed(parse(pond(always="before(step) < step")))[0] == "1.2"
    assert needed(parse(pond(seen="show step")))[0] == "1.2"
    assert needed(parse(pond(seen="show agent.home")))[0] == "1"


@pytest.mark.parametrize("name", ["any", "round", "quotient", "before"])
def test_a_define_of_a_name_that_became_one_of_the_language_stays(name: str) -> None:
    text = pond(late=f"{name}(step, 5)").text.replace("define late", f"define {name}(a, b) = a > b  define late")
    assert needed(parse(Source("pond.sj", text)))[0] == "1"


@pytest.mark.parametrize("sent", ["send agent by 1 ahead", "send agent to agent.den"])
def test_sending_by_a_direction_and_to_a_held_cell_came_later(sent: str) -> None:
    assert needed(parse(pond(sent=sent)))[0] == "1.1"


def test_a_file_may_say_more_than_it_needs() -> None:
    assert upgrade(pond("1.1")) is None


@pytest.mark.parametrize("version", VERSIONS)
def test_the_line_does_not_change_what_a_file_means(version: str) -> None:
    said, plain = read_tree(pond(version))[1], read_tree(pond())[1]
    assert said.children[1:] == plain.children[1:]


def test_a_newer_language_is_refused_with_what_to_do() -> None:
    with pytest.raises(CompileError) as caught:
        parse(pond("1.3"))
    (problem,) = caught.value.diagnostics
    assert problem.code == "SJ001"
    assert problem.message == f"this file is for `sj 1.3`, and this compiler reads `sj 1` to `sj {NEWEST}`"


def test_bundled_games_say_what_they_need() -> None:
    behind = [path for path in games_folder().rglob("*.sj") if upgrade(Source(path.name, path.read_text("utf-8"), path.parent)) is not None]
    assert not behind, "`sjdsl fmt --upgrade games` writes the first lines"


def test_the_page_has_all_versions() -> None:
    page = (Path(__file__).parents[2] / "docs/versions.md").read_text("utf-8")
    assert all(f"| `sj {version}` |" in page for version in VERSIONS)
