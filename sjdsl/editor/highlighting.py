"""How the words and signs of a text are coloured: patterns of a TextMate grammar, from which every highlighter of the language is made."""

from typing import Any

from sjdsl.compiler.elaborate.constants import UNITS
from sjdsl.compiler.ir.operations import FUNCTIONS
from sjdsl.compiler.syntax.parse import automaton
from sjdsl.compiler.syntax.recovery.repair import ENTRIES, SECTIONS, STATEMENTS
from sjdsl.runtime.actions import HEADINGS

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


def patterns() -> list[dict[str, Any]]:
    """Returns the patterns; at each place the first that matches gives the colour.

    Each has `match`, a regular expression, with `name`, the scope of all of it, or `captures`, scopes by the number of a group; or it has
    `begin`, `end`, `name`, and `patterns` for what stands between.
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
            "match": rf"\b({any_of(FUNCTIONS)})\s*(?=\()",
            "captures": {"1": {"name": "support.function.sj"}},
        },
        *({"name": scope, "match": rf"\b({any_of(words)})\b"} for scope, words in word_groups().items()),
        {"name": "keyword.operator.sj", "match": r"->|\.\.|<=|>=|==|!=|[-+*/%<>=]"},
    ]
