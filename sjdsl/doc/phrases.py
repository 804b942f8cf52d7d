"""The English of rules: expressions with a value, conditions, and the agents or cells that a quantifier ranges over; each has the others inside it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeGuard, assert_never

from sjdsl.compiler import ir
from sjdsl.compiler.ir.free_variables import free_variables
from sjdsl.compiler.ir.operations import CALCULATIONS, COMPARISONS, PAYOFF_CLASSES, REDUCTIONS
from sjdsl.doc.vocabulary import Vocabulary
from sjdsl.doc.wording import article, code, codes, joined, number, table_value, variable

ATOMS = (
    ir.Number, ir.Word, ir.Nobody, ir.Nowhere, ir.ParamRef, ir.Member, ir.Local, ir.FieldRead, ir.Attribute, ir.Step, ir.SumRow,
    ir.EventTotal,
)  # fmt: skip


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
            return f"the number of {members(e.domain, v, plural=True)}"
        case ir.Sum():
            return f"the sum of {operand(e.value, v)} over all {members(e.domain, v, plural=True)}"
        case ir.Extreme():
            otherwise = "" if e.otherwise is None else f", or {operand(e.otherwise, v)} if there are none"
            return f"the {REDUCTIONS[e.fn].over} of {operand(e.value, v)} over all {members(e.domain, v, plural=True)}{otherwise}"
        case ir.Truth() | ir.Compare() | ir.Same() | ir.InRange() | ir.InWords() | ir.InSet() | ir.IsEmpty():
            return f"whether {condition(e, v)}"
        case ir.Chose() | ir.ChoseWith() | ir.Unoccupied() | ir.StandsOn() | ir.Not() | ir.Logic() | ir.MatrixClass():
            return f"whether {condition(e, v)}"
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
        return f"{arms['yes']} if {condition(e.subject, v)}; {arms['no']} if not"
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


@dataclass(frozen=True)
class Saying:
    """One condition: `subject` is what it is about, `says` what must hold of it, both without the other no sentence."""

    subject: ir.Expr
    says: str


def condition(e: ir.Expr, v: Vocabulary, holds: bool = True) -> str:
    """Returns a condition as a clause, or with `holds=False` its opposite."""
    saying = say(e, v, holds)
    if saying is not None:
        return f"{operand(saying.subject, v)} {saying.says}"
    match e:
        case ir.Truth():
            return "always" if e.value == holds else "never"
        case ir.Unoccupied():
            return f"{'no' if holds else 'some'} {v.somebody} stands on {value(e.cell, v)}"
        case ir.Not():
            return condition(e.value, v, not holds)
        case ir.Logic():  # parts that are joined themselves stand in brackets
            whole = f" {e.fn} ".join(f"({condition(a, v)})" if is_compound(a, v) else condition(a, v) for a in e.args)
            return whole if holds else f"it is not so that ({whole})"
        case ir.MatrixClass():
            return payoff_class(e) if holds else f"it is not so that {payoff_class(e)}"
        case ir.Local():
            return f"{variable(e.name)} {'holds' if holds else 'does not hold'}"
        case ir.Named() if e.name in v.defined:
            return f"{value(e, v)} {'holds' if holds else 'does not hold'}"
        case ir.Named() | ir.Narrowed():
            return condition(e.value, v, holds)
        case ir.Before():
            return f"{condition(e.value, v, holds)} when the step began"
        case ir.Case():
            arms = case(e, v, lambda arm, v: f"({condition(arm, v)})")
            return f"this {'holds' if holds else 'does not hold'}: {arms}"
        case _:
            return f"{operand(e, v)} {'holds' if holds else 'does not hold'}"


def say(e: ir.Expr, v: Vocabulary, holds: bool = True) -> Saying | None:
    """Returns a condition that is about one thing as that thing and what is said of it; None for any other."""
    is_ = "is" if holds else "is not"
    match e:
        case ir.Compare():
            fn = e.fn if holds else COMPARISONS[e.fn].opposite
            return Saying(e.left, f"{COMPARISONS[fn].english} {side(e.right, v)}")
        case ir.Same():
            return Saying(e.left, f"{is_} {side(e.right, v)}")
        case ir.InRange():
            return Saying(e.value, f"{is_} in the range from {side(e.low, v)} to {side(e.high, v)} (both included)")
        case ir.InWords():
            words = codes(e.words, "or")
            return Saying(
                e.value, f"is {words}" if holds else f"is neither {codes(e.words, 'nor')}" if len(e.words) > 1 else f"is not {words}"
            )
        case ir.InSet():
            return Saying(e.value, f"{is_} among {operand(e.container, v)}")
        case ir.IsEmpty():
            return Saying(e.container, f"{is_} empty")
        case ir.Chose():
            return Saying(e.agent, f"{'chose' if holds else 'did not choose'} {v.action(e.action)}")
        case ir.ChoseWith():
            return Saying(
                e.agent, f"{'chose' if holds else 'did not choose'} {code(e.action)}{f' with {arguments(e.given, v)}' if e.given else ''}"
            )
        case ir.StandsOn():
            return Saying(e.agent, f"{'stands' if holds else 'does not stand'} on {v.a_cell(e.kinds)}")
        case ir.Attribute(name="moved"):
            return Saying(e.owner, "changed its cell in the last move" if holds else "did not change its cell in the last move")
        case ir.Attribute(name="away"):
            return Saying(e.owner, f"{is_} away")
        case ir.Not():
            return say(e.value, v, not holds)
        case _:
            return None


def arguments(given: tuple[ir.Given, ...], v: Vocabulary) -> str:
    """Returns the arguments of an action: `apples` 1 and `pears` 2."""
    said = []
    for g in given:
        is_agent = g.type.kind == "agent" and isinstance(g.value, ir.Number)
        said.append((f"{code(g.name)} " if g.name else "") + ("agent " if is_agent else "") + side(g.value, v))
    return joined(said)


def is_compound(e: ir.Expr, v: Vocabulary) -> bool:
    """Returns whether a condition needs brackets inside a longer one."""
    match e:
        case ir.Logic() | ir.Case() | ir.MatrixClass():
            return True
        case ir.Not(value=ir.Logic()):
            return False
        case ir.Named() if e.name in v.defined:
            return False
        case ir.Not() | ir.Named() | ir.Narrowed():
            return is_compound(e.value, v)
        case _:
            return False


def members(d: ir.Domain, v: Vocabulary, plural: bool = False, restriction: bool = True) -> str:
    """Returns the members of a domain: `soil cell whose fruit is none and that lies in the disc(1) around the soil cell`.

    Args:
      plural: `soil cells that lie ...`.
      restriction: whether to say where they are looked for; `nearest` says it elsewhere.
    """
    where = d.restriction if restriction else None
    if isinstance(where, ir.Among):
        return _among(d, where, v, plural)
    own, under, rest = _clauses(d, v)
    match where:
        case ir.Near():
            verb = "lie" if d.var.sort.what == "cell" else "stand"
            own.append(f"that {verb}{'' if plural else 's'} in {shape_of(where.shape, where.anchor, v)}")
        case ir.InAgents() | ir.InCell():
            among = "among " if where.value.type.kind == "agents" else ""
            own.append(f"that {'are' if plural else 'is'} {among}{value(where.value, v)}")
    if d.on is not None:
        cell = v.named(d.on)
        own.append(" ".join([f"that {'each stand' if plural else 'stands'} on {article(cell)}", *under]))
    if rest:
        own.append(f"for which {joined(rest)}")
    return " ".join([v.named(d.var, plural), joined(own)] if own else [v.named(d.var, plural)])


def _among(d: ir.Domain, restriction: ir.Among, v: Vocabulary, plural: bool) -> str:
    """Returns a choice among named variables; they are listed at once."""
    own, under, rest = _clauses(d, v)
    listed = joined(v.refer(m) for m in restriction.members)
    noun = v.noun(d.var) + ("s" if plural else "")
    called = f"{noun} {variable(d.var.name)}, standing for {listed} in turn"
    on = [] if d.on is None else [" ".join([f"that stands on {v.a_cell(d.on.kinds)} called {variable(d.on.name)}", *under])]
    said = [*own, *on, *([f"for which {joined(rest)}"] if rest else [])]
    return f"{called}, {joined(said)}" if said else called


def _clauses(d: ir.Domain, v: Vocabulary) -> tuple[list[str], list[str], list[str]]:
    """Returns what is said of the member itself, of the cell under it, and everything else, in this order."""
    own, under, rest = [], [], []
    tests = conjuncts(d.where)
    about_cell = [t for t in tests if d.on is not None and relative(t, d.on, v)]
    for test in tests:
        clause = relative(test, d.var, v)
        if clause:
            own.append(clause)
        elif d.on is not None and about_cell == [test]:
            under.append(relative(test, d.on, v))
        else:
            text = condition(test, v)
            rest.append(f"({text})" if is_compound(test, v) else text)
    return own, under, rest


def conjuncts(test: ir.Expr | None) -> list[ir.Expr]:
    """Returns the parts of `a and b and c`."""
    match test:
        case None:
            return []
        case ir.Logic(fn="and"):
            return [part for arg in test.args for part in conjuncts(arg)]
        case _:
            return [test]


def relative(test: ir.Expr, member: ir.Member, v: Vocabulary) -> str:
    """Returns a condition as a clause behind its noun, `whose fruit is ripe`; empty if it is not about this member."""
    match test:
        case ir.Unoccupied(cell=cell) if _is(cell, member):
            return f"on which no {v.somebody} stands"
        case ir.Not(value=ir.Unoccupied(cell=cell)) if _is(cell, member):
            return f"on which some {v.somebody} stands"
    saying = say(test, v)
    if saying is None:
        return ""
    match saying.subject:
        case ir.FieldRead(owner=owner, name=name) | ir.Attribute(owner=owner, name=name) if _is(owner, member):
            shown = code(name) if isinstance(saying.subject, ir.FieldRead) else name
            return f"whose {shown} {saying.says}"
        case ir.Member() if _is(saying.subject, member) and isinstance(_bare(test), ir.Chose | ir.ChoseWith):
            return f"that {saying.says}"
    return ""


def _bare(test: ir.Expr) -> ir.Expr:
    return _bare(test.value) if isinstance(test, ir.Not) else test


def _is(e: ir.Expr | None, member: ir.Member) -> bool:
    return isinstance(e, ir.Member) and e.name == member.name


def shape_of(shape: str, anchor: ir.Member, v: Vocabulary) -> str:
    """Returns `the beam of agent *zapper*`, `the disc(2) around the soil cell`."""
    directed = v.shapes[shape].directed
    return f"the {code(shape)} {'of' if directed else 'around'} {v.refer(anchor)}"


def nearest(d: ir.Domain, v: Vocabulary) -> tuple[str, str]:
    """Returns the members of a `first`, without the restriction, and the restriction alone."""
    assert isinstance(d.restriction, ir.Near)
    return members(d, v, restriction=False), shape_of(d.restriction.shape, d.restriction.anchor, v)
