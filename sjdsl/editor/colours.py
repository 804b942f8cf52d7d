"""Semantic tokens: the colour of each word by what is declared under its name, without waiting for elaboration."""

from collections.abc import Iterator

from lsprotocol import types

from sjdsl.compiler.ast.names import Names, Space
from sjdsl.compiler.elaborate.constants import UNITS
from sjdsl.compiler.elaborate.shapes import BUILT_IN as FORMS
from sjdsl.compiler.ir.operations import FUNCTIONS
from sjdsl.compiler.syntax.parse import automaton
from sjdsl.editor.analysis import Analysis

TYPES = (
    "keyword", "comment", "string", "number", "operator", "namespace", "class", "interface", "struct", "enumMember", "function", "method",
    "property", "variable", "parameter", "event", "type",
)  # fmt: skip
MODIFIERS = ("declaration", "readonly", "defaultLibrary")
PLAIN = {"STRING": "string", "INT": "number", "DEC": "number"}
OPERATORS = ("CMP", "SIGN", "TIMES", "ARROW", "DOTS", "EQUAL")
SORTS = {
    "size": "parameter", "parameter": "parameter", "kind": "class", "sort of movers": "class", "group": "interface", "define": "function",
    "field of the world": "property",
}  # fmt: skip
SPACES: dict[Space, str] = {  # in the order in which a name is looked for
    "name": "", "local": "variable", "word": "enumMember", "field": "property", "action": "enumMember", "phase": "method", "metric": "event",
    "shape": "struct", "argument": "property", "policy": "function", "scenario": "function", "checks": "namespace", "variant": "namespace",
    "game": "namespace",
}  # fmt: skip
AFTER: dict[str, tuple[Space, ...]] = {  # what comes first behind a token; behind `phase` a phase, and so on
    "DOT": ("field", "action", "argument"), "CHOSE": ("action",), "CHOOSE": ("action",), "FORBID": ("action",), "ACTS": ("action",),
    "TALLY": ("metric",), "EVENT": ("metric",), "MEAN": ("metric",), "FINAL": ("metric",), "ARROW": ("phase",), "SCHEDULE": ("phase",),
    "MARK": ("shape",), "IN": ("shape",), "BLOCKS": ("shape",), "AIM": ("shape",), "WITH": ("policy", "field"),
}  # fmt: skip
DECLARING = frozenset((
    "GAME", "SIZE", "PARAM", "KIND", "GROUP", "FIELD", "TIMER", "DEFINE", "MOVERS", "SHAPE", "PHASE", "EVENT", "MEAN", "FINAL", "POLICY",
    "SCENARIO", "VARIANT", "AS", "LET", "DRAW",
))  # fmt: skip
LEGEND = types.SemanticTokensLegend(list(TYPES), list(MODIFIERS))
Coloured = tuple[int, int, str, tuple[str, ...]]  # from, to, type, modifiers


def semantic_tokens(analysis: Analysis, names: Names) -> types.SemanticTokens:
    """Returns the words of a text in colours, each after the one before, as the protocol counts them."""
    lines = analysis.document.lines
    data: list[int] = []
    line = character = 0
    for start, end, sort, modifiers in coloured(analysis, names):
        at, until = lines.position(start), lines.position(end)
        if until.line != at.line:
            continue
        step = at.line - line
        data += [step, at.character - (character if step == 0 else 0), until.character - at.character, TYPES.index(sort)]
        data.append(sum(1 << MODIFIERS.index(m) for m in modifiers))
        line, character = at.line, at.character
    return types.SemanticTokens(data=data)


def coloured(analysis: Analysis, names: Names) -> Iterator[Coloured]:
    """Yields the words of a text that have a colour, in its order. `names`: what it declares, perhaps as it could be read last."""
    words = automaton().words
    for before, token, after in zip(("", *analysis.tokens), analysis.tokens, (*analysis.tokens[1:], ""), strict=False):
        sort, modifiers = PLAIN.get(token.type, ""), list[str]()
        if token.type == "NAME":
            sort, modifiers = _named(str(token), getattr(before, "type", ""), after == "(", names)
        elif not sort:
            sort = "operator" if token.type in OPERATORS else "keyword" if words.get(token.type, "").isalpha() else ""
        if sort:
            yield (token.start_pos or 0, token.end_pos or 0, sort, tuple(modifiers))


def _named(word: str, before: str, is_called: bool, names: Names) -> tuple[str, list[str]]:
    """Returns the colour of a name and its modifiers. `before`: the kind of token in front of it."""
    for space in (*AFTER.get(before, (before.lower(),)), *SPACES):
        symbol = next(iter(names.called(word, (space,))), None)
        if symbol is not None or (space == "local" and word in names.locals):
            sort = SORTS[names.sort(symbol)] if symbol is not None and space == "name" else SPACES[space]
            is_fixed = space == "word" or sort == "parameter"
            return sort, ["declaration"] * (before in DECLARING) + ["readonly"] * is_fixed
    if before == "COLON" and word in (*UNITS, "agent", "cell"):
        return "type", ["defaultLibrary"]
    if is_called and (word in FUNCTIONS or word in FORMS):
        return "function", ["defaultLibrary"]
    return ("variable", ["defaultLibrary"]) if word in ("agent", "step", "other", "everyone") else ("", [])
