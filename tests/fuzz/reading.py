"""Where a generated expression stands: the variables around it, what is known of them, and every value it may begin with."""

from dataclasses import dataclass, replace
from functools import cached_property

from sjdsl.compiler import ir
from sjdsl.runtime.actions import HEADINGS
from tests.fuzz.declared import World

Typed = tuple[str, ir.Type]


@dataclass(frozen=True)
class Variable:
    """An agent, or a cell of `kinds`.

    frame: the number of the quantifier that binds it, -1 for none. listed: it runs through all agents, so that it can be marked around.
    sort: of a mover.
    """

    name: str
    kinds: tuple[str, ...] = ()
    frame: int = -1
    listed: bool = False
    sort: str = ""

    @property
    def is_agent(self) -> bool:
        return not self.kinds and not self.sort

    @property
    def turns(self) -> bool:
        """Whether it has a heading: an agent or a mover."""
        return not self.kinds


@dataclass(frozen=True)
class Frame:
    """A quantifier. `single`: at most one instance for each around it; `placed`: its member is reached through a place."""

    single: bool
    placed: bool = False
    match: bool = False


@dataclass(frozen=True)
class Scope:
    """One place of the text.

    sort: phase, start, metric, check, numbers (require), forbid, block, define, destination, observable, limits of nothing else.
    sure: texts of agents that are somebody; filled: rows with something in them. draws: locals that differ by chance.
    """

    world: World
    sort: str = "phase"
    variables: tuple[Variable, ...] = ()
    locals: tuple[Typed, ...] = ()
    frames: tuple[Frame, ...] = ()
    sure: frozenset[str] = frozenset()
    filled: frozenset[str] = frozenset()
    parameters: tuple[Typed, ...] = ()
    bound: frozenset[str] = frozenset()

    def having(self, *variables: Variable) -> "Scope":
        return replace(
            self,
            variables=(*self.variables, *variables),
            bound=self.bound | {v.name for v in variables},
        )

    def agents(self) -> list[Variable]:
        return [v for v in self.variables if v.is_agent]

    def cells(self) -> list[Variable]:
        return [v for v in self.variables if v.kinds]

    def movers(self) -> list[Variable]:
        return [v for v in self.variables if v.sort]

    def uses(self, name: str) -> bool:
        """Returns whether a variable around has this name, be it one that is of no use here."""
        return name in self.bound

    @property
    def by_game(self) -> bool:
        """Whether the state can be read at all."""
        return self.sort != "numbers"

    @property
    def counts(self) -> bool:
        """Whether members can be counted and shapes looked into."""
        return self.sort not in ("numbers", "forbid")

    @cached_property
    def values(self) -> tuple[Typed, ...]:
        """Every field, attribute, number and local that can be named here, rows and tables whole."""
        found: list[Typed] = [*self.locals, *self.parameters]
        w = self.world
        found += [(n.name, n.type) for n in (*w.sizes, *w.params)]
        if not self.by_game:
            return tuple(found)
        found.append(("step", ir.Type(kind="int", unit="steps", low=0)))
        found += [(f.name, f.type) for f in w.fields]
        for v in self.variables:
            found += self._of_cell(v) if v.kinds else self._of_agent(v)
        for text in self.sure:
            found += [(f"{text}.{f.name}", f.type) for f in w.agent_fields]
            found.append((f"{text}.index", _index(w)))
        return tuple(found)

    def _of_agent(self, v: Variable) -> list[Typed]:
        w = self.world
        found = [(f"{v.name}.{f.name}", f.type) for f in w.fields_of(v.sort)]
        found += [
            (f"{v.name}.index", _index(w, v.sort)),
            (f"{v.name}.heading", ir.Type(kind="word", words=HEADINGS)),
        ]
        if self.sort not in ("forbid", "start"):
            found += self._place(v)
        return found

    def _of_cell(self, v: Variable) -> list[Typed]:
        fields = self.world.cell_fields(v.kinds)
        return [(f"{v.name}.{f.name}", f.type) for f in fields] + self._place(v)

    def _place(self, v: Variable) -> list[Typed]:
        rows, cols = len(self.world.rows), len(self.world.rows[0])
        sides = (("row", rows), ("col", cols))
        return [
            (f"{v.name}.{name}", ir.Type(kind="int", unit="cells", low=0, high=most - 1))
            for name, most in sides
        ]

    def single_values(self, kind: str) -> list[Typed]:
        """Returns the values of a kind that are one value, not a row."""
        return [v for v in self.values if v[1].kind == kind and not v[1].indexed_by]

    def rows(self, kind: str) -> list[Typed]:
        return [v for v in self.values if v[1].kind == kind and v[1].indexed_by]

    def nobodies(self) -> list[str]:
        """Returns the fields here that hold an agent or nobody."""
        return [text for text, _ in self.single_values("agent")]


def _index(w: World, sort: str = "") -> ir.Type:
    return ir.Type(kind="int", unit="number", low=0, high=w.number_of(sort) - 1)


__all__ = ["Frame", "Scope", "Typed", "Variable"]
