"""Elaborates `show event NAME`: a field holds what the last step counted, and agents see it."""

from collections.abc import Mapping

from sjdsl.compiler import ast, ir
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.elaborate.effects import declared_event
from sjdsl.compiler.elaborate.observations import planes_of_rows
from sjdsl.compiler.elaborate.scope import Scope
from sjdsl.compiler.ir.entity_types import AGENTS
from sjdsl.compiler.ir.queries import ATTRIBUTES
from sjdsl.compiler.ir.types import integer

LARGEST = 255  # that a plane can show
WORLD = ir.EntityType("world")


def with_shown_events(composed: Composition, game: ir.Game, scope: Scope) -> ir.Game:
    """Returns the game with a field and a plane for each event that is shown."""
    events = {event.name: event for event in game.events}
    of_agents = list(game.agents.fields)
    of_world = list(game.fields)
    observables = list(game.observables)
    for show in composed.observables.values():
        if not isinstance(show, ast.ShowEvent):
            continue
        with scope.problems.skip_if_broken():
            field = _field(show, events, scope)
            fields = of_agents if field.held_by == AGENTS else of_world
            fields.append(field)
            observables += planes_of_rows([_seen(field)])
            events[field.name] = events[field.name].changed(shown=True)
    return game.changed(
        agents=game.agents.changed(fields=tuple(of_agents)),
        fields=tuple(of_world),
        events=tuple(events.values()),
        observables=tuple(observables),
    )


def _field(show: ast.ShowEvent, events: Mapping[str, ir.Event], scope: Scope) -> ir.VarField:
    """Returns the field for the counts of an event, of each agent or of the world."""
    name = show.name.text
    declared_event(show.name, scope)
    if name not in events:
        raise Poisoned
    event = events[name]
    static = scope.static
    taken = {*static.agent_fields, *ATTRIBUTES} if event.per_agent else static.names()
    if name in taken:
        owner = "a field of the agents" if event.per_agent else "something of the world"
        raise scope.fail(errors.NameTaken(show.name.span, name=name, taken_by=owner))
    type_ = integer(0, LARGEST)
    if event.by is not None:
        type_ = type_.changed(indexed_by=(event.by,))
    held_by = AGENTS if event.per_agent else WORLD
    return ir.VarField(name=name, held_by=held_by, type=type_, start=0, origin=show.span)


def _seen(field: ir.VarField) -> ir.Observable:
    """Returns what agents see of a count: their own, or the world's."""
    return ir.Observable(
        what="own" if field.held_by == AGENTS else "world",
        field=field.name,
        type=field.type,
        origin=field.origin,
    )
