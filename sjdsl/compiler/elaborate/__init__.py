"""Elaboration: resolves names and checks types, from a composed game to the typed IR.

Composition -> ir.Game, with every mistake of the game reported at once
"""

from collections.abc import Mapping
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.agents import build_agents
from sjdsl.compiler.elaborate.declarations import build_kinds, declare_numbers, declare_world
from sjdsl.compiler.elaborate.looks import looks
from sjdsl.compiler.elaborate.metrics_and_checks import (
    check_requires,
    checks,
    events,
    measures,
    requires,
)
from sjdsl.compiler.elaborate.observations import hidden, observables, window
from sjdsl.compiler.elaborate.policies import policies, scenarios
from sjdsl.compiler.elaborate.possible import know_steps, report_never
from sjdsl.compiler.elaborate.schedule import schedule, start
from sjdsl.compiler.elaborate.scope import Scope, Static
from sjdsl.compiler.elaborate.world_map import check_rows, count_cells, glyph_table, read_rows
from sjdsl.compiler.ir.implications import facts


class Overrides(Record):
    """What a caller changes that is fixed when compiled: sizes by name, the number of agents, the map's rows and where they stand.

    placed_by_hand: a test puts agents and movers on the map, which needs no cells to send them to.
    """

    sizes: Mapping[str, Any] | None = None
    num_agents: int | None = None
    rows: tuple[str, ...] | None = None
    row_spans: tuple[Span, ...] = ()
    placed_by_hand: bool = False


def elaborate(
    game: Composition, overrides: Overrides, problems: Problems
) -> tuple[ir.Game | None, Static]:
    """Returns the typed game, None if a part of it is missing, and its declarations; `problems` gets all that is wrong."""
    static = declare_numbers(game, problems, overrides.sizes or {}, overrides.num_agents)
    if any(isinstance(problem, errors.WordClash) for problem in problems.found):
        return None, static  # what the name means decides what else is wrong
    static.phases = tuple(game.phases.values())
    declare_world(game, static, problems)
    rows = _read_map(game, static, overrides, problems)
    scope = Scope(static, problems)
    episode = None
    with problems.survive():
        episode = _episode(game, scope)
        know_steps(episode, static)
    kinds = build_kinds(game, static, problems)
    checks_scope = Scope(static, problems, part="checks", events_readable=True)
    static.requires = requires(game, checks_scope)
    static.required_facts = tuple(fact for required in static.requires for fact in facts(required))
    check_requires(game, checks_scope)
    agents = build_agents(game, static, problems)
    begin = start(game, scope)
    turns = schedule(game, scope)
    view = window(game, scope)
    rules = (*turns, *kinds, *([] if agents is None else [agents]))
    seen = observables(game, rules, scope)
    unseen = hidden(game, scope)
    measured = measures(game, Scope(static, problems, part="metrics"))
    checked = checks(game, checks_scope)
    drawn = looks(game, static, problems)
    counted: tuple[ir.Event, ...] = ()
    with problems.survive():
        counted = events([p for p in (begin, *turns) if p is not None], scope)
    of_rules, known = set(static.used), set(static.shapes)
    played = policies(game, scope.with_agent("policy"))
    of_policies = {
        name
        for name in static.shapes
        if name not in known or Symbol("shape", name) in static.used - of_rules
    }
    lineups = scenarios(game, scope)
    report_never(static.never.values(), problems)
    if agents is None or begin is None or episode is None or game.schedule is None:
        return None, static
    typed = ir.Game(
        name=game.name,
        title=game.title,
        cites=tuple(game.cites),
        about=tuple(game.about.items()),
        variants=tuple(game.variants),
        chosen=game.chosen,
        sizes=tuple(static.sizes.values()),
        params=tuple(static.params.values()),
        episode=episode,
        kinds=kinds,
        rows=rows,
        edges="joined" if static.wraps else "",
        glyphs=tuple(glyph for _, glyph in static.glyphs),
        fields=tuple(static.fields.values()),
        agents=agents,
        movers=tuple(static.movers.values()),
        shapes=tuple(shape for name, shape in static.shapes.items() if name not in of_policies),
        start=begin,
        schedule=turns,
        window=view,
        observables=seen,
        hidden=unseen,
        events=counted,
        measures=measured,
        checks=checked,
        looks=drawn,
        policies=played,
        policy_shapes=tuple(shape for name, shape in static.shapes.items() if name in of_policies),
        scenarios=lineups,
    )
    return typed, static


def _read_map(
    game: Composition, static: Static, overrides: Overrides, problems: Problems
) -> tuple[str, ...]:
    glyphs = glyph_table(static, problems)
    static.wraps = game.map is not None and game.map.edges == "joined"
    if game.map is None and overrides.rows is None:
        problems.add(
            errors.MissingPart(game.span, what="map", how='`map "maps/name.txt"` or `map { "…" }`')
        )
        return ()
    span = game.map.span if game.map is not None else game.span
    inline = game.map.rows if game.map is not None and overrides.rows is None else ()
    before = len(problems.found)
    if overrides.rows is not None:
        rows, spans = overrides.rows, overrides.row_spans
    else:
        rows, spans = read_rows(game.map, game.sources[span.file], problems)  # type: ignore[arg-type]
    if len(problems.found) > before or not check_rows(
        (rows, spans), glyphs, span, problems, inline
    ):
        static.cells = dict.fromkeys(static.kinds, 1)
        static.map_rows = static.map_cols = 1
        return ()
    static.cells = count_cells(rows, glyphs)
    static.rows, static.map_rows, static.map_cols = rows, len(rows), len(rows[0])
    return rows


def _episode(game: Composition, scope: Scope) -> ir.Expr:
    """Returns the steps of an episode: numbers and parameters, for it is as long whatever happens in it."""
    if game.episode is None:
        raise scope.fail(errors.MissingPart(game.span, what="episode", how="`episode 1000`"))
    steps = scope.number(game.episode.steps, ("steps",), "a number of steps")
    if any(isinstance(node, ir.Step | ir.FieldRead | ir.Aggregate) for node in ir.walk(steps)):
        help_ = "use numbers, `size`s and `param`s; `end` ends an episode when something happens"
        raise scope.fail(
            errors.NotFixed(game.episode.steps.span, what="the length of an episode", help=help_)
        )
    return steps
