"""Lowers `match`: greedy pairs of two domains in random order."""

from sjdsl.compiler import ir
from sjdsl.compiler.lower.axes import Axis, Value, binary, both, iota, spread
from sjdsl.compiler.lower.domains import enter
from sjdsl.compiler.lower.draws import KEY
from sjdsl.compiler.lower.scope import AgentVar, CellVar, IterationScope, NotSupported, Variable
from sjdsl.compiler.lower.selection import mask_over, nearest, under
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import (
    ALL,
    NEW_AXIS,
    Binary,
    Cast,
    Expression,
    Index,
    Literal,
    Name,
    Unary,
    call,
)


def match_(s: ir.Match, scope: IterationScope, w: Writer) -> IterationScope:
    """Returns the scope inside a `match`: the left side's axis, those without a partner masked out."""
    if scope.axes or scope.digits:  # a `pick 1` around it gives no axis, yet its pairs are others
        instead = "write the `match` outside, and what is around it as conditions in its `where`"
        raise NotSupported(
            "`match` inside `each`, `pick`, `first` or another `match`", s.origin, instead
        )
    left = enter(s.left, scope.always(), w)
    if not left.axes:
        instead = "one agent has no rivals for it: write `each` for the left side, and `pick 1` inside for the right"
        raise NotSupported("`match` of one certain agent", s.origin, instead)
    var = s.right.var
    partner = w.keep(var.name, _partners(s, left, w))
    size = w.module.extent(var.sort)
    matched = binary("<", partner, Value(size, "i32"), "bool")
    right: Variable = (
        CellVar(partner, var.kinds) if var.sort.what == "cell" else AgentVar(partner, sort=var.sort)
    )
    inner = left.always().binding(**{var.name: right}, **under(s.right, right, w))
    return inner.when(scope.mask).when(w.keep("matched", matched))


def _partners(s: ir.Match, left: IterationScope, w: Writer) -> Value:
    """Returns the partner of each left member, past the end for those who have none."""
    right, rows = s.right, left.axes[-1]
    alike = s.left.var.sort == right.var.sort
    if not alike and s.left.var.sort.overlaps(right.var.sort):
        raise NotSupported(
            "a `match` of two groups that have cells in common",
            s.origin,
            "match a group with itself, or with other kinds",
        )
    size = w.module.extent(right.var.sort)
    if s.first:
        inner, lanes, found = nearest(right, left.always(), w)
        mask = both(left.mask, found)
        return _among_reached(
            s, inner.variables[right.var.name].number, mask, (rows, lanes), size, alike, w
        )
    inner = enter(right, left, w)
    cols = inner.axes[-1]
    variable = inner.variables[right.var.name]
    if cols == rows:
        instead = "write `each` for both sides, one inside the other"
        raise NotSupported(
            "a `match` whose right side is one certain agent for each left one", s.origin, instead
        )
    if variable.axis is None:
        return _among_reached(s, variable.number, inner.mask, (rows, cols), size, alike, w)
    assert size.value == cols.size
    pairs = mask_over(inner, (rows, cols)).node
    if alike:
        pairs = Binary("&", pairs, Unary("~", call("jnp.eye", size, dtype=Name("bool"))))
    pairs = w.keep("pairs", Value(pairs, "bool", (rows, cols))).node
    drawn = call("random_bits", KEY, w.stream(s.stream), rows.extent, cols.extent)
    ranks = w.keep("order", Value(call("ranks", drawn, pairs), "u32", (rows, cols)))
    return Value(call("pair", ranks.node, alike=Literal(alike)), "i32", (rows,))


def _among_reached(
    s: ir.Match,
    index: Value,
    mask: Value,
    axes: tuple[Axis, Axis],
    size: Literal,
    alike: bool,
    w: Writer,
) -> Value:
    """Returns partners among the few members that each left one reaches: a word for each of them, not for all pairs there are."""
    rows = axes[0]
    reached = w.keep("reached", Value(spread(index, axes), "i32", axes)).node
    happens = spread(mask, axes)
    mine = Index(iota(rows).node, (ALL, NEW_AXIS))
    if alike:
        happens = Binary("&", happens, Binary("!=", reached, mine))
    numbers: Expression = Cast(Binary("+", Binary("*", mine, size), reached), "u32")
    happens = w.keep("pairs", Value(happens, "bool", axes)).node
    drawn = call(
        "random_bits_at",
        KEY,
        w.stream(s.stream),
        w.keep("instance", Value(numbers, "u32", axes)).node,
    )
    ranks = w.keep("order", Value(call("ranks", drawn, happens), "u32", axes))
    return Value(
        call("pair_reached", reached, ranks.node, size, alike=Literal(alike)), "i32", (rows,)
    )
