"""Why something happened, as a tree: the conditions and random draws behind a change, the values they read, and where these come from."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from sjdsl.compiler import ir
from sjdsl.compiler.ir.free_variables import free_variables
from sjdsl.compiler.ir.queries import is_quantified
from sjdsl.interpreter.account import Done, Drawn
from sjdsl.interpreter.board import Board
from sjdsl.interpreter.evaluate import applies, evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import Value
from sjdsl.trace.effects import Effect, Used
from sjdsl.trace.episode import Told
from sjdsl.trace.rules import Rules
from sjdsl.trace.wording import say_value

WHOLE = 2**31  # a chance is compared with the upper 31 bits of its word
# Values that a formula is said to be made of; what is inside them isn't.
_VALUES = (ir.Named, ir.ParamRef, ir.At, ir.Count, ir.Sum, ir.Extreme, ir.SumRow, ir.Step)
_CHOICES = {
    "which cell": "its cell was drawn at random",
    "which heading": "its heading was drawn at random",
    "which way": "its way was drawn at random",
}


@dataclass(frozen=True)
class Reason:
    """One link of a chain: `chance growth drew 0.00013 < 0.000625`. because: what is behind it. bits: the random bits, as a rule not shown."""

    text: str
    because: tuple["Reason", ...] = ()
    bits: str = ""


@dataclass(frozen=True)
class Explainer:
    """Explains one turn of the schedule. here: the state that its rules read; around: the node around each node, by identity."""

    here: Instance
    around: Mapping[int, ir.Node]
    rules: Rules
    is_told: bool  # false of a `tick`, whose statements are those of earlier turns

    def effect(self, effect: Effect) -> tuple[Reason, ...]:
        """Returns why a change happened."""
        found = [reason for done in effect.by for reason in self._done(done)]
        return tuple(dict.fromkeys([*found, *map(_used, effect.draws)]))

    def draw(self, drawn: Drawn) -> Reason:
        """Returns a draw, what came of it, and the values that it depended on."""
        statement, here = drawn.statement, self.here.only(drawn.names)
        bits = _bits(drawn.bits, drawn.number, statement.stream)
        match statement:
            case ir.Chance():
                last = len(statement.branches) - 1 if drawn.result is None else drawn.result
                read = [
                    value
                    for branch in statement.branches[: last + 1]
                    for value in _read(branch.test, here)
                ]
                bound = (
                    statement.branches[0].test if last == 0 else None
                )  # the number that is compared with
                return self._reason(
                    _chance(drawn, self.rules.branch(statement, last)), read, here, bits, bound
                )
            case ir.Draw():
                read = [
                    value
                    for e in (statement.low, statement.high, *statement.weights)
                    if e is not None
                    for value in _read(e, here)
                ]
                return self._reason(
                    f"{self.rules.text(statement)}: {say_value(drawn.result, statement.type)}",
                    read,
                    here,
                    bits,
                )
            case ir.Pick():
                return Reason(
                    f"{self.rules.text(statement)}: {'picked' if drawn.result else 'not picked'}",
                    bits=bits,
                )
            case ir.Match():
                return Reason(
                    f"{self.rules.text(statement)}: {'matched' if drawn.result else 'not matched'}",
                    bits=bits,
                )

    def _done(self, done: Done) -> Iterator[Reason]:
        """Yields the conditions and draws around a statement, outermost first, and then the values that it reads itself."""
        draws = {id(drawn.statement): drawn for drawn in done.causes}
        if self.is_told:
            here, conditions = self.here.only(done.names), list[Reason]()
            inner: ir.Node = done.statement
            while (outer := self.around.get(id(inner))) is not None:
                conditions += reversed([*self._around(outer, inner, here, draws)])
                inner = outer
            yield from reversed(conditions)
            own = [
                e
                for name, e in vars(done.statement).items()
                if name != "target" and isinstance(e, ir.Node) and ir.is_expression(e)
            ]
            yield from (self._value(value, here) for e in own for value in _read(e, here))
        yield from (
            self.draw(drawn) for drawn in draws.values()
        )  # a `draw` is before the statement, not around it

    def _around(
        self, outer: ir.Node, inner: ir.Node, here: Instance, draws: dict[int, Drawn]
    ) -> Iterator[Reason]:
        """Yields what the node around a part of a phase says, and takes the draws that it tells out of `draws`."""
        if (drawn := draws.pop(id(outer), None)) is not None:
            yield self.draw(drawn)
        match outer:
            case ir.Branch(test=test) if isinstance(self.around[id(outer)], ir.When):
                yield self._reason(self.rules.expression(test), _read(test, here), here)
            case ir.When() if not isinstance(inner, ir.Branch):
                for branch in outer.branches:
                    yield self._reason(
                        f"not: {self.rules.expression(branch.test)}", _read(branch.test, here), here
                    )
            case ir.Each() | ir.Pick() | ir.First() if (
                outer.domain.where is not None and not isinstance(inner, ir.Domain)
            ):
                read = (
                    list(_read(outer.domain.where, here))
                    if outer.domain.var.name in here.names
                    else []
                )
                if read:
                    yield self._reason(self.rules.expression(outer.domain.where), read, here)

    def _reason(
        self,
        text: str,
        read: Iterator[ir.Expr] | list[ir.Expr],
        here: Instance,
        bits: str = "",
        said: ir.Expr | None = None,
    ) -> Reason:
        """Returns a sentence with the values that it reads, without the one it has said, and behind it where those come from that have a formula."""
        values = list(read)
        told = dict.fromkeys(f"{self._name(e)} = {_said(e, here)}" for e in values if e is not said)
        formulas = dict.fromkeys(
            self._value(e, here)
            for e in values
            if isinstance(e, ir.Named) and not isinstance(e.value, ir.Number)
        )
        return Reason(f"{text}, with {', '.join(told)}" if told else text, tuple(formulas), bits)

    def _value(self, e: ir.Expr, here: Instance) -> Reason:
        """Returns a value: `apple = 1`, or with its formula `growth = best_rate * clean = 0.02, with best_rate = 0.05, clean = 0.4`."""
        if not isinstance(e, ir.Named):
            return Reason(f"{self._name(e)} = {_said(e, here)}")
        return self._reason(
            f"{e.name} = {self.rules.expression(e.value)} = {_said(e, here)}",
            _read(e.value, here),
            here,
            said=e.value,
        )

    def _name(self, e: ir.Expr) -> str:
        return e.name if isinstance(e, ir.Named) else self.rules.expression(e)


def explainer_of(turn: Told, board: Board, rules: Rules) -> Explainer:
    """Returns what explains the effects and draws of one turn."""
    account = turn.account
    around = {id(child): node for node in ir.walk(account.turn) for child in ir.children(node)}
    return Explainer(
        Instance(board, account.before, account.actions),
        around,
        rules,
        isinstance(account.turn, ir.Phase),
    )


def _read(e: ir.Expr, here: Instance) -> Iterator[ir.Expr]:
    """Yields the values that an expression was made of, and not what `and`, `or` and `case` left out."""
    if isinstance(e, _VALUES) or is_quantified(e):
        if all(variable.name in here.names for variable in free_variables(e)):
            yield e
        return
    match e:
        case ir.Logic():
            for arg in e.args:
                yield from _read(arg, here)
                if bool(evaluate(arg, here)) == (e.fn == "or"):
                    return
        case ir.Case():
            yield from _read(e.subject, here)
            subject = evaluate(e.subject, here)
            word = ("yes" if subject else "no") if isinstance(subject, bool) else subject
            for arm in e.arms:
                if applies(arm, word):
                    yield from _read(arm.value, here)
        case _:
            for child in ir.children(e):
                if ir.is_expression(child):
                    yield from _read(child, here)


def _said(e: ir.Expr, here: Instance) -> str:
    value: Value = evaluate(e, here)
    return (
        f"{float(value):.4g}"
        if e.type.kind == "real" and not e.type.by
        else say_value(value, e.type)
    )


def _chance(drawn: Drawn, header: str) -> str:
    """Returns `chance luck drew 0.08873 < 0.25`; of a later branch also the bound that was not met before."""
    numbers = [(drawn.bits >> 1) / WHOLE, *(bound / WHOLE for bound in drawn.bounds)]
    digits = next(
        digits
        for digits in (4, 12)
        if len({f"{n:.{digits}g}" for n in numbers}) == len(set(numbers)) or digits == 12
    )
    share, *bounds = (f"{number:.{digits}g}" for number in numbers)
    if drawn.result is None:
        return f"{header} drew {share} >= {bounds[-1]}: does not happen"
    return f"{header} drew {share} < {bounds[-1]}" + (
        f" and >= {bounds[-2]}" if len(bounds) > 1 else ""
    )


def _used(used: Used) -> Reason:
    return Reason(_CHOICES[used.purpose], bits=_bits(used.bits, used.number, used.stream))


def _bits(word: int, number: int, stream: int) -> str:
    return f"random bits {word:08x}: number {number} of stream {stream:08x}"
