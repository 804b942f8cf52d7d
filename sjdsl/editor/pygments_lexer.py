"""A Pygments lexer of the language, made from the same patterns as the TextMate grammar: for Sphinx, MkDocs, LaTeX and terminals."""

import re
from collections.abc import Callable, Iterator
from typing import Any, ClassVar, TypeAlias

from pygments.lexer import RegexLexer
from pygments.token import (
    Comment,
    Keyword,
    Name,
    Number,
    Operator,
    Punctuation,
    String,
    Text,
    Whitespace,
)

from sjdsl.editor.highlighting import NAME, patterns

TOKENS = {  # TextMate's scopes as Pygments has them
    "comment.line.number-sign.sj": Comment.Single,
    "string.quoted.double.sj": String.Double,
    "constant.character.escape.sj": String.Escape,
    "constant.numeric.sj": Number,
    "constant.language.sj": Keyword.Constant,
    "storage.type.sj": Keyword.Declaration,
    "entity.name.type.sj": Name.Class,
    "variable.other.property.sj": Name.Attribute,
    "variable.other.local.sj": Name.Variable,
    "variable.language.sj": Name.Builtin.Pseudo,
    "support.type.sj": Keyword.Type,
    "support.function.sj": Name.Builtin,
    "keyword.control.sj": Keyword,
    "keyword.other.statement.sj": Keyword.Reserved,
    "keyword.operator.word.sj": Operator.Word,
    "keyword.operator.sj": Operator,
}
Token: TypeAlias = Any  # a type of Pygments, which has no types of its own
Coloured: TypeAlias = Iterator[tuple[int, Token, str]]
Action: TypeAlias = Token | Callable[[Any, re.Match[str]], Coloured]
Rule: TypeAlias = tuple[str, Action] | tuple[str, Action, str]


def rules(found: list[dict[str, Any]]) -> dict[str, list[Rule]]:
    """Returns the states of a lexer, `root` among them, that colours as a TextMate grammar of these patterns does.

    Raises KeyError for a scope that has no token.
    """
    states: dict[str, list[Rule]] = {"root": [(r"\s+", Whitespace)]}
    for pattern in found:
        if "begin" in pattern:
            token, inner = TOKENS[pattern["name"]], pattern["name"]
            states["root"].append((pattern["begin"], token, inner))
            states[inner] = [(pattern["end"], token, "#pop")]
            states[inner] += [(within["match"], TOKENS[within["name"]]) for within in pattern["patterns"]]
            states[inner].append((r"[\s\S]", token))
        elif "name" in pattern:
            states["root"].append((pattern["match"], TOKENS[pattern["name"]]))
        else:
            groups = {int(number): TOKENS[scope["name"]] for number, scope in pattern["captures"].items()}
            states["root"].append((pattern["match"], by_groups(groups)))
    states["root"] += [(NAME, Name), (r"[A-Za-z_]\w*", Text), (r".", Punctuation)]
    return states


def by_groups(groups: dict[int, Token]) -> Callable[[Any, re.Match[str]], Coloured]:
    """Returns what colours the groups of a match by their numbers, and what stands around them as punctuation and spaces."""

    def coloured(_lexer: Any, match: re.Match[str]) -> Coloured:
        at = match.start()
        for number, token in sorted(groups.items()):
            yield from _between(match.string, at, match.start(number))
            yield match.start(number), token, match.group(number)
            at = match.end(number)
        yield from _between(match.string, at, match.end())

    return coloured


def _between(text: str, start: int, end: int) -> Coloured:
    for piece in re.finditer(r"\s+|\w+|[^\w\s]+", text[start:end]):
        token = Whitespace if piece.group().isspace() else Name if piece.group()[0].isalnum() else Punctuation
        yield start + piece.start(), token, piece.group()


class SjLexer(RegexLexer):  # type: ignore[misc]  # Pygments has no types
    """Colours texts of the language `sj`; Pygments finds it by the name `sj` and by the ending of a file."""

    name = "sj"
    url = ""
    aliases: ClassVar = ["sj", "sjdsl"]
    filenames: ClassVar = ["*.sj"]
    mimetypes: ClassVar = ["text/x-sj"]
    tokens: ClassVar = rules(patterns())
