"""What editors and pre-commit take from the language is up to date: grammars, snippets, hooks."""

import json
import re
import runpy
from pathlib import Path

import pytest
import yaml

from sjdsl.cli import COMMANDS
from sjdsl.compiler import check
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.elaborate.constants import UNITS
from sjdsl.compiler.ir.operations import FUNCTIONS
from sjdsl.compiler.syntax.parse import automaton
from sjdsl.editor.highlighting import VALUES, patterns, word_groups

ROOT = Path(__file__).parents[2]
VSCODE = ROOT / "editors" / "vscode"
GENERATE = runpy.run_path(str(ROOT / "editors" / "generate.py"))
SNIPPETS = json.loads((VSCODE / "snippets" / "sj.json").read_text("utf-8"))
PACKAGE = json.loads((VSCODE / "package.json").read_text("utf-8"))


@pytest.mark.parametrize("path", GENERATE["files"](), ids=lambda path: path.name)
def test_what_is_generated_is_up_to_date(path: Path) -> None:
    assert path.read_text("utf-8") == GENERATE["files"]()[path], "run `python editors/generate.py`"


def test_every_word_of_the_language_has_one_colour() -> None:
    groups = word_groups()
    listed = [word for words in groups.values() for word in words]
    words = {word for word in automaton().words.values() if word.isalpha()}
    assert len(listed) == len(set(listed))
    assert set(listed) | set(VALUES) >= words
    assert set(listed) <= words
    assert all(groups.values())


def test_every_keyword_function_and_unit_is_in_the_syntax_file_of_vim() -> None:
    keywords = {word for word in automaton().words.values() if word.isalpha()}
    named = set(re.findall(r"[a-z_]+", GENERATE["VIM_SYNTAX"].read_text("utf-8")))
    assert keywords | set(FUNCTIONS) | set(UNITS) <= named


def test_the_patterns_of_the_grammar_are_regular_expressions() -> None:
    found = [p[key] for p in patterns() for key in ("match", "begin", "end") if key in p]
    assert len(found) > 12
    assert all(re.compile(pattern) for pattern in found)


def test_what_the_extension_names_is_there() -> None:
    contributes = PACKAGE["contributes"]
    named = [
        PACKAGE["main"],
        contributes["languages"][0]["configuration"],
        contributes["grammars"][0]["path"],
        contributes["snippets"][0]["path"],
    ]
    assert [name for name in named if not (VSCODE / name).is_file()] == []
    script = (VSCODE / PACKAGE["main"]).read_text("utf-8")
    run = set(json.loads(re.search(r"COMMANDS = (\[.*\])", script).group(1)))  # type: ignore[union-attr]
    assert {f"sjdsl.{name}" for name in run} | {"sjdsl.restart"} == {
        command["command"] for command in contributes["commands"]
    }
    assert run - {"studio"} <= set(COMMANDS)
    lock = (VSCODE / "package-lock.json").read_text("utf-8")
    assert "resolved" not in lock, "the lock file names no registry"


@pytest.mark.parametrize("word", SNIPPETS)
def test_a_text_with_gaps_can_be_written_where_its_word_can(word: str) -> None:
    filled = re.sub(r"\$\{\d+:([^}]*)\}", r"\1", "\n".join(SNIPPETS[word]["body"])).replace(
        "$0", ""
    )
    places = (
        "{}",
        "sj 1 game x {{ {} }}",
        "sj 1 game x {{ phase p {{ {} }} }}",
        "sj 1 game x {{ checks {{ {} }} }}",
        "sj 1 game x {{ define d = {} }}",
    )
    errors = [
        [
            d
            for d in check(Source("x.sj", place.format(filled)))
            if d.code == "SJ002" and "expected" in d.message
        ]
        for place in places
    ]
    gaps = {"define", "case", "count", "checks", "policy"}
    assert word in gaps or [] in errors


def test_hooks_run_commands_that_there_are() -> None:
    hooks = {
        hook["id"]: hook
        for hook in yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text("utf-8"))
    }
    assert set(hooks) == {"sjdsl-fmt", "sjdsl-check"}
    for hook in hooks.values():
        program, command = hook["entry"].split()
        assert program == "sjdsl" and command in COMMANDS
        assert re.search(hook["files"], "games/coins.sj") and not re.search(
            hook["files"], "games/coins.toml"
        )
