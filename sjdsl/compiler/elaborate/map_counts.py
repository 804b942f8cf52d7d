"""Counts of the map in `require`: how many cells of a kind it has, as they are at the start, and how many agents there are.

require count(gate) >= count(agent)   ->   7 >= 7
"""

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.diagnostics.tree import rewrite
from sjdsl.compiler.elaborate.scope import Static
from sjdsl.compiler.ir.evaluate_constant import holds
from sjdsl.compiler.ir.printer import domain
from sjdsl.compiler.ir.types import integer


def of_the_map(test: ir.Expr, static: Static) -> ir.Expr:
    """Returns a condition in which the counts of the map are numbers; other counts stay. Raises Poisoned for a game without a sound map."""

    def counted(node: ir.Node) -> ir.Node:
        found = _number(node, static) if isinstance(node, ir.Count) else None
        if found is None or not isinstance(node, ir.Count):
            return node
        number = ir.Number(type=integer(found, found), value=found, origin=node.origin)
        return ir.Named(type=number.type, name=f"count({domain(node.domain)})", value=number, origin=node.origin)

    result: ir.Expr = rewrite(test, counted)
    return result


def _number(count: ir.Count, static: Static) -> int | None:
    """Returns how many members a domain has at the start; None if that is not the map's alone."""
    d = count.domain
    if d.on is not None or d.restriction is not None:
        return None
    if d.var.sort.what != "cell":
        everybody = static.num_agents if d.var.sort.what == "agent" else static.movers[d.var.sort.name].number
        return everybody if d.where is None else None
    if d.where is not None and not _of_the_cell(d.where, d.var):
        return None
    if not static.rows:
        raise Poisoned
    meanings = {meaning.glyph: meaning for _, meaning in static.glyphs if meaning.kind in d.var.kinds}
    return sum(_is_member(d, meanings[glyph], static) for row in static.rows for glyph in row if glyph in meanings)


def _of_the_cell(test: ir.Expr, cell: ir.Member) -> bool:
    """Returns whether a condition compares fields of the cell with words and numbers, and reads nothing else."""
    known = (
        ir.Number,
        ir.Truth,
        ir.Word,
        ir.Nobody,
        ir.Named,
        ir.Compare,
        ir.InRange,
        ir.InWords,
        ir.Same,
        ir.Not,
        ir.Logic,
        ir.Arithmetic,
    )
    plain = all(isinstance(n, (*known, ir.FieldRead, ir.Member)) for n in ir.walk(test))
    reads = [n for n in ir.walk(test) if isinstance(n, ir.FieldRead)]
    simple = all(isinstance(n.owner, ir.Member) and n.owner.name == cell.name and not n.type.by for n in reads)
    return plain and simple and sum(isinstance(n, ir.Member) for n in ir.walk(test)) == len(reads)


def _is_member(d: ir.Domain, meaning: ir.GlyphMeaning, static: Static) -> bool:
    starts = {name: field.start for name, field in static.kinds[meaning.kind].items()} | dict(meaning.starts)

    def at_start(node: ir.Node) -> ir.Node:
        if not isinstance(node, ir.FieldRead):
            return node
        value = starts[node.name]
        if value is None:
            return ir.Nobody()
        return ir.Word(type=node.type, value=value) if isinstance(value, str) else ir.Number(type=node.type, value=value)

    return d.where is None or holds(rewrite(d.where, at_start), {})
