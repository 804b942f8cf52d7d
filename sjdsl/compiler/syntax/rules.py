"""Says what each rule of the grammar is in the AST: a class, or a small function."""

from collections.abc import Callable
from dataclasses import fields, replace
from itertools import zip_longest
from typing import Any, Literal

from sjdsl.compiler import ast
from sjdsl.compiler.ast.node import Node
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.source import Span

Build = Callable[..., Any]
# Kinds of tokens that become plain texts.
AS_WRITTEN = frozenset(("INT", "DEC", "CMP", "SIGN", "TIMES", "DOTS", "OTHERWISE"))


class Part(Record):
    """The content of an optional clause (`as x`, `where c`), for the rule around it."""

    rule: str
    content: Any


def unquote(text: str) -> str:
    r"""Returns the inside of a quoted string.

    `\"` is a quote, `\\` a backslash, and any other backslash stands for itself.
    """
    return text[1:-1].replace("\\\\", "\0").replace('\\"', '"').replace("\0", "\\")


def split(items: tuple[Any, ...]) -> tuple[tuple[Any, ...], dict[str, Any]]:
    """Returns the plain children of a rule, and the contents of its clauses by name."""
    plain = tuple(item for item in items if not isinstance(item, Part))
    return plain, {item.rule: item.content for item in items if isinstance(item, Part)}


def node(kind: type[Node], *same: str, **other: str) -> Build:
    """Returns what builds a node from a rule whose children fill its fields in order.

    The last field, if it is a tuple, takes all that are left. A clause fills the field of its name
    (`same`), or that of `field=clause`. A field whose child or clause is missing is None, or empty
    for a list of names.
    """
    make: Build = kind
    clauses = dict(zip(same, same, strict=True)) | other
    declared = [field for field in fields(kind)[1:] if field.name not in clauses]
    names = [field.name for field in declared]
    number = len(declared)
    takes_rest = bool(declared) and str(declared[-1].type).startswith("tuple[")

    def build(span: Span, *items: Any) -> Node:
        """Returns the node of one rule."""
        plain, contents = split(items)
        if takes_rest:
            plain = (*plain[: number - 1], plain[number - 1 :])
        values = dict(zip_longest(names, plain))
        for name, clause in clauses.items():
            values[name] = contents.get(clause, () if clause == "names" else None)
        built: Node = make(span=span, **values)
        return built

    return build


# A function with the name of a rule of the grammar builds its node from the rule's children.


def constant(span: Span, *items: Any) -> ast.Constant:
    (name, unit, value, *limits), clauses = split(items)
    low, high = limits[0] if limits else (None, None)
    return ast.Constant(span, False, name, clauses.get("by"), unit, value, low, high)


def blocks(span: Span, *items: Any) -> ast.Blocks:
    names = tuple(i for i in items if isinstance(i, ast.Name))
    return ast.Blocks(span, names, items[-1] if len(items) > len(names) else None)


def map_(span: Span, *items: Any) -> ast.Map:
    """Returns a map, in a file or as rows."""
    *wraps, content = items
    edges: Literal["joined"] | None = "joined" if wraps else None
    if isinstance(content, ast.String):
        return ast.Map(span, content, (), edges)
    return ast.Map(span, None, content, edges)


def agents(span: Span, *items: Any) -> ast.Agents:
    kinds = ast.Acts | ast.Moves | ast.Field | ast.Timer | ast.Forbid | ast.Blocks
    attributes = tuple(i for i in items if isinstance(i, kinds))
    return ast.Agents(span, items[0] if len(items) > len(attributes) else None, attributes)


def chosen(span: Span, action: ast.Name | ast.Call) -> ast.Chosen:
    if isinstance(action, ast.Name):
        return ast.Chosen(span, action, None)
    return ast.Chosen(span, action.name, action.arguments)


def shape(span: Span, name: ast.Name, content: ast.Call | tuple[ast.String, ...]) -> ast.Shape:
    if isinstance(content, ast.Call):
        return ast.Shape(span, name, (), content)
    return ast.Shape(span, name, content, None)


def window(span: Span, *items: Any) -> ast.Window:
    has_condition = len(items) % 2 == 1
    *flat, condition = items if has_condition else (*items, None)
    sides = tuple(zip(flat[::2], flat[1::2], strict=True))
    return ast.Window(span, sides, condition)


def show(span: Span, what: ast.Path, *items: Any) -> ast.Show:
    plain, clauses = split(items)
    labels = tuple(i for i in plain if isinstance(i, ast.Relabel))
    condition = plain[-1] if len(plain) > len(labels) else None
    return ast.Show(span, what, clauses.get("observer"), labels, condition)


def checks(span: Span, *items: Any) -> ast.Checks:
    name = items[0] if items and isinstance(items[0], ast.Name) else None
    return ast.Checks(span, name, items[1:] if name else items)


def policy(span: Span, first: Any, *rest: Any) -> ast.Policy:
    """Returns a policy of an `expect`: `seek KIND`, `never(ACTION)` or a name."""
    match first, rest:
        case Part(rule="seek", content=domain), ():
            seek = ast.Name(replace(span, end=span.start + len("seek")), "seek")
            return ast.Policy(span, seek, (), domain)
        case ast.Name() as name, (Part(content=actions),):
            return ast.Policy(span, name, actions, None)
        case _:
            return ast.Policy(span, first, (), None)


def guard(span: Span, *items: Any) -> ast.Guard:
    (first, *_), clauses = split(items)
    if isinstance(first, ast.On):
        return ast.Guard(span, first, clauses.get("where"))
    return ast.Guard(span, None, first)


def go(span: Span, *items: Any) -> ast.Go:
    (*guards, domain), clauses = split(items)
    return ast.Go(span, guards[0] if guards else None, domain, clauses.get("avoiding"))


def aim(span: Span, *items: Any) -> ast.Aim:
    (*guards, shape, domain, action), clauses = split(items)
    by = guards[0] if guards else None
    return ast.Aim(span, by, shape_ref(shape), domain, clauses.get("avoiding"), action)


def task_field(span: Span, name: ast.Name, *items: Any) -> ast.TaskField:
    (type_,), clauses = split(items)
    return ast.TaskField(span, name, clauses.get("by"), "different" in clauses, type_)


def draw(span: Span, name: ast.Name, *items: Any) -> ast.Draw:
    (source, *high), clauses = split(items)
    is_different = "different" in clauses
    return ast.Draw(span, name, source, high[0] if high else None, clauses.get("by"), is_different)


def match_(span: Span, left: ast.Domain, *items: Any) -> ast.Match:
    (right, block), clauses = split(items)
    return ast.Match(span, left, "nearest" in clauses, right, block)


def shape_ref(shape: ast.ShapeRef | ast.Call) -> ast.ShapeRef:
    if isinstance(shape, ast.Call):
        return ast.ShapeRef(shape.span, shape.name, shape.arguments)
    return shape


def chain(span: Span, left: ast.Expr, *rest: Any) -> ast.Expr:
    """Returns a chain of operators: `a + b - c` becomes `(a + b) - c`."""
    *inner, last_op, last = rest
    for op, right in zip(inner[::2], inner[1::2], strict=True):
        left = ast.Binary(replace(span, end=right.span.end), op, left, right)
    return ast.Binary(span, last_op, left, last)


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


# The rules whose nodes have the names of the rules, and their children as fields.
PLAIN = (
    ast.Cite, ast.About, ast.Override, ast.Drop, ast.Table, ast.Episode, ast.Task, ast.Kind,
    ast.Numbers, ast.Words, ast.Group, ast.Movers, ast.Acts, ast.Action, ast.Moves, ast.Schedule,
    ast.Turn, ast.Block, ast.Let, ast.Each, ast.Pick, ast.First, ast.When, ast.Chance,
    ast.Add, ast.Give, ast.Remove, ast.Move, ast.Ahead, ast.Along, ast.End, ast.Members,
    ast.Observe, ast.Paint, ast.Metrics, ast.Require, ast.Always, ast.Once, ast.Conserved,
    ast.Monotone, ast.Act, ast.Slots, ast.Chose, ast.Standing, ast.Within, ast.Nobody, ast.Count,
    ast.Total, ast.Case, ast.Call, ast.Path, ast.Member, ast.Index,
)  # fmt: skip
RULES: dict[str, Build] = {kind.__name__.lower(): node(kind) for kind in PLAIN} | {
    "start": lambda span, version, game: ast.File(span, int(version), game),
    "game": node(ast.Game, "title", "extends"),
    "variant": node(ast.Variant, "title"),
    "size": lambda span, constant: replace(constant, span=span, is_size=True),
    "param": lambda span, constant: replace(constant, span=span),
    "constant": constant,
    "limits": lambda _, *items: items,
    "unit": lambda _, item: item,
    "entry": entry,
    "glyph": lambda span, glyph, *starts: ast.Glyph(
        span, glyph, tuple(zip(starts[::2], starts[1::2], strict=True))
    ),
    "blocks": blocks,
    "blocked": lambda _, item: item,
    "field": node(ast.Field, "by"),
    "timer": node(ast.Timer, "by"),
    "range": lambda span, low, high, *capped: ast.Range(span, low, high, bool(capped)),
    "reals": lambda span, unit, low, high, *capped: ast.Reals(span, unit, low, high, bool(capped)),
    "agent_type": lambda span, *items: ast.NamedType(span, len(items) == 2, items[-1]),
    "cell_type": ast.CellType,
    "map": map_,
    "rows": lambda _, *items: items,
    "agents": agents,
    "argument": lambda span, *items: ast.Argument(
        span, items[0] if len(items) > 1 else None, items[-1]
    ),
    "chosen": chosen,
    "forbid": lambda span, *items: ast.Forbid(
        span, tuple(a for a in items[:-1] if isinstance(a, ast.Chosen)), items[-1]
    ),
    "all": lambda span: ast.All(span, None),
    "all_but": ast.All,
    "shape": shape,
    "define": node(ast.Define, parameters="names"),
    "trials": lambda span, steps, *kept: ast.Trials(span, steps, kept[0] if kept else ()),
    "keep": lambda _, *paths: paths,
    "phase": node(ast.Phase, parameters="names", at="moment"),
    "draw": draw,
    "task_field": task_field,
    "train_on": node(ast.TrainOn),
    "hold_out": node(ast.HoldOut, condition="where"),
    "match": match_,
    "otherwise": lambda _, item: item,
    "set": node(ast.Set, lot="by_lot"),
    "tally": node(ast.Tally, by="amount", receiver="gainer"),
    "send": node(ast.Send, "after", "facing", "stay"),
    "held_cell": node(ast.Path),
    "shift": node(ast.Shift, "facing", "stay"),
    "direction": lambda span, path: ast.Direction(span, "along", path),
    "away": lambda span, path: ast.Direction(span, "away", path),
    "toward": lambda span, path: ast.Direction(span, "toward", path),
    "nearer": node(ast.Toward, avoided="avoiding"),
    "farther": node(ast.AwayFrom, avoided="avoiding"),
    "at_random": node(ast.AtRandom, avoided="avoiding"),
    "mark": lambda span, shape, anchor: ast.Mark(span, shape_ref(shape), anchor),
    "domain": node(ast.Domain, "bind", "where", restriction="inside"),
    "on": node(ast.On, "bind"),
    "near": lambda span, shape, anchor: ast.Near(span, shape_ref(shape), anchor),
    "shape_name": lambda span, name: ast.ShapeRef(span, name, None),
    "window": window,
    "show": show,
    "relabel": node(ast.Relabel, "where"),
    "look": node(ast.Look, "where", "body", "badge"),
    "show_event": node(ast.ShowEvent),
    "hide": node(ast.Hide, on="hidden_on"),
    "event": node(ast.Event, "by"),
    "mean": lambda span, name, value: ast.Measure(span, True, name, value),
    "final": lambda span, name, value: ast.Measure(span, False, name, value),
    "checks": checks,
    "symmetric": lambda span, _, what: ast.Symmetric(span, what),
    "expect": lambda span, condition, *policies: ast.Expect(
        span, condition, policies[:-1], int(policies[-1])
    ),
    "policy": policy,
    "scripted": node(ast.ScriptedPolicy, "title"),
    "guard": guard,
    "go": go,
    "aim": aim,
    "scenario": node(ast.Scenario, "title"),
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
    "extreme": node(ast.Extreme, "if_none"),
    "arm": arm,
    "key": lambda _, *items: items,
}
