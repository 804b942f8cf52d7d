"""The English of expressions: values as nouns, conditions as clauses, domains as nouns.

`English` is an analysis of the fold of `ir/fold.py`: every expression becomes a `Phrase`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import inf
from typing import Any, ClassVar, assert_never

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.fold import Analysis, Rule, UnknownValue, fold
from sjdsl.compiler.ir.free_variables import free_variables
from sjdsl.compiler.ir.operations import CALCULATIONS, COMPARISONS
from sjdsl.compiler.ir.queries import is_number_of_cells, num_cells, shape_named
from sjdsl.compiler.ir.values import Evaluation
from sjdsl.doc.wording import joined, number
from sjdsl.told.naming import Naming, article

COMPARED = {
    "<": "is less than",
    "<=": "is at most",
    ">": "is more than",
    ">=": "is at least",
    "==": "is",
    "!=": "is not",
}
SIGNS = {"*": "×", "/": "÷", "+": "+", "-": "-"}
# Of functions whose name doesn't say enough; all others are written `name(a, b)`.
CALCULATED: Mapping[str, Callable[..., str]] = {
    "ramp": lambda x, zero, one: (
        f"a number that goes in a straight line from 0 where {x} is {zero} to 1 where it is {one}, "
        "and stays at 0 and 1 beyond"
    ),
    "quotient": lambda a, b: f"{a} ÷ {b} rounded down",
    "%": lambda a, b: f"the remainder of {a} ÷ {b}",
    "round": lambda a: f"{a} rounded to the nearest whole number",
    "abs": lambda a: f"{a} without its sign",
    "neg": lambda a: f"-{a}",
    "min": lambda *parts: f"the smallest of {joined(parts)}",
    "max": lambda *parts: f"the largest of {joined(parts)}",
}
REDUCED = {"sum": "sum", "min": "smallest", "max": "largest"}


@dataclass(frozen=True)
class Phrase:
    """The English of an expression.

    text: a noun, or the clause of a condition. opposite: the clause that it doesn't hold.
    is_simple: whether it needs no brackets inside a longer one; is_formula: beside `is at least`.
    about: what a condition is about, if one thing: then `text` is that thing, then `says`.
    """

    text: str
    opposite: str = ""
    is_simple: bool = False
    is_formula: bool = False
    about: ir.Expr | None = None
    says: str = ""

    @property
    def operand(self) -> str:
        """The phrase as it stands inside a longer one."""
        return self.text if self.is_simple else f"({self.text})"

    @property
    def side(self) -> str:
        """The phrase as it stands at one side of a comparison."""
        return self.text if self.is_formula else self.operand


@dataclass(frozen=True)
class English(Analysis[Phrase]):
    """Folds expressions to English."""

    rules: ClassVar[Mapping[type[ir.Node], Rule]] = {}  # `leaf` knows every expression
    naming: Naming

    def leaf(self, e: ir.Expr) -> Phrase:
        constant = self.constant(e)
        if constant is not None:
            return Phrase(constant, is_simple=True)
        if e.type.kind == "condition":
            return self._condition(e)
        return self._value(e)

    def constant(self, e: ir.Expr) -> str | None:
        """Returns a number or word that the parameters decide; None for all else."""
        if e.type.indexed_by or e.type.kind not in ("int", "real", "word"):
            return None
        if isinstance(e, ir.Named) and e.name.startswith("count("):
            return None
        try:
            value = fold(e, Evaluation(self._parameter))
        except UnknownValue:
            return None
        if isinstance(value, str):
            return value
        return number(value if isinstance(value, int) else shortest(value))

    def _parameter(self, e: ir.Expr) -> Any:
        if isinstance(e, ir.ParamRef):
            return self.naming.values[e.name]
        raise UnknownValue

    # ---- values

    def _value(self, e: ir.Expr) -> Phrase:
        match e:
            case ir.Number():
                return _simple(number(e.value))
            case ir.Word():
                return _simple(e.value)
            case ir.Nobody():
                return _simple("nobody")
            case ir.Nowhere():
                return _simple("nowhere")
            case ir.ParamRef() | ir.Local():
                return _simple(e.name)
            case ir.Member():
                return _simple(self.naming.refer(e))
            case ir.FieldRead():
                return _simple(self._of(e.owner, e.name))
            case ir.Attribute():
                name = "number" if e.name == "index" else e.name
                return _simple(self._of(e.owner, name))
            case ir.ArgumentOf():
                agent = fold(e.agent, self).text
                return _simple(f"the {e.name or 'argument'} of {agent}'s {e.action}")
            case ir.Distance():
                left = fold(e.left, self).text
                right = fold(e.right, self).text
                return _simple(f"the distance from {left} to {right}")
            case ir.Bearing():
                left = fold(e.left, self).text
                right = fold(e.right, self).text
                side = "ahead of" if e.fn == "steps_ahead" else "to the right of"
                return _simple(f"the number of steps that {right} is {side} {left}")
            case ir.At():
                return self._entry(e)
            case ir.Step():
                return _simple("the step number")
            case ir.Arithmetic():
                return self._arithmetic(e)
            case ir.Case():
                return Phrase(self._arms(e, lambda arm: fold(arm, self).operand))
            case ir.Lowest():
                return self._lowest(e)
            case ir.Mix():
                return Phrase(f"the shares of {fold(e.row, self).text}")
            case ir.SumRow():
                row = fold(e.row, self)
                return Phrase(f"the {REDUCED[e.fn]} of all entries of {row.operand}")
            case ir.ShiftRow():
                return self._shifted(e)
            case ir.Named():
                return self._named(e)
            case ir.Narrowed():
                return fold(e.value, self)
            case ir.Count() if is_number_of_cells(e):
                kinds = e.domain.var.kinds
                cells = self.naming.noun(e.domain.var, plural=True)
                return Phrase(f"{num_cells(self.naming.game, kinds)}, the number of {cells}")
            case ir.Count():
                members = self.members(e.domain, plural=True, is_named=False)
                return Phrase(f"the number of {members}")
            case ir.Sum():
                over = self.members(e.domain, plural=True)
                return Phrase(f"the sum of {fold(e.value, self).operand} over all {over}")
            case ir.Extreme():
                return self._extreme(e)
            case (
                ir.Truth()
                | ir.Compare()
                | ir.Same()
                | ir.InRange()
                | ir.InWords()
                | ir.InSet()
                | ir.IsEmpty()
                | ir.Chose()
                | ir.ChoseWith()
                | ir.Unoccupied()
                | ir.StandsOn()
                | ir.StandsAt()
                | ir.Not()
                | ir.Logic()
            ):
                return self._condition(e)
            case ir.Before() | ir.EventTotal() | ir.MatrixClass():
                raise AssertionError(f"only checks have it, which nobody is told: {e!r}")
            case _:
                assert_never(e)

    def _of(self, owner: ir.Expr | None, name: str) -> str:
        """Returns `the zapper's hits`, `the hits of the tree's owner`, or a field of the world."""
        if owner is None:
            return name
        text = fold(owner, self).text
        return f"{text}'s {name}" if isinstance(owner, ir.Member) else f"the {name} of {text}"

    def _entry(self, e: ir.At) -> Phrase:
        row = fold(e.row, self)
        key = fold(e.key, self)
        if e.key.type.kind == "mix":
            weights = e.key.row if isinstance(e.key, ir.Mix) else e.key
            by = fold(weights, self).operand
            return Phrase(f"the mean of {row.operand} weighted by {by}")
        return _simple(f"{row.operand}[{key.text}]")

    def _arithmetic(self, e: ir.Arithmetic) -> Phrase:
        """Returns a calculation: as a formula, `a × b`, or in words; a factor of 1 is left out."""
        parts = [fold(part, self) for part in e.args]
        if e.fn == "*":
            parts = [part for part in parts if part.text != "1"] or parts[:1]
        if len(parts) == 1 and e.fn in SIGNS:
            return parts[0]
        if e.fn in SIGNS:
            text = f" {SIGNS[e.fn]} ".join(part.operand for part in parts)
            return Phrase(text, is_formula=True)
        if e.fn in CALCULATED:
            return Phrase(CALCULATED[e.fn](*(part.operand for part in parts)))
        sign = CALCULATIONS[e.fn].sign
        if sign:
            return Phrase(f" {sign} ".join(part.operand for part in parts))
        return _simple(f"{e.fn}({', '.join(part.text for part in parts)})")

    def _lowest(self, e: ir.Lowest) -> Phrase:
        row = fold(e.row, self).operand
        which = "last" if e.last else "first"
        names = e.row.type.indexed_by[0].names
        otherwise = names[-1] if e.last else names[0]
        text = f"the {which} of {joined(names)} whose entry in {row} is above 0"
        return Phrase(f"{text}, or {otherwise} if none is")

    def _shifted(self, e: ir.ShiftRow) -> Phrase:
        row = fold(e.row, self).text
        filler = fold(e.filler, self).operand
        way = "further on" if e.by >= 0 else "further back"
        return Phrase(
            f"{row} with every entry {abs(e.by)} places {way}, and {filler} where none comes from"
        )

    def _extreme(self, e: ir.Extreme) -> Phrase:
        value = fold(e.value, self).operand
        over = self.members(e.domain, plural=True)
        text = f"the {REDUCED[e.fn]} value of {value} over all {over}"
        if e.otherwise is not None:
            text += f", or {fold(e.otherwise, self).operand} if there are none"
        return Phrase(text)

    def _named(self, e: ir.Named) -> Phrase:
        if e.name.startswith("count(") and isinstance(e.value, ir.Number):
            kinds = e.name.removeprefix("count(").removesuffix(")")
            return Phrase(f"{number(e.value.value)}, the number of {kinds} cells")
        if e.name not in self.naming.terms:
            return fold(e.value, self)
        return _simple(self.term(e))

    def term(self, e: ir.Named) -> str:
        """Returns a define's name with what it is about: `growth`, `near(the bush)`."""
        about = [fold(free, self).text for free in free_variables(e.value)]
        return f"{e.name}({', '.join(about)})" if about else e.name

    def _arms(self, e: ir.Case, say: Callable[[ir.Expr], str]) -> str:
        """Returns the values of a `case`; the one of most arms comes last, as `else`."""
        if e.subject.type.kind == "condition":
            arms = {word: say(arm.value) for arm in e.arms for word in arm.words}
            return f"{arms['yes']} if {fold(e.subject, self).text}, else {arms['no']}"
        by_value: dict[str, list[ir.Arm]] = {}
        for arm in e.arms:
            by_value.setdefault(say(arm.value), []).append(arm)
        last = max(by_value, key=lambda value: sum(map(_width, by_value[value])))
        others = [value for value in by_value if value != last]
        if not others:
            return last
        subject = fold(e.subject, self).operand
        texts = []
        for value in others:
            texts.append(f"{value} if {subject} is {joined(map(_arm, by_value[value]), 'or')}")
            subject = "it"
        return f"{', '.join(texts)}, else {last}"

    # ---- conditions

    def _condition(self, e: ir.Expr) -> Phrase:
        match e:
            case ir.Truth():
                text = "always" if e.value else "never"
                opposite = "never" if e.value else "always"
                return Phrase(text, opposite, is_simple=True)
            case ir.Compare():
                return self._compared(e)
            case ir.Same():
                return self._about(e.left, f"is {fold(e.right, self).operand}", "is", "is not")
            case ir.InRange():
                low = fold(e.low, self).operand
                high = fold(e.high, self).operand
                return self._about(e.value, f"is from {low} to {high}", "is", "is not")
            case ir.InWords():
                thing = fold(e.value, self).operand
                denies = f"is not {e.words[0]}"
                if len(e.words) > 1:
                    denies = f"is neither {joined(e.words, 'nor')}"
                return _clause(thing, f"is {joined(e.words, 'or')}", denies, e.value)
            case ir.InSet():
                container = fold(e.container, self).text
                return self._about(e.value, f"is one of {container}", "is", "is not")
            case ir.IsEmpty():
                return self._about(e.container, "is empty", "is", "is not")
            case ir.Chose():
                action = self.naming.game.agents.actions[e.action]
                return self._about(e.agent, f"chose {action}", "chose", "did not choose")
            case ir.ChoseWith():
                given = f" with {self.arguments(e.given)}" if e.given else ""
                return self._about(e.agent, f"chose {e.action}{given}", "chose", "did not choose")
            case ir.StandsOn():
                on = article(self.naming.kinds(e.kinds))
                return self._about(e.agent, f"stands on {on}", "stands", "does not stand")
            case ir.StandsAt():
                on = self.naming.refer(e.cell)
                return self._about(e.agent, f"stands on {on}", "stands", "does not stand")
            case ir.Attribute(name="away"):
                return self._about(e.owner, "is away", "is", "is not")
            case ir.Attribute():
                said = "has just changed its cell"
                return self._about(e.owner, said, "has just", "has not just")
            case ir.Unoccupied():
                cell = fold(e.cell, self).text
                on = f"{self.naming.somebody} stands on {cell}"
                return Phrase(f"no {on}", f"some {on}", is_simple=True)
            case ir.Not():
                return self._negated(e)
            case ir.Logic():
                return self._joined(e)
            case ir.Case():
                arms = self._arms(e, lambda arm: fold(arm, self).operand)
                return Phrase(f"this holds: {arms}", f"this does not hold: {arms}")
            case ir.Named() if e.name not in self.naming.terms:
                return fold(e.value, self)
            case ir.Narrowed():
                return fold(e.value, self)
            case _:
                text = self._value(e).text
                return Phrase(f"{text} holds", f"{text} does not hold", is_simple=True)

    def _about(self, subject: ir.Expr, says: str, verb: str, negated: str) -> Phrase:
        """Returns a clause about one thing; its opposite has another verb."""
        thing = fold(subject, self).operand
        denies = says.replace(verb, negated, 1)
        return _clause(thing, says, denies, subject)

    def _compared(self, e: ir.Compare) -> Phrase:
        zero = isinstance(e.right, ir.Number) and e.right.value == 0
        if isinstance(e.left, ir.Count) and zero and e.fn in (">", "==", "!="):
            members = self.members(e.left.domain, is_named=False)
            some = f"there is {article(members)}"
            none = f"there is no {members}"
            found = Phrase(some, none, is_simple=True)
            return Phrase(none, some, is_simple=True) if e.fn == "==" else found
        right = fold(e.right, self).side
        says = f"{COMPARED[e.fn]} {right}"
        denies = f"{COMPARED[COMPARISONS[e.fn].opposite]} {right}"
        return _clause(fold(e.left, self).side, says, denies, e.left)

    def _negated(self, e: ir.Not) -> Phrase:
        inner = fold(e.value, self)
        about = inner.about
        says = ""
        if about is not None:
            says = inner.opposite.removeprefix(f"{fold(about, self).side} ")
        return Phrase(inner.opposite, inner.text, is_simple=inner.is_simple, about=about, says=says)

    def _joined(self, e: ir.Logic) -> Phrase:
        parts = [fold(part, self) for part in self._parts(e, e.fn)]
        text = f" {e.fn} ".join(part.operand for part in parts)
        other = "or" if e.fn == "and" else "and"
        opposites = (part.opposite if part.is_simple else f"({part.opposite})" for part in parts)
        return Phrase(text, f" {other} ".join(opposites))

    def _parts(self, e: ir.Expr, fn: str) -> list[ir.Expr]:
        """Returns what is joined by `and`, or by `or`, also inside parts joined by the same."""
        if isinstance(e, ir.Named) and e.name not in self.naming.terms:
            return self._parts(e.value, fn)
        if isinstance(e, ir.Logic) and e.fn == fn:
            return [part for arg in e.args for part in self._parts(arg, fn)]
        return [e]

    def text(self, e: ir.Expr) -> str:
        """Returns the noun of a value, or the clause of a condition."""
        return fold(e, self).text

    def arguments(self, given: tuple[ir.Given, ...]) -> str:
        """Returns the arguments of an action: `apples 1 and pears 2`."""
        texts = []
        for one in given:
            is_agent = one.type.kind == "agent" and isinstance(one.value, ir.Number)
            name = f"{one.name} " if one.name else ""
            kind = "agent " if is_agent else ""
            texts.append(f"{name}{kind}{fold(one.value, self).operand}")
        return joined(texts)

    # ---- domains

    def members(
        self, d: ir.Domain, plural: bool = False, restricted: bool = True, is_named: bool = True
    ) -> str:
        """Returns the members of a domain: `agents (each victim) in the zapper's beam`.

        restricted: whether to say where they are looked for.
        is_named: whether what follows speaks of a member by its name.
        """
        own, under, rest = self._clauses(d, plural)
        clauses = [joined(own)] if own else []
        places = []
        if d.restriction is not None and restricted:
            places.append(self._restricted(d.restriction))
        if d.on is not None:
            says = f" {joined(under)}" if under else ""
            cell = self._introduced(d.on, False, is_named, [*own, *rest])
            places.append(f"on {article(cell)}{says}")
        if own and places:
            clauses[-1] += ","
        clauses += places
        if rest:
            clauses.append(f"{'and ' if clauses else ''}for which {joined(rest)}")
        return " ".join([self._introduced(d.var, plural, is_named, clauses), *clauses])

    def _introduced(
        self, member: ir.Member, plural: bool, is_named: bool, clauses: list[str]
    ) -> str:
        """Returns a variable with its name, if that is used."""
        name = self.naming.refer(member)
        if is_named or any(name in clause for clause in clauses):
            return self.naming.introduced(member, plural)
        return self.naming.noun(member, plural)

    def _restricted(self, restriction: ir.Restriction) -> str:
        match restriction:
            case ir.Near():
                return f"in {self.shape(restriction.shape, restriction.anchor)}"
            case ir.InAgents():
                among = "among" if restriction.value.type.kind == "agents" else "that is"
                return f"{among} {fold(restriction.value, self).text}"
            case ir.InCell():
                return f"that is {fold(restriction.value, self).text}"
            case ir.Among():
                listed = joined(map(self.naming.refer, restriction.members), "or")
                return f"that is {listed}"
            case _:
                assert_never(restriction)

    def shape(self, shape: str, anchor: ir.Member) -> str:
        """Returns `the zapper's beam`, ``the shape `disc(2)` around the soil``."""
        who = self.naming.refer(anchor)
        if not shape_named(self.naming.game, shape).directed:
            return f"the shape `{shape}` around {who}"
        if self.naming.is_ambiguous(shape):
            return f"{who}'s shape `{shape}`"
        return f"{who}'s {shape}"

    def _clauses(self, d: ir.Domain, plural: bool) -> tuple[list[str], list[str], list[str]]:
        """Returns what is said of the member, of the cell under it, and everything else."""
        own: list[str] = []
        under: list[str] = []
        rest: list[str] = []
        for test in conjuncts(d.where):
            clause = self._relative(test, d.var, plural)
            below = "" if d.on is None else self._relative(test, d.on)
            if clause:
                own.append(clause)
            elif below:
                under.append(below)
            else:
                rest.append(fold(test, self).operand)
        return own, under, rest

    def _relative(self, test: ir.Expr, member: ir.Member, plural: bool = False) -> str:
        """Returns a condition as a clause behind its noun; empty if it is about another."""
        it = "them" if plural else "it"
        match test:
            case ir.Unoccupied(cell=cell) if _is(cell, member):
                return f"with nobody on {it}"
            case ir.Not(value=ir.Unoccupied(cell=cell)) if _is(cell, member):
                return f"with somebody on {it}"
        phrase = fold(test, self)
        about = phrase.about
        match about:
            case ir.FieldRead(owner=owner, name=name) if _is(owner, member):
                return f"whose {name} {phrase.says}"
            case ir.Attribute(owner=owner, name=name) if _is(owner, member):
                if name in ("moved", "away"):
                    return f"that {phrase.says}"
                return f"whose {'number' if name == 'index' else name} {phrase.says}"
            case ir.Member() if _is(about, member):
                return f"that {phrase.says}"
        return ""


def conjuncts(test: ir.Expr | None) -> list[ir.Expr]:
    """Returns the parts of `a and b and c`."""
    match test:
        case None:
            return []
        case ir.Logic(fn="and"):
            return [part for arg in test.args for part in conjuncts(arg)]
        case _:
            return [test]


def _simple(text: str) -> Phrase:
    return Phrase(text, is_simple=True)


def _clause(thing: str, says: str, denies: str, about: ir.Expr) -> Phrase:
    return Phrase(f"{thing} {says}", f"{thing} {denies}", is_simple=True, about=about, says=says)


def _is(e: ir.Expr | None, member: ir.Member) -> bool:
    return isinstance(e, ir.Member) and e.name == member.name


def _arm(arm: ir.Arm) -> str:
    """Returns for which numbers or words an arm of a `case` is."""
    if arm.words:
        return joined(arm.words, "or")
    if arm.low == arm.high:
        return "anything" if arm.low is None else str(arm.low)
    if arm.low is None:
        return f"{arm.high} or less"
    return f"{arm.low} or more" if arm.high is None else f"{arm.low} to {arm.high}"


def _width(arm: ir.Arm) -> float:
    """Returns how many words or numbers an arm of a `case` is for."""
    if arm.words:
        return len(arm.words)
    if arm.low is None or arm.high is None:
        return inf
    return arm.high - arm.low + 1


def shortest(value: float) -> float:
    """Returns the decimal with the fewest digits that is the same number in float32."""
    return float(str(np.float32(value)))
