"""The English of statements: a sentence for each, with the sentences inside it below."""

from dataclasses import dataclass
from typing import assert_never

from sjdsl.compiler import ir
from sjdsl.compiler.ir.fold import fold
from sjdsl.compiler.ir.free_variables import free_variables
from sjdsl.compiler.ir.queries import declared_field, shape_named, written_field
from sjdsl.doc.wording import counted, joined, number
from sjdsl.runtime.actions import HEADINGS
from sjdsl.told.legal import can_turn
from sjdsl.told.lines import Line
from sjdsl.told.naming import Naming, article
from sjdsl.told.phrases import English, conjuncts

TURNED = ("the way it looks", "to its right", "backward", "to its left")


@dataclass(frozen=True)
class Speaker:
    """Puts the statements of a game into sentences."""

    english: English

    @property
    def naming(self) -> Naming:
        return self.english.naming

    def block(self, body: tuple[ir.Stmt, ...]) -> tuple[Line, ...]:
        """Returns the sentences of a block of statements."""
        return tuple(line for statement in body for line in self.lines(statement))

    def lines(self, s: ir.Stmt) -> list[Line]:
        """Returns a statement's sentence; one with several branches has one for each."""
        match s:
            case ir.Let():
                return [self._let(s)]
            case ir.Draw():
                return [self._draw(s)]
            case ir.Each():
                return [Line(f"each {self.english.members(s.domain)}", self.block(s.body))]
            case ir.Pick():
                return self._pick(s)
            case ir.First():
                return [self._first(s)]
            case ir.Match():
                return [self._match(s)]
            case ir.When():
                return self._when(s)
            case ir.Chance():
                return self._chance(s)
            case ir.Set():
                return [self._set(s)]
            case ir.Add():
                return [self._add(s)]
            case ir.Give():
                return [self._give(s)]
            case ir.Tally():
                return [self._tally(s)]
            case ir.Send():
                return [self._send(s)]
            case ir.Shift():
                return [self._shift(s)]
            case ir.Face():
                return [Line(f"{self._text(s.who)} turns to face {self._text(s.heading)}")]
            case ir.Remove():
                return [Line(f"{self._text(s.who)} is taken away until the end")]
            case ir.Move():
                return [self._move(s)]
            case ir.Mark():
                return [Line(f"the cells of {self.english.shape(s.shape, s.anchor)} are marked")]
            case ir.End():
                return [Line(f"the {self._whole} ends after this step")]
            case _:
                assert_never(s)

    @property
    def _whole(self) -> str:
        return "episode" if self.naming.game.trials is None else "trial"

    def _text(self, e: ir.Expr) -> str:
        return fold(e, self.english).text

    def _operand(self, e: ir.Expr) -> str:
        return fold(e, self.english).operand

    def _let(self, s: ir.Let) -> Line:
        if s.value.type.kind == "condition":
            return Line(f"let {s.name} hold if {self._text(s.value)}")
        return Line(f"let {s.name} be {self._text(s.value)}")

    def _draw(self, s: ir.Draw) -> Line:
        return Line(f"let {s.name} be drawn at random: {self.drawn(s)}")

    def drawn(self, s: ir.Draw) -> str:
        """Returns what a `draw` draws from."""
        text = self._one_drawn(s)
        if s.by is None:
            return text
        if s.by.kind == "agent":
            entries = "agent"
        else:
            entries = f"of {joined(s.by.names)}"
        different = ", no two the same" if s.different else ""
        return f"for each {entries}, {text}{different}"

    def _one_drawn(self, s: ir.Draw) -> str:
        if s.low is not None and s.high is not None:
            low = self._operand(s.low)
            high = self._operand(s.high)
            what = "any number between" if s.type.kind == "real" else "a whole number from"
            link = "and" if s.type.kind == "real" else "to"
            return f"{what} {low} {link} {high}, all equally likely"
        values = [*s.words] or [number(one) for one in s.numbers]
        if s.weights:
            weights = map(self._operand, s.weights)
            both = zip(values, weights, strict=True)
            return joined((f"{one} with probability {weight}" for one, weight in both), "or")
        return f"{joined(values, 'or')}, all equally likely"

    def _pick(self, s: ir.Pick) -> list[Line]:
        one = isinstance(s.number, ir.Number) and s.number.value == 1
        if one:
            head = f"for one {self.english.members(s.domain)}, drawn at random"
        else:
            crowd = self.english.members(s.domain, plural=True)
            many = self._operand(s.number)
            drawn = f"{many} different {crowd}, drawn at random"
            head = f"for each of {drawn} (all, if there are fewer)"
        found = [Line(head, self._body(s.body))]
        if s.otherwise:
            found.append(Line("if there is none", self.block(s.otherwise)))
        return found

    def _near(self, d: ir.Domain) -> ir.Near:
        assert isinstance(d.restriction, ir.Near), d
        return d.restriction

    def _first(self, s: ir.First) -> Line:
        near = self._near(s.domain)
        noun = self.english.members(s.domain, restricted=False)
        shape = self.english.shape(near.shape, near.anchor)
        if len(shape_named(self.naming.game, near.shape).lanes) > 1:
            shape = f"each lane of {shape}"
        return Line(f"in {shape}, the first {noun}", self._body(s.body))

    def _match(self, s: ir.Match) -> Line:
        of_left, of_both = _split_by(s.right, s.left.var)
        of_left = [*conjuncts(s.left.where), *of_left]
        left_domain = s.left.model_copy(update={"where": _all_of(of_left)})
        right_domain = s.right.model_copy(update={"where": _all_of(of_both)})
        left = article(self.english.members(left_domain))
        if s.first:
            near = self._near(s.right)
            noun = self.english.members(right_domain, restricted=False)
            shape = self.english.shape(near.shape, near.anchor)
            if len(shape_named(self.naming.game, near.shape).lanes) > 1:
                shape = f"a lane of {shape}"
            right = f", in {shape}, the first {noun}"
        else:
            right = f" {article(self.english.members(right_domain))}"
        head = (
            "pairs are made in random order, with nobody and nothing in more than one. "
            f"A pair is {left} and{right}. For each pair"
        )
        return Line(head, self._body(s.body))

    def _when(self, s: ir.When) -> list[Line]:
        found = []
        for number_, branch in enumerate(s.branches):
            head = f"if {self._text(branch.test)}"
            found.append(self._branch(number_, head, branch))
        return [*found, *self._otherwise(s.otherwise)]

    def _chance(self, s: ir.Chance) -> list[Line]:
        found: list[Line] = []
        for number_, branch in enumerate(s.branches):
            if self.english.constant(branch.test) == "1":
                return [*found, *self._certain(branch.body, is_first=not number_)]
            head = f"with probability {self._operand(branch.test)}"
            found.append(self._branch(number_, head, branch))
        return [*found, *self._otherwise(s.otherwise)]

    def _certain(self, body: tuple[ir.Stmt, ...], is_first: bool) -> list[Line]:
        """Returns what happens for sure, unless a branch before it does."""
        return list(self.block(body)) if is_first else self._otherwise(body)

    def _branch(self, place: int, head: str, branch: ir.Branch) -> Line:
        return Line(f"otherwise, {head}" if place else head, self._body(branch.body))

    def _otherwise(self, body: tuple[ir.Stmt, ...]) -> list[Line]:
        return [Line("otherwise", self.block(body))] if body else []

    def _body(self, body: tuple[ir.Stmt, ...]) -> tuple[Line, ...]:
        return self.block(body) or (Line("nothing happens"),)

    def _set(self, s: ir.Set) -> Line:
        target = self._text(s.target)
        if s.target.type.indexed_by and not s.value.type.indexed_by:
            target = f"every entry of {target}"
        text = f"{target} is set to {self._text(s.value)}"
        if s.target.type.kind == "agents" and isinstance(s.value, ir.Nobody):
            text = f"{target} is emptied"
        if s.lot is not None:
            text += " (if several would change it in this stage, one of them does, by lot)"
        return Line(text)

    def _add(self, s: ir.Add) -> Line:
        target = self._text(s.target)
        value = self._text(s.value)
        if s.target.type.kind == "agents":
            return Line(f"{value} joins {target}")
        if s.value.type.indexed_by:
            return Line(f"each entry of {value} is added to that of {target}{self._limits(s)}")
        if isinstance(s.value, ir.Number) and s.value.value < 0:
            return Line(f"{target} falls by {number(-s.value.value)}{self._limits(s)}")
        taken = _negative_of(s.value)
        if taken is not None:
            return Line(f"{target} falls by {self._text(taken)}{self._limits(s)}")
        return Line(f"{target} rises by {value}{self._limits(s)}")

    def _limits(self, s: ir.Add) -> str:
        field = declared_field(self.naming.game, written_field(s.target))
        if not field.capped:
            return ""
        if isinstance(s.value, ir.Number):
            if s.value.value > 0:
                return f" (to at most {number(field.type.high)})"
            return f" (to at least {number(field.type.low)})"
        return f" (kept within {number(field.type.low)} to {number(field.type.high)})"

    def _give(self, s: ir.Give) -> Line:
        if s.receiver is None:
            but = "" if s.but is None else f" except {self.naming.refer(s.but)}"
            who = f"every agent{but}"
        elif s.receiver.type.kind == "agents":
            who = f"each agent among {self._text(s.receiver)}"
        else:
            who = self._text(s.receiver)
        return Line(f"{who} gets a reward of {self._text(s.value)}")

    def _tally(self, s: ir.Tally) -> Line:
        word = "" if s.word is None else f"[{self._text(s.word)}]"
        whose = ""
        if s.receiver is not None:
            each = "each agent among " if s.receiver.type.kind == "agents" else ""
            whose = f" for {each}{self._text(s.receiver)}"
        times = "" if s.amount is None else f", {self._text(s.amount)} times"
        return Line(f"{s.event}{word} is counted{whose}{times}")

    def _send(self, s: ir.Send) -> Line:
        who = self._text(s.who)
        cell = one_cell(s.domain)
        if cell is None:
            goal = f"a random free {self.english.members(s.domain, is_named=False)}"
        else:
            goal = self._text(cell)
        facing = _facing(s.facing)
        constant = None if s.after is None else self.english.constant(s.after)
        if s.after is None or constant == "0":
            stay = "; it stays where it is if none is free" if s.stay else ""
            return Line(f"{who} goes to {goal}{facing}{stay}")
        wait = f"{self._operand(s.after)} steps"
        if constant is not None:
            wait = counted(float(constant), "step")
        stay = " as soon as one is free" if s.stay else ""
        return Line(f"{who} is away for {wait}, then comes back to {goal}{stay}{facing}")

    def _shift(self, s: ir.Shift) -> Line:
        who = self._text(s.who)
        if s.to is not None:
            goal = f"{self._text(s.to)}{_facing(s.facing)}"
            return Line(f"{who} goes to {goal}, or stays where it is if it cannot go there")
        assert s.steps is not None
        constant = self.english.constant(s.steps)
        far = f"{self._operand(s.steps)} cells"
        if constant is not None:
            far = counted(float(constant), "cell")
        way = self._way(s)
        return Line(
            f"{who} is moved {far} {way}{_facing(s.facing)}, or stays if the way is not free"
        )

    def _way(self, s: ir.Shift) -> str:
        match s:
            case ir.Shift(heading=ir.Attribute(name="heading", owner=owner)) if owner == s.who:
                return TURNED[s.quarters % 4]
            case ir.Shift(heading=ir.Word(value=word)):
                return HEADINGS[(HEADINGS.index(word) + s.quarters) % 4]
            case ir.Shift(heading=None):
                assert s.other is not None
                other = self._text(s.other)
                turned = {0: "toward", 2: "away from"}.get(s.quarters)
                if turned is None:
                    turned = f"turned {s.quarters} quarters to the right of the way toward"
                return f"{turned} {other}, along the longer of the two distances"
            case _:
                assert s.heading is not None
                quarters = f", turned {s.quarters} quarters to the right" if s.quarters else ""
                return f"in the direction {self._text(s.heading)}{quarters}"

    def _move(self, s: ir.Move) -> Line:
        who = self.english.members(s.domain, plural=True)
        if s.course is None:
            does = "turn and step" if can_turn(self.naming.game) else "step"
            return Line(f"all {who} {does} as they chose, at the same time")
        course = self._course(s.course)
        return Line(f"at the same time, each {self.english.members(s.domain)} {course}")

    def _course(self, course: ir.Course) -> str:
        match course:
            case ir.Along():
                return f"steps one cell in the direction {self._text(course.heading)}"
            case ir.Wander():
                return self._wander(course)
            case _:
                assert_never(course)

    def _wander(self, course: ir.Wander) -> str:
        which = "the free cells beside it"
        if course.goal is not None:
            way = "farther from" if course.away else "nearer to"
            goal = self.english.members(course.goal, plural=True)
            which += f" that are {way} the nearest of the {goal}"
        if course.avoided is not None:
            which += f" (never {self.english.members(course.avoided, plural=True)})"
        return f"steps to one of {which}, drawn at random; it stays if there is none"


def one_cell(d: ir.Domain) -> ir.Expr | None:
    """Returns the cell that a destination is, if it is one that a field holds."""
    match d.where:
        case ir.Same(left=ir.Member(name=name), right=right) if name == d.var.name:
            return right if right.type.kind == "cell" else None
        case _:
            return None


def _split_by(d: ir.Domain, member: ir.Member) -> tuple[list[ir.Expr], list[ir.Expr]]:
    """Returns the conditions of a domain that are about another member alone, and the others."""
    alone: list[ir.Expr] = []
    others: list[ir.Expr] = []
    for test in conjuncts(d.where):
        names = {variable.name for variable in free_variables(test)}
        (alone if names == {member.name} else others).append(test)
    return alone, others


def _all_of(tests: list[ir.Expr]) -> ir.Expr | None:
    """Returns a condition that holds if all of these do; None of none."""
    if len(tests) < 2:
        return tests[0] if tests else None
    return ir.Logic(type=tests[0].type, fn="and", args=tuple(tests))


def _negative_of(e: ir.Expr) -> ir.Expr | None:
    """Returns what a value is the negative of, as written; None for any other."""
    match e:
        case ir.Arithmetic(fn="neg", args=(part,)):
            return part
        case ir.Arithmetic(fn="*", args=(ir.Number(value=-1), part)):
            return part
        case _:
            return None


def _facing(facing: str | None) -> str:
    if facing is None:
        return ", looking in a random direction"
    return "" if facing == "same" else f", looking {facing}"
