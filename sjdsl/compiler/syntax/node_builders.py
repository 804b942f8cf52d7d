"""Builders of AST nodes whose fields are not simply the children of their grammar rule."""

from collections.abc import Callable
from dataclasses import fields, replace
from itertools import zip_longest
from typing import Any, Literal

from sjdsl.compiler import ast
from sjdsl.compiler.ast.node import Node
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.source import Span

Build = Callable[..., Any]


class Part(Record):
    """The content of an optional clause (`as x`, `where c`), named after its rule, for the rule around it."""

    rule: str
    content: Any


def unquote(text: str) -> str:
    r"""Returns the inside of a quoted string: `\"` is a quote, `\\` a backslash, any other backslash stands for itself."""
    return text[1:-1].replace("\\\\", "\0").replace('\\"', '"').replace("\0", "\\")


def split(items: tuple[Any, ...]) -> tuple[tuple[Any, ...], dict[str, Any]]:
    """Returns the plain children of a rule, and its clauses by name."""
    plain = tuple(i for i in items if not isinstance(i, Part))
    return plain, {i.rule: i.content for i in items if isinstance(i, Part)}


def optional(node: Build, width: int) -> Build:
    """A rule whose last children may be missing: `width` children in all, None for those that are not there."""
    return lambda span, *items: node(span, *items, *[None] * (width - len(items)))


def several(node: Build, single: int = 0) -> Build:
    """A rule with `single` children and then a list."""
    return lambda span, *items: node(span, *items[:single], items[single:])


def with_clauses(node: type[Node], *same: str, **other: str) -> Build:
    """A rule with clauses, each of which fills the field of its name, or that of `field=clause`; its other children fill the rest in order.

    A field whose child or clause is missing is None; a missing list of names is empty.
    """
    clauses = dict(zip(same, same, strict=True)) | other
    rest = [field.name for field in fields(node)[1:] if field.name not in clauses]

    def build(span: Span, *items: Any) -> Node:
        plain, given = split(items)
        values = {name: given.get(clause, () if clause == "names" else None) for name, clause in clauses.items()}
        return node(span=span, **values, **dict(zip_longest(rest, plain)))

    return build


# ---- the file and its declarations


def game(span: Span, *items: Any) -> ast.Game:
    (name, *sections), clauses = split(items)
    return ast.Game(span, name, clauses.get("title"), clauses.get("extends"), tuple(sections))


def variant(span: Span, *items: Any) -> ast.Variant:
    (name, *changes), clauses = split(items)
    return ast.Variant(span, name, clauses.get("title"), tuple(changes))


def constant(span: Span, *items: Any) -> ast.Constant:
    (name, unit, value, *limits), clauses = split(items)
    return ast.Constant(span, False, name, clauses.get("by"), unit, value, *(limits[0] if limits else (None, None)))


def size(span: Span, constant: ast.Constant) -> ast.Constant:
    return replace(constant, span=span, is_size=True)


def param(span: Span, constant: ast.Constant) -> ast.Constant:
    return replace(constant, span=span)


def glyph(span: Span, glyph: ast.String, *starts: Any) -> ast.Glyph:
    return ast.Glyph(span, glyph, tuple(zip(starts[::2], starts[1::2], strict=True)))


def blocks(span: Span, *items: Any) -> ast.Blocks:
    what = tuple(i for i in items if isinstance(i, ast.Name))
    return ast.Blocks(span, what, items[-1] if len(items) > len(what) else None)


def range_(span: Span, low: ast.Expr, high: ast.Expr, *capped: Part) -> ast.Range:
    return ast.Range(span, low, high, bool(capped))


def agent_type(span: Span, *items: Any) -> ast.NamedType:
    return ast.NamedType(span, len(items) == 2, items[-1])


def map_(span: Span, *items: Any) -> ast.Map:
    *wraps, content = items
    edges: Literal["joined"] | None = "joined" if wraps else None
    return ast.Map(span, content, (), edges) if isinstance(content, ast.String) else ast.Map(span, None, content, edges)


def agents(span: Span, *items: Any) -> ast.Agents:
    attributes = tuple(i for i in items if isinstance(i, ast.Acts | ast.Moves | ast.Field | ast.Timer | ast.Forbid | ast.Blocks))
    return ast.Agents(span, items[0] if len(items) > len(attributes) else None, attributes)


def forbid(span: Span, *items: Any) -> ast.Forbid:
    *actions, condition = items
    return ast.Forbid(span, tuple(a for a in actions if isinstance(a, ast.Chosen)), condition)


def argument(span: Span, *items: Any) -> ast.Argument:
    *name, type_ = items
    return ast.Argument(span, name[0] if name else None, type_)


def chosen(span: Span, action: ast.Name | ast.Call) -> ast.Chosen:
    return ast.Chosen(span, action, None) if isinstance(action, ast.Name) else ast.Chosen(span, action.name, action.arguments)


def shape(span: Span, name: ast.Name, content: ast.Call | tuple[ast.String, ...]) -> ast.Shape:
    return ast.Shape(span, name, (), content) if isinstance(content, ast.Call) else ast.Shape(span, name, content, None)


def window(span: Span, *items: Any) -> ast.Window:
    sides = items[: len(items) - len(items) % 2]
    return ast.Window(span, tuple(zip(sides[::2], sides[1::2], strict=True)), items[-1] if len(items) % 2 else None)


def show(span: Span, what: ast.Path, *items: Any) -> ast.Show:
    labels = tuple(i for i in items if isinstance(i, ast.Relabel))
    return ast.Show(span, what, labels, items[-1] if len(items) > len(labels) else None)


def checks(span: Span, *items: Any) -> ast.Checks:
    name = items[0] if items and isinstance(items[0], ast.Name) else None
    return ast.Checks(span, name, items[1:] if name else items)


def symmetric(span: Span, _: ast.Name, what: ast.Name) -> ast.Symmetric:
    return ast.Symmetric(span, what)


def expect(span: Span, condition: ast.Expr, *items: Any) -> ast.Expect:
    *policies, episodes = items
    return ast.Expect(span, condition, tuple(policies), int(episodes))


def policy(span: Span, first: Any, *rest: Any) -> ast.Policy:
    match first, rest:
        case Part(rule="seek", content=domain), ():
            return ast.Policy(span, ast.Name(replace(span, end=span.start + len("seek")), "seek"), (), domain)
        case ast.Name() as name, (Part(content=actions),):
            return ast.Policy(span, name, actions, None)
        case _:
            return ast.Policy(span, first, (), None)


def aim(span: Span, *items: Any) -> ast.Aim:
    (shape, domain, action), clauses = split(items)
    return ast.Aim(span, shape_ref(shape), domain, clauses.get("avoiding"), action)


def scripted(span: Span, *items: Any) -> ast.ScriptedPolicy:
    (name, *rules), clauses = split(items)
    return ast.ScriptedPolicy(span, name, clauses.get("title"), tuple(rules))


def scenario(span: Span, *items: Any) -> ast.Scenario:
    (name, *slots), clauses = split(items)
    return ast.Scenario(span, name, clauses.get("title"), tuple(slots))


# ---- statements and who


def match_(span: Span, left: ast.Domain, *items: Any) -> ast.Match:
    (right, block), clauses = split(items)
    return ast.Match(span, left, "nearest" in clauses, right, block)


def shape_name(span: Span, name: ast.Name) -> ast.ShapeRef:
    return ast.ShapeRef(span, name, None)


def near(span: Span, shape: ast.ShapeRef | ast.Call, anchor: ast.Name) -> ast.Near:
    return ast.Near(span, shape_ref(shape), anchor)


def mark(span: Span, shape: ast.ShapeRef | ast.Call, anchor: ast.Name) -> ast.Mark:
    return ast.Mark(span, shape_ref(shape), anchor)


def shape_ref(shape: ast.ShapeRef | ast.Call) -> ast.ShapeRef:
    return ast.ShapeRef(shape.span, shape.name, shape.arguments) if isinstance(shape, ast.Call) else shape


# ---- expressions


def chain(span: Span, left: ast.Expr, *rest: Any) -> ast.Expr:
    """`a + b - c` becomes `(a + b) - c`."""
    for op, right in zip(rest[:-2:2], rest[1:-2:2], strict=True):
        left = ast.Binary(replace(span, end=right.span.end), op, left, right)
    return ast.Binary(span, rest[-2], left, rest[-1])


def binary(op: str) -> Build:
    """A chain of one operator that the tree leaves out, or a single pair."""
    return lambda span, first, *rest: chain(span, first, *(item for right in rest for item in (op, right)))


def compare(span: Span, left: ast.Expr, op: str, right: ast.Expr) -> ast.Binary:
    return ast.Binary(span, op, left, right)


def negate(span: Span, operand: ast.Expr) -> ast.Unary:
    return ast.Unary(span, "not", operand)


def int_(span: Span, digits: str) -> ast.Int:
    return ast.Int(span, int(digits))


def dec(span: Span, digits: str) -> ast.Decimal:
    return ast.Decimal(span, float(digits))


def entry(span: Span, key: tuple[Any, ...], value: Any) -> ast.Entry:
    """The key of a table is kept as it is written: a word, or numbers and signs."""
    if len(key) == 1 and isinstance(key[0], ast.Name):
        return ast.Entry(span, key[0], value)
    text = " ".join(key)
    return ast.Entry(span, ast.Name(replace(span, end=span.start + len(text)), text), value)


def arm(span: Span, key: tuple[Any, ...], value: ast.Expr) -> ast.Arm:
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


def only(_: Span, item: Any) -> Any:
    return item


def all_of(_: Span, *items: Any) -> tuple[Any, ...]:
    return items
