"""The English of conditions: their subject, and what they say about it."""

from dataclasses import dataclass

from sjdsl.compiler import ir
from sjdsl.compiler.ir.operations import COMPARISONS
from sjdsl.doc.expressions import case, operand, payoff_class, side, value
from sjdsl.doc.vocabulary import Vocabulary
from sjdsl.doc.wording import code, codes, joined, variable


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
