"""Why something happened, as a tree of reasons.

Behind a change are conditions and random draws, behind these the values that they read, and behind
a define its formula.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from sjdsl.compiler import ir
from sjdsl.compiler.ir.free_variables import free_variables
from sjdsl.compiler.ir.queries import is_any_or_all
from sjdsl.interpreter.account import Done, Drawn
from sjdsl.interpreter.board import Board
from sjdsl.interpreter.evaluate import applies, evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import Value
from sjdsl.trace.effects import Effect, Used
from sjdsl.trace.episode import Turn
from sjdsl.trace.rules import Rules
from sjdsl.trace.wording import say_value

CERTAIN = 2**31  # a chance is compared with the upper 31 of 32 random bits
# Values that a reason names as a whole, without what they are computed from.
_VALUES = (ir.Named, ir.ParamRef, ir.At, ir.Count, ir.Sum, ir.Extreme, ir.SumRow, ir.Step)
_CHOICES = {
    "which cell": "its cell was drawn at random",
    "which heading": "its heading was drawn at random",
    "which way": "its way was drawn at random",
}


@dataclass(frozen=True)
class Reason:
    """A reason, such as `chance growth drew 0.00013 < 0.000625`.

    because: the reasons behind it; bits: its random bits in words, "" without.
    """

    text: str
    because: tuple["Reason", ...] = ()
    bits: str = ""


@dataclass(frozen=True)
class Explainer:
    """Explains one turn of the schedule.

    instance: the state that its rules read; parents: the node around each node, by identity.
    explains_rules: whether conditions are explained: not at a `tick`, which performs statements of
    earlier turns.
    """

    instance: Instance
    parents: Mapping[int, ir.Node]
    rules: Rules
    explains_rules: bool

    def effect(self, effect: Effect) -> tuple[Reason, ...]:
        """Returns why a change happened."""
        reasons: list[Reason] = []
        for done in effect.by:
            reasons += self._statement_reasons(done)
        reasons += map(_choice_reason, effect.draws)
        return tuple(dict.fromkeys(reasons))

    def draw(self, drawn: Drawn) -> Reason:
        """Returns a draw with its result and the values that it depended on."""
        statement = drawn.statement
        instance = self.instance.only(drawn.names)
        bits = _bits_text(drawn.bits, drawn.number, statement.stream)
        values: list[ir.Expr] = []
        match statement:
            case ir.Chance():
                last = len(statement.branches) - 1 if drawn.result is None else drawn.result
                for branch in statement.branches[: last + 1]:
                    values += _values_read(branch.test, instance)
                text = _chance_text(drawn, self.rules.branch(statement, last))
                bound = statement.branches[0].test if last == 0 else None  # the text has its value
                return self._reason(text, values, instance, bits, left_out=bound)
            case ir.Draw():
                for e in (statement.low, statement.high, *statement.weights):
                    if e is not None:
                        values += _values_read(e, instance)
                result = say_value(drawn.result, statement.type)
            case ir.Pick():
                result = "picked" if drawn.result else "not picked"
            case ir.Match():
                result = "matched" if drawn.result else "not matched"
        text = f"{self.rules.text(statement)}: {result}"
        return self._reason(text, values, instance, bits)

    def _statement_reasons(self, done: Done) -> Iterator[Reason]:
        """Yields the conditions and draws around a statement, outermost first, then its values.

        At last come draws before it, which a `draw` statement makes.
        """
        draws = {id(drawn.statement): drawn for drawn in done.causes}
        if self.explains_rules:
            instance = self.instance.only(done.names)
            conditions: list[Reason] = []
            inner: ir.Node = done.statement
            while (outer := self.parents.get(id(inner))) is not None:
                conditions = [*self._node_reasons(outer, inner, instance, draws), *conditions]
                inner = outer
            yield from conditions
            for name, part in vars(done.statement).items():
                if name != "target" and isinstance(part, ir.Node) and ir.is_expression(part):
                    for value in _values_read(part, instance):
                        yield self._value(value, instance)
        yield from map(self.draw, draws.values())

    def _node_reasons(
        self, outer: ir.Node, inner: ir.Node, instance: Instance, draws: dict[int, Drawn]
    ) -> Iterator[Reason]:
        """Yields the draw and the conditions of the node around a part of a phase.

        The draw is taken out of `draws`.
        """
        drawn = draws.pop(id(outer), None)
        if drawn is not None:
            yield self.draw(drawn)
        match outer:
            case ir.Branch(test=test) if isinstance(self.parents[id(outer)], ir.When):
                yield self._condition(test, instance)
            case ir.When() if not isinstance(inner, ir.Branch):
                for branch in outer.branches:
                    yield self._condition(branch.test, instance, "not: ")
            case ir.Each(domain=domain) | ir.Pick(domain=domain) | ir.First(domain=domain) if (
                domain.where is not None and not isinstance(inner, ir.Domain)
            ):
                is_bound = domain.var.name in instance.names
                if is_bound and next(_values_read(domain.where, instance), None) is not None:
                    yield self._condition(domain.where, instance)

    def _condition(self, e: ir.Expr, instance: Instance, prefix: str = "") -> Reason:
        return self._reason(prefix + self.rules.expression(e), _values_read(e, instance), instance)

    def _reason(
        self,
        text: str,
        values: Iterable[ir.Expr],
        instance: Instance,
        bits: str = "",
        left_out: ir.Expr | None = None,
    ) -> Reason:
        """Returns a reason with the values that it reads, and behind it the formulas of these.

        Args:
          left_out: a value that the text has already.
        """
        assignments: dict[str, None] = {}
        formulas: dict[Reason, None] = {}
        for e in values:
            if e is not left_out:
                assignments[f"{self._name(e)} = {_value_text(e, instance)}"] = None
            if isinstance(e, ir.Named) and not isinstance(e.value, ir.Number):
                formulas[self._value(e, instance)] = None
        if assignments:
            text = f"{text}, with {', '.join(assignments)}"
        return Reason(text, tuple(formulas), bits)

    def _value(self, e: ir.Expr, instance: Instance) -> Reason:
        """Returns a value, such as `apple = 1`; of a define with its formula and its values.

        For example, `growth = best_rate * clean = 0.02, with best_rate = 0.05, clean = 0.4`.
        """
        value = _value_text(e, instance)
        if not isinstance(e, ir.Named):
            return Reason(f"{self._name(e)} = {value}")
        text = f"{e.name} = {self.rules.expression(e.value)} = {value}"
        return self._reason(text, _values_read(e.value, instance), instance, left_out=e.value)

    def _name(self, e: ir.Expr) -> str:
        return e.name if isinstance(e, ir.Named) else self.rules.expression(e)


def explainer_of(turn: Turn, board: Board, rules: Rules) -> Explainer:
    """Returns what explains the effects and draws of one turn."""
    account = turn.account
    parents = {id(child): node for node in ir.walk(account.turn) for child in ir.children(node)}
    instance = Instance(board, account.before, account.actions)
    return Explainer(instance, parents, rules, isinstance(account.turn, ir.Phase))


def _values_read(e: ir.Expr, instance: Instance) -> Iterator[ir.Expr]:
    """Yields the values that an expression reads, without what `and`, `or` and `case` skip."""
    if isinstance(e, _VALUES) or is_any_or_all(e):
        if all(variable.name in instance.names for variable in free_variables(e)):
            yield e
        return
    match e:
        case ir.Logic():
            for arg in e.args:
                yield from _values_read(arg, instance)
                if bool(evaluate(arg, instance)) == (e.fn == "or"):
                    return
        case ir.Case():
            yield from _values_read(e.subject, instance)
            subject = evaluate(e.subject, instance)
            if isinstance(subject, bool):
                subject = "yes" if subject else "no"
            for arm in e.arms:
                if applies(arm, subject):
                    yield from _values_read(arm.value, instance)
        case _:
            for child in ir.children(e):
                if ir.is_expression(child):
                    yield from _values_read(child, instance)


def _value_text(e: ir.Expr, instance: Instance) -> str:
    """Returns the value of an expression in words, reals with 4 digits."""
    value: Value = evaluate(e, instance)
    if e.type.kind == "real" and not e.type.indexed_by:
        return f"{float(value):.4g}"
    return say_value(value, e.type)


def _chance_text(drawn: Drawn, header: str) -> str:
    """Returns `chance luck drew 0.08873 < 0.25`; of a later branch also the bound before it.

    Numbers have 4 digits, or 12 if 4 don't tell them apart.
    """
    numbers = [(drawn.bits >> 1) / CERTAIN, *(bound / CERTAIN for bound in drawn.bounds)]
    digits = 4
    if len({f"{number:.4g}" for number in numbers}) < len(set(numbers)):
        digits = 12
    number, *bounds = (f"{number:.{digits}g}" for number in numbers)
    if drawn.result is None:
        return f"{header} drew {number} >= {bounds[-1]}: does not happen"
    text = f"{header} drew {number} < {bounds[-1]}"
    return f"{text} and >= {bounds[-2]}" if len(bounds) > 1 else text


def _choice_reason(used: Used) -> Reason:
    """Returns that a cell, a heading or a way was drawn, with the random bits."""
    return Reason(_CHOICES[used.purpose], bits=_bits_text(used.bits, used.number, used.stream))


def _bits_text(bits: int, number: int, stream: int) -> str:
    return f"random bits {bits:08x}: number {number} of stream {stream:08x}"
