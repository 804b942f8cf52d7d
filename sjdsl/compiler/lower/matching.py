"""Lowers `match`: pairs of the members of two domains, taken in random order.

Each pair that may be taken draws a rank. The kernel takes the pair with the greatest rank, drops
those that have a member in common with it, and goes on with the rest.
"""

from sjdsl.compiler import ir
from sjdsl.compiler.lower.axes import Axis, Value, iota, spread
from sjdsl.compiler.lower.domains import enter
from sjdsl.compiler.lower.draws import KEY
from sjdsl.compiler.lower.scope import (
    IterationScope,
    NotSupported,
    numbered,
)
from sjdsl.compiler.lower.selection import bound, nearest
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import (
    Cast,
    Expression,
    Literal,
    Name,
    call,
)


def match_(s: ir.Match, scope: IterationScope, w: Writer) -> IterationScope:
    """Returns the scope inside a `match`: along the left members, those without a partner masked.

    Raises NotSupported for a `match` inside other quantifiers, or of one certain agent.
    """
    if scope.axes or scope.digits:  # a `pick 1` around it has no axis, but each pick other pairs
        feature = "`match` inside `each`, `pick`, `first` or another `match`"
        instead = "write the `match` outside, and what is around it as conditions in its `where`"
        raise NotSupported(feature, s.origin, instead)
    left = enter(s.left, scope.always(), w)
    if not left.axes:
        instead = (
            "one agent has no rivals for it: "
            "write `each` for the left side, and `pick 1` inside for the right"
        )
        raise NotSupported("`match` of one certain agent", s.origin, instead)
    var = s.right.var
    partner = w.keep(var.name, _partners(s, left, w))
    matched = partner < w.module.extent(var.entity_type)
    right = numbered(var, partner)
    inner = bound(s.right, right, left.always(), w)
    return inner.when(scope.mask).when(w.keep("matched", matched))


def _partners(s: ir.Match, left: IterationScope, w: Writer) -> Value:
    """Returns the number of each left member's partner, past the end for those without one.

    left: the scope of the left members.
    """
    right = s.right
    rows = left.axes[-1]
    same_type = s.left.var.entity_type == right.var.entity_type
    if not same_type and s.left.var.entity_type.overlaps(right.var.entity_type):
        feature = "a `match` of two groups that have cells in common"
        raise NotSupported(feature, s.origin, "match a group with itself, or with other kinds")
    size = w.module.extent(right.var.entity_type)
    if s.first:
        inner, exists = nearest(right, left.always(), w)
        reached = inner.variables[right.var.name].number
        axes = (rows, inner.axes[-1])
        return _among_reached(s, reached, left.mask & exists, axes, size, same_type, w)
    inner = enter(right, left, w)
    cols = inner.axes[-1]
    variable = inner.variables[right.var.name]
    if cols == rows:
        feature = "a `match` whose right side is one certain agent for each left one"
        instead = "write `each` for both sides, one inside the other"
        raise NotSupported(feature, s.origin, instead)
    if variable.axis is None:
        return _among_reached(s, variable.number, inner.mask, (rows, cols), size, same_type, w)
    assert size.value == cols.size
    pairs = spread(inner.mask, (rows, cols))
    if same_type:
        pairs = pairs & ~call("jnp.eye", size, dtype=Name("bool"))
    pairs = w.keep_node("pairs", pairs, "bool")
    drawn = call("random_bits", KEY, w.stream(s.stream), rows.extent, cols.extent)
    ranks = w.keep_node("order", call("ranks", drawn, pairs), "u32")
    return Value(call("pair", ranks, alike=same_type), "i32", (rows,))


def _among_reached(
    s: ir.Match,
    numbers: Value,
    mask: Value,
    axes: tuple[Axis, Axis],
    size: Literal,
    same_type: bool,
    w: Writer,
) -> Value:
    """Returns what `_partners` does if each left member reaches only a few right ones.

    Random bits are drawn for these pairs alone. A pair's draw has the number of the pair among all
    pairs of a left and a right member.

    Args:
      numbers: the right members that each left one reaches; mask: which of these pairs there are.
      axes: of the left members, and of the places that each of them reaches.
      size: how many right members there are. same_type: whether both sides are of one type.
    """
    rows, _ = axes
    reached = w.keep_node("reached", spread(numbers, axes), "i32")
    is_pair = spread(mask, axes)
    left = iota(rows).node[:, None]
    if same_type:
        is_pair = is_pair & reached.ne(left)
    pair_numbers: Expression = Cast(left * size + reached, "u32")
    is_pair = w.keep_node("pairs", is_pair, "bool")
    stream = w.stream(s.stream)
    instance = w.keep_node("instance", pair_numbers, "u32")
    drawn = call("random_bits_at", KEY, stream, instance)
    ranks = w.keep_node("order", call("ranks", drawn, is_pair), "u32")
    partners = call("pair_reached", reached, ranks, size, alike=same_type)
    return Value(partners, "i32", (rows,))
