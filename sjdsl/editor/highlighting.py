"""The patterns of a TextMate grammar, from which every highlighter of the language is made."""

from collections.abc import Iterable
from typing import Any

from sjdsl.compiler.elaborate.constants import UNITS
from sjdsl.compiler.ir.operations import FUNCTIONS
from sjdsl.compiler.syntax.parse import automaton
from sjdsl.compiler.syntax.recovery.repair import ENTRIES, SECTIONS, STATEMENTS
from sjdsl.runtime.actions import HEADINGS

NAMED = (  # keywords before a new name
    "size", "param", "kind", "group", "define", "movers", "shape", "phase", "policy", "scenario",
    "variant", "event", "mean", "final", "game", "task",
)  # fmt: skip
FIELDS = ("field", "timer")
CONTROL = ("when", "chance", "otherwise", "each", "pick", "first", "match", "case")
VALUES = ("nobody", "nowhere", "yes", "no", "same", *HEADINGS)
LANGUAGE = ("agent", "step")
NAME = "[a-z][a-z0-9_]*"
SPACE = "punctuation.whitespace.sj"


def word_groups() -> dict[str, list[str]]:
    """Returns the keywords of the language by scope; each is in one group."""
    groups: dict[str, list[str]] = {
        "keyword.control.sj": [],
        "storage.type.sj": [],
        "keyword.other.statement.sj": [],
        "keyword.operator.word.sj": [],
    }
    for kind, word in sorted(automaton().words.items(), key=lambda item: item[1]):
        if not word.isalpha() or word in VALUES:
            continue
        if word in CONTROL:
            scope = "keyword.control.sj"
        elif kind in SECTIONS | ENTRIES or word in ("game", "sj", "extends", *FIELDS):
            scope = "storage.type.sj"
        elif kind in STATEMENTS:
            scope = "keyword.other.statement.sj"
        else:
            scope = "keyword.operator.word.sj"
        groups[scope].append(word)
    return groups


def any_of(words: Iterable[str]) -> str:
    return "|".join(sorted(words))


def captured(match: str, *scopes: str) -> dict[str, Any]:
    """Returns a pattern whose groups have these scopes, in order; they make up the whole match."""
    return {
        "match": match,
        "captures": {str(number): {"name": scope} for number, scope in enumerate(scopes, 1)},
    }


def patterns() -> list[dict[str, Any]]:
    """Returns the patterns; at each position the first that matches gives the colour.

    A pattern has `match`, a regular expression, and either `name`, the scope of all of it, or
    `captures`, scopes by the number of a group. Or it has `begin`, `end`, `name`, and `patterns`
    for the text between.
    """
    return [
        {"name": "comment.line.number-sign.sj", "match": "#.*$"},
        {
            "name": "string.quoted.double.sj",
            "begin": '"',
            "end": '"|$',
            "patterns": [{"name": "constant.character.escape.sj", "match": r"\\."}],
        },
        {"name": "constant.numeric.sj", "match": r"\b[0-9]+(\.[0-9]+)?\b"},
        captured(
            rf"\b({any_of(NAMED)})(\s+)({NAME})", "storage.type.sj", SPACE, "entity.name.type.sj"
        ),
        captured(
            rf"\b({any_of(FIELDS)})(\s+)({NAME})",
            "storage.type.sj",
            SPACE,
            "variable.other.property.sj",
        ),
        captured(
            rf"\b(as|let|draw)(\s+)({NAME})",
            "keyword.operator.word.sj",
            SPACE,
            "variable.other.local.sj",
        ),
        captured(
            rf"(\.)(\s*)({NAME})", "punctuation.accessor.sj", SPACE, "variable.other.property.sj"
        ),
        captured(
            rf"(:)(\s*)({any_of(UNITS)})\b", "punctuation.separator.sj", SPACE, "support.type.sj"
        ),
        {"name": "constant.language.sj", "match": rf"\b({any_of(VALUES)})\b"},
        {"name": "variable.language.sj", "match": rf"\b({any_of(LANGUAGE)})\b"},
        captured(rf"\b({any_of(FUNCTIONS)})(?=\s*\()", "support.function.sj"),
        *(
            {"name": scope, "match": rf"\b({any_of(words)})\b"}
            for scope, words in word_groups().items()
        ),
        {"name": "keyword.operator.sj", "match": r"->|\.\.|<=|>=|==|!=|[-+*/%<>=]"},
    ]
