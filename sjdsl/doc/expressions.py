"""The English of expressions with a value: what is read, counted and computed."""

from collections.abc import Callable
from typing import TypeGuard, assert_never

from sjdsl.compiler import ir
from sjdsl.compiler.ir.free_variables import free_variables
from sjdsl.compiler.ir.operations import CALCULATIONS, PAYOFF_CLASSES, REDUCTIONS
from sjdsl.doc.vocabulary import Vocabulary
from sjdsl.doc.wording import code, codes, number, table_value, variable

ATOMS = (
    ir.Number,
    ir.Word,
    ir.Nobody,
    ir.Nowhere,
    ir.ParamRef,
    ir.Member,
    ir.Local,
    ir.FieldRead,
    ir.Attribute,
    ir.Step,
    ir.SumRow,
    ir.EventTotal,
)


def value(e: ir.Expr, v: Vocabulary) -> str:
    """Returns an expression as a phrase; a parameter that stands alone shows its default value."""
    match e:
        case ir.Number():
            return number(e.value)
        case ir.Word():
            return code(e.value)
        case ir.Nobody():
            return "nobody"
        case ir.Nowhere():
            return "nowhere"
        case ir.ParamRef() if e.type.by or e.name not in v.numbers:
            return code(e.name)
        case ir.ParamRef():
            return f"{code(e.name)} ({table_value(v.numbers[e.name].value, ())})"
        case ir.Member():
            return v.refer(e)
        case ir.Local():
            return variable(e.name)
        case ir.FieldRead():
            return f"the {code(e.name)} of {'the world' if e.owner is None else value(e.owner, v)}"
        case ir.ArgumentOf():
            return f"the {f'{code(e.name)} in the ' if e.name else ''}{code(e.action)} of {value(e.agent, v)}"
        case ir.Attribute():
            return f"the {e.name} of {value(e.owner, v)}"
        case ir.Distance():
            return f"the distance between {value(e.left, v)} and {value(e.right, v)}"
        case ir.At():
            return entry(e, v, _default_entry(e, v))
        case ir.Step():
            return "the number of finished steps"
        case ir.Arithmetic():
            return CALCULATIONS[e.fn].english(*(operand(a, v) for a in e.args))
        case ir.Case():
            return case(e, v)
        case ir.Lowest():
            return _lowest(e, v)
        case ir.Mix():
            return f"the shares of {value(e.row, v)}"
        case ir.SumRow():
            return f"{REDUCTIONS[e.fn].english} of {value(e.row, v)}"
        case ir.ShiftRow():
            where = f"{abs(e.by)} {'place' if abs(e.by) == 1 else 'places'} {'further on' if e.by >= 0 else 'further back'}"
            return f"{value(e.row, v)} with every entry {where}, and {operand(e.filler, v)} where none comes from"
        case ir.Named():
            return _named(e, v)
        case ir.Narrowed():
            return value(e.value, v)
        case ir.Before():
            return f"{value(e.value, v)} when the step began"
        case ir.EventTotal():
            return f"the total of {code(e.name)}" + ("" if e.word is None else f" {code(e.word)}")
        case ir.Count():
            return f"the number of {v.members(e.domain)}"
        case ir.Sum():
            return f"the sum of {operand(e.value, v)} over all {v.members(e.domain)}"
        case ir.Extreme():
            otherwise = "" if e.otherwise is None else f", or {operand(e.otherwise, v)} if there are none"
            return f"the {REDUCTIONS[e.fn].over} of {operand(e.value, v)} over all {v.members(e.domain)}{otherwise}"
        case ir.Truth() | ir.Compare() | ir.Same() | ir.InRange() | ir.InWords() | ir.InSet() | ir.IsEmpty():
            return f"whether {v.condition(e)}"
        case ir.Chose() | ir.ChoseWith() | ir.Unoccupied() | ir.StandsOn() | ir.Not() | ir.Logic() | ir.MatrixClass():
            return f"whether {v.condition(e)}"
        case _:
            assert_never(e)


def _lowest(e: ir.Lowest, v: Vocabulary) -> str:
    which, level = "last" if e.last else "first", e.row.type.by[0]
    if level.sort == "number":
        names, none = f"the numbers {level.names[0]} to {level.names[-1]}", level.names[-e.last]
    else:
        names, none = f"the words {codes(level.names)}", code(level.names[-e.last])
    return f"the {which} of {names} whose entry in {value(e.row, v)} is above 0 ({none} if none is)"


def operand(e: ir.Expr, v: Vocabulary) -> str:
    """Returns an expression as it stands inside a longer one: in brackets unless no misreading is possible."""
    if isinstance(e, ir.ParamRef):
        return code(e.name)
    if isinstance(e, ir.Narrowed):
        return operand(e.value, v)
    if _is_simple_entry(e):
        return entry(e, v)
    if isinstance(e, ATOMS) or (isinstance(e, ir.Named) and e.name in v.defined):
        return value(e, v)
    return f"({value(e, v)})"


def side(e: ir.Expr, v: Vocabulary) -> str:
    """Returns an expression that stands at the end of a clause, so that its default value may follow it."""
    return value(e, v) if isinstance(e, ir.ParamRef) or _is_simple_entry(e) else operand(e, v)


def _is_simple_entry(e: ir.Expr) -> TypeGuard[ir.At]:
    return isinstance(e, ir.At) and e.key.type.kind != "mix" and isinstance(e.row, ATOMS)


def entry(e: ir.At, v: Vocabulary, default: str = "") -> str:
    """Returns one entry of a row or table, or its mean weighted by a row; `default` is its default value if that is known."""
    row = operand(e.row, v)
    if e.key.type.kind == "mix":
        weights = operand(e.key.row, v) if isinstance(e.key, ir.Mix) else operand(e.key, v)
        return f"the mean of {row} weighted by {weights}"
    if isinstance(e.key, ir.Word):
        return f"the {code(e.key.value)} entry of {row}{default}"
    return f"the entry of {row} for {f'({value(e.key, v)})' if isinstance(e.key, ir.At) else operand(e.key, v)}"


def _default_entry(e: ir.At, v: Vocabulary) -> str:
    """Returns the default value of one entry of a parameter, in brackets; empty for all other entries."""
    if isinstance(e.row, ir.ParamRef) and isinstance(e.key, ir.Word) and len(e.row.type.by) == 1 and e.row.name in v.numbers:
        found = v.numbers[e.row.name].value[e.row.type.by[0].place_of(e.key.value)]  # type: ignore[index]
        return f" ({code(found) if isinstance(found, str) else number(found)})"
    return ""


def case(e: ir.Case, v: Vocabulary, say: Callable[[ir.Expr, Vocabulary], str] = side) -> str:
    """Returns the arms of a `case` one after the other; `say` puts what stands in an arm into words."""
    if e.subject.type.kind == "condition":
        arms = {word: say(arm.value, v) for arm in e.arms for word in arm.words}
        return f"{arms['yes']} if {v.condition(e.subject)}; {arms['no']} if not"
    subject, alone = operand(e.subject, v), isinstance(e.subject, ATOMS)
    return "; ".join(f"{say(arm.value, v)} if {subject if alone or not i else 'it'} {_arm(arm)}" for i, arm in enumerate(e.arms))


def _arm(arm: ir.Arm) -> str:
    if arm.words:
        return f"is {codes(arm.words, 'or')}"
    if arm.low == arm.high:
        return "is anything" if arm.low is None else f"is {arm.low}"
    if arm.low is None:
        return f"is {arm.high} or less"
    return f"is {arm.low} or more" if arm.high is None else f"is {arm.low} to {arm.high}"


def _named(e: ir.Named, v: Vocabulary) -> str:
    if e.name not in v.defined:
        counted = isinstance(e.value, ir.Number) and e.name.startswith("count(")
        return f"{value(e.value, v)} ({code(e.name)} of the map)" if counted else value(e.value, v)
    about = [v.refer(free) if isinstance(free, ir.Member) else variable(free.name) for free in free_variables(e.value)]
    return code(e.name) + (f" of {' and '.join(about)}" if about else "")


def payoff_class(e: ir.MatrixClass) -> str:
    """Returns `payoff is a stag hunt (...)`."""
    first = e.table.type.by[0].names[0] if e.table.type.by else ""
    name = code(e.table.name) if isinstance(e.table, ir.ParamRef) else "the table"
    return f"{name} is {PAYOFF_CLASSES[e.name].english}, cooperating being {code(first)}"
