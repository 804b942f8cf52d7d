"""The hash of a game: of what the rules say, under names of its own."""

import re
import tomllib
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.compose import compose
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.diagnostics.tree import rewrite
from sjdsl.compiler.ir.hash import HASHED, game_hash
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import bundled, find_game, games_folder, main_games

HASHES = tomllib.loads((games_folder() / "hashes.toml").read_text("utf-8"))
CASES = sorted((Path(__file__).parents[1] / "cases").glob("*.sj"))
UNHASHED = {
    ir.Game,
    ir.Named,
    ir.Narrowed,
    ir.Size,
    ir.Policy,
    ir.Slots,
    ir.Scenario,
    ir.TaskPart,
    ir.GivenPart,
}  # by name, seen through, or beside the rules
IN_CHECKS = {ir.Before, ir.EventTotal}  # and never in `require`
INFERRED = {  # of classes other than expressions: what follows from the rest
    ir.Given: {"type"},
    ir.Draw: {"type"},
    ir.Send: {"pool"},
    ir.VarField: {"held_by"},
    ir.ActionArgument: {"count"},
    ir.ActionWithArguments: {"first"},
    ir.Forbid: {"action", "names"},
    ir.Phase: {"name"},
    ir.Task: {"fields", "name", "number_stream", "row_stream", "side", "split", "given"},
    ir.TrainOn: {"candidates"},
    ir.HoldOut: {"name"},
    ir.Event: {"per_agent"},
    ir.Check: {"words", "policies", "episodes"},
    ir.ScriptedPolicy: {"title"},
    ir.Act: {"chosen"},
    ir.Aim: {"chosen"},
    ir.FieldRead: {"type", "held_by"},
    ir.ArgumentOf: {"type", "name"},
}
GAME = """sj 1
game plain "Plain" {
  size most : count = 3
  param rate : probability = 0.5 in 0.1 .. 0.9
  episode 30
  kind soil "." { field fruit : { raw, ripe } = raw  field worms : 0 .. most capped = 1  timer rest }
  kind rock "#" { blocks agents }
  map { "..#" "..." }
  agents 2 { acts stay, gather }
  field season : { wet, dry } = wet
  define many(cell) = cell.worms > 1
  phase start { each agent { send agent to soil } }
  schedule grow -> eat -> tick
  phase grow {
    each soil where soil.fruit is raw and soil.rest == 0 {
      chance rate { set soil.fruit = ripe  set soil.rest = 3 }
      otherwise { when many(soil) { set soil.worms = 0 } otherwise { add 1 to soil.worms } }
    }
  }
  phase eat {
    each agent on soil where agent chose gather and soil.fruit is ripe { give 2 to agent  tally picked for agent  set soil.fruit = raw }
  }
  observe { window ahead 3, behind 0, left 1, right 1  show soil.fruit }
  metrics { event picked  final worms = sum(soil.worms over soil) }
  checks { require rate > 0.05  always count(soil) == 5 }
}
"""


def hash_of(text: str) -> str:
    return game_hash(build(Source("plain.sj", text)).game)


def nodes() -> set[type[ir.Node]]:
    """Returns all classes of nodes."""
    found = {
        kind for kind in vars(ir).values() if isinstance(kind, type) and issubclass(kind, ir.Node)
    }
    return {kind for kind in found if not kind.__subclasses__()}


def test_every_class_and_field_is_said_or_left_out_on_purpose() -> None:
    assert nodes() == (HASHED.keys() - {ir.Type}) | UNHASHED | IN_CHECKS
    for kind, said in HASHED.items():
        named = [name.rpartition("=")[2].partition(".")[0] for name in said.split()[1:]]
        left_out = kind.model_fields.keys() - {*named, "origin"}
        assert left_out == INFERRED.get(kind, {"type"} & kind.model_fields.keys() - set(named)), (
            kind
        )
        assert set(named) <= kind.model_fields.keys(), kind


def test_a_tag_is_one_class() -> None:
    """`param` is one where it is declared and where it is read, `window` the whole and a part: places that no class shares."""
    tags = Counter(said.split()[0] for said in HASHED.values())
    assert {tag for tag, times in tags.items() if times > 1} == {"param"}


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("size most", "size largest"),
        ("many", "wormy"),
        ("    each soil where", "    # a remark\n\n    each   soil where"),
        ('"Plain"', '"Another title"'),
        ("always count(soil) == 5", "always count(soil) > 4"),
        (
            "  observe {",
            '  cite "somebody"\n  about summary "plain"\n  look soil as tree\n  observe {',
        ),
        ("  metrics {", "  variant dry { set rate = 0.2 }\n  metrics {"),
        ("  metrics {", "  group land = soil, rock\n  metrics {"),
    ],
)
def test_what_changes_nothing_that_happens_keeps_it(old: str, new: str) -> None:
    text = re.sub(rf"\b{old}\b", new, GAME) if old == "many" else GAME.replace(old, new)
    text = text.replace(".. most", ".. largest") if "largest" in new else text
    assert text != GAME and hash_of(text) == hash_of(GAME)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("game plain", "game other"),
        ("count = 3", "count = 4"),
        ("0.5 in", "0.6 in"),
        ("0.1 .. 0.9", "0.2 .. 0.9"),
        ("episode 30", "episode 31"),
        (" capped", ""),
        ('"..#"', '"..."'),
        ("agents 2", "agents 3"),
        ("acts stay, gather", "acts gather, stay"),
        ("= wet", "= dry"),
        ("grow -> eat", "eat -> grow"),
        ("is raw and", "is ripe and"),
        ("cell.worms > 1", "cell.worms >= 1"),
        ("give 2 to agent", "give 2.0 to agent"),
        ("add 1 to", "add 2 to"),
        ("show soil.fruit", "show soil.fruit as { food where soil.fruit is ripe, none_yet }"),
        ("left 1", "left 0"),
        ("final worms", "mean worms"),
        ("rate > 0.05", "rate > 0.06"),
        ("set soil.worms = 0", "set soil.worms = 1"),
        ("{ set soil.worms = 0 } otherwise { add 1 to soil.worms }", "{ set soil.worms = 0 }"),
    ],
)
def test_what_the_rules_say_is_in_it(old: str, new: str) -> None:
    assert old in GAME and hash_of(GAME.replace(old, new)) != hash_of(GAME)


@pytest.mark.parametrize("case", CASES, ids=lambda path: path.stem)
def test_inferred_types_are_not(case: Path) -> None:
    """Of expressions and draws; not of what is shown, since agents see numbers in proportion to the largest."""
    game = build(read_source(case)).game

    def wider(node: Any) -> Any:
        if isinstance(node, ir.Draw) or (isinstance(node, ir.Node) and ir.is_expression(node)):
            return node.model_copy(
                update={"type": node.type.model_copy(update={"low": -12345.0, "high": 54321.0})}
            )
        return node

    changed = rewrite(game, wider)
    assert changed != game and game_hash(changed) == game_hash(game)


def test_a_whole_number_is_no_real() -> None:
    numbers = [
        n
        for case in CASES
        for n in ir.walk(build(read_source(case)).game)
        if isinstance(n, ir.Number)
    ]
    assert [n for n in numbers if isinstance(n.value, float) != (n.type.kind == "real")] == []
    assert {type(n.value) for n in numbers} == {int, float}


def test_each_bundled_game_has_its_hashes() -> None:
    assert sorted(HASHES) == bundled()


@pytest.mark.parametrize(
    "name",
    [
        name if name in main_games() else pytest.param(name, marks=pytest.mark.thorough)
        for name in bundled()
    ],
)
def test_the_rules_of_a_game_and_its_variants_have_their_hashes(name: str) -> None:
    source = read_source(find_game(name))
    hashes = {"": game_hash(build(source).game)}
    for variant in compose(source).variants:
        hashes[variant] = game_hash(build(source, (variant,)).game)
    assert HASHES[name] == hashes
