"""Evaluates expressions in one instance, reading the state before the phase (the snapshot)."""

from collections.abc import Callable, Iterable
from typing import Any, Literal, assert_never

from sjdsl.compiler import ir
from sjdsl.interpreter import members, numbers
from sjdsl.interpreter.closed import is_closed
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import HEADINGS, Value


def evaluate(e: ir.Expr, here: Instance) -> Value:
    """Returns the value of an expression; reals as float32, numbers and words checked against what their type allows."""
    if e.__class__ in _ONCE and is_closed(e, here.board):
        known = here.known.get(id(e))
        if known is None:
            known = here.known[id(e)] = (e, _checked(e, here))
        return known[1]
    return _checked(e, here)


def _checked(e: ir.Expr, here: Instance) -> Value:
    value = VALUES[e.__class__](e, here)
    type_ = e.type
    match type_.kind:
        case "real":
            value = numbers.real(value)
            numbers.check_interval(value, type_, e)
        case "int":
            numbers.check_interval(value, type_, e)
        case "word" if not type_.by:
            assert value in type_.words, (value, e)
    return value


def _name(e: "ir.Member | ir.Local", here: Instance) -> Value:
    assert e.name in here.names, f"`{e.name}` has no value here"
    return here.names[e.name]


def _arithmetic(e: ir.Arithmetic, here: Instance) -> Value:
    return numbers.arithmetic(e.fn, [evaluate(a, here) for a in e.args], e.type.kind == "real")


def _sum(e: ir.Sum, here: Instance) -> Value:
    values = [evaluate(e.value, here.binding(m.names)) for m in members.found(e.domain, here)]
    return numbers.total(values, e.type.kind == "real")


def _event_total(e: ir.EventTotal, here: Instance) -> int:
    return sum(n for (name, word), n in here.totals.items() if name == e.name and e.word in (None, word))


def _is_in_range(e: ir.InRange, here: Instance) -> bool:
    value = evaluate(e.value, here)
    return numbers.compare("<=", evaluate(e.low, here), value) and numbers.compare("<=", value, evaluate(e.high, here))


def _stands_on(e: ir.StandsOn, here: Instance) -> bool:
    cell = here.world.position[evaluate(e.agent, here)]
    return cell is not None and here.board.kind_of[cell] in e.kinds


def _logic(e: ir.Logic, here: Instance) -> bool:
    """Returns what `and` or `or` says; both stop at the first side that decides, so that guards protect."""
    decides = e.fn == "or"
    for arg in e.args:
        if bool(evaluate(arg, here)) == decides:
            return decides
    return not decides


def agents_in(value: Value) -> Iterable[int]:
    """Returns the agents of a set, the one agent, or none."""
    if isinstance(value, frozenset):
        return value
    return frozenset() if value is None else frozenset({value})


def _field(e: ir.FieldRead, here: Instance) -> Value:
    if e.owner is None:
        return here.world.fields[e.name]
    owner = evaluate(e.owner, here)
    assert owner is not None, f"`{e.name}` of nobody"
    if e.place == "agent":
        return here.world.agents[e.name][owner]
    return here.world.cells[here.board.kind_of[owner], e.name][here.board.number[owner]]


def _attribute(e: ir.Attribute, here: Instance) -> Value:
    owner = evaluate(e.owner, here)
    assert owner is not None, f"`{e.name}` of nobody"
    match e.name:
        case "index":
            return owner
        case "heading":
            return HEADINGS[here.world.heading[owner]]
        case "moved":
            return here.world.moved[owner]
        case "away":
            return not members.is_here(owner, here)
        case "row" | "col":
            cell = here.world.position[owner] if isinstance(owner, int) else owner
            assert cell is not None, f"`{e.name}` of an agent that is away"
            return cell.row if e.name == "row" else cell.col
        case _:
            assert_never(e.name)


def _entry(e: ir.At, here: Instance) -> Value:
    row, key, words = evaluate(e.row, here), evaluate(e.key, here), e.row.type.by[0]
    if e.key.type.kind != "mix":
        return row[words.index(key)]
    share = dict(zip(e.key.type.words, key, strict=True))
    parts = [numbers.arithmetic("*", [share[word], entry], is_real=True) for word, entry in zip(words, row, strict=True)]
    return numbers.total(parts, is_real=True)


def _case(e: ir.Case, here: Instance) -> Value:
    subject = evaluate(e.subject, here)
    if isinstance(subject, bool):
        subject = "yes" if subject else "no"
    arms = [arm for arm in e.arms if _applies(arm, subject)]
    assert len(arms) == 1, f"{len(arms)} arms apply to {subject}"
    return evaluate(arms[0].value, here)


def _applies(arm: ir.Arm, subject: int | str) -> bool:
    if isinstance(subject, str):
        return subject in arm.words
    return (arm.low is None or arm.low <= subject) and (arm.high is None or subject <= arm.high)


def _lowest(e: ir.Lowest, here: Instance) -> str:
    words = e.row.type.by[0]
    positive = [word for word, entry in zip(words, evaluate(e.row, here), strict=True) if entry > 0]
    order = -1 if e.last else 0
    return positive[order] if positive else words[order]


def _is_of_class(
    name: Literal["prisoners_dilemma", "stag_hunt", "chicken"], table: tuple[tuple[Value, Value], tuple[Value, Value]]
) -> bool:
    """Returns whether a table [own word][other's word], cooperation first, is such a game.

    Source: Macy and Flache, "Learning dynamics in social dilemmas", PNAS 2002; a chicken game by its order alone.
    """
    (reward, sucker), (temptation, punishment) = table
    match name:
        case "prisoners_dilemma":
            return bool(temptation > reward > punishment > sucker and 2 * reward > temptation + sucker)
        case "stag_hunt":
            return bool(reward > temptation >= punishment > sucker)
        case "chicken":
            return bool(temptation > reward > sucker > punishment)
        case _:
            assert_never(name)


_ONCE = (ir.Named, ir.Count, ir.Sum)  # kept where they name nothing around them

# The value of each class of expression, looked up: this is asked millions of times in the courses of `sjdsl test`.
VALUES: dict[type[ir.Node], Callable[[Any, Instance], Value]] = {
    ir.Member: _name,
    ir.Local: _name,
    ir.FieldRead: _field,
    ir.Number: lambda e, _: e.value,
    ir.Word: lambda e, _: e.value,
    ir.Truth: lambda e, _: e.value,
    ir.Nobody: lambda _, __: None,
    ir.ParamRef: lambda e, here: here.world.params[e.name],
    ir.Attribute: _attribute,
    ir.At: _entry,
    ir.Step: lambda _, here: here.world.step,
    ir.Arithmetic: _arithmetic,
    ir.Count: lambda e, here: len(members.found(e.domain, here)),
    ir.Sum: _sum,
    ir.SumRow: lambda e, here: numbers.total(list(evaluate(e.row, here)), e.type.kind == "real"),
    ir.Case: _case,
    ir.Lowest: _lowest,
    ir.Mix: lambda e, here: numbers.shares(evaluate(e.row, here)),
    ir.Ramp: lambda e, here: numbers.ramp(*(evaluate(x, here) for x in (e.value, e.zero_at, e.one_at))),
    ir.Named: lambda e, here: evaluate(e.value, here),
    ir.Narrowed: lambda e, here: evaluate(e.value, here),
    ir.EventTotal: _event_total,
    ir.Compare: lambda e, here: numbers.compare(e.fn, evaluate(e.left, here), evaluate(e.right, here)),
    ir.Same: lambda e, here: evaluate(e.left, here) == evaluate(e.right, here),
    ir.InRange: _is_in_range,
    ir.InWords: lambda e, here: evaluate(e.value, here) in e.words,
    ir.InSet: lambda e, here: evaluate(e.value, here) in agents_in(evaluate(e.container, here)),
    ir.IsEmpty: lambda e, here: not agents_in(evaluate(e.container, here)),
    ir.Chose: lambda e, here: here.actions[evaluate(e.agent, here)] == e.action,
    ir.Unoccupied: lambda e, here: members.agent_on(evaluate(e.cell, here), here) is None,
    ir.StandsOn: _stands_on,
    ir.Not: lambda e, here: not evaluate(e.value, here),
    ir.Logic: _logic,
    ir.MatrixClass: lambda e, here: _is_of_class(e.name, evaluate(e.table, here)),
}
