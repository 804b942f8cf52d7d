"""Expressions: what each one is worth in one instance. Everything is read from the snapshot."""

from collections.abc import Iterable
from typing import Literal, assert_never

from sjdsl.compiler import ir
from sjdsl.interpreter import members, numbers
from sjdsl.interpreter.closed import is_closed
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import HEADINGS, Value


def evaluate(e: ir.Expr, here: Instance) -> Value:
    """Returns the value of an expression; reals as float32, numbers and words checked against what their type allows."""
    if isinstance(e, ir.Named | ir.Count | ir.Sum) and is_closed(e, here.board):
        if id(e) not in here.known:
            here.known[id(e)] = (e, _checked(e, here))
        return here.known[id(e)][1]
    return _checked(e, here)


def _checked(e: ir.Expr, here: Instance) -> Value:
    value = _value(e, here)
    if e.type.kind == "real":
        value = numbers.real(value)
    if e.type.kind in ("int", "real"):
        numbers.check_interval(value, e.type, e)
    if e.type.kind == "word" and not e.type.by:
        assert value in e.type.words, (value, e)
    return value


def _value(e: ir.Expr, here: Instance) -> Value:
    match e:
        case ir.Member() | ir.Local():
            assert e.name in here.names, f"`{e.name}` has no value here"
            return here.names[e.name]
        case ir.FieldRead():
            return _field(e, here)
        case ir.Number() | ir.Word() | ir.Truth():
            return e.value
        case ir.Nobody():
            return None
        case ir.ParamRef():
            return here.world.params[e.name]
        case ir.Attribute():
            return _attribute(e, here)
        case ir.At():
            return _entry(e, here)
        case ir.Step():
            return here.world.step
        case ir.Arithmetic():
            return numbers.arithmetic(e.fn, [evaluate(a, here) for a in e.args], e.type.kind == "real")
        case ir.Count():
            return len(members.found(e.domain, here))
        case ir.Sum():
            values = [evaluate(e.value, here.binding(m.names)) for m in members.found(e.domain, here)]
            return numbers.total(values, e.type.kind == "real")
        case ir.SumRow():
            return numbers.total(list(evaluate(e.row, here)), e.type.kind == "real")
        case ir.Case():
            return _case(e, here)
        case ir.Lowest():
            return _lowest(e, here)
        case ir.Mix():
            return numbers.shares(evaluate(e.row, here))
        case ir.Ramp():
            return numbers.ramp(*(evaluate(x, here) for x in (e.value, e.zero_at, e.one_at)))
        case ir.Named() | ir.Narrowed():
            return evaluate(e.value, here)
        case ir.EventTotal():
            return sum(n for (name, word), n in here.totals.items() if name == e.name and e.word in (None, word))
        case _:
            return _holds(e, here)


def _holds(
    e: "ir.Compare | ir.Same | ir.InRange | ir.InWords | ir.InSet | ir.IsEmpty | ir.Chose | ir.Unoccupied | ir.StandsOn"
    " | ir.Not | ir.Logic | ir.MatrixClass",
    here: Instance,
) -> bool:
    """Returns whether a condition holds. `and` and `or` stop at the first side that decides, so that guards protect."""
    match e:
        case ir.Compare():
            return numbers.compare(e.fn, evaluate(e.left, here), evaluate(e.right, here))
        case ir.Same():
            return evaluate(e.left, here) == evaluate(e.right, here)
        case ir.InRange():
            value = evaluate(e.value, here)
            return numbers.compare("<=", evaluate(e.low, here), value) and numbers.compare("<=", value, evaluate(e.high, here))
        case ir.InWords():
            return evaluate(e.value, here) in e.words
        case ir.InSet():
            return evaluate(e.value, here) in agents_in(evaluate(e.container, here))
        case ir.IsEmpty():
            return not agents_in(evaluate(e.container, here))
        case ir.Chose():
            return here.actions[evaluate(e.agent, here)] == e.action
        case ir.Unoccupied():
            return members.agent_on(evaluate(e.cell, here), here) is None
        case ir.StandsOn():
            cell = here.world.position[evaluate(e.agent, here)]
            return cell is not None and here.board.kind_of[cell] in e.kinds
        case ir.Not():
            return not evaluate(e.value, here)
        case ir.Logic():
            return (all if e.fn == "and" else any)(evaluate(a, here) for a in e.args)
        case ir.MatrixClass():
            return _is_of_class(e.name, evaluate(e.table, here))
        case _:
            assert_never(e)


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
