"""Says what each rule of the grammar is in the AST: a class, or a small function.

A rule has a child for each of its parts, None for an optional one that isn't there. A rule without
a row here is a clause, such as `as x` or `where c`: it is its content.
"""

from collections.abc import Callable
from dataclasses import fields, replace
from itertools import zip_longest
from typing import Any, Literal, TypeGuard

from sjdsl.compiler import ast
from sjdsl.compiler.ast.node import Node
from sjdsl.compiler.diagnostics.source import Span

Build = Callable[..., Any]
# Kinds of tokens that become plain texts.
AS_WRITTEN = frozenset(("INT", "DEC", "CMP", "SIGN", "TIMES", "DOTS", "OTHERWISE"))


def unquote(text: str) -> str:
    r"""Returns the inside of a quoted string.

    `\"` is a quote, `\\` a backslash, and any other backslash stands for itself.
    """
    return text[1:-1].replace("\\\\", "\0").replace('\\"', '"').replace("\0", "\\")


def node(kind: type[Node]) -> Build:
    """Returns what builds a node from a rule whose children are its fields, in order.

    The last field, if it is a tuple, takes all that are left. A field whose child is missing is
    None, empty or False, as its type says.
    """
    make: Build = kind
    types = [field.type for field in fields(kind)[1:]]
    missing = [_missing(type_) for type_ in types]
    takes_rest = bool(missing) and missing[-1] == ()
    before_rest = len(types) - 1

    def build(span: Span, *children: Any) -> Node:
        """Returns the node of one rule."""
        if takes_rest:
            children = (*children[:before_rest], children[before_rest:])
        pairs = zip_longest(children, missing)
        built: Node = make(span, *(empty if child is None else child for child, empty in pairs))
        return built

    return build


def is_node(value: object) -> TypeGuard[type[Node]]:
    """Returns whether something is a class of nodes."""
    return isinstance(value, type) and issubclass(value, Node)


def _missing(type_: Any) -> Any:
    """Returns what a field of a type is without a child."""
    if str(type_).startswith("tuple["):
        return ()
    return False if type_ in (bool, "bool") else None


# A function with the name of a rule of the grammar builds its node from the rule's children.


def map_(span: Span, wraps: bool | None, content: ast.String | tuple[ast.String, ...]) -> ast.Map:
    """Returns a map, in a file or as rows."""
    edges: Literal["joined"] | None = "joined" if wraps else None
    if isinstance(content, ast.String):
        return ast.Map(span, content, (), edges)
    return ast.Map(span, None, content, edges)


def chosen(span: Span, action: ast.Name | ast.Call) -> ast.Chosen:
    if isinstance(action, ast.Name):
        return ast.Chosen(span, action, None)
    return ast.Chosen(span, action.name, action.arguments)


def shape(span: Span, name: ast.Name, content: ast.Call | tuple[ast.String, ...]) -> ast.Shape:
    if isinstance(content, ast.Call):
        return ast.Shape(span, name, (), content)
    return ast.Shape(span, name, content, None)


def window(span: Span, *items: Any) -> ast.Window:
    *sides, condition = items
    return ast.Window(span, tuple(zip(sides[::2], sides[1::2], strict=True)), condition)


def look(span: Span, what: ast.Name, where: ast.Expr | None, *paints: ast.Paint) -> ast.Look:
    body, badge = paints if len(paints) == 2 else (None, *paints)
    return ast.Look(span, what, where, body, badge)


def policy(
    span: Span, first: ast.Name | ast.Domain, actions: tuple[ast.Name, ...] | None = None
) -> ast.Policy:
    """Returns a policy of an `expect`: `seek KIND`, `never(ACTION)` or a name."""
    if isinstance(first, ast.Domain):
        seek = ast.Name(replace(span, end=span.start + len("seek")), "seek")
        return ast.Policy(span, seek, (), first)
    return ast.Policy(span, first, actions or (), None)


def shape_ref(shape: ast.ShapeRef | ast.Call) -> ast.ShapeRef:
    if isinstance(shape, ast.Call):
        return ast.ShapeRef(shape.span, shape.name, shape.arguments)
    return shape


def chain(span: Span, left: ast.Expr, *rest: Any) -> ast.Expr:
    """Returns a chain of operators: `a + b - c` becomes `(a + b) - c`."""
    operators = rest[::2]
    operands = rest[1::2]
    for op, right in zip(operators, operands, strict=True):
        left = ast.Binary(replace(span, end=right.span.end), op, left, right)
    return replace(left, span=span)  # the last operand may end before a bracket around it


def binary(op: str) -> Build:
    """Returns what builds a chain of one operator, which is no child of the rule."""

    def build(span: Span, first: ast.Expr, *rest: ast.Expr) -> ast.Expr:
        operators_and_operands: list[Any] = []
        for operand in rest:
            operators_and_operands += [op, operand]
        return chain(span, first, *operators_and_operands)

    return build


def entry(span: Span, key: tuple[Any, ...], value: Any) -> ast.Entry:
    """Returns an entry of a table, its key as written: a word, or numbers and signs."""
    if len(key) == 1 and isinstance(key[0], ast.Name):
        return ast.Entry(span, key[0], value)
    text = " ".join(key)
    return ast.Entry(span, ast.Name(replace(span, end=span.start + len(text)), text), value)


def arm(span: Span, key: tuple[Any, ...], value: ast.Expr) -> ast.Arm:
    """Returns an arm of a `case`: for an enum value, a number, a range, or `otherwise`."""
    otherwise = ast.Arm(span, low=None, high=None, open=False, word=None, value=value)
    match key:
        case ("otherwise",):
            return otherwise
        case (ast.Name() as word,):
            return replace(otherwise, word=word)
        case (low,):
            return replace(otherwise, low=int(low), high=int(low))
        case (low, ".."):
            return replace(otherwise, low=int(low), open=True)
        case (low, "..", high):
            return replace(otherwise, low=int(low), high=int(high))
    raise AssertionError(key)


# Most rules have the names of the classes of their nodes.
NODES = {kind.__name__.lower(): node(kind) for kind in vars(ast).values() if is_node(kind)}
RULES: dict[str, Build] = NODES | {
    "start": lambda span, version, game: ast.File(span, int(version), game),
    "game": lambda span, name, title, *sections: ast.Game(span, name, title, None, sections),
    "extending": node(ast.Game),
    "size": lambda span, constant: replace(constant, span=span, is_size=True),
    "param": lambda span, constant: replace(constant, span=span),
    "entry": entry,
    "glyph": lambda span, glyph, *starts: ast.Glyph(
        span, glyph, tuple(zip(starts[::2], starts[1::2], strict=True))
    ),
    "blocks": lambda span, *items: ast.Blocks(span, items[:-1], items[-1]),
    "agent_type": node(ast.NamedType),
    "cell_type": node(ast.CellType),
    "map": map_,
    "rows": lambda _, *items: items,
    "names": lambda _, *items: items,
    "chosen": chosen,
    "forbid": lambda span, *items: ast.Forbid(
        span, tuple(a for a in items[:-1] if isinstance(a, ast.Chosen)), items[-1]
    ),
    "all_but": node(ast.All),
    "shape": shape,
    "task_field": node(ast.TaskField),
    "train_on": node(ast.TrainOn),
    "hold_out": node(ast.HoldOut),
    "held_cell": node(ast.Path),
    "direction": lambda span, path: ast.Direction(span, "along", path),
    "away": lambda span, path: ast.Direction(span, "away", path),
    "toward": lambda span, path: ast.Direction(span, "toward", path),
    "nearer": node(ast.Toward),
    "farther": node(ast.AwayFrom),
    "at_random": node(ast.AtRandom),
    "mark": lambda span, shape, anchor: ast.Mark(span, shape_ref(shape), anchor),
    "near": lambda span, shape, anchor: ast.Near(span, shape_ref(shape), anchor),
    "shape_name": lambda span, name: ast.ShapeRef(span, name, None),
    "window": window,
    "show": lambda span, what, observer, *items: ast.Show(
        span, what, observer, items[:-1], items[-1]
    ),
    "show_event": node(ast.ShowEvent),
    "look": look,
    "mean": lambda span, name, value: ast.Measure(span, True, name, value),
    "final": lambda span, name, value: ast.Measure(span, False, name, value),
    "symmetric": lambda span, _, what: ast.Symmetric(span, what),
    "expect": lambda span, condition, *policies: ast.Expect(
        span, condition, policies[:-1], int(policies[-1])
    ),
    "policy": policy,
    "scripted": node(ast.ScriptedPolicy),
    "guard": lambda span, *items: ast.Guard(span, items[0] if items[1:] else None, items[-1]),
    "aim": lambda span, guard, shape, *others: ast.Aim(span, guard, shape_ref(shape), *others),
    "expr": binary("or"),
    "and_e": binary("and"),
    "negate": lambda span, operand: ast.Unary(span, "not", operand),
    "compare": lambda span, left, op, right: ast.Binary(span, op, left, right),
    "is_": binary("is"),
    "is_not": binary("is not"),
    "sum": chain,
    "prod": chain,
    "signed": ast.Unary,
    "power": lambda span, base, exponent: ast.Binary(span, "^", base, exponent),
    "int": lambda span, digits: ast.Int(span, int(digits)),
    "dec": lambda span, digits: ast.Decimal(span, float(digits)),
    "some": lambda span, domain: ast.Quantified(span, "any", domain),
    "every": lambda span, domain: ast.Quantified(span, "all", domain),
    "arm": arm,
    "key": lambda _, *items: items,
}
