"""Time and use: timers and `tick`, kinds that are not on the map, what nobody reads, chooses in vain or counts."""

from sjdsl.compiler import ir
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.elaborate.scope import Static

MOVES = ("turn_left", "turn_right", "step_left", "step_right", "forward", "backward")


def check_time(game: ir.Game, problems: Problems, composition: Composition) -> None:
    """Reports a missing, doubled or needless `tick`, and timers set on both sides of it."""
    timers = [f for k in game.kinds for f in k.fields if f.timer]
    timers += [f for f in (*game.agents.fields, *game.fields) if f.timer]
    away = any(isinstance(n, ir.Send) and n.after is not None for n in ir.walk(game))
    ticks = [t for t in game.schedule if isinstance(t, ir.Tick)]
    assert composition.schedule is not None
    span = composition.schedule.span
    if (timers or away) and not ticks:
        what = "there are timers" if timers else "agents are sent away for some steps (`after`)"
        problems.add(errors.NoTick(span, what=what))
    if len(ticks) > 1:
        problems.add(errors.TickTwice(ticks[1].origin or span))
    if len(ticks) == 1:
        _check_sides(game, timers, problems)


def _check_sides(game: ir.Game, timers: list[ir.VarField], problems: Problems) -> None:
    at = next(i for i, t in enumerate(game.schedule) if isinstance(t, ir.Tick))
    for timer in timers:
        before = _sets(game.schedule[:at], timer)
        after = _sets(game.schedule[at + 1 :], timer)
        if before and after:
            problems.add(errors.TimerBothSides(before[0].origin or timer.origin, name=timer.name))  # type: ignore[arg-type]


def _sets(turns: tuple[ir.Turn, ...], timer: ir.VarField) -> list[ir.Set]:
    """Returns the sentences that set a timer to something that can be above 0."""
    found = []
    for node in (n for t in turns for n in ir.walk(t)):
        if isinstance(node, ir.Set) and isinstance(node.target, ir.FieldRead) and node.target.name == timer.name:
            same = timer.kind in node.target.kinds if timer.place == "cell" else node.target.place == timer.place
            if same and node.value.type.high > 0:
                found.append(node)
    return found


def check_actions(game: ir.Game, composition: Composition, problems: Problems) -> None:
    """Warns of actions that change nothing: no rule asks who chose them, and nobody moves."""
    nodes = [n for turn in game.schedule for n in ir.walk(turn)]
    asked = {game.agents.actions[n.action] for n in nodes if isinstance(n, ir.Chose)}
    moving = any(isinstance(n, ir.Move) for n in nodes)
    assert composition.acts is not None
    idle = [a for a in composition.acts.actions if a.text not in asked and a.text != "stay"]
    for action in idle:
        if action.text not in MOVES:
            problems.add(errors.IdleAction(action.span, name=action.text))
    steps = [a for a in idle if a.text in MOVES]
    if steps and not moving:
        problems.add(errors.IdleSteps(steps[0].span, names=", ".join(f"`{a.text}`" for a in steps)))


def check_events(game: ir.Game, static: Static, problems: Problems) -> None:
    """Warns of events that no rule counts."""
    counted = {n.event for phase in (game.start, *game.schedule) for n in ir.walk(phase) if isinstance(n, ir.Tally)}
    for name, event in static.events.items():
        if name not in counted:
            path = name if event.by is None else f"{name}[{event.by.names[0].text}]"
            problems.add(errors.NeverCounted(event.name.span, name=name, path=path))


def check_use(composition: Composition, static: Static, problems: Problems) -> None:
    """Warns of kinds not on the map, and of numbers, defines, shapes and fields nobody uses."""
    used = static.used
    for name, kind in composition.kinds.items():
        if static.cells.get(name, 0) == 0 and not static.kinds[name].blocks:  # walls are for other maps too
            problems.add(errors.KindAbsent(kind.name.span, name=name))
        for attribute in static.kinds[name].fields if name in static.kinds else ():
            if f"{name}.{attribute.name}" not in used and attribute.type.kind != "word":
                problems.add(errors.Unused(attribute.origin, what="the field", name=f"{name}.{attribute.name}"))  # type: ignore[arg-type]
    for name, constant in composition.constants.items():
        if name not in used:
            what = "the size" if constant.is_size else "the parameter"
            problems.add(errors.Unused(constant.name.span, what=what, name=name))
    for name, define in composition.defines.items():
        if name not in used:
            problems.add(errors.Unused(define.name.span, what="the define", name=name))
    for name, shape in composition.shapes.items():
        if f"shape {name}" not in used:
            problems.add(errors.Unused(shape.name.span, what="the shape", name=name))
    for name, declared in static.agent_fields.items():
        if f"agent.{name}" not in used:
            problems.add(errors.Unused(declared.origin, what="the field", name=f"agent.{name}"))  # type: ignore[arg-type]
    for name, declared in static.fields.items():
        if f"field {name}" not in used:
            problems.add(errors.Unused(declared.origin, what="the field", name=name))  # type: ignore[arg-type]
