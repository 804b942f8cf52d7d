"""Elaboration: resolves names and checks types, from a composed game to the typed IR.

Composition -> ir.Game, with every mistake of the game reported at once
"""

from collections.abc import Mapping
from typing import Any

from sjdsl.compiler import ast, ir
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
    checks,
    declare_requires,
    events,
    measures,
)
from sjdsl.compiler.elaborate.observations import hidden, observables
from sjdsl.compiler.elaborate.policies import policies, scenarios
from sjdsl.compiler.elaborate.possible import know_steps, report_never
from sjdsl.compiler.elaborate.schedule import schedule, start, starting
from sjdsl.compiler.elaborate.scope import Scope, Static
from sjdsl.compiler.elaborate.shown_events import with_shown_events
from sjdsl.compiler.elaborate.tasks import check_not_told, task
from sjdsl.compiler.elaborate.trials import episode
from sjdsl.compiler.elaborate.window import window
from sjdsl.compiler.elaborate.world_map import check_rows, count_cells, glyph_table, read_rows


class Overrides(Record):
    """Values that a caller sets in place of the file's, and that are fixed when a game is compiled.

    sizes: by name. rows: of the map; row_spans: where each stands.
    placed_by_hand: a test puts agents and movers on the map itself, so the map needs no cells
      that `phase start` could send them to.
    """

    sizes: Mapping[str, Any] | None = None
    num_agents: int | None = None
    rows: tuple[str, ...] | None = None
    row_spans: tuple[Span, ...] = ()
    placed_by_hand: bool = False


def elaborate(
    game: Composition, overrides: Overrides, problems: Problems
) -> tuple[ir.Game | None, Static]:
    """Returns the typed game and its declarations; `problems` gets every mistake.

    The game is None if a part of it is missing.
    """
    static = declare_numbers(game, problems, overrides.sizes or {}, overrides.num_agents)
    if any(isinstance(problem, errors.WordClash) for problem in problems.diagnostics):
        return None, static  # every use of the name would be one more mistake
    static.phases = tuple(game.phases.values())
    declare_world(game, static, problems)
    rows = _read_map(game, static, overrides, problems)
    typed = _typed_game(game, rows, static, problems)
    report_never(static.never.values(), problems)
    return typed, static


def _typed_game(
    game: Composition, rows: tuple[str, ...], static: Static, problems: Problems
) -> ir.Game | None:
    """Returns the typed game; None if a part of it is missing.

    Every part is elaborated even so: `problems` gets the mistakes of all. The order matters: later
    parts know the length of an episode and the `require`s, and what agents see is compared with all
    rules.
    """
    scope = Scope(static, problems)
    checks_scope = Scope(static, problems, part="checks", events_readable=True)
    length = None
    trials = None
    with problems.skip_if_broken():
        length, trials = episode(game, scope)
        know_steps(length, static)
    kinds = build_kinds(game, static, problems)
    declare_requires(game, checks_scope)
    agents = build_agents(game, static, problems)
    start_phase = start(game, scope)
    typed_task = task(game, scope)
    starting_phases = starting(game, scope)
    turns = schedule(game, [phase.name for phase in starting_phases], scope)
    view = window(game, scope)
    rules: list[ir.Node] = [*turns, *kinds]
    if agents is not None:
        rules.append(agents)
    typed_observables = observables(game, rules, scope)
    typed_hidden = hidden(game, scope)
    if agents is not None:
        check_not_told(agents, typed_observables, scope)
    typed_measures = measures(game, Scope(static, problems, part="metrics"))
    typed_checks = checks(game, checks_scope)
    typed_looks = looks(game, static, problems)
    typed_events: tuple[ir.Event, ...] = ()
    with problems.skip_if_broken():
        phases = turns if start_phase is None else (start_phase, *turns)
        typed_events = events(phases, scope)
    typed_policies, policy_shapes = _policies_and_shapes(game, scope)
    typed_scenarios = scenarios(game, scope)
    if agents is None or start_phase is None or length is None or game.schedule is None:
        return None
    typed = ir.Game(
        name=game.name,
        title=game.title,
        cites=tuple(game.cites),
        about=tuple(game.about.items()),
        variants=tuple(game.variants),
        chosen=game.chosen,
        sizes=tuple(static.sizes.values()),
        params=tuple(static.params.values()),
        episode=length,
        trials=trials,
        task=typed_task,
        kinds=kinds,
        rows=rows,
        edges="joined" if static.wraps else "",
        glyphs=tuple(glyph for _, glyph in static.glyphs),
        fields=tuple(static.fields.values()),
        agents=agents,
        movers=tuple(static.movers.values()),
        shapes=tuple(shape for shape in static.shapes.values() if shape not in policy_shapes),
        start=start_phase,
        starting=starting_phases,
        schedule=turns,
        window=view,
        observables=typed_observables,
        hidden=typed_hidden,
        events=typed_events,
        measures=typed_measures,
        checks=typed_checks,
        looks=typed_looks,
        policies=typed_policies,
        policy_shapes=policy_shapes,
        scenarios=typed_scenarios,
    )
    return with_shown_events(game, typed, scope)


def _policies_and_shapes(
    game: Composition, scope: Scope
) -> tuple[tuple[ir.ScriptedPolicy, ...], tuple[ir.Shape, ...]]:
    """Returns the policies, and the shapes that they use and no rule of the game does."""
    static = scope.static
    used_by_rules = set(static.used)
    shapes_of_rules = set(static.shapes)
    typed = policies(game, scope.with_agent("policy"))
    used_by_policies = static.used - used_by_rules
    shapes = []
    for name, shape in static.shapes.items():
        if name not in shapes_of_rules or Symbol("shape", name) in used_by_policies:
            shapes.append(shape)
    return typed, tuple(shapes)


def _read_map(
    game: Composition, static: Static, overrides: Overrides, problems: Problems
) -> tuple[str, ...]:
    """Returns the rows of the map, none if they have a mistake; adds them to the tables."""
    glyphs = glyph_table(static, problems)
    static.wraps = game.map is not None and game.map.edges == "joined"
    span = game.span if game.map is None else game.map.span
    inline: tuple[ast.String, ...] = ()
    before = len(problems.diagnostics)
    if overrides.rows is not None:
        rows = overrides.rows
        spans = overrides.row_spans
    elif game.map is not None:
        rows, spans = read_rows(game.map, game.sources[span.file], problems)
        inline = game.map.rows
    else:
        example = '`map "maps/name.txt"` or `map { "…" }`'
        problems.add(errors.MissingPart(span, part="map", example=example))
        return ()
    is_read = len(problems.diagnostics) == before
    if not is_read or not check_rows((rows, spans), glyphs, span, problems, inline):
        static.cells = dict.fromkeys(static.kinds, 1)
        static.map_rows = static.map_cols = 1
        return ()
    static.cells = count_cells(rows, glyphs)
    static.rows = rows
    static.map_rows = len(rows)
    static.map_cols = len(rows[0])
    return rows
