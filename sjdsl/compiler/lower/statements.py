"""Lowers statements: each becomes array code for all its instances at once."""

from dataclasses import replace
from typing import assert_never

from sjdsl.compiler import ir
from sjdsl.compiler.lower.assignments import add, set_
from sjdsl.compiler.lower.axes import Value, both, invert, literal, reduce, select, wrapped
from sjdsl.compiler.lower.domains import enter, is_empty, sweep
from sjdsl.compiler.lower.draws import chances, draw
from sjdsl.compiler.lower.expressions import lower
from sjdsl.compiler.lower.movement import move
from sjdsl.compiler.lower.relocation import Sends
from sjdsl.compiler.lower.rewards_and_events import give, tally
from sjdsl.compiler.lower.scope import AgentVar, Frame, NotSupported, Writer
from sjdsl.compiler.lower.selection import first, match_, pick


def block(body: tuple[ir.Stmt, ...], frame: Frame, w: Writer, sends: Sends) -> None:
    """Writes the lines of a block; names bound in it end with it."""
    for s in body:
        w.origin = s.origin
        match s:
            case ir.Let():
                value = lower(s.value, frame.always(), w)
                frame = replace(frame, locals={**frame.locals, s.name: w.keep(s.name, value)})
            case ir.Draw():
                frame = replace(frame, locals={**frame.locals, s.name: draw(s, frame, w)})
            case _:
                sentence(s, frame, w, sends)


def sentence(s: ir.Stmt, frame: Frame, w: Writer, sends: Sends) -> None:
    match s:
        case ir.Each() if not is_empty(s.domain, w):
            _inside(s.body, enter(s.domain, frame, w), w, sends)
        case ir.Pick():
            inner, nobody = pick(s, frame, w)
            _inside(s.body, inner, w, sends)
            _inside(s.otherwise, frame.when(nobody), w, sends)
        case ir.First():
            inner, none = first(s, frame, w)
            _inside(s.body, inner, w, sends)
            _inside(s.otherwise, none, w, sends)
        case ir.Match() if not is_empty(s.left, w) and not is_empty(s.right, w):
            _inside(s.body, match_(s, frame, w), w, sends)
        case ir.Each() | ir.Match():
            pass
        case ir.When():
            when(s, frame, w, sends)
        case ir.Chance():
            happens, none = chances(s, frame, w)
            for branch, hit in zip(s.branches, happens, strict=True):
                _inside(branch.body, frame.when(hit), w, sends)
            _inside(s.otherwise, frame.when(none), w, sends)
        case ir.Set():
            set_(s, frame, w)
        case ir.Add():
            add(s, frame, w)
        case ir.Give():
            give(s, frame, w)
        case ir.Tally():
            tally(s, frame, w)
        case ir.Send():
            sends.add(s, frame, w)
        case ir.Remove():
            sends.remove(s, frame, w)
        case ir.Move():
            move(s, frame, w)
        case ir.Mark():
            mark(s, frame, w)
        case ir.End():
            active = active_mask(frame)
            w.accumulate("ended", f"{w.total('ended')} | {wrapped(reduce('any', active, active.axes))}")
        case ir.Let() | ir.Draw():
            raise AssertionError(s)
        case _:
            assert_never(s)


def _inside(body: tuple[ir.Stmt, ...], frame: Frame, w: Writer, sends: Sends) -> None:
    if not body or (frame.mask is not None and frame.mask.text == "False"):
        return
    if frame.mask is not None and len(body) + sum(len(getattr(s, "body", ())) for s in body) > 1:
        frame = replace(frame, mask=w.keep("active", frame.mask))
    block(body, frame, w, sends)


def active_mask(frame: Frame) -> Value:
    return frame.mask if frame.mask is not None else literal(True, "bool")


def when(s: ir.When, frame: Frame, w: Writer, sends: Sends) -> None:
    """Branches in order: each where its condition holds and none before it did."""
    rest = frame
    for branch in s.branches:
        test = lower(branch.test, frame.always(), w)
        if len(s.branches) > 1 or s.otherwise:
            test = w.keep("holds", test)
        _inside(branch.body, rest.when(test), w, sends)
        rest = rest.when(invert(test))
    _inside(s.otherwise, rest, w, sends)


def mark(s: ir.Mark, frame: Frame, w: Writer) -> None:
    """Keeps the cells to be shown in the next observation; 0 stands for none."""
    if frame.variables[s.anchor.name].axis is None or not isinstance(frame.variables[s.anchor.name], AgentVar):
        instead = "mark around an agent that an `each` names"
        raise NotSupported("`mark` around anything but an agent of an `each`", s.origin, instead)
    place = ir.Near(shape=s.shape, anchor=s.anchor)
    swept = sweep(place, frame, w)
    over = tuple(a for a in frame.axes if a not in swept.cells.axes)
    happens = None if frame.mask is None else reduce("any", frame.mask, over)
    ok = both(happens, swept.ok)
    cells = select(ok, swept.cells, literal(0, "i32"))
    w.marked[w.keep("marked", Value(f"{wrapped(cells)}.reshape(-1)", "i32")).text] = mark_size(s, w.module.game)


def mark_size(rules: ir.Node, game: ir.Game) -> int:
    """Returns how many cells a phase or a sentence can mark."""
    size = 0
    shapes = {s.name: s for s in game.shapes}
    for node in ir.walk(rules):
        if isinstance(node, ir.Mark):
            size += game.agents.number * sum(map(len, shapes[node.shape].lanes))
    return size


__all__ = ["block", "mark_size"]
