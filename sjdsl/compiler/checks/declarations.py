"""Checks declarations: names that clash, timers and `tick`, and what is never used."""

from itertools import chain

from sjdsl.compiler import ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.scope import Static
from sjdsl.compiler.ir.entity_types import AGENTS
from sjdsl.compiler.ir.names import STATE, state_names
from sjdsl.compiler.ir.queries import all_fields, body_type, phases_of, sets
from sjdsl.runtime.actions import MOVES


def check_state_names(game: ir.Game, problems: Problems) -> None:
    """Reports declarations that would share an attribute of the compiled state.

    `a_b.c` and `a.b_c` would become one attribute.
    """
    seen: dict[str, str] = dict.fromkeys(STATE, "the language")
    for attribute, node in state_names(game):
        if attribute in seen and node.origin is not None:
            problem = (
                f"the compiled state would have `{attribute}` twice (also of {seen[attribute]})"
            )
            name = getattr(node, "label", "") or getattr(node, "name", attribute)
            role = "the name of this"
            problems.add(errors.BadName(node.origin, name=name, role=role, problem=problem))
        place = "another declaration" if node.origin is None else f"line {node.origin.line}"
        seen.setdefault(attribute, place)


def check_timers(game: ir.Game, composition: Composition, problems: Problems) -> None:
    """Reports a missing, doubled or needless `tick`, and timers set on both sides of it."""
    timers = [field for field in all_fields(game) if field.timer]
    sends = [node for node in ir.walk(game) if isinstance(node, ir.Send)]
    away = [body_type(send.who) for send in sends if send.after is not None]
    ticks = [place for place, turn in enumerate(game.schedule) if isinstance(turn, ir.Tick)]
    assert composition.schedule is not None
    span = composition.schedule.span
    if (timers or away) and not ticks:
        who = "agents" if AGENTS in away or not away else f"movers `{away[0].name}`"
        what = "there are timers" if timers else f"{who} are sent away for some steps (`after`)"
        problems.add(errors.NoTick(span, need=what))
    if len(ticks) > 1:
        problems.add(errors.TickTwice(game.schedule[ticks[1]].origin or span))
    if len(ticks) == 1:
        for timer in timers:
            before = _starts_of(game.schedule[: ticks[0]], timer)
            after = _starts_of(game.schedule[ticks[0] + 1 :], timer)
            if before and after:
                problems.add(errors.TimerBothSides(before[0].origin or timer.span, name=timer.name))


def _starts_of(turns: tuple[ir.Turn, ...], timer: ir.VarField) -> list[ir.Set]:
    """Returns the statements that set a timer to something that can be above 0."""
    starts = (node for turn in turns for node in ir.walk(turn) if isinstance(node, ir.Set))
    return [s for s in starts if sets(s, timer) and s.value.type.high > 0]


def check_unused(
    game: ir.Game, static: Static, composition: Composition, problems: Problems
) -> None:
    """Warns of all that is declared and makes no difference; assumes a game without errors."""
    _check_names(game, composition, static, problems)
    _check_actions(game, composition, problems)
    counted = {
        n.event for phase in phases_of(game) for n in ir.walk(phase) if isinstance(n, ir.Tally)
    }
    for name, event in static.events.items():
        if name not in counted:
            index_set = static.event_index_sets.get(name)
            key = ""
            if index_set is not None:
                key = "[agent]" if index_set.kind == "agent" else f"[{index_set.names[0]}]"
            problems.add(errors.NeverCounted(event.name.span, name=name, path=f"{name}{key}"))


def _check_actions(game: ir.Game, composition: Composition, problems: Problems) -> None:
    """Warns of actions that change nothing: no rule asks who chose them, and nobody moves."""
    used = {"stay"}
    agents_move = False
    for node in chain.from_iterable(map(ir.walk, game.schedule)):
        match node:
            case ir.Chose():
                used.add(game.agents.actions[node.action])
            case ir.ChoseWith():
                used.add(node.action)
            case ir.Move(course=None):
                agents_move = True
    assert composition.acts is not None
    names = [action.name for action in composition.acts.actions]
    idle = [name for name in names if name.text not in used]
    for name in idle:
        if name.text not in MOVES:
            problems.add(errors.IdleAction(name.span, name=name.text))
    steps = [name for name in idle if name.text in MOVES]
    if steps and not agents_move:
        listed = ", ".join(f"`{name.text}`" for name in steps)
        problems.add(errors.IdleSteps(steps[0].span, names=listed))


def _check_names(
    game: ir.Game, composition: Composition, static: Static, problems: Problems
) -> None:
    """Warns of kinds not on the map, and of numbers, defines, shapes and fields nobody uses."""

    def check_used(symbol: Symbol, span: Span, entity: str, help_: str = "") -> None:
        """Warns of something that nobody uses; a field is called with its owner."""
        if symbol not in static.used:
            name = f"{symbol.owner}.{symbol.name}" if symbol.owner else symbol.name
            problems.add(errors.Unused(span, entity=entity, name=name, help=help_))

    for kind in game.kinds:
        if static.cells.get(kind.name, 0) == 0 and not kind.blocks:  # walls are for other maps too
            problems.add(errors.KindAbsent(composition.kinds[kind.name].name.span, name=kind.name))
        for field in kind.fields:
            if field.type.kind != "word":
                check_used(Symbol("field", field.name, kind.name), field.span, "the field")
    for movers in game.movers:
        span = composition.movers[movers.name].name.span
        check_used(Symbol("name", movers.name), span, "the sort of movers")
        for field in movers.fields:
            if field.name != "heading":
                check_used(Symbol("field", field.name, movers.name), field.span, "the field")
    for name, constant in composition.constants.items():
        symbol = Symbol("name", name)
        help_ = "a `require` reads it, but no rule does" if symbol in static.required else ""
        entity = "the size" if constant.is_size else "the parameter"
        check_used(symbol, constant.name.span, entity, help_)
    for name, define in composition.defines.items():
        if define.span.file == composition.file:  # a base has defines for all games built on it
            check_used(Symbol("name", name), define.name.span, "the define")
    for name, shape in composition.shapes.items():
        check_used(Symbol("shape", name), shape.name.span, "the shape")
    for name, field in static.agent_fields.items():
        check_used(Symbol("field", name, "agent"), field.span, "the field")
    for name, field in static.fields.items():
        check_used(Symbol("name", name), field.span, "the field")
