"""A game under test, and its instances in other sizes, which proofs are made for."""

from bisect import bisect
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

from sjdsl.compiler import Build, ast, build_composition, ir
from sjdsl.compiler.compose import compose
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.elaborate import Overrides
from sjdsl.compiler.elaborate.world_map import row_spans
from sjdsl.properties.statements import StatementId, count_statements
from sjdsl.trace.rules import Rules

if TYPE_CHECKING:
    from sjdsl.runtime.env import Environment


class GameFamily:
    """A composed game and its instances. `own`: the one that the file describes.

    Raises CompileError with every problem of the file.
    """

    def __init__(self, source: Source, variants: Sequence[str] = (), overrides: Overrides | None = None):
        self.composition = compose(source, variants)
        made = build_composition(self.composition, overrides)
        self.own, self.warnings = made.game, made.warnings
        self._sizes = (overrides or Overrides()).sizes or {}
        self._built: dict[tuple[tuple[str, Any], ...], ir.Game | None] = {}

    def in_sizes(self, sizes: Mapping[str, Any]) -> ir.Game | None:
        """Returns the game on its own map in other sizes; None where the compiler refuses that."""
        key = tuple(sizes.items())
        if key not in self._built:
            self._built[key] = self._build(self.own.rows, sizes=sizes)
        return self._built[key]

    def _build(self, rows: tuple[str, ...], agents: int | None = None, sizes: Mapping[str, Any] | None = None) -> ir.Game | None:
        try:
            overrides = Overrides({**self._sizes, **(sizes or {})}, agents, rows, row_spans(rows, "map"))
            return build_composition(self.composition, overrides).game
        except CompileError:
            return None

    @cached_property
    def doubled(self) -> ir.Game:
        """The game on its own map twice, one copy below the other: a check that holds only for the number of cells fails here.

        The game itself if the compiler does not take such a map.
        """
        return self._build(self.own.rows * 2) or self.own

    @cached_property
    def sends_later(self) -> bool:
        """Whether a `send … after n` is written, also where n is a size that is 0 now."""
        nodes = (node for phase in self.composition.phases.values() for node in walk(phase))
        return any(isinstance(node, ast.Send) and node.after is not None for node in nodes)

    @cached_property
    def crowded(self) -> ir.Game:
        """The game on its own map with as many agents as the file allows there; perhaps with fewer if a `require` refuses some numbers."""
        number = self.composition.number
        size = self.composition.constants.get(number.name.text) if isinstance(number, ast.Path) and not number.steps else None
        if size is None or not isinstance(size.high, ast.Int):
            return self.own
        more = range(self.own.agents.number + 1, size.high.value + 1)
        accepted = bisect(more, False, key=lambda agents: self._build(self.own.rows, agents) is None)
        return (self._build(self.own.rows, more[accepted - 1]) if accepted else None) or self.own

    @cached_property
    def compiled(self) -> "tuple[Environment, Mapping[str, StatementId]]":
        """The compiled game with an event for each statement, and the statement that each of these events counts, by its name.

        Raises CompileError for what cannot be compiled exactly.
        """
        from sjdsl.library.factory import environment_of

        counted, events = count_statements(self.own)
        return environment_of(Build(counted, self.warnings, self.composition.sources), {}), events

    def text_of(self, node: ir.Node) -> str:
        """Returns how a node is written, on one line and without comments."""
        return Rules(self.composition.sources).text(node)
