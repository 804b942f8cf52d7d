"""Local names at a place of a text that may be unfinished, and declarations of such a text: read from its tokens alone."""

from collections.abc import Sequence
from itertools import takewhile

from lark import Token

from sjdsl.compiler import ast
from sjdsl.compiler.ast.names import Names, Owners, Symbol
from sjdsl.compiler.diagnostics.source import Span

DOMAINS = frozenset(("EACH", "FIRST", "MATCH", "WITH", "OVER", "SEEK", "AVOIDING", "TOWARD", "ON"))  # words before who is spoken of
BEFORE_DOMAIN = DOMAINS | {"FROM", "AT", "TO"}
NAMED = {
    "PARAM": ("name", "parameter"), "SIZE": ("name", "size"), "KIND": ("name", "kind"), "GROUP": ("name", "group"), "DEFINE": ("name", "define"),
    "MOVERS": ("name", "sort of movers"), "SHAPE": ("shape", ""), "PHASE": ("phase", ""), "EVENT": ("metric", ""), "MEAN": ("metric", ""),
    "FINAL": ("metric", ""), "POLICY": ("policy", ""), "SCENARIO": ("scenario", ""), "VARIANT": ("variant", ""),
}  # fmt: skip


def local_names(tokens: Sequence[Token], names: Names) -> dict[str, Owners]:
    """Returns the local names behind the tokens, each with what it can be."""
    blocks: list[dict[str, Owners]] = [{}]
    pending: dict[str, Owners] = {}
    for at, token in enumerate(tokens):
        before = tokens[at - 1].type if at else ""
        match token.type:
            case "LBRACE":
                blocks.append({**blocks[-1], **pending})
                pending = {}
            case "RBRACE":
                pending = {}
                if len(blocks) > 1:
                    blocks.pop()
            case "PHASE" | "DEFINE" | "FORBID":
                pending = _parameters(tokens, at)
            case "NAME" if before == "AS":
                pending[str(token)] = names.owners(str(tokens[at - 2])) if at > 1 and tokens[at - 2].type == "NAME" else None
            case "NAME" if before in ("LET", "DRAW"):
                blocks[-1][str(token)] = None
            case "NAME" if _is_of_domain(tokens, at) and names.owners(str(token)) and [t.type for t in tokens[at + 1 : at + 2]] != ["AS"]:
                pending[str(token)] = names.owners(str(token))
            case "EACH" | "PICK" | "SET" | "GIVE" | "ADD" | "TALLY" | "SEND" | "WHEN" | "CHANCE" | "LET" | "DRAW" if before != "OTHERWISE":
                pending = {} if before in ("RBRACE", "LBRACE") else pending
    return {**blocks[-1], **pending}


def _is_of_domain(tokens: Sequence[Token], at: int) -> bool:
    """Whether a name stands where a domain begins: `each NAME`, `pick 1 NAME`, `count(NAME`."""
    before = tokens[at - 1].type if at else ""
    if before == "LPAR":
        return at > 1 and tokens[at - 2].type in ("COUNT", "ANY", "ALL")
    return before in BEFORE_DOMAIN or (at > 1 and tokens[at - 2].type == "PICK")


def _parameters(tokens: Sequence[Token], at: int) -> dict[str, Owners]:
    """Returns the names in the brackets behind a declaration: `phase sow(act, colour)`, `define ready(who)`."""
    if [t.type for t in tokens[at + 1 : at + 3]] != ["NAME", "LPAR"]:
        return {}
    inside = takewhile(lambda token: token.type != "RPAR", tokens[at + 3 :])
    return {str(token): None for token in inside if token.type == "NAME"}


def declared_in(tokens: Sequence[Token], name: str = "") -> Names:
    """Returns what an unfinished text declares, as far as its tokens tell."""
    found, owner, depth, opened = Names(), "", 0, 0
    for at, token in enumerate(tokens[:-1]):
        after = tokens[at + 1]
        depth += (token.type == "LBRACE") - (token.type == "RBRACE")
        owner = "" if owner and depth <= opened and token.type == "RBRACE" else owner
        span = _span(after, name)
        if token.type == "AGENTS":
            owner, opened = "agent", depth
        if token.type in ("FIELD", "TIMER") and after.type == "NAME":
            field = _field(tokens, at, ast.Name(span, str(after)))
            found.fields.setdefault(owner, {}).setdefault(field.name.text, field)
            found.nodes.setdefault(Symbol("field" if owner else "name", str(after), owner), field)
            found.sorts.update({} if owner else {str(after): "field of the world"})
            for word in field.type.names if isinstance(field, ast.Field) and isinstance(field.type, ast.Words) else ():
                found.words.setdefault(word.text, []).append(word.span)
        if token.type in NAMED and after.type == "NAME":
            space, sort = NAMED[token.type]
            named = ast.Name(span, str(after))
            node = ast.Measure(span, token.type == "MEAN", named, ast.Nobody(span)) if token.type in ("MEAN", "FINAL") else named
            found.nodes.setdefault(Symbol(space, str(after)), node)  # type: ignore[arg-type]
            found.sorts.update({str(after): sort} if sort else {})
            if token.type in ("KIND", "MOVERS"):
                (found.kinds if token.type == "KIND" else found.movers).add(str(after))
                owner, opened = str(after), depth
        if token.type == "GROUP" and after.type == "NAME":
            found.groups[str(after)] = _listed(tokens, at + 3)
        if token.type == "ACTS":
            for name in _listed(tokens, at + 1):
                found.nodes.setdefault(Symbol("action", name), ast.Action(span, ast.Name(span, name), ()))
    return found


def _span(token: Token, file: str) -> Span:
    return Span(file, token.start_pos or 0, token.end_pos or 0, token.line or 1, token.column or 1)


def _listed(tokens: Sequence[Token], at: int) -> tuple[str, ...]:
    """Returns the names of a list from a token on."""
    found = []
    while at < len(tokens) and tokens[at].type == "NAME":
        found.append(str(tokens[at]))
        at += 2 if at + 1 < len(tokens) and tokens[at + 1].type == "COMMA" else len(tokens)
    return tuple(found)


def _field(tokens: Sequence[Token], at: int, name: ast.Name) -> ast.Field | ast.Timer:
    """Returns the field declared at a token, with its words if it has some."""
    if tokens[at].type == "TIMER":
        return ast.Timer(name.span, name)
    is_set = [t.type for t in tokens[at + 2 : at + 4]] == ["COLON", "LBRACE"]
    listed = takewhile(lambda token: token.type in ("NAME", "COMMA"), tokens[at + 4 :] if is_set else ())
    words = [ast.Name(_span(token, name.span.file), str(token)) for token in listed if token.type == "NAME"]
    sort = str(tokens[at + 3]) if len(tokens) > at + 3 and tokens[at + 3].type == "NAME" else "reward"
    of: ast.Type = ast.Words(name.span, tuple(words)) if words else ast.NamedType(name.span, False, ast.Name(name.span, sort))
    return ast.Field(name.span, name, None, of, None)


def joined(first: Names, second: Names) -> Names:
    """Returns the declarations of two readings of one text; where both have one, that of the first."""
    fields = {
        owner: {**second.fields.get(owner, {}), **first.fields.get(owner, {})} for owner in first.fields.keys() | second.fields.keys()
    }
    return Names(
        {**second.sorts, **first.sorts},
        {**second.nodes, **first.nodes},
        first.kinds | second.kinds,
        {**second.groups, **first.groups},
        first.movers | second.movers,
        fields,
        {**second.words, **first.words},
    )
