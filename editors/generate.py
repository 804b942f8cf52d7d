"""Writes what editors and the cheat sheet take from the language: grammar, syntax file, functions.

python editors/generate.py
"""

import json
import re
from pathlib import Path
from typing import Any

from sjdsl.compiler.ir.operations import FUNCTIONS
from sjdsl.editor.highlighting import patterns

EDITORS = Path(__file__).parent
TEXTMATE_GRAMMAR = EDITORS / "vscode" / "syntaxes" / "sj.tmLanguage.json"
VIM_SYNTAX = EDITORS / "vim" / "syntax" / "sj.vim"
CHEAT_SHEET = EDITORS.parent / "docs" / "cheatsheet.md"

VIM_GROUPS = {  # TextMate's scopes and the colour groups of Vim
    "comment.line.number-sign.sj": "Comment",
    "string.quoted.double.sj": "String",
    "constant.character.escape.sj": "SpecialChar",
    "constant.numeric.sj": "Number",
    "constant.language.sj": "Constant",
    "storage.type.sj": "Structure",
    "entity.name.type.sj": "Type",
    "variable.other.property.sj": "Identifier",
    "variable.other.local.sj": "Identifier",
    "variable.language.sj": "Special",
    "support.type.sj": "Type",
    "support.function.sj": "Function",
    "keyword.control.sj": "Conditional",
    "keyword.other.statement.sj": "Statement",
    "keyword.operator.word.sj": "Keyword",
    "keyword.operator.sj": "Operator",
    "punctuation.accessor.sj": "Delimiter",
    "punctuation.separator.sj": "Delimiter",
}

VIM_START = """\
" Syntax file of the language sj for Vim and Neovim; written by editors/generate.py.
" Of several matches at one place Vim takes the one that is defined last.
if exists("b:current_syntax")
  finish
endif
syntax case match
"""


def textmate_grammar() -> str:
    """Returns the TextMate grammar as JSON."""
    grammar = {
        "$schema": "https://raw.githubusercontent.com/martinring/tmlanguage/master/tmlanguage.json",
        "name": "sj",
        "scopeName": "source.sj",
        "fileTypes": ["sj"],
        "patterns": patterns(),
    }
    return json.dumps(grammar, indent=2, ensure_ascii=False) + "\n"


def vim_syntax() -> str:
    """Returns a Vim syntax file that colours as the TextMate grammar does."""
    lines = [line for pattern in reversed(patterns()) for line in vim_items(pattern)]
    links = [
        f"highlight default link {vim_item(scope)} {group}" for scope, group in VIM_GROUPS.items()
    ]
    return VIM_START + "\n".join([*lines, *links, 'let b:current_syntax = "sj"']) + "\n"


def vim_items(pattern: dict[str, Any]) -> list[str]:
    """Returns the commands of Vim for one pattern of the TextMate grammar.

    Of a pattern with three groups the first is an item, the second is white space, and the third is
    an item that Vim tries only behind the first.
    """
    if "begin" in pattern:
        item = vim_item(pattern["name"])
        begin = vim_pattern(pattern["begin"])
        end = vim_pattern(pattern["end"])
        inner = [line for within in pattern["patterns"] for line in vim_items(within)]
        names = ",".join(vim_item(within["name"]) for within in pattern["patterns"])
        return [
            *(f"{line} contained" for line in inner),
            f"syntax region {item} start='{begin}' end='{end}' contains={names}",
        ]
    match = pattern["match"]
    if "name" in pattern:
        return [f"syntax match {vim_item(pattern['name'])} '{vim_pattern(match)}'"]
    items = [vim_item(capture["name"]) for capture in pattern["captures"].values()]
    if len(items) == 1:
        return [f"syntax match {items[0]} '{vim_pattern(match)}'"]
    group = r"(\((?:\\.|[^()\\])*\))"
    parts = re.fullmatch(rf"(.*?){group}{group}{group}(.*)", match)
    assert parts is not None, match
    start, first, space, second, end = parts.groups()
    before = vim_pattern(start + first)
    behind = vim_pattern(space + second + end)
    return [
        f"syntax match {items[0]} '{before}\\ze{behind}' nextgroup={items[2]} skipwhite",
        f"syntax match {items[2]} '{vim_pattern(second + end)}' contained",
    ]


def vim_pattern(regex: str) -> str:
    """Returns a regular expression of TextMate, of the few kinds that `patterns` has, as Vim's."""
    regex = re.sub(r"\(\?=(.*)\)$", r"\\ze\1", regex)
    regex = re.sub(r"^\\b", r"\\<", regex).replace(r"\b", r"\>")
    return re.sub(r"\[[^]]*\]|\\.|[()|+?]", _vim_token, regex)


def _vim_token(token: re.Match[str]) -> str:
    """Returns a class or an escaped sign as it is; for signs with a meaning Vim needs a backslash."""
    text = token[0]
    if text in ("\\(", "\\)"):
        return text[1]
    if len(text) == 1:
        return "\\" + text
    return text


def vim_item(scope: str) -> str:
    """Returns the name of a syntax item: sjKeywordControl for keyword.control.sj."""
    parts = re.findall(r"[a-z]+", scope.removesuffix(".sj"))
    return "sj" + "".join(part.title() for part in parts)


def cheat_sheet() -> str:
    """Returns the cheat sheet as it stands, with all functions of the language."""
    before, _, after = re.split(
        r"(?<=## Functions\n\n```text\n)(.*?)(?=```)",
        CHEAT_SHEET.read_text("utf-8"),
        maxsplit=1,
        flags=re.DOTALL,
    )
    uses = [use for function in FUNCTIONS.values() for use in function.uses]
    return before + "".join(f"{written:<39}{gives}\n" for written, gives in uses) + after


def files() -> dict[Path, str]:
    """Returns the text of each file that is written."""
    return {
        CHEAT_SHEET: cheat_sheet(),
        TEXTMATE_GRAMMAR: textmate_grammar(),
        VIM_SYNTAX: vim_syntax(),
    }


if __name__ == "__main__":
    for path, text in files().items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        print(path.relative_to(EDITORS.parent))
