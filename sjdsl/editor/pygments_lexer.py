"""A Pygments lexer of the language, made from the same patterns as the TextMate grammar: for Sphinx, MkDocs, LaTeX and terminals."""

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
    "punctuation.accessor.sj": Punctuation,
    "punctuation.separator.sj": Punctuation,
    "punctuation.whitespace.sj": Whitespace,
}
Rule: TypeAlias = tuple[
    Any, ...
]  # a pattern, its token or what makes tokens, and perhaps the state that follows; Pygments has no types


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
            states[inner] += [
                (within["match"], TOKENS[within["name"]]) for within in pattern["patterns"]
            ]
            states[inner].append((r"[\s\S]", token))
        elif "name" in pattern:
            states["root"].append((pattern["match"], TOKENS[pattern["name"]]))
        else:
            states["root"].append(
                (
                    pattern["match"],
                    bygroups(*(TOKENS[scope["name"]] for scope in pattern["captures"].values())),
                )
            )
    states["root"] += [(NAME, Name), (r"[A-Za-z_]\w*", Text), (r".", Punctuation)]
    return states


class SjLexer(RegexLexer):  # type: ignore[misc]  # Pygments has no types
    """Colours texts of the language `sj`; Pygments finds it by the name `sj` and by the ending of a file."""

    name = "sj"
    url = ""
    aliases: ClassVar = ["sj", "sjdsl"]
    filenames: ClassVar = ["*.sj"]
    mimetypes: ClassVar = ["text/x-sj"]
    tokens: ClassVar = rules(patterns())
