"""Makes one function of all uses of a phase with parameters.

    schedule sprout(red) -> sprout(blue)

would make two functions that differ by numbers and tables, such as 0 and 1, the places of `red` and
`blue` in an enum, or RED_START and BLUE_START. They become one function `sprout` with a parameter
for each such difference, which a step calls twice.
"""

import re
from dataclasses import dataclass, field, fields, replace
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
    """A call of a function in a step.

    arguments: after those that every phase gets. marks: the attribute of State in which the marked
    cells that the function returns are stored; empty if it returns none.
    """

    function: Function
    arguments: tuple[Expression, ...] = ()
    marks: str = ""


class CannotShare(Exception):
    """Functions differ by more than numbers and tables."""


@dataclass
class SharedBody:
    """The bodies of several uses while they become one.

    parameters: of the phase as the game declares it: `what`.
    texts: of each use, what it is called with: `red`.
    names: those that the shared function has used.
    variables: a local variable's name in each use -> its name in the shared function.
    added: the nodes and names by which the uses differ -> the new parameter that stands for them.
    arguments: of each new parameter, its value in each use.
    numbers: a parameter of the phase -> the first new parameter that is a number because of it, and
      that number in each use.
    """

    parameters: tuple[str, ...]
    texts: tuple[tuple[str, ...], ...]
    names: Names
    variables: dict[tuple[str, ...], str] = field(default_factory=dict)
    added: dict[tuple[object, ...], Name] = field(default_factory=dict)
    arguments: list[tuple[Expression, ...]] = field(default_factory=list)
    numbers: dict[str, tuple[Name, list[int]]] = field(default_factory=dict)

    def node(self, nodes: tuple[Any, ...]) -> Any:
        """Returns one node for the same place in all uses, with a parameter where they differ.

        Raises CannotShare if they differ by more than numbers and tables.
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
        """Returns what stands for a number or table by which the uses differ.

        It is a new parameter, or one that there is already plus a number: the same enum values may
        have other numbers in another enum.

        Args:
          nodes: of each use; names: their constants' names.
          can_differ: whether they are numbers or tables.
        """
        if not can_differ:
            raise CannotShare
        key = tuple(zip(nodes, names, strict=True))
        if key in self.added:
            return self.added[key]
        cause = self.parameter_in(names)
        literals = [node.value for node in nodes if isinstance(node, Literal)]
        numbers = [value for value in literals if isinstance(value, int)]
        are_numbers = len(numbers) == len(nodes)
        if are_numbers and cause in self.numbers:
            parameter, its_numbers = self.numbers[cause]
            differences = {a - b for a, b in zip(numbers, its_numbers, strict=True)}
            if len(differences) == 1:
                return _plus(parameter, differences.pop())
        is_stream = names[0].startswith("STREAM")
        name = "stream" if is_stream else self.common(names) or "number"
        self.added[key] = Name(self.names.fresh(name))
        self.arguments.append(nodes)
        if cause and are_numbers:
            self.numbers.setdefault(cause, (self.added[key], numbers))
        return self.added[key]

    def variable(self, names: tuple[str, ...]) -> str:
        """Returns the shared name of a local variable, which uses may call differently."""
        if names not in self.variables:
            name = names[0]
            if len(set(names)) > 1:
                name = self.names.fresh(self.common(names) or name)
            self.variables[names] = name
        return self.variables[names]

    def common(self, names: tuple[str, ...]) -> str:
        """Returns one name for those of all uses: `ground_what` for `ground_red`, `ground_blue`.

        Empty if they differ by more than what the phase is called with.
        """
        parameter = self.parameter_in(names)
        return self.renamed(names, parameter)[0] if parameter else ""

    def parameter_in(self, names: tuple[str, ...]) -> str:
        """Returns the parameter of the phase that makes names differ; empty if there is none.

        It is `what` for `ground_red` and `ground_blue`.
        """
        if len(set(names)) > 1:
            for parameter in self.parameters:
                if len(set(self.renamed(names, parameter))) == 1:
                    return parameter
        return ""

    def renamed(self, names: tuple[str, ...], parameter: str) -> list[str]:
        """Returns the names in all uses with the argument in them replaced by its parameter."""
        place = self.parameters.index(parameter)
        renamed = []
        for name, texts in zip(names, self.texts, strict=True):
            renamed.append(name.lower().replace(texts[place], parameter, 1))
        return renamed


def _plus(parameter: Name, number: int) -> Expression:
    """Returns `parameter + number`, or `parameter - 1` for -1."""
    if number == 0:
        return parameter
    return parameter - abs(number) if number < 0 else parameter + number


def share(uses: list[tuple[ir.Turn, Function]]) -> list[Turn]:
    """Returns the calls of a step, in order.

    Uses of one declared phase call one function if they differ by numbers and tables alone.

    uses: the turns of the schedule, each with a function of its own.
    """
    uses_of: dict[str, list[tuple[ir.Phase, Function]]] = {}
    for turn, function in uses:
        if isinstance(turn, ir.Phase):
            declared = re.split(r"\W", turn.label)[0]  # of `sprout(red)` and `eat #2`
            uses_of.setdefault(declared, []).append((turn, function))
    calls: dict[str, Turn] = {}
    for declared, uses_of_phase in uses_of.items():
        calls |= _share_phase(phase_function(declared), uses_of_phase)
    turns = []
    for turn, function in uses:
        turns.append(calls[turn.name] if isinstance(turn, ir.Phase) else Turn(function))
    return turns


def _share_phase(name: str, uses: list[tuple[ir.Phase, Function]]) -> dict[str, Turn]:
    """Returns the call of each use of a declared phase, by the use's name.

    `sprout(red)` and `sprout(blue)` call one function, with what differs between them as arguments.
    If they differ in more than numbers and tables, each calls a function of its own.

    name: of the function that they share.
    """
    separate = {phase.name: Turn(function) for phase, function in uses}
    if len(uses) == 1:
        return separate
    first = uses[0][1]
    identifiers = {node.identifier for node in walk(first) if isinstance(node, Name)}
    shared = SharedBody(*_parameters(uses), Names(RESERVED | identifiers))
    bodies = []
    for phase, function in uses:
        bodies.append(_marks_apart(function.body, f"mark_{phase.name}"))
    try:
        body = shared.node(tuple(bodies))
    except CannotShare:
        return separate
    returns_marks = len(body[-1].values) > 2  # after the state and the outcome
    returns = "tuple[State, Outcome, Array]" if returns_marks else first.returns
    parameters = list(first.parameters)
    for parameter, arguments in zip(shared.added.values(), shared.arguments, strict=True):
        parameters.append((parameter.identifier, _type_of(arguments[0])))
    function = Function(name, tuple(parameters), returns, first.doc, body)
    turns = {}
    for number, (phase, _) in enumerate(uses):
        arguments_of_use = tuple(arguments[number] for arguments in shared.arguments)
        marks = f"mark_{phase.name}" if returns_marks else ""
        turns[phase.name] = Turn(function, arguments_of_use, marks)
    return turns


def _parameters(
    uses: list[tuple[ir.Phase, Function]],
) -> tuple[tuple[str, ...], tuple[tuple[str, ...], ...]]:
    """Returns the parameters of a declared phase, and what each use has for them, as texts.

    There are no parameters if a text has a comma inside, so that it can't be split into arguments.
    """
    first_function = uses[0][1]
    parameters = _declared_parameters(first_function.doc)
    if not parameters:
        return (), ((),) * len(uses)
    texts = tuple(_arguments(phase.label) for phase, _ in uses)
    if any(len(texts_of_use) != len(parameters) for texts_of_use in texts):
        parameters = ()
    return parameters, texts


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
    """Returns a body that returns what it would store in the attribute `mark` as a third value."""
    last = body[-1]
    assert isinstance(last, Return)
    state, out = last.values
    changes = dict(state.keywords) if isinstance(state, Call) else {}
    if mark not in changes:
        return body
    marked = changes.pop(mark)
    values = (replaced("state", changes), out, marked)
    return (*body[:-1], replace(last, values=values))
