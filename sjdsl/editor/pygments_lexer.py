"""A Pygments lexer of the language, for Sphinx, MkDocs, LaTeX and terminals.

It is made from the same patterns as the TextMate grammar.
"""

from typing import Any, ClassVar, TypeAlias

from pygments.lexer import RegexLexer, bygroups
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

TOKENS = {  # Pygments' tokens of TextMate's scopes
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
    "punctuation.accessor.sj": Punctuation,
    "punctuation.separator.sj": Punctuation,
    "punctuation.whitespace.sj": Whitespace,
}
# A regular expression, its token or callback, and perhaps the next state; Pygments has no types.
Rule: TypeAlias = tuple[Any, ...]


def rules(textmate_patterns: list[dict[str, Any]]) -> dict[str, list[Rule]]:
    """Returns the states of a lexer that colours as a TextMate grammar does; it starts in `root`.

    Raises:
      KeyError: a scope has no token.
    """
    root: list[Rule] = [(r"\s+", Whitespace)]
    states = {"root": root}
    for pattern in textmate_patterns:
        if "begin" in pattern:
            state = pattern["name"]
            token = TOKENS[state]
            inner = [(each["match"], TOKENS[each["name"]]) for each in pattern["patterns"]]
            root.append((pattern["begin"], token, state))
            states[state] = [(pattern["end"], token, "#pop"), *inner, (r"[\s\S]", token)]
        elif "name" in pattern:
            root.append((pattern["match"], TOKENS[pattern["name"]]))
        else:
            tokens = [TOKENS[scope["name"]] for scope in pattern["captures"].values()]
            root.append((pattern["match"], bygroups(*tokens)))
    root += [(NAME, Name), (r"[A-Za-z_]\w*", Text), (r".", Punctuation)]
    return states


class SjLexer(RegexLexer):  # type: ignore[misc]  # Pygments has no types
    """Colours texts of the language; Pygments finds it by the name `sj` and for files `*.sj`."""

    name = "sj"
    url = ""
    aliases: ClassVar = ["sj", "sjdsl"]
    filenames: ClassVar = ["*.sj"]
    mimetypes: ClassVar = ["text/x-sj"]
    tokens: ClassVar = rules(patterns())
