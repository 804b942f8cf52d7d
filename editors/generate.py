"""Writes what is taken from the language itself: the TextMate grammar of the VS Code extension, and functions on the cheat sheet.

python editors/generate.py
"""

import json
import re
from pathlib import Path
from typing import Any

from sjdsl.compiler.ir.operations import FUNCTIONS
from sjdsl.editor.highlighting import patterns

GRAMMAR = Path(__file__).parent / "vscode" / "syntaxes" / "sj.tmLanguage.json"
SHEET = Path(__file__).parents[1] / "docs" / "cheatsheet.md"


def grammar() -> dict[str, Any]:
    """Returns the TextMate grammar."""
    return {
        "$schema": "https://raw.githubusercontent.com/martinring/tmlanguage/master/tmlanguage.json",
        "name": "sj",
        "scopeName": "source.sj",
        "fileTypes": ["sj"],
        "patterns": patterns(),
    }


def cheat_sheet() -> str:
    """Returns the cheat sheet as it stands, with all functions of the language."""
    before, _, after = re.split(
        r"(?<=## Functions\n\n```text\n)(.*?)(?=```)",
        SHEET.read_text("utf-8"),
        maxsplit=1,
        flags=re.DOTALL,
    )
    uses = [use for function in FUNCTIONS.values() for use in function.uses]
    return before + "".join(f"{written:<39}{gives}\n" for written, gives in uses) + after


def files() -> dict[Path, str]:
    """Returns what is written where."""
    return {
        SHEET: cheat_sheet(),
        GRAMMAR: json.dumps(grammar(), indent=2, ensure_ascii=False) + "\n",
    }


if __name__ == "__main__":
    for path, text in files().items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        print(path.relative_to(Path(__file__).parents[1]))
