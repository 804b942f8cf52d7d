"""The constructs of the language as an author knows them, and which of them a game has: what a campaign counts."""

from collections import Counter
from collections.abc import Callable
from functools import partial

from sjdsl.compiler import ir
from sjdsl.compiler.ir.operations import CALCULATIONS


def _has_row(node: ir.Node, sort: str) -> bool:
    return isinstance(node, ir.VarField) and any(level.sort == sort for level in node.type.by)


def _holds(node: ir.Node, kind: str) -> bool:
    return isinstance(node, ir.VarField) and node.type.kind == kind


def _calculates(name: str, node: ir.Node) -> bool:
    return isinstance(node, ir.Arithmetic) and node.fn == name


CONSTRUCTS: dict[str, Callable[[ir.Node], bool]] = {
    "`each`": lambda n: isinstance(n, ir.Each),
    "`pick`": lambda n: isinstance(n, ir.Pick),
    "`first`": lambda n: isinstance(n, ir.First),
    "`match`": lambda n: isinstance(n, ir.Match),
    "`when`": lambda n: isinstance(n, ir.When),
    "`chance`": lambda n: isinstance(n, ir.Chance),
    "`draw` of numbers with weights": lambda n: isinstance(n, ir.Draw) and bool(n.numbers),
    **{f"`{name}`": partial(_calculates, name) for name, row in CALCULATIONS.items() if not row.sign},
    "`before` in checks": lambda n: isinstance(n, ir.Before),
    "`show` of `step` and of defines": lambda n: isinstance(n, ir.Observable) and n.value is not None,
    "`draw` of words or whole numbers": lambda n: isinstance(n, ir.Draw) and (bool(n.words) or (n.low is not None and not _real(n))),
    "`draw` of real numbers": lambda n: isinstance(n, ir.Draw) and _real(n),
    "`set … by lot`": lambda n: isinstance(n, ir.Set) and n.lot is not None,
    "`add`": lambda n: isinstance(n, ir.Add),
    "`give`": lambda n: isinstance(n, ir.Give),
    "`tally`": lambda n: isinstance(n, ir.Tally),
    "`mark`": lambda n: isinstance(n, ir.Mark),
    "`end`": lambda n: isinstance(n, ir.End),
    "`move` of agents": lambda n: isinstance(n, ir.Move) and n.course is None,
    "`move` of movers": lambda n: isinstance(n, ir.Move) and n.course is not None,
    "`send` to a domain": lambda n: isinstance(n, ir.Send),
    "`send … after`": lambda n: isinstance(n, ir.Send) and n.after is not None,
    "`send … by`, or to a cell": lambda n: isinstance(n, ir.Shift),
    "`remove`": lambda n: isinstance(n, ir.Remove),
    "`map wraps`": lambda n: isinstance(n, ir.Game) and n.wraps,
    "movers": lambda n: isinstance(n, ir.Movers),
    "actions with arguments": lambda n: isinstance(n, ir.ActionWithArguments),
    "`forbid`": lambda n: isinstance(n, ir.Forbid),
    "timers": lambda n: isinstance(n, ir.VarField) and n.timer,
    "fields that hold an agent": lambda n: _holds(n, "agent"),
    "fields that hold a set of agents": lambda n: _holds(n, "agents"),
    "fields that hold a cell": lambda n: _holds(n, "cell"),
    "rows by words": lambda n: _has_row(n, "word"),
    "rows by numbers": lambda n: _has_row(n, "number"),
    "rows by agent": lambda n: _has_row(n, "agent"),
    "tables of parameters": lambda n: isinstance(n, ir.Param) and bool(n.type.by),
    "`shift` of rows": lambda n: isinstance(n, ir.ShiftRow),
    "`min`, `max` over a domain": lambda n: isinstance(n, ir.Extreme),
    "`distance`": lambda n: isinstance(n, ir.Distance),
    "shapes that something blocks": lambda n: isinstance(n, ir.Block) and n.what != "agents",
    "windows of one's own": lambda n: isinstance(n, ir.Window) and bool(n.views),
    "`show` with labels": lambda n: isinstance(n, ir.Observable) and bool(n.labels),
    "`show … when`": lambda n: isinstance(n, ir.Observable) and n.shown_when is not None,
    "`hide other`, marks or content": lambda n: isinstance(n, ir.Hidden),
    "policies": lambda n: isinstance(n, ir.ScriptedPolicy),
    "scenarios": lambda n: isinstance(n, ir.Scenario),
    "checks": lambda n: isinstance(n, ir.Check),
    "looks": lambda n: isinstance(n, ir.Look),
}


def _real(draw: ir.Draw) -> bool:
    return any(end is not None and end.type.kind == "real" for end in (draw.low, draw.high))


def constructs_of(game: ir.Game) -> set[str]:
    """Returns which constructs a game has."""
    left, found = dict(CONSTRUCTS), set()
    for node in ir.walk(game):
        for name in [name for name, test in left.items() if test(node)]:
            found.add(name)
            del left[name]
    return found


def table(found: Counter[str], games: int) -> list[str]:
    """Returns the rows of a table: in how many of the games each construct is."""
    rows = [f"| {name} | {found[name]:,} |" for name in CONSTRUCTS]
    return [f"| construct | games of {games:,} |", "|---|--:|", *rows]
