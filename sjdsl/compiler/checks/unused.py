"""Checks for unused declarations: kinds not on the map, names never read, actions never used, events never counted."""

from sjdsl.compiler import ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors, guesses
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.elaborate.scope import Static
from sjdsl.compiler.ir.queries import phases_of
from sjdsl.compiler.ir.sorts import Level
from sjdsl.runtime.actions import MOVES


def check_unused(game: ir.Game, static: Static, composition: Composition, problems: Problems) -> None:
    """Warns of all that is declared and makes no difference; assumes a game without errors."""
    _check_names(game, composition, static, problems)
    _check_actions(game, composition, problems)
    _check_events(game, static, problems)


def _check_actions(game: ir.Game, composition: Composition, problems: Problems) -> None:
    """Warns of actions that change nothing: no rule asks who chose them, and nobody moves."""
    nodes = [n for turn in game.schedule for n in ir.walk(turn)]
    asked = {game.agents.actions[n.action] for n in nodes if isinstance(n, ir.Chose)}
    asked |= {n.action for n in nodes if isinstance(n, ir.ChoseWith)}
    moving = any(isinstance(n, ir.Move) and n.course is None for n in nodes)
    assert composition.acts is not None
    idle = [a.name for a in composition.acts.actions if a.name.text not in asked and a.name.text != "stay"]
    for action in idle:
        if action.text not in MOVES:
            problems.add(errors.IdleAction(action.span, name=action.text, help=guesses.ACTIONS.get(action.text, "")))
    steps = [a for a in idle if a.text in MOVES]
    if steps and not moving:
        problems.add(errors.IdleSteps(steps[0].span, names=", ".join(f"`{a.text}`" for a in steps)))


def _check_events(game: ir.Game, static: Static, problems: Problems) -> None:
    """Warns of events that no rule counts."""
    counted = {n.event for phase in phases_of(game) for n in ir.walk(phase) if isinstance(n, ir.Tally)}
    for name, event in static.events.items():
        if name not in counted:
            path = name if name not in static.event_levels else f"{name}[{_example(static.event_levels[name])}]"
            problems.add(errors.NeverCounted(event.name.span, name=name, path=path))


def _example(level: Level) -> str:
    """Returns a key that a rule could count by."""
    return "agent" if level.sort == "agent" else level.names[0]


def _check_names(game: ir.Game, composition: Composition, static: Static, problems: Problems) -> None:
    """Warns of kinds not on the map, and of numbers, defines, shapes and fields nobody uses."""
    used = static.used
    for kind in game.kinds:
        if static.cells.get(kind.name, 0) == 0 and not kind.blocks:  # walls are for other maps too
            problems.add(errors.KindAbsent(composition.kinds[kind.name].name.span, name=kind.name))
        for attribute in kind.fields:
            if Symbol("field", attribute.name, kind.name) not in used and attribute.type.kind != "word":
                problems.add(errors.Unused(attribute.span, what="the field", name=f"{kind.name}.{attribute.name}"))
    for sort in game.movers:
        if Symbol("name", sort.name) not in used:
            problems.add(errors.Unused(composition.movers[sort.name].name.span, what="the sort of movers", name=sort.name))
        for attribute in sort.fields:
            if Symbol("field", attribute.name, sort.name) not in used and attribute.name != "heading":
                problems.add(errors.Unused(attribute.span, what="the field", name=f"{sort.name}.{attribute.name}"))
    for name, constant in composition.constants.items():
        if Symbol("name", name) not in used:
            what = "the size" if constant.is_size else "the parameter"
            help_ = "a `require` reads it, but no rule does" if Symbol("name", name) in static.required else ""
            problems.add(errors.Unused(constant.name.span, what=what, name=name, help=help_))
    for name, define in composition.defines.items():
        if Symbol("name", name) not in used and define.span.file == composition.file:  # a base has defines for all games built on it
            problems.add(errors.Unused(define.name.span, what="the define", name=name))
    for name, shape in composition.shapes.items():
        if Symbol("shape", name) not in used:
            problems.add(errors.Unused(shape.name.span, what="the shape", name=name))
    for name, declared in static.agent_fields.items():
        if Symbol("field", name, "agent") not in used:
            problems.add(errors.Unused(declared.span, what="the field", name=f"agent.{name}"))
    for name, declared in static.fields.items():
        if Symbol("name", name) not in used:
            problems.add(errors.Unused(declared.span, what="the field", name=name))
