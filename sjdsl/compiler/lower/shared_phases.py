"""Makes one function of all uses of a phase: `sprout(red)` and `sprout(blue)` call `sprout`."""

import re
from dataclasses import dataclass, field, fields, replace
from itertools import groupby
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.ir.names import RESERVED, Names, phase_function
from sjdsl.compiler.lower.writer import replaced
from sjdsl.compiler.program import Function
from sjdsl.compiler.program.expressions import (
    Assign,
    Call,
    Expression,
    Literal,
    Name,
    Return,
    Statement,
)


class Turn(Record):
    """A call of a function of a step.

    arguments: beside those of every phase. marks: the attribute of State for the cells that the
    function returns.
    """

    function: Function
    arguments: tuple[Expression, ...] = ()
    marks: str = ""


class CannotShare(Exception):
    """Functions differ by more than numbers and tables."""


@dataclass
class SharedBody:
    """The functions of several uses while they become one.

    parameters: of the phase, with texts: what each use has for them.
    variables: the shared name of a variable, by its names in the uses.
    added: the parameters that the function has beside those of every phase, by what they stand
      for; arguments: what the uses have for each of them.
    numbers: for each parameter of the phase that is a word, the first of `added` that stands for
      its number, with the numbers of the uses.
    """

    parameters: tuple[str, ...]
    texts: tuple[tuple[str, ...], ...]
    names: Names
    variables: dict[tuple[str, ...], str] = field(default_factory=dict)
    added: dict[tuple[object, ...], Name] = field(default_factory=dict)
    arguments: list[tuple[Expression, ...]] = field(default_factory=list)
    numbers: dict[str, tuple[Name, list[int]]] = field(default_factory=dict)

    def node(self, nodes: tuple[Any, ...]) -> Any:
        """Returns the nodes of all uses as one, with a parameter where they differ.

        Raises CannotShare.
        """
        first = nodes[0]
        if any(type(node) is not type(first) for node in nodes):
            raise CannotShare
        match first:
            case Assign():
                value = self.node(tuple(node.value for node in nodes))
                names_of_uses = zip(*(node.names for node in nodes), strict=True)
                targets = tuple(self.variable(names) for names in names_of_uses)
                return replace(first, names=targets, value=value)
            case Name():
                identifiers = tuple(node.identifier for node in nodes)
                if identifiers in self.variables:
                    return Name(self.variables[identifiers])
                if len(set(identifiers)) == 1:
                    return first
                return self.parameter(nodes, identifiers, all(map(str.isupper, identifiers)))
            case Literal():
                if len({(node.value, node.name) for node in nodes}) == 1:
                    return first
                are_numbers = all(isinstance(node.value, int | float) for node in nodes)
                return self.parameter(nodes, tuple(node.name for node in nodes), are_numbers)
            case tuple():
                if len({len(node) for node in nodes}) > 1:
                    raise CannotShare
                return tuple(self.node(parts) for parts in zip(*nodes, strict=True))
            case Record():
                changes = {}
                for part in fields(first):
                    if part.name != "origin":
                        parts = tuple(getattr(node, part.name) for node in nodes)
                        changes[part.name] = self.node(parts)
                return replace(first, **changes)
            case _ if len(set(nodes)) == 1:
                return first
            case _:
                raise CannotShare

    def parameter(
        self, nodes: tuple[Any, ...], names: tuple[str, ...], can_differ: bool
    ) -> Expression:
        """Returns what stands for different numbers or tables: a parameter, or one plus a number.

        can_differ: whether the nodes are numbers or tables.
        """
        if not can_differ:
            raise CannotShare
        key = tuple(zip(nodes, names, strict=True))
        if key in self.added:
            return self.added[key]
        word = self.parameter_in(names)
        literals = [node.value for node in nodes if isinstance(node, Literal)]
        numbers = [value for value in literals if isinstance(value, int)]
        are_numbers = len(numbers) == len(nodes)
        if are_numbers and word in self.numbers:
            parameter, others = self.numbers[word]
            differences = {a - b for a, b in zip(numbers, others, strict=True)}
            if len(differences) == 1:
                return _plus(parameter, differences.pop())
        is_stream = names[0].startswith("STREAM")
        name = "stream" if is_stream else self.common(names) or "number"
        self.added[key] = Name(self.names.fresh(name))
        self.arguments.append(nodes)
        if word and are_numbers:
            self.numbers.setdefault(word, (self.added[key], numbers))
        return self.added[key]

    def variable(self, names: tuple[str, ...]) -> str:
        """Returns the name of a variable that the uses may call differently, after their words."""
        if names not in self.variables:
            name = names[0]
            if len(set(names)) > 1:
                name = self.names.fresh(self.common(names) or name)
            self.variables[names] = name
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
        place = self.parameters.index(parameter)
        return [
            name.lower().replace(texts[place], parameter, 1)
            for name, texts in zip(names, self.texts, strict=True)
        ]


def _plus(parameter: Name, number: int) -> Expression:
    """Returns a parameter plus a number: an enum value has other numbers in other enums."""
    if number == 0:
        return parameter
    return parameter - abs(number) if number < 0 else parameter + number


def share(uses: list[tuple[ir.Phase, Function]]) -> list[Turn]:
    """Returns the turns of phases.

    Uses of one phase call one function, if they differ by numbers and tables alone.
    """
    turns: dict[str, Turn] = {}
    by_name = sorted(uses, key=_declared)
    for name, group in groupby(by_name, key=_declared):
        turns |= _one_function(phase_function(name), list(group))
    return [turns[phase.name] for phase, _ in uses]


def _declared(use: tuple[ir.Phase, Function]) -> str:
    """Returns the name that a phase is declared by."""
    phase, _ = use
    return re.split(r"\W", phase.label)[0]  # of `sprout(red)` and `eat #2`


def _one_function(name: str, uses: list[tuple[ir.Phase, Function]]) -> dict[str, Turn]:
    """Returns the turn of each use of a phase, by the use's name."""
    alone = {phase.name: Turn(function) for phase, function in uses}
    if len(uses) == 1:
        return alone
    first = uses[0][1]
    identifiers = {node.identifier for node in walk(first) if isinstance(node, Name)}
    shared = SharedBody(*_parameters(uses), Names(RESERVED | identifiers))
    marks = [f"mark_{phase.name}" for phase, _ in uses]
    functions = [function for _, function in uses]
    bodies = [_marks_apart(f.body, mark) for f, mark in zip(functions, marks, strict=True)]
    try:
        body = shared.node(tuple(bodies))
    except CannotShare:
        return alone
    is_marking = len(body[-1].values) > 2  # it returns its mark, beside the state and the outcome
    returns = "tuple[State, Outcome, Array]" if is_marking else first.returns
    added = [
        (parameter.identifier, _type_of(arguments[0]))
        for parameter, arguments in zip(shared.added.values(), shared.arguments, strict=True)
    ]
    function = Function(name, (*first.parameters, *added), returns, first.doc, body)
    turns = {}
    for number, (phase, _) in enumerate(uses):
        arguments = tuple(of_uses[number] for of_uses in shared.arguments)
        turns[phase.name] = Turn(function, arguments, marks[number] if is_marking else "")
    return turns


def _parameters(
    uses: list[tuple[ir.Phase, Function]],
) -> tuple[tuple[str, ...], tuple[tuple[str, ...], ...]]:
    """Returns the parameters of a phase, and the arguments of each use, as written.

    There are no parameters if the arguments of a use can't be told apart.
    """
    first_function = uses[0][1]
    parameters = _declared_parameters(first_function.doc)
    if not parameters:
        return (), ((),) * len(uses)
    arguments = tuple(_arguments(phase.label) for phase, _ in uses)
    if any(len(of_use) != len(parameters) for of_use in arguments):
        parameters = ()
    return parameters, arguments


def _declared_parameters(text: str) -> tuple[str, ...]:
    """Returns the parameters in the text of a phase: `phase grow(hue, often) { … }`."""
    declaration = re.match(r"phase\s+\w+\s*\(([^)]*)\)", text)
    if declaration is None:
        return ()
    return tuple(part.strip() for part in declaration[1].split(","))


def _arguments(label: str) -> tuple[str, ...]:
    """Returns the arguments in the label of a use: `grow(red, 0.5)`, `grow(red, 0.5) #2`."""
    in_brackets = re.sub(r"^\w+\(|\).*$", "", label)
    return tuple(in_brackets.split(", "))


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
    values = (replaced("state", changes), out, marked)
    return (*body[:-1], replace(last, values=values))
