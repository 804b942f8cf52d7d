"""Writes what the VS Code extension takes from the language itself: its TextMate grammar and its snippets.

python editors/generate.py
"""

import json
from pathlib import Path
from typing import Any

from sjdsl.compiler.elaborate.constants import UNITS
from sjdsl.compiler.elaborate.row_functions import ROW_FUNCTIONS
from sjdsl.compiler.syntax.parse import automaton
from sjdsl.compiler.syntax.recovery.repair import ENTRIES, SECTIONS, STATEMENTS
from sjdsl.editor.fitting import CLASSES, FUNCTIONS
from sjdsl.editor.snippets import SNIPPETS
from sjdsl.runtime.actions import HEADINGS

FOLDER = Path(__file__).parent / "vscode"
NAMED = (
    "size",
    "param",
    "kind",
    "group",
    "define",
    "movers",
    "shape",
    "phase",
    "policy",
    "scenario",
    "variant",
    "event",
    "mean",
    "final",
    "game",
)
FIELDS = ("field", "timer")
CONTROL = ("when", "chance", "otherwise", "each", "pick", "first", "match", "case")
VALUES = ("nobody", "nowhere", "yes", "no", "same", *HEADINGS)
LANGUAGE = ("agent", "step")
NAME = "[a-z][a-z0-9_]*"


def word_groups() -> dict[str, list[str]]:
    """Returns the words of the language by how they are coloured; each is in one group."""
    table = automaton()
    words = {word: kind for kind, word in table.words.items() if word.isalpha()}
    groups: dict[str, list[str]] = {
        "keyword.control.sj": [],
        "storage.type.sj": [],
        "keyword.other.statement.sj": [],
        "keyword.operator.word.sj": [],
    }
    for word, kind in sorted(words.items()):
        if word in VALUES:
            continue
        scope = "keyword.operator.word.sj"
        if word in CONTROL:
            scope = "keyword.control.sj"
        elif kind in SECTIONS | ENTRIES or word in ("game", "sj", "extends", *FIELDS):
            scope = "storage.type.sj"
        elif kind in STATEMENTS:
            scope = "keyword.other.statement.sj"
        groups[scope].append(word)
    return groups


def any_of(words: Any) -> str:
    return "|".join(sorted(words))


def grammar() -> dict[str, Any]:
    """Returns the TextMate grammar."""
    patterns: list[dict[str, Any]] = [
        {"name": "comment.line.number-sign.sj", "match": "#.*$"},
        {
            "name": "string.quoted.double.sj",
            "begin": '"',
            "end": '"|$',
            "patterns": [{"name": "constant.character.escape.sj", "match": r"\\."}],
        },
        {"name": "constant.numeric.sj", "match": r"\b[0-9]+(\.[0-9]+)?\b"},
        {
            "match": rf"\b({any_of(NAMED)})\s+({NAME})",
            "captures": {"1": {"name": "storage.type.sj"}, "2": {"name": "entity.name.type.sj"}},
        },
        {
            "match": rf"\b({any_of(FIELDS)})\s+({NAME})",
            "captures": {"1": {"name": "storage.type.sj"}, "2": {"name": "variable.other.property.sj"}},
        },
        {
            "match": rf"\b(as|let|draw)\s+({NAME})",
            "captures": {"1": {"name": "keyword.operator.word.sj"}, "2": {"name": "variable.other.local.sj"}},
        },
        {"match": rf"\.\s*({NAME})", "captures": {"1": {"name": "variable.other.property.sj"}}},
        {"match": rf":\s*({any_of(UNITS)})\b", "captures": {"1": {"name": "support.type.sj"}}},
        {"name": "constant.language.sj", "match": rf"\b({any_of(VALUES)})\b"},
        {"name": "variable.language.sj", "match": rf"\b({any_of(LANGUAGE)})\b"},
        {
            "match": rf"\b({any_of((*FUNCTIONS, *ROW_FUNCTIONS, *CLASSES, 'count', 'sum'))})\s*(?=\()",
            "captures": {"1": {"name": "support.function.sj"}},
        },
        *({"name": scope, "match": rf"\b({any_of(words)})\b"} for scope, words in word_groups().items()),
        {"name": "keyword.operator.sj", "match": r"->|\.\.|<=|>=|==|!=|[-+*/%<>=]"},
    ]
    return {
        "$schema": "https://raw.githubusercontent.com/martinring/tmlanguage/master/tmlanguage.json",
        "name": "sj",
        "scopeName": "source.sj",
        "fileTypes": ["sj"],
        "patterns": patterns,
    }


def snippets() -> dict[str, Any]:
    """Returns the texts with gaps, as VS Code has them."""
    return {word: {"prefix": word, "body": text.split("\n"), "description": text.split("\n")[0]} for word, text in SNIPPETS.items()}


def files() -> dict[Path, str]:
    """Returns what is written where."""
    made = {FOLDER / "syntaxes" / "sj.tmLanguage.json": grammar(), FOLDER / "snippets" / "sj.json": snippets()}
    return {path: json.dumps(content, indent=2, ensure_ascii=False) + "\n" for path, content in made.items()}


if __name__ == "__main__":
    for path, text in files().items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        print(path.relative_to(Path(__file__).parents[1]))
