"""Instances of a game under test: the same rules on other maps and for other numbers of agents."""

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
from sjdsl.compiler.ir.free_variables import variables_around
from sjdsl.compiler.ir.queries import blocks_always, body_sort, glyphs_of, kinds_by_glyph, movers_named, phases_of
from sjdsl.interpreter.board import board_of, declared_world
from sjdsl.interpreter.evaluate import evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import default_params
from sjdsl.library.agent_range import agent_range, number_of_agents
from sjdsl.trace.rules import Rules

if TYPE_CHECKING:
    from sjdsl.runtime.env import Environment

FEW = range(1, 5)  # numbers of agents on small maps
MORE = 4  # agents more than the file has, where it allows them
KEPT = 512  # layouts remembered
Sizes = tuple[tuple[str, Any], ...]  # those that differ from the file's, by name


class GameFamily:
    """A composed game and its instances. `own`: the one that the file describes.

    Raises CompileError with every problem of the file.
    """

    def __init__(self, source: Source, variants: Sequence[str] = (), overrides: Overrides | None = None):
        self.composition = compose(source, variants)
        made = build_composition(self.composition, overrides)
        self.own, self.warnings = made.game, made.warnings
        self._sizes = (overrides or Overrides()).sizes
        self._laid: dict[tuple[tuple[str, ...], int, Sizes], ir.Game | None] = {}

    def on(self, rows: tuple[str, ...], agents: int, sizes: Sizes = ()) -> ir.Game | None:
        """Returns the game on another map with so many agents and some other sizes; None where the compiler refuses that."""
        if (rows, agents, sizes) == (self.own.rows, self.own.agents.number, ()):
            return self.own
        if (rows, agents, sizes) not in self._laid:
            if len(self._laid) >= KEPT:
                self._laid.clear()
            number = None if agents == self.own.agents.number else agents
            overrides = Overrides({**(self._sizes or {}), **dict(sizes)}, number, rows, row_spans(rows, "map"))
            self._laid[rows, agents, sizes] = self._built(overrides)
        return self._laid[rows, agents, sizes]

    def in_sizes(self, sizes: Mapping[str, int]) -> ir.Game | None:
        """Returns the game on its own map in other sizes; None where the compiler refuses that."""
        return self.on(self.own.rows, self.own.agents.number, tuple(sizes.items()))

    def _built(self, overrides: Overrides) -> ir.Game | None:
        try:
            return build_composition(self.composition, overrides).game
        except CompileError:
            return None

    @cached_property
    def doubled(self) -> ir.Game:
        """The game on its own map twice, one copy below the other: a check that holds only for the number of cells fails here.

        The game itself if the compiler does not take such a map.
        """
        return self.on(self.own.rows * 2, self.own.agents.number) or self.own

    @cached_property
    def most_agents(self) -> int:
        """The greatest number of agents, a few more than the file's, that the game takes on its own map."""
        own = self.own.agents.number
        return max((n for n in range(own + 1, own + 1 + MORE) if self.on(self.own.rows, n) is not None), default=own)

    @cached_property
    def free_sizes(self) -> tuple[ir.Size, ...]:
        """The sizes for which the file gives limits in numbers, typed with these, but the one that is the number of agents."""
        of_agents, found = number_of_agents(self.composition), []
        for size in self.own.sizes:
            declared = self.composition.constants[size.name]
            if declared is not of_agents and isinstance(declared.low, ast.Int) and isinstance(declared.high, ast.Int):
                limits = size.type.model_copy(update={"low": declared.low.value, "high": declared.high.value})
                found.append(size.model_copy(update={"type": limits}))
        return tuple(size for size in found if size.name not in (self._sizes or {}))

    @cached_property
    def sends_later(self) -> bool:
        """Whether a `send … after n` is written, also where n is a size that is 0 now."""
        nodes = (node for phase in self.composition.phases.values() for node in walk(phase))
        return any(isinstance(node, ast.Send) and node.after is not None for node in nodes)

    @cached_property
    def crowded(self) -> ir.Game:
        """The game on its own map with as many agents as the file allows there."""
        allowed = agent_range(self.composition, self.own.agents.number)
        return (None if allowed is None else self.on(self.own.rows, allowed[2])) or self.own

    @cached_property
    def few_agents(self) -> tuple[int, ...]:
        """Small numbers of agents that the game takes on its own map; its own number if there is none."""
        found = tuple(n for n in FEW if self.on(self.own.rows, n) is not None)
        return found or (self.own.agents.number,)

    @cached_property
    def reads_places(self) -> bool:
        """Whether a rule or a check reads a row or a column: on another map it would say something else."""
        game = self.own
        rules = (game.start, *game.schedule, game.agents, *game.kinds, *game.movers, *game.checks)
        return any(isinstance(n, ir.Attribute) and n.name in ("row", "col") for rule in rules for n in ir.walk(rule))

    def is_own(self, rows: tuple[str, ...]) -> bool:
        """Returns whether a map is the game's own."""
        return rows == self.own.rows

    @cached_property
    def glyphs(self) -> tuple[str, ...]:
        """The glyphs of the game, those that agents are sent to first."""
        everything = [g.glyph for g in self.own.glyphs]
        wanted = [g for _, group in self.destinations for g in group]
        return tuple(dict.fromkeys([*wanted, *everything]))

    @cached_property
    def open_glyphs(self) -> tuple[str, ...]:
        """The glyphs of cells that agents, or movers of some sort, may always enter."""
        everybody = ("agents", *(sort.name for sort in self.own.movers))
        closed = {kind.name for kind in self.own.kinds if all(blocks_always(kind, who) for who in everybody)}
        kind_of = kinds_by_glyph(self.own)
        return tuple(glyph for glyph in self.glyphs if kind_of[glyph] not in closed)

    @cached_property
    def destinations(self) -> tuple[tuple[ir.Sort, tuple[str, ...]], ...]:
        """Whom a `send` places, its sort, and the glyphs of cells that are free for it at the start."""
        sends = (node for phase in phases_of(self.own) for node in ir.walk(phase) if isinstance(node, ir.Send))
        return tuple(dict.fromkeys((body_sort(send.who), self._free_glyphs(send.domain)) for send in sends))

    def needed(self, sort: ir.Sort, agents: int) -> int:
        """Returns how many cells whoever is placed needs: each mover of a sort, or each agent, one."""
        return movers_named(self.own, sort.name).number if sort.what == "mover" else agents

    def _free_glyphs(self, domain: ir.Domain) -> tuple[str, ...]:
        game = self.own
        here = Instance(board_of(game), declared_world(board_of(game), default_params(game)))
        glyphs = tuple(glyphs_of(game, domain.var.kinds))
        if domain.where is None or variables_around(domain):
            return glyphs
        fitting = []
        for cell, kind in here.board.kind_of.items():
            glyph = game.rows[cell.row][cell.col]
            if kind in domain.var.kinds and glyph not in fitting and evaluate(domain.where, here.only({domain.var.name: cell})):
                fitting.append(glyph)
        return tuple(fitting) or glyphs

    def compiled(self, game: ir.Game) -> "Environment":
        """Returns an instance as a compiled game. Raises CompileError for what cannot be compiled exactly."""
        from sjdsl.library.factory import environment_of

        return environment_of(Build(game, self.warnings, self.composition.sources), {})

    def text_of(self, node: ir.Node) -> str:
        """Returns how a node is written, on one line and without comments."""
        return Rules(self.composition.sources).text(node)
