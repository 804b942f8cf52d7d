"""Lowers statements: each becomes array code for all its instances at once.

A statement that contains others lowers these in a scope with its quantifier, or with a narrower
mask; nothing of a block is a branch or a loop in generated code.
"""

from dataclasses import replace
from typing import assert_never

from sjdsl.compiler import ir
from sjdsl.compiler.ir.entity_types import AGENTS
from sjdsl.compiler.ir.queries import shape_named
from sjdsl.compiler.lower.assignments import add, set_
from sjdsl.compiler.lower.axes import FALSE, TRUE, joined, reduce, select, without
from sjdsl.compiler.lower.condition_names import condition_name, domain_name
from sjdsl.compiler.lower.domains import enter, is_empty, sweep
from sjdsl.compiler.lower.draws import chances, draw
from sjdsl.compiler.lower.matching import match_
from sjdsl.compiler.lower.movement import move, move_on_course, nobody_moves
from sjdsl.compiler.lower.per_agent import per_agent, turn, way_of_each
from sjdsl.compiler.lower.rewards_and_events import give, tally
from sjdsl.compiler.lower.scope import AgentVar, IterationScope, NotSupported
from sjdsl.compiler.lower.selection import nearest, pick
from sjdsl.compiler.lower.sending import Sends
from sjdsl.compiler.lower.state_reads import nowhere
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import Name, reshaped


def block(body: tuple[ir.Stmt, ...], scope: IterationScope, w: Writer, sends: Sends) -> None:
    """Writes the statements of a block; a name that `let` or `draw` gives ends with the block."""
    for s in body:
        w.origin = s.origin
        match s:
            case ir.Let():
                before = len(w.body)
                with w.deciding(s.name in w.module.deciding.variables):
                    value = w.value(s.value, scope)
                value = w.keep(s.name, w.rename(s.name, value, before))
                scope = scope.letting(s.name, value)
            case ir.Draw():
                scope = scope.letting(s.name, draw(s, scope, w))
            case _:
                statement(s, scope, w, sends)


def statement(s: ir.Stmt, scope: IterationScope, w: Writer, sends: Sends) -> None:
    """Lowers one statement of a phase, under the mask of the scope."""
    match s:
        case ir.Each() if not is_empty(s.domain, w):
            inner = enter(s.domain, scope, w)
            _inside(s.body, inner, w, sends, domain_name(s.domain, w.game))
        case ir.Pick():
            inner, nobody, body = pick(s, scope, w)
            _inside(body, inner, w, sends, f"{s.domain.var.name}_found")
            _inside(s.otherwise, scope.when(nobody), w, sends)
        case ir.First() if not is_empty(s.domain, w):
            inner, exists = nearest(s.domain, scope, w)
            inner = inner.when(scope.mask).when(exists)
            _inside(s.body, inner, w, sends, f"{s.domain.var.name}_found")
        case ir.Match() if not is_empty(s.left, w) and not is_empty(s.right, w):
            _inside(s.body, match_(s, scope, w), w, sends)
        case ir.Each() | ir.First() | ir.Match():
            pass
        case ir.When():
            when(s, scope, w, sends)
        case ir.Chance():
            happens, none = chances(s, scope, w)
            for branch, hit in zip(s.branches, happens, strict=True):
                _inside(branch.body, scope.when(hit), w, sends)
            _inside(s.otherwise, scope.when(none), w, sends)
        case ir.Set():
            set_(s, scope, w)
        case ir.Add():
            add(s, scope, w)
        case ir.Give():
            give(s, scope, w)
        case ir.Tally():
            tally(s, scope, w)
        case ir.Send():
            sends.add(s, scope, w)
        case ir.Shift():
            sends.shift(s, scope, w)
        case ir.Face():
            who = per_agent("turned", s.who, scope, w)
            turn(AGENTS, who, None, way_of_each(s.who, s.heading, scope, w), None, w)
        case ir.Remove():
            sends.remove(s, scope, w)
        case ir.Move() if is_empty(s.domain, w):
            nobody_moves(s, w)
        case ir.Move(course=None):
            move(s, scope, w)
        case ir.Move():
            move_on_course(s, scope, w)
        case ir.Mark():
            mark(s, scope, w)
        case ir.End():
            ended = w.total("ended")
            ends = reduce("any", scope.mask, scope.mask.axes)
            w.accumulate("ended", joined("|", ended, ends.node))
        case ir.Let() | ir.Draw():
            raise AssertionError(s)
        case _:
            assert_never(s)


def _inside(
    body: tuple[ir.Stmt, ...], scope: IterationScope, w: Writer, sends: Sends, name: str = ""
) -> None:
    """Writes the block of a statement, unless it never happens.

    name: of the scope's mask, which becomes a variable if several statements read it.
    """
    if not body or scope.mask == FALSE:
        return
    num_readers = len(body) + sum(len(getattr(s, "body", ())) for s in body)
    if num_readers > 1:
        scope = replace(scope, mask=w.keep(name or "active", scope.mask))
    block(body, scope, w, sends)


def when(s: ir.When, scope: IterationScope, w: Writer, sends: Sends) -> None:
    """Writes branches in order: each where its condition holds and none before it did."""
    is_read_twice = len(s.branches) > 1 or bool(s.otherwise)
    rest = scope  # where no branch so far happens
    for number, branch in enumerate(s.branches):
        if number > 2:  # of many branches the conditions would pile up
            rest = replace(rest, mask=w.keep("rest", rest.mask))
        name = condition_name(branch.test, w.game)
        test = w.value(branch.test, scope)
        if is_read_twice:
            test = w.keep(name or "holds", test)
        mask_name = f"where_{name}" if name and rest.mask != TRUE else name
        _inside(branch.body, rest.when(test), w, sends, mask_name)
        rest = rest.when(~test)
    _inside(s.otherwise, rest, w, sends)


def mark(s: ir.Mark, scope: IterationScope, w: Writer) -> None:
    """Writes `mark beam of x`: notes the beam's cells, to be seen in the next observation.

    Cell 0 stands for none. Raises NotSupported unless x is each agent once.
    """
    anchor = scope.variables[s.anchor.name]
    if anchor.axis is None or not isinstance(anchor, AgentVar):
        instead = "mark around an agent that an `each` names"
        raise NotSupported("`mark` around anything but an agent of an `each`", s.origin, instead)
    swept = sweep(ir.Near(shape=s.shape, anchor=s.anchor), scope, w)
    happens = reduce("any", scope.mask, without(scope.axes, swept.cells.axes))
    cells = select(happens & swept.is_reached, swept.cells, nowhere(w))
    marked = w.keep_node("marked", reshaped(cells.node, -1), "i32")
    assert isinstance(marked, Name)
    w.marked[marked] = mark_size(s, w.game)


def mark_size(rules: ir.Node, game: ir.Game) -> int:
    """Returns how many cells a phase or a statement can mark."""
    size = 0
    for node in ir.walk(rules):
        if isinstance(node, ir.Mark):
            size += shape_named(game, node.shape).num_cells
    return size * game.agents.number
