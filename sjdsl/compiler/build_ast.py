"""Turns the parser's tree into `ast` nodes: a table from grammar rule to class or small function.

Assumes the tree of a text without syntax errors, no deeper than `limits.MAX_DEPTH`; adds and changes no meaning.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from lark import Token, Tree

from sjdsl.compiler import ast
from sjdsl.compiler.source import Span

Build = Callable[..., Any]


@dataclass(frozen=True)
class Part:
    """The content of an optional clause (`as x`, `where c`), named after its rule, for the rule around it."""

    rule: str
    content: Any


def build_ast(tree: Tree[Token], file: str) -> ast.File:
    """Returns the file as `ast` nodes; spans name `file`."""
    node = _build(tree, file)
    assert isinstance(node, ast.File)
    return node


def _build(tree: Tree[Token], file: str) -> Any:
    items = [_build(c, file) if isinstance(c, Tree) else _token(c, file) for c in tree.children if c is not None]
    if tree.data == "names":
        return Part("names", tuple(items))
    if tree.data in CLAUSES:
        return Part(tree.data, items[0] if items else None)
    span = Span(file, tree.meta.start_pos, tree.meta.end_pos, tree.meta.line, tree.meta.column)
    return RULES[tree.data](span, *items)


def _token(token: Token, file: str) -> ast.Name | ast.String | str:
    span = Span(file, token.start_pos or 0, token.end_pos or 0, token.line or 0, token.column or 0)
    match token.type:
        case "STRING":
            return ast.String(span, unquote(token))
        case "INT" | "DEC" | "CMP" | "SIGN" | "TIMES" | "DOTS" | "OTHERWISE":
            return str(token)
        case _:
            return ast.Name(span, str(token))


def unquote(text: str) -> str:
    r"""Returns the inside of a quoted string: `\"` is a quote, `\\` a backslash, any other backslash stands for itself."""
    return text[1:-1].replace("\\\\", "\0").replace('\\"', '"').replace("\0", "\\")


def _split(items: tuple[Any, ...]) -> tuple[tuple[Any, ...], dict[str, Any]]:
    """Returns the plain children of a rule, and its clauses by name."""
    plain = tuple(i for i in items if not isinstance(i, Part))
    return plain, {i.rule: i.content for i in items if isinstance(i, Part)}


def _optional(node: Build, width: int) -> Build:
    """A rule whose last children may be missing: `width` children in all, None for those that are not there."""
    return lambda span, *items: node(span, *items, *[None] * (width - len(items)))


def _several(node: Build, single: int = 0) -> Build:
    """A rule with `single` children and then a list."""
    return lambda span, *items: node(span, *items[:single], items[single:])


# ---- the file and its declarations


def _game(span: Span, *items: Any) -> ast.Game:
    (name, *sections), clauses = _split(items)
    return ast.Game(span, name, clauses.get("title"), clauses.get("extends"), tuple(sections))


def _variant(span: Span, *items: Any) -> ast.Variant:
    (name, *changes), clauses = _split(items)
    return ast.Variant(span, name, clauses.get("title"), tuple(changes))


def _constant(span: Span, name: ast.Name, unit: ast.Name, value: Any, limits: Any = (None, None)) -> ast.Constant:
    return ast.Constant(span, False, name, unit, value, *limits)


def _size(span: Span, constant: ast.Constant) -> ast.Constant:
    return replace(constant, span=span, is_size=True)


def _param(span: Span, constant: ast.Constant) -> ast.Constant:
    return replace(constant, span=span)


def _glyph(span: Span, glyph: ast.String, *starts: Any) -> ast.Glyph:
    return ast.Glyph(span, glyph, tuple(zip(starts[::2], starts[1::2], strict=True)))


def _blocks(span: Span, *items: Any) -> ast.Blocks:
    what = tuple(i for i in items if isinstance(i, ast.Name))
    return ast.Blocks(span, what, items[-1] if len(items) > len(what) else None)


def _field(span: Span, *items: Any) -> ast.Field:
    (name, type_, *start), clauses = _split(items)
    return ast.Field(span, name, clauses.get("by"), type_, start[0] if start else None)


def _range(span: Span, low: ast.Expr, high: ast.Expr, *capped: Part) -> ast.Range:
    return ast.Range(span, low, high, bool(capped))


def _agent_type(span: Span, *items: Any) -> ast.NamedType:
    return ast.NamedType(span, len(items) == 2, items[-1])


def _map(span: Span, content: ast.String | tuple[ast.String, ...]) -> ast.Map:
    return ast.Map(span, content, ()) if isinstance(content, ast.String) else ast.Map(span, None, content)


def _agents(span: Span, *items: Any) -> ast.Agents:
    attributes = tuple(i for i in items if isinstance(i, ast.Acts | ast.Moves | ast.Field | ast.Timer | ast.Forbid))
    return ast.Agents(span, items[0] if len(items) > len(attributes) else None, attributes)


def _forbid(span: Span, *items: Any) -> ast.Forbid:
    *actions, condition = items
    return ast.Forbid(span, tuple(a for a in actions if isinstance(a, ast.Name)), condition)


def _shape(span: Span, name: ast.Name, content: ast.Call | tuple[ast.String, ...]) -> ast.Shape:
    return ast.Shape(span, name, (), content) if isinstance(content, ast.Call) else ast.Shape(span, name, content, None)


def _define(span: Span, *items: Any) -> ast.Define:
    (name, value), clauses = _split(items)
    return ast.Define(span, name, clauses.get("names", ()), value)


def _phase(span: Span, *items: Any) -> ast.Phase:
    (name, block), clauses = _split(items)
    return ast.Phase(span, name, clauses.get("names", ()), block)


def _window(span: Span, *items: Any) -> ast.Window:
    return ast.Window(span, tuple(zip(items[::2], items[1::2], strict=True)))


def _relabel(span: Span, *items: Any) -> ast.Relabel:
    (label,), clauses = _split(items)
    return ast.Relabel(span, label, clauses.get("where"))


def _event(span: Span, *items: Any) -> ast.Event:
    (name,), clauses = _split(items)
    return ast.Event(span, name, clauses.get("by"))


def _symmetric(span: Span, _: ast.Name, what: ast.Name) -> ast.Symmetric:
    return ast.Symmetric(span, what)


def _expect(span: Span, condition: ast.Expr, *items: Any) -> ast.Expect:
    *policies, episodes = items
    return ast.Expect(span, condition, tuple(policies), int(episodes))


def _policy(span: Span, first: Any, *rest: Any) -> ast.Policy:
    match first, rest:
        case Part(rule="seek", content=domain), ():
            return ast.Policy(span, ast.Name(replace(span, end=span.start + len("seek")), "seek"), (), domain)
        case ast.Name() as name, (Part(content=actions),):
            return ast.Policy(span, name, actions, None)
        case _:
            return ast.Policy(span, first, (), None)


# ---- sentences and who


def _match(span: Span, left: ast.Domain, *items: Any) -> ast.Match:
    (right, block), clauses = _split(items)
    return ast.Match(span, left, "nearest" in clauses, right, block)


def _tally(span: Span, *items: Any) -> ast.Tally:
    (event,), clauses = _split(items)
    return ast.Tally(span, event, clauses.get("amount"), clauses.get("gainer"))


def _send(span: Span, *items: Any) -> ast.Send:
    (who, domain), clauses = _split(items)
    return ast.Send(span, who, domain, clauses.get("after"), clauses.get("facing"), clauses.get("stay"))


def _on(span: Span, *items: Any) -> ast.On:
    (kind,), clauses = _split(items)
    return ast.On(span, kind, clauses.get("bind"))


def _domain(span: Span, *items: Any) -> ast.Domain:
    (kind, *on), clauses = _split(items)
    where = clauses.get("where")
    return ast.Domain(span, kind, clauses.get("bind"), on[0] if on else None, clauses.get("inside"), where)


def _shape_name(span: Span, name: ast.Name) -> ast.ShapeRef:
    return ast.ShapeRef(span, name, None)


def _near(span: Span, shape: ast.ShapeRef | ast.Call, anchor: ast.Name) -> ast.Near:
    return ast.Near(span, _shape_ref(shape), anchor)


def _mark(span: Span, shape: ast.ShapeRef | ast.Call, anchor: ast.Name) -> ast.Mark:
    return ast.Mark(span, _shape_ref(shape), anchor)


def _shape_ref(shape: ast.ShapeRef | ast.Call) -> ast.ShapeRef:
    return ast.ShapeRef(shape.span, shape.name, shape.arguments) if isinstance(shape, ast.Call) else shape


# ---- expressions


def _chain(span: Span, *items: Any) -> ast.Expr:
    """`a + b - c` becomes `(a + b) - c`."""
    left, *rest = items
    for op, right in zip(rest[::2], rest[1::2], strict=True):
        left = ast.Binary(replace(span, end=right.span.end), op, left, right)
    return replace(left, span=span)


def _binary(op: str) -> Build:
    """A chain of one operator that the tree leaves out, or a single pair."""
    return lambda span, first, *rest: _chain(span, first, *(item for right in rest for item in (op, right)))


def _compare(span: Span, left: ast.Expr, op: str, right: ast.Expr) -> ast.Binary:
    return ast.Binary(span, op, left, right)


def _negate(span: Span, operand: ast.Expr) -> ast.Unary:
    return ast.Unary(span, "not", operand)


def _int(span: Span, digits: str) -> ast.Int:
    return ast.Int(span, int(digits))


def _dec(span: Span, digits: str) -> ast.Decimal:
    return ast.Decimal(span, float(digits))


def _arm(span: Span, key: tuple[Any, ...], value: ast.Expr) -> ast.Arm:
    match key:
        case ("otherwise",):
            return ast.Arm(span, None, None, False, None, value)
        case (ast.Name() as word,):
            return ast.Arm(span, None, None, False, word, value)
        case (low,):
            return ast.Arm(span, int(low), int(low), False, None, value)
        case (low, ".."):
            return ast.Arm(span, int(low), None, True, None, value)
        case (low, "..", high):
            return ast.Arm(span, int(low), int(high), False, None, value)
    raise AssertionError(key)


def _only(_: Span, item: Any) -> Any:
    return item


def _all_of(_: Span, *items: Any) -> tuple[Any, ...]:
    return items


CLAUSES = {
    "title", "extends", "by", "capped", "set_of", "nearest", "amount", "gainer", "after", "facing", "stay",
    "bind", "inside", "where", "seek",
}  # fmt: skip

RULES: dict[str, Build] = {
    "start": lambda span, version, game: ast.File(span, int(version), game),
    "game": _game,
    "cite": ast.Cite,
    "variant": _variant,
    "override": ast.Override,
    "drop": ast.Drop,
    "size": _size,
    "param": _param,
    "constant": _constant,
    "limits": _all_of,
    "unit": _only,
    "table": _several(ast.Table),
    "entry": ast.Entry,
    "episode": ast.Episode,
    "kind": _several(ast.Kind, 2),
    "glyph": _glyph,
    "blocks": _blocks,
    "blocked": _only,
    "field": _field,
    "timer": ast.Timer,
    "range": _range,
    "agent_type": _agent_type,
    "words": _several(ast.Words),
    "group": _several(ast.Group, 1),
    "map": _map,
    "rows": _all_of,
    "agents": _agents,
    "acts": _several(ast.Acts),
    "moves": ast.Moves,
    "forbid": _forbid,
    "all": lambda span: ast.All(span, None),
    "shape": _shape,
    "define": _define,
    "schedule": _several(ast.Schedule),
    "turn": _several(ast.Turn, 1),
    "phase": _phase,
    "block": _several(ast.Block),
    "let": ast.Let,
    "draw": _optional(ast.Draw, 3),
    "each": ast.Each,
    "pick": _optional(ast.Pick, 4),
    "first": _optional(ast.First, 3),
    "match": _match,
    "when": _optional(ast.When, 3),
    "chance": _optional(ast.Chance, 3),
    "otherwise": _only,
    "set": ast.Set,
    "add": ast.Add,
    "give": ast.Give,
    "all_but": ast.All,
    "tally": _tally,
    "send": _send,
    "remove": ast.Remove,
    "move": ast.Move,
    "mark": _mark,
    "end": ast.End,
    "domain": _domain,
    "on": _on,
    "near": _near,
    "shape_name": _shape_name,
    "members": _several(ast.Members),
    "observe": _several(ast.Observe),
    "window": _window,
    "show": _several(ast.Show, 1),
    "relabel": _relabel,
    "hide": _optional(ast.Hide, 2),
    "metrics": _several(ast.Metrics),
    "event": _event,
    "mean": lambda span, name, value: ast.Measure(span, True, name, value),
    "final": lambda span, name, value: ast.Measure(span, False, name, value),
    "checks": _several(ast.Checks),
    "require": ast.Require,
    "always": ast.Always,
    "once": ast.Once,
    "conserved": ast.Conserved,
    "monotone": ast.Monotone,
    "symmetric": _symmetric,
    "expect": _expect,
    "policy": _policy,
    "expr": _binary("or"),
    "and_e": _binary("and"),
    "negate": _negate,
    "compare": _compare,
    "is_": _binary("is"),
    "is_not": _binary("is not"),
    "chose": ast.Chose,
    "standing": ast.Standing,
    "within": _optional(ast.Within, 3),
    "sum": _chain,
    "prod": _chain,
    "signed": ast.Unary,
    "int": _int,
    "dec": _dec,
    "nobody": ast.Nobody,
    "count": ast.Count,
    "total": _optional(ast.Total, 2),
    "case": _several(ast.Case, 1),
    "arm": _arm,
    "key": lambda span, *tokens: tokens,
    "call": _several(ast.Call, 1),
    "path": _several(ast.Path, 1),
    "member": ast.Member,
    "index": ast.Index,
}
