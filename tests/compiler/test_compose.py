"""Games on games and variants: `set` and `drop` in both, nothing said twice."""

from pathlib import Path

import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.syntax.read import read_source

BASE = """sj 1
game base "Base" {
  episode 9
  param apple : reward = 1
  param pay : reward = { red: 1, blue: 2 }
  kind grass "." { field colour : { red, blue } = red }
  map { ".." }
  agents 1 { acts stay, zap  field bag : 0 .. 9 = 0 }
  phase start { each agent { send agent to grass } }
  schedule rule
  phase rule { each agent on grass { give apple to agent  give pay[grass.colour] to agent } }
  metrics { mean reds = count(grass where grass.colour is red) }
  variant rich { %s }
}
"""


def game(folder: Path, changes: str, variant: str = "", *variants: str) -> ir.Game:
    """Returns a game on the base with these changes."""
    (folder / "base.sj").write_text(BASE % variant, encoding="utf-8")
    (folder / "more.sj").write_text(
        f'sj 1\ngame more "More" extends "base.sj" {{ {changes} }}\n', encoding="utf-8"
    )
    return build(read_source(folder / "more.sj"), variants).game


def codes(folder: Path, changes: str, variant: str = "", *variants: str) -> list[str]:
    with pytest.raises(CompileError) as error:
        game(folder, changes, variant, *variants)
    return [d.code for d in error.value.diagnostics]


def test_a_game_on_a_game_sets_and_drops(tmp_path: Path) -> None:
    made = game(tmp_path, "set apple = 3  set pay[blue] = -1  drop reds")
    assert {p.name: p.value for p in made.params} == {"apple": 3, "pay": (1, -1)}
    assert made.measures == ()


def test_a_variant_comes_after_the_game(tmp_path: Path) -> None:
    made = game(tmp_path, "set apple = 3", "set apple = 4", "rich")
    assert made.params[0].value == 4


def test_only_what_is_there_can_be_changed(tmp_path: Path) -> None:
    assert codes(tmp_path, "set aple = 3") == ["SJ108"]
    assert codes(tmp_path, "drop blues") == ["SJ108"]


def test_a_game_of_its_own_has_nothing_to_change(tmp_path: Path) -> None:
    (tmp_path / "alone.sj").write_text(
        (BASE % "").replace("episode 9", "episode 9  set apple = 2"), encoding="utf-8"
    )
    with pytest.raises(CompileError) as error:
        build(read_source(tmp_path / "alone.sj"))
    assert [d.code for d in error.value.diagnostics] == ["SJ002"]


@pytest.mark.parametrize(
    "changes",
    [
        "set apple = 2  set apple = 3",
        "set pay[red] = 2  set pay[red] = 2",
        "set pay = { red: 1, blue: 1 }  set pay[red] = 2",
    ],
)
def test_nothing_is_changed_twice(changes: str, tmp_path: Path) -> None:
    assert codes(tmp_path, changes) == ["SJ115"]
    assert codes(tmp_path, "", changes, "rich") == ["SJ115"]


def test_stay_cannot_be_forbidden(tmp_path: Path) -> None:
    assert codes(tmp_path, "agents { forbid zap, stay when agent.bag > 2 }") == ["SJ113"]
    assert game(tmp_path, "agents { forbid all when agent.bag > 2 }").agents.forbids


CHECKS = "checks { require apple > 0 }  checks cheap { require apple < 2  conserved count(agent) }  variant rich"


def test_checks_are_added_and_those_with_a_name_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Otherwise no game on this one could fail a check that belongs to the numbers of this one."""
    monkeypatch.setitem(globals(), "BASE", BASE.replace("variant rich", CHECKS))

    def sorts(changes: str, variant: str = "", *variants: str) -> list[str]:
        return [check.kind for check in game(tmp_path, changes, variant, *variants).checks]

    assert sorts("") == ["require", "require", "conserved"]
    assert sorts("checks { always apple > 0 }") == ["require", "always", "require", "conserved"]
    assert codes(tmp_path, "set apple = 3  checks dear { require apple > 2 }") == ["SJ212"]
    assert sorts("set apple = 3  checks cheap { require apple > 2 }") == ["require", "require"]
    assert sorts("set apple = 3  drop cheap") == ["require"]
    assert sorts("", "set apple = 3  checks cheap { always apple > 2 }", "rich") == [
        "require",
        "always",
    ]
    assert codes(tmp_path, "drop chaep") == ["SJ108"]
    assert codes(tmp_path, "checks cheap { } checks cheap { }") == ["SJ115"]


def test_a_define_that_a_base_has_for_other_games_is_not_missed(tmp_path: Path) -> None:
    """Of a game's own defines, and of a base's numbers, those that nothing uses are still told."""
    (tmp_path / "shared.sj").write_text(
        'sj 1\ngame shared "Shared" { define late(n) = step >= n  param idle : reward = 1 }\n',
        encoding="utf-8",
    )
    body = (BASE % "").replace('"Base" {', '"Base" extends "shared.sj" { define mine = step')
    (tmp_path / "base.sj").write_text(body, encoding="utf-8")
    told = [w.name for w in build(read_source(tmp_path / "base.sj")).warnings if w.code == "SJ505"]  # type: ignore[attr-defined]
    assert sorted(name for name in told if name not in ("bag", "agent.bag")) == ["idle", "mine"]
