"""Writes what the VS Code extension takes from the language itself: its TextMate grammar and its snippets.

python editors/generate.py
"""

import json
from pathlib import Path
from typing import Any

from sjdsl.editor.highlighting import patterns
from sjdsl.editor.snippets import SNIPPETS

FOLDER = Path(__file__).parent / "vscode"


def grammar() -> dict[str, Any]:
    """Returns the TextMate grammar."""
    return {
        "$schema": "https://raw.githubusercontent.com/martinring/tmlanguage/master/tmlanguage.json",
        "name": "sj",
        "scopeName": "source.sj",
        "fileTypes": ["sj"],
        "patterns": patterns(),
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
