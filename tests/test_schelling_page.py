"""docs/schelling.md and its appendix say what the diagrams in docs/schelling hold, and the diagrams are of the policies in the games' files."""

import json
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

from sjdsl.compiler import build
from sjdsl.compiler.ir.hash import game_hash, policy_hash
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import find_game

ROOT = Path(__file__).parents[1]
DIAGRAMS = sorted(path.parent for path in (ROOT / "docs" / "schelling").glob("*/schelling.json"))


def test_the_tables_are_those_of_the_stored_diagrams() -> None:
    spec = spec_from_file_location("tables", ROOT / "docs" / "schelling" / "tables.py")
    assert spec is not None and spec.loader is not None
    tables = module_from_spec(spec)
    spec.loader.exec_module(tables)
    assert tables.main(check=True) == 0, "write them again with `python docs/schelling/tables.py`"


@pytest.mark.parametrize(
    "folder",
    [folder for folder in DIAGRAMS if not folder.name.endswith("_trained")],
    ids=lambda folder: folder.name,
)
def test_scripted_diagrams_are_of_the_policies_of_the_file(folder: Path) -> None:
    stored = json.loads((folder / "schelling.json").read_text(encoding="utf-8"))
    game = build(read_source(find_game(folder.name))).game
    digests = {policy.name: policy_hash(policy) for policy in game.policies}
    assert {part["name"]: part["players"][0]["digest"] for part in stored["policies"]} == digests


@pytest.mark.parametrize("folder", DIAGRAMS, ids=lambda folder: folder.name)
def test_diagrams_are_of_the_rules_of_the_file(folder: Path) -> None:
    stored = json.loads((folder / "schelling.json").read_text(encoding="utf-8"))
    rules = game_hash(build(read_source(find_game(stored["game"]["name"]))).game)
    assert stored["game"]["hash"] == rules, (
        "the rules have changed since: play the diagram again by the command in docs/schelling.md"
    )
