"""The symbol table of a rule sheet: what the names of one game stand for while it is put into English."""

from dataclasses import dataclass, field
from functools import cached_property

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import declared_field
from sjdsl.doc.wording import article, code, joined, variable


@dataclass(frozen=True)
class Vocabulary:
    """A game with its names; `defines.vocabulary` makes it.

    defined: the defines that are explained in one place, so that their name is enough elsewhere.
    """

    game: ir.Game
    defined: frozenset[str] = field(default=frozenset())

    @cached_property
    def nodes(self) -> tuple[ir.Node, ...]:
        """All parts of the rules."""
        return tuple(ir.walk(self.game))

    def has(self, *sorts: type[ir.Node]) -> bool:
        """Returns whether the rules have a part of one of these sorts."""
        return any(isinstance(node, sorts) for node in self.nodes)

    @cached_property
    def phases(self) -> dict[str, tuple[ir.Node, ...]]:
        """The parts of each phase of the schedule, by its label."""
        return {phase.label: tuple(ir.walk(phase)) for phase in self.game.schedule if isinstance(phase, ir.Phase)}

    @cached_property
    def waits(self) -> bool:
        """Whether an agent or a mover can be away for a time."""
        return any(isinstance(node, ir.Send) and node.after is not None for node in self.nodes)

    @property
    def somebody(self) -> str:
        """Who occupies cells: `agent`, or `agent or mover`."""
        return "agent or mover" if self.game.movers else "agent"

    @cached_property
    def groups(self) -> dict[tuple[str, ...], str]:
        return {kinds: name for name, kinds in reversed(self.game.groups)}

    @cached_property
    def shapes(self) -> dict[str, ir.Shape]:
        """The shapes of the game, those that only its policies speak of last."""
        return {shape.name: shape for shape in (*self.game.shapes, *self.game.policy_shapes)}

    @cached_property
    def numbers(self) -> dict[str, ir.Param]:
        """The parameters whose default a statement may show."""
        return {param.name: param for param in self.game.params}

    def kinds(self, kinds: tuple[str, ...]) -> str:
        """Returns `soil`; `river` for the kinds of a group; `soil or sand`."""
        return kinds[0] if len(kinds) == 1 else self.groups.get(kinds) or joined(kinds, "or")

    def noun(self, member: ir.Member) -> str:
        """Returns `agent`, `deer` or `soil cell`."""
        return f"{self.kinds(member.kinds)} cell" if member.sort.what == "cell" else member.sort.name

    def is_plain(self, member: ir.Member) -> bool:
        """Returns whether a variable has no name of its own: it is called as what it is."""
        return member.name == (self.kinds(member.kinds) if member.sort.what == "cell" else member.sort.name)

    def named(self, member: ir.Member, plural: bool = False) -> str:
        """Returns a variable where it is introduced: `soil cell`, `agent *zapper*`."""
        noun = self.noun(member) + (" movers" if plural and member.sort.what == "mover" else "s" if plural else "")
        return noun if self.is_plain(member) else f"{noun} {variable(member.name)}"

    def refer(self, member: ir.Member) -> str:
        """Returns a variable where it is used: `the soil cell`, `agent *zapper*`."""
        return f"the {self.noun(member)}" if self.is_plain(member) else self.named(member)

    def a_cell(self, kinds: tuple[str, ...]) -> str:
        return article(f"{self.kinds(kinds)} cell")

    def field(self, read: ir.FieldRead) -> ir.VarField:
        """Returns the declaration of the field that is read or written."""
        return declared_field(self.game, read)

    def action(self, number: int) -> str:
        return code(self.game.agents.actions[number])
