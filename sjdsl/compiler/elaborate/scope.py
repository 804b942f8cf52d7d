"""Scopes: the symbol table of a game, and the variables and facts at one place of the rules."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol, local_symbol
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.problems import Poisoned, Problems
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.ir.entity_types import AGENTS, IndexSet
from sjdsl.compiler.ir.implications import Fact, computed_range, facts, narrow_word
from sjdsl.compiler.ir.range_arithmetic import Range
from sjdsl.compiler.ir.types import describe, is_number

Part = Literal[
    "phase", "start", "blocks", "forbid", "observe", "metrics", "checks", "look", "policy"
]
ALL_ACTIONS = Symbol("action", "", "agent")


@dataclass
class Static:
    """The declarations that every scope sees.

    elaborate_expression: `expressions.expression`, by which all that contains expressions makes
      them typed, through `Scope.expression`: `expressions` imports those modules itself.
    kinds: the fields of each kind. cell_types: the kinds that `cell of NAME` can be, known before
      any field is. action_names: as declared, `vote` where `actions` has `vote(0)`, `vote(1)`, ...
    event_index_sets: by what the entries of an event are told apart, of events with entries.
    number_from_file: whether `num_agents` is the file's, not a caller's.
    references: each name that was resolved, with what it stands for. used: what makes a
      difference to the game. required: numbers that a `require` reads, which doesn't use them.
    broken: what has a mistake in its declaration, where that is reported; uses of it are not.
    required_facts: what the `require`s say. observed_facts, rule_facts: what holds in every state that
      is observed, or that rules read.
    sized: fields whose range is made of sizes.
    never: by phase and define, a list for each use of it: what can't happen in that use.
    """

    sources: dict[str, Source]
    elaborate_expression: "Callable[[ast.Expr, Scope], ir.Expr]"
    sizes: dict[str, ir.Size] = field(default_factory=dict)
    params: dict[str, ir.Param] = field(default_factory=dict)
    kinds: dict[str, dict[str, ir.VarField]] = field(default_factory=dict)
    glyphs: list[tuple[Span, ir.GlyphMeaning]] = field(default_factory=list)
    groups: dict[str, tuple[str, ...]] = field(default_factory=dict)
    cell_types: dict[str, tuple[str, ...]] = field(default_factory=dict)
    fields: dict[str, ir.VarField] = field(default_factory=dict)
    agent_fields: dict[str, ir.VarField] = field(default_factory=dict)
    movers: dict[str, ir.Movers] = field(default_factory=dict)
    mover_types: tuple[str, ...] = ()
    actions: tuple[str, ...] = ()
    action_names: list[str] = field(default_factory=list)
    with_arguments: dict[str, ir.ActionWithArguments] = field(default_factory=dict)
    broken_actions: set[str] = field(default_factory=set)
    shapes: dict[str, ir.Shape] = field(default_factory=dict)
    defines: dict[str, ast.Define] = field(default_factory=dict)
    word_sets: list[tuple[str, ...]] = field(default_factory=list)
    events: dict[str, ast.Event] = field(default_factory=dict)
    event_index_sets: dict[str, IndexSet] = field(default_factory=dict)
    cells: dict[str, int] = field(default_factory=dict)
    num_agents: int = 1
    number_from_file: bool = True
    rows: tuple[str, ...] = ()
    map_rows: int = 0
    map_cols: int = 0
    wraps: bool = False
    has_trials: bool = False
    task_fields: set[str] = field(default_factory=set)
    references: list[tuple[Span, Symbol]] = field(default_factory=list)
    used: set[Symbol] = field(default_factory=set)
    required: set[Symbol] = field(default_factory=set)
    broken: set[Symbol] = field(default_factory=set)
    expansions: int = 0
    required_facts: tuple[Fact, ...] = ()
    observed_facts: tuple[Fact, ...] = ()
    rule_facts: tuple[Fact, ...] = ()
    sized: set[Symbol] = field(default_factory=set)
    never: dict[str, list[list[errors.NeverHappens]]] = field(default_factory=dict)
    phases: tuple[ast.Phase, ...] = ()

    @cached_property
    def can_be_away(self) -> bool:
        """Whether a phase sends agents away for some ticks, or removes them."""
        nodes = (node for phase in self.phases for node in walk(phase))
        return any(
            isinstance(node, ast.Remove) or (isinstance(node, ast.Send) and node.after is not None)
            for node in nodes
        )

    def refer(self, name: ast.Name, declared: Symbol) -> None:
        """Records what a name of the text stands for, such as a word, which may go unused."""
        self.references.append((name.span, declared))

    def use(self, name: ast.Name, declared: Symbol) -> None:
        """Records what a name stands for, and that it is used: else there is a warning (SJ505)."""
        self.refer(name, declared)
        self.used.add(declared)

    def never_in(self, text: str) -> list[errors.NeverHappens]:
        """Returns the list that collects the warnings of one more use of a phase or define."""
        warnings: list[errors.NeverHappens] = []
        self.never.setdefault(text, []).append(warnings)
        return warnings

    @contextmanager
    def requiring(self) -> Iterator[None]:
        """Numbers that are read in here don't count as used."""
        before = set(self.used)
        yield
        numbers = self.params.keys() | self.sizes.keys()
        read = {symbol for symbol in self.used - before if symbol.name in numbers}
        self.required |= read
        self.used -= read

    def kinds_of(self, name: str) -> tuple[str, ...] | None:
        """Returns the kinds that the name of a kind or group stands for, None for other names."""
        return (name,) if name in self.kinds else self.groups.get(name)

    def entity_type_of(self, name: str) -> ir.EntityType | None:
        """Returns what a name of agents, movers, a kind or a group stands for, None for others."""
        if name == "agent":
            return AGENTS
        if name in self.movers:
            return ir.EntityType("mover", (name,))
        kinds = self.kinds_of(name)
        return None if kinds is None else ir.EntityType("cell", kinds)

    def fields_of(self, owner: ir.EntityType) -> dict[str, ir.VarField]:
        """Returns the fields of agents, movers, cells of the first of some kinds, or the world."""
        match owner.what:
            case "agent":
                return self.agent_fields
            case "mover":
                return {field.name: field for field in self.movers[owner.name].fields}
            case "cell":
                return self.kinds[owner.names[0]]
            case "world":
                return self.fields

    def is_word(self, name: str) -> bool:
        return any(name in words for words in self.word_sets)

    def written(self, span: Span) -> str:
        """Returns a part of the text as its author wrote it, in one line."""
        text = self.sources[span.file].text[span.start : span.end]
        return " ".join(text.split())

    def names(self) -> set[str]:
        """Returns every name an expression may start with."""
        tables = (
            self.sizes,
            self.params,
            self.fields,
            self.defines,
            self.kinds,
            self.groups,
            self.movers,
        )
        return {"step", "agent"}.union(*tables, *self.word_sets)


class Scope(Record):
    """Variables and known facts at one place of the text.

    variables: a Member, a Local, or (a phase's or define's parameter) any expression or action
      name; None for one whose declaration has a mistake.
    locals: the variables that the text names in or around this place; others have the name of
      their kind.
    facts: conditions that hold here.
    part: of the game; in `start` no agent stands anywhere.
    defining: the defines that this place is in, outermost first.
    withheld: variables around that can't be used here, with what to write instead.
    returning: an agent that is away until now.
    about_steps: whether this is a check that compares the state with that before the step.
    elsewhere: variables that may have been away in the state that is read.
    never: collects what can't happen in this use of a phase or define; None if there are no other
      uses.
    ranges: those of the reals that `let` and `draw` have named, as they are computed.
    """

    static: Static
    problems: Problems
    variables: "dict[str, ir.Expr | str | None]" = field(default_factory=dict)
    locals: Mapping[str, Symbol] = field(default_factory=dict)
    facts: tuple[Fact, ...] = ()
    part: Part = "phase"
    events_readable: bool = False
    defining: tuple[str, ...] = ()
    withheld: Mapping[str, str] = field(default_factory=dict)
    returning: str = ""
    about_steps: bool = False
    elsewhere: frozenset[str] = frozenset()
    never: list[errors.NeverHappens] | None = None
    ranges: Mapping[str, Range] = field(default_factory=dict)

    def fail(self, diagnostic: Diagnostic) -> Poisoned:
        """Records one diagnostic and returns what to raise: `raise scope.fail(...)`."""
        return self.problems.fail(diagnostic)

    def expected(self, span: Span, wanted: str, actual: str, help_: str = "") -> Poisoned:
        """Reports that something of another type is wanted."""
        return self.fail(errors.WrongType(span, wanted=wanted, actual=actual, help=help_))

    def misused(self, name: ast.Name, actual: str, wanted: str, help_: str = "") -> Poisoned:
        """Reports the name of something else than is wanted."""
        return self.fail(
            errors.WrongSort(name.span, name=name.text, actual=actual, wanted=wanted, help=help_)
        )

    def expression(self, e: ast.Expr) -> ir.Expr:
        """Returns the typed form of any expression."""
        return self.static.elaborate_expression(e, self)

    def narrowed(self, e: ast.Expr) -> ir.Expr:
        """Returns an expression; of a word without the words that the facts here exclude."""
        return narrow_word(self.expression(e), self.facts)

    def expressions(self, trees: Sequence[ast.Expr]) -> list[ir.Expr]:
        """Returns the typed forms; reports the mistakes of all before giving up."""
        built = self.problems.each(trees, self.expression)
        if len(built) < len(trees):
            raise Poisoned
        return built

    def condition(self, e: ast.Expr) -> ir.Expr:
        """Returns a condition; reports anything else."""
        built = self.expression(e)
        if not built.type.is_single("condition"):
            raise wrong_type(self, e, "a condition", built.type)
        return built

    def number(self, e: ast.Expr, units: tuple[ir.Unit, ...], wanted: str) -> ir.Expr:
        """Returns a number of one of the units, or a bare one; reports anything else.

        wanted: what the message asks for.
        """
        built = self.expression(e)
        if not is_number(built.type) or built.type.unit not in (*units, "number"):
            raise wrong_type(self, e, wanted, built.type)
        if units[0] in ("count", "steps", "cells") and built.type.kind != "int":
            raise wrong_type(self, e, wanted, built.type)
        return built

    def any_number(self, e: ast.Expr) -> ir.Expr:
        """Returns a number of any unit; reports anything else."""
        built = self.expression(e)
        if not is_number(built.type):
            raise wrong_type(self, e, "a number", built.type)
        return built

    def not_negative(
        self, e: ast.Expr, units: tuple[ir.Unit, ...], wanted: str, name: str
    ) -> ir.Expr:
        """Returns a number as `number` does; reports one that can be negative.

        name: what that message calls it.
        """
        built = self.number(e, units, wanted)
        if built.type.low < 0:
            raise self.fail(errors.Negative(e.span, name=name))
        return built

    def fixed(self, e: ast.Expr, quantity: str) -> int | float:
        """Returns the value of an expression that is known when compiled: numbers and sizes only.

        quantity: what messages call it.
        """
        built = self.expression(e)
        if isinstance(built, ir.Number):
            return built.value
        for node in ir.walk(built):
            if isinstance(node, ir.ParamRef):
                raise self.fail(errors.ShapeParam(e.span, name=node.name, quantity=quantity))
        raise self.fail(errors.NotFixed(e.span, quantity=quantity))

    def whole(self, e: ast.Expr, quantity: str, name: str, low: int, high: int) -> int:
        """Returns a whole number from `low` to `high` that is known when compiled.

        quantity, name: what messages call it.
        """
        value = self.fixed(e, quantity)
        if value != int(value) or not low <= value <= high:
            raise self.fail(errors.OutOfLimits(e.span, name=name, value=value, low=low, high=high))
        return int(value)

    def but(self, **changes: Any) -> "Scope":
        """Returns this scope with some fields changed, several times as fast as `replace`."""
        return Scope(*(self.__dict__ | changes).values())

    def bind(self, name: str, value: "ir.Expr | str | None") -> "Scope":
        """Returns this scope with one more variable, which has the name of its kind."""
        locals_ = {n: symbol for n, symbol in self.locals.items() if n != name}
        return self.but(variables={**self.variables, name: value}, locals=locals_)

    def bind_member(self, name: str, entity_type: ir.EntityType) -> "Scope":
        """Returns this scope with one more variable of a domain, which has the name of its kind."""
        return self.bind(name, ir.Member(name=name, entity_type=entity_type))

    def bind_named(self, name: ast.Name, value: "ir.Expr | str | None") -> "Scope":
        """Returns this scope with one more variable, which the text names here."""
        return self.but(
            variables={**self.variables, name.text: value},
            locals={**self.locals, name.text: local_symbol(name)},
        )

    def refer(self, name: ast.Name) -> None:
        """Records which variable a name stands for, or which kind, for one with its kind's name."""
        static = self.static
        if name.text in self.locals:
            static.refer(name, self.locals[name.text])
        elif static.kinds_of(name.text) or name.text in static.movers:
            static.refer(name, Symbol("name", name.text))

    def knowing(self, conditions: "Iterable[ir.Expr]") -> "Scope":
        """Returns this scope in which the conditions are known to hold."""
        known = [fact for condition in conditions for fact in facts(condition)]
        return self.but(facts=(*self.facts, *known))

    @property
    def members(self) -> list[ir.Member]:
        """The agents, movers and cells that domains around have bound."""
        return [value for value in self.variables.values() if isinstance(value, ir.Member)]

    @property
    def facts_and_requires(self) -> tuple[Fact, ...]:
        """What holds here, with the game's `require`s."""
        return (*self.facts, *self.static.required_facts)

    def computed_range(self, e: ir.Expr) -> Range:
        """Returns the range of a real as it is computed in float32, from what holds here."""
        return computed_range(e, self.facts, self.static.required_facts, self.ranges)

    def after_unreadable_guard(self) -> "Scope":
        """Returns this scope inside a condition that has a mistake.

        Mistakes that the condition might have ruled out are then not reported.
        """
        return self.but(problems=replace(self.problems, suppressed=errors.GUARDABLE))

    def reporting_all(self) -> "Scope":
        """Returns this scope for a mistake that no condition around it could rule out."""
        return self.but(problems=replace(self.problems, suppressed=()))

    def with_agent(self, part: Part) -> "Scope":
        """Returns a scope of another part of the game, in which `agent` is any one of them."""
        return Scope(self.static, self.problems, part=part).bind_member("agent", AGENTS)


def wrong_type(
    scope: Scope, e: ast.Expr, wanted: str, actual: ir.Type, help: str = "", described: str = ""
) -> Poisoned:
    """Reports that something else is wanted in the place of `e`.

    described: what stands there, if its type doesn't say that well.
    """
    described = described or describe(actual)
    if isinstance(e, ast.Path) and actual.kind == "member":
        bound = scope.variables.get(e.name.text)
        if isinstance(bound, ir.Member):
            described = {
                "agent": "an agent",
                "cell": "a cell",
                "mover": f"a mover `{bound.entity_type.name}`",
            }[bound.entity_type.what]
    return scope.expected(e.span, wanted, described, help)
