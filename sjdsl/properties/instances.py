"""A game under test, and its instances in other sizes, which proofs are made for."""

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

from sjdsl.compiler import Build, ast, build_composition, ir
from sjdsl.compiler.compose import compose
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.limits import MAX_AGENTS
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.elaborate import Overrides
from sjdsl.compiler.elaborate.world_map import row_spans
from sjdsl.properties.statements import StatementId, count_statements
from sjdsl.trace.rules import Rules

if TYPE_CHECKING:
    from sjdsl.runtime.env import Environment


class GameFamily:
    """A composed game and its instances. own: the one that the file describes.

    Raises CompileError with every problem of the file.
    """

    def __init__(
        self, source: Source, variants: Sequence[str] = (), overrides: Overrides | None = None
    ):
        self.composition = compose(source, variants)
        build = build_composition(self.composition, overrides)
        self.own = build.game
        self.warnings = build.warnings
        self._sizes = (overrides or Overrides()).sizes or {}
        self._built: dict[tuple[tuple[str, Any], ...], ir.Game | None] = {}

    def in_sizes(self, sizes: Mapping[str, Any]) -> ir.Game | None:
        """Returns the game on its own map in other sizes; None where the compiler refuses that."""
        key = tuple(sizes.items())
        if key not in self._built:
            self._built[key] = self._build(self.own.rows, sizes=sizes)
        return self._built[key]

    def _build(
        self,
        rows: tuple[str, ...],
        agents: int | None = None,
        sizes: Mapping[str, Any] | None = None,
    ) -> ir.Game | None:
        """Returns the game on another map; None where the compiler refuses it."""
        sizes = {**self._sizes, **(sizes or {})}
        try:
            overrides = Overrides(sizes, agents, rows, row_spans(rows, "map"))
            return build_composition(self.composition, overrides).game
        except CompileError:
            return None

    @cached_property
    def doubled(self) -> ir.Game:
        """The game on two copies of its map, one below the other; itself if that is refused.

        A check that holds only for the number of cells fails here.
        """
        return self._build(self.own.rows * 2) or self.own

    @cached_property
    def sends_later(self) -> bool:
        """Whether a `send … after n` is written, also where n is a size that is 0 now."""
        nodes = (node for phase in self.composition.phases.values() for node in walk(phase))
        return any(isinstance(node, ast.Send) and node.after is not None for node in nodes)

    @property
    def number_varies(self) -> bool:
        """Whether the file allows several numbers of agents."""
        assert self.composition.number is not None
        return any(isinstance(node, ast.Name) for node in walk(self.composition.number))

    @property
    def number_is_a_size(self) -> bool:
        """Whether one size is the number of agents."""
        number = self.composition.number
        return (
            isinstance(number, ast.Path)
            and not number.steps
            and number.name.text in self.composition.constants
        )

    def in_all_numbers(self) -> Iterator[ir.Game]:
        """Yields the game on its own map with each number of agents that the file allows there.

        Only as it is, if that number is fixed or computed.
        """
        yield self.own
        if not self.number_is_a_size:
            return
        for agents in range(1, MAX_AGENTS + 1):
            if agents != self.own.agents.number:
                game = self._build(self.own.rows, agents)
                if game is not None:
                    yield game

    @cached_property
    def compiled(self) -> "tuple[Environment, Mapping[str, StatementId]]":
        """The compiled game with events that count its statements: name -> statement.

        Raises CompileError for what cannot be compiled exactly.
        """
        from sjdsl.library.factory import environment_of

        game, events = count_statements(self.own)
        return environment_of(Build(game, self.warnings, self.composition.sources), {}), events

    def text_of(self, node: ir.Node) -> str:
        """Returns how a node is written, on one line and without comments."""
        return Rules(self.composition.sources).text(node)
