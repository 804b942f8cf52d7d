"""Makes one function of all uses of a phase: `sprout(red)` and `sprout(blue)` call `sprout`."""

import re
from dataclasses import dataclass, field, fields, replace
from itertools import groupby

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.ir.names import RESERVED, Names, phase_function
from sjdsl.compiler.lower.writer import replaced
from sjdsl.compiler.program import Function
from sjdsl.compiler.program.expressions import (
    Assign,
    Binary,
    Call,
    Expression,
    Literal,
    Name,
    Return,
    Statement,
)


class Turn(Record):
    """A call of a function of a step.

    given: its arguments beside those of every phase. marks: the attribute of State for the cells
    that it returns.
    """

    function: Function
    given: tuple[Expression, ...] = ()
    marks: str = ""


class CannotShare(Exception):
    """Functions differ by more than numbers and tables."""


@dataclass
class SharedBody:
    """The functions of several uses while they become one.

    parameters: of the phase. given: what each use has for them, as written. own: the parameters of
    the function beside those that every phase has, by what they stand for. arguments: what each
    use has for them.
    numbers: the first of these for each parameter of the phase that is a word, with the numbers
    of the uses.
    """

    parameters: tuple[str, ...]
    given: tuple[tuple[str, ...], ...]
    names: Names
    variables: dict[tuple[str, ...], str] = field(default_factory=dict)
    own: dict[tuple[object, ...], Name] = field(default_factory=dict)
    numbers: dict[str, tuple[Name, list[int]]] = field(default_factory=dict)
    arguments: list[tuple[Expression, ...]] = field(default_factory=list)

    def node(self, nodes: tuple[object, ...]) -> object:
        """Returns the nodes of all uses as one, with a parameter where they differ.

        Raises CannotShare.
        """
        first = nodes[0]
        if any(type(node) is not type(first) for node in nodes):
            raise CannotShare
        match first:
            case Assign():
                value = self.node(tuple(node.value for node in nodes))  # type: ignore[attr-defined]
                names_of_uses = (node.names for node in nodes)  # type: ignore[attr-defined]
                targets = [self.variable(names) for names in zip(*names_of_uses, strict=True)]
                return replace(first, names=tuple(targets), value=value)  # type: ignore[arg-type]
            case Name():
                identifiers = tuple(node.identifier for node in nodes)  # type: ignore[attr-defined]
                if identifiers in self.variables:
                    return Name(self.variables[identifiers])
                return (
                    first
                    if len(set(identifiers)) == 1
                    else self.parameter(nodes, identifiers, tuple(map(str.isupper, identifiers)))
                )
            case Literal():
                values = tuple((node.value, node.name) for node in nodes)  # type: ignore[attr-defined]
                names = tuple(name for _, name in values)
                if len(set(values)) == 1:
                    return first
                return self.parameter(
                    nodes, names, tuple(isinstance(value, int | float) for value, _ in values)
                )
            case tuple():
                if len({len(node) for node in nodes}) > 1:  # type: ignore[arg-type]
                    raise CannotShare
                return tuple(self.node(parts) for parts in zip(*nodes, strict=True))
            case Record():
                parts = {
                    f.name: tuple(getattr(node, f.name) for node in nodes)
                    for f in fields(first)
                    if f.name != "origin"
                }
                return replace(first, **{name: self.node(values) for name, values in parts.items()})
            case _ if len(set(nodes)) == 1:
                return first
            case _:
                raise CannotShare

    def parameter(
        self, nodes: tuple[object, ...], names: tuple[str, ...], closed: tuple[bool, ...]
    ) -> Expression:
        """Returns what stands for different numbers or tables: a parameter, or one plus a number."""
        if not all(closed):
            raise CannotShare
        key = tuple((node, name) for node, name in zip(nodes, names, strict=True))
        if key in self.own:
            return self.own[key]
        word = self.parameter_in(names)
        literals = [node.value for node in nodes if isinstance(node, Literal)]
        numbers = [value for value in literals if isinstance(value, int)]
        are_numbers = len(numbers) == len(nodes)
        if are_numbers and word in self.numbers:
            parameter, others = self.numbers[word]
            differences = {one - other for one, other in zip(numbers, others, strict=True)}
            if len(differences) == 1:
                return _plus(parameter, differences.pop())
        is_stream = names[0].startswith("STREAM")
        name = "stream" if is_stream else self.common(names) or "number"
        self.own[key] = Name(self.names.fresh(name))
        self.arguments.append(nodes)  # type: ignore[arg-type]
        if word and are_numbers:
            self.numbers.setdefault(word, (self.own[key], numbers))
        return self.own[key]

    def variable(self, names: tuple[str, ...]) -> str:
        """Returns the name of a variable that the uses may call differently, after their words."""
        if names not in self.variables:
            self.variables[names] = (
                names[0]
                if len(set(names)) == 1
                else self.names.fresh(self.common(names) or names[0])
            )
        return self.variables[names]

    def common(self, names: tuple[str, ...]) -> str:
        """Returns the names of all uses as one: `ground_red`, `ground_blue` are `ground_what`.

        The arguments of the phase are replaced by its parameters; empty if they still differ.
        """
        parameter = self.parameter_in(names)
        return self.renamed(names, parameter)[0] if parameter else ""

    def parameter_in(self, names: tuple[str, ...]) -> str:
        """Returns the parameter of the phase by which names differ; empty if there is none.

        It is `what` for `ground_red` and `ground_blue`.
        """
        if len(set(names)) > 1:
            for parameter in self.parameters:
                if len(set(self.renamed(names, parameter))) == 1:
                    return parameter
        return ""

    def renamed(self, names: tuple[str, ...], parameter: str) -> list[str]:
        """Returns the names of all uses with the arguments replaced by the parameter."""
        number = self.parameters.index(parameter)
        return [
            name.lower().replace(given[number], parameter, 1)
            for name, given in zip(names, self.given, strict=True)
        ]


def _plus(parameter: Name, number: int) -> Expression:
    """Returns a parameter plus a number: an enum value has other numbers in other enums."""
    if number == 0:
        return parameter
    return Binary("-" if number < 0 else "+", parameter, Literal(abs(number)))


def share(uses: list[tuple[ir.Phase, Function]]) -> list[Turn]:
    """Returns the turns of phases.

    Uses of one phase call one function, if they differ by numbers and tables alone.
    """
    found: dict[str, Turn] = {}
    named = sorted(uses, key=lambda use: _declared(use[0]))
    for name, group in groupby(named, key=lambda use: _declared(use[0])):
        found |= _one_function(phase_function(name), list(group))
    return [found[phase.name] for phase, _ in uses]


def _declared(phase: ir.Phase) -> str:
    return re.split(r"\W", phase.label)[0]


def _one_function(name: str, uses: list[tuple[ir.Phase, Function]]) -> dict[str, Turn]:
    """Returns the turn of each use of a phase, by the use's name."""
    alone = {phase.name: Turn(function) for phase, function in uses}
    if len(uses) == 1:
        return alone
    declared = re.match(r"phase\s+\w+\s*\(([^)]*)\)", uses[0][1].doc)
    parameters = tuple(part.strip() for part in declared[1].split(",")) if declared else ()
    given = tuple(tuple(re.sub(r"^\w+\(|\).*$", "", phase.label).split(", ")) for phase, _ in uses)
    if any(len(one) != len(parameters) for one in given):
        parameters = ()
    first = uses[0][1]
    taken = {node.identifier for node in walk(first) if isinstance(node, Name)}
    shared_body = SharedBody(parameters, given, Names(RESERVED | taken))
    marks = [f"mark_{phase.name}" for phase, _ in uses]
    try:
        body = shared_body.node(
            tuple(
                _marks_apart(function.body, mark)
                for (_, function), mark in zip(uses, marks, strict=True)
            )
        )
    except CannotShare:
        return alone
    assert isinstance(body, tuple)
    last = body[-1]
    assert isinstance(last, Return)
    marked = len(last.values) > 2
    returns = "tuple[State, Outcome, Array]" if marked else first.returns
    types = [_type_of(nodes[0]) for nodes in shared_body.arguments]
    own = tuple(
        (parameter.identifier, type_)
        for parameter, type_ in zip(shared_body.own.values(), types, strict=True)
    )
    shared = Function(name, first.parameters + own, returns, first.doc, body)
    given_of = (
        tuple(nodes[number] for nodes in shared_body.arguments) for number in range(len(uses))
    )
    return {
        phase.name: Turn(shared, own, mark if marked else "")
        for (phase, _), own, mark in zip(uses, given_of, marks, strict=True)
    }


def _type_of(argument: Expression) -> str:
    """Returns the type of an argument: a table, or a number."""
    if isinstance(argument, Literal):
        return type(argument.value).__name__
    return "Array"


def _marks_apart(body: tuple[Statement, ...], mark: str) -> tuple[Statement, ...]:
    """Returns the body of a function that returns the cells it marks apart from the state."""
    last = body[-1]
    assert isinstance(last, Return)
    state, out = last.values
    changes = dict(state.keywords) if isinstance(state, Call) else {}
    if mark not in changes:
        return body
    marked = changes.pop(mark)
    return (*body[:-1], replace(last, values=(replaced("state", changes), out, marked)))
