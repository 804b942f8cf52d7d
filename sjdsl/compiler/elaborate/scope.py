"""What names mean: the static tables of a game, and the variables and known facts in scope."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.ir.implications import conjuncts, fact_text
from sjdsl.near_names import nearest

START = "`phase start`"  # the place of a scope in which no agent stands anywhere


@dataclass
class Static:
    """The declarations every scope sees."""

    sources: dict[str, Source]
    sizes: dict[str, ir.Size] = field(default_factory=dict)
    params: dict[str, ir.Param] = field(default_factory=dict)
    kinds: dict[str, ir.Kind] = field(default_factory=dict)
    groups: dict[str, tuple[str, ...]] = field(default_factory=dict)
    fields: dict[str, ir.VarField] = field(default_factory=dict)
    agent_fields: dict[str, ir.VarField] = field(default_factory=dict)
    actions: tuple[str, ...] = ()
    shapes: dict[str, ir.Shape] = field(default_factory=dict)
    defines: dict[str, ast.Define] = field(default_factory=dict)
    word_sets: list[tuple[str, ...]] = field(default_factory=list)
    events: dict[str, ast.Event] = field(default_factory=dict)
    cells: dict[str, int] = field(default_factory=dict)
    num_agents: int = 1
    map_rows: int = 0
    map_cols: int = 0
    used: set[str] = field(default_factory=set)
    broken: set[str] = field(default_factory=set)  # declared, but wrong: reported once, where it is declared
    expansions: int = 0
    requires: tuple[ir.Expr, ...] = ()

    def kinds_of(self, name: str) -> tuple[str, ...] | None:
        """Returns the kinds a kind's or group's name stands for."""
        return (name,) if name in self.kinds else self.groups.get(name)

    def is_word(self, name: str) -> bool:
        return any(name in words for words in self.word_sets)

    def names(self) -> set[str]:
        """Returns every name an expression may start with."""
        named = {*self.sizes, *self.params, *self.fields, *self.defines, *self.kinds, *self.groups, "step", "agent"}
        return named | {w for words in self.word_sets for w in words}


@dataclass(frozen=True)
class Scope:
    """Variables and known facts at one place of the text.

    `variables`: a Member, a Local, or (a phase's or define's parameter) any expression or action name; None: poisoned.
    `facts`: canonical texts of conditions that hold here. `place`: what this is, for messages about draws and events.
    `withheld`: variables around that cannot be used here, with what to write instead.
    """

    static: Static
    problems: Problems
    variables: "dict[str, ir.Expr | str | None]" = field(default_factory=dict)
    facts: frozenset[str] = frozenset()
    fact_nodes: tuple[ir.Expr, ...] = ()
    place: str = "a phase"
    events_readable: bool = False
    defining: tuple[str, ...] = ()
    withheld: Mapping[str, str] = field(default_factory=dict)

    def bind(self, name: str, value: "ir.Expr | str | None") -> "Scope":
        """Returns this scope with one more variable."""
        return replace(self, variables={**self.variables, name: value})

    def knowing(self, conditions: "Iterable[ir.Expr]") -> "Scope":
        """Returns this scope in which the conditions are known to hold."""
        parts = tuple(part for condition in conditions for part in conjuncts(condition))
        return replace(self, facts=self.facts | {fact_text(p) for p in parts}, fact_nodes=self.fact_nodes + parts)

    def unsure(self) -> "Scope":
        """Returns this scope where a condition around could not be read: what it may have made sure is not reported as missing."""
        return replace(self, problems=Problems(self.problems.found, errors.GUARDABLE))

    def near(self, name: str) -> str:
        """Returns the known name closest to `name`."""
        return nearest(name, self.static.names() | set(self.variables))
