"""Elaborates the schedule: each use of a phase is built separately, with its arguments filled in."""

from dataclasses import replace

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol, local_symbol
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.elaborate.lookup import check_arguments
from sjdsl.compiler.elaborate.scope import Scope
from sjdsl.compiler.elaborate.statements import block
from sjdsl.compiler.elaborate.streams import PhaseUse, Streams
from sjdsl.compiler.ir.names import Names, phase_function
from sjdsl.compiler.ir.printer import expression as text
from sjdsl.near_names import nearest

ALIKE = (
    ir.Word,
    ir.Number,
    ir.ParamRef,
    ir.At,
    ir.Arithmetic,
    ir.SumRow,
    ir.Named,
    ir.Narrowed,
)  # the same in all of an episode
USED_WITH = "use words, numbers, `size`s, `param`s and names of actions; what changes in play, and who is meant, the phase says itself"


def start(game: Composition, scope: Scope) -> ir.Phase | None:
    """Returns the phase that runs at reset."""
    phase = game.phases.get("start")
    if phase is None:
        scope.problems.add(errors.NoStart(game.span))
        return None
    if phase.parameters:
        scope.problems.add(
            errors.WrongArguments(
                phase.name.span, name="start", wanted="no arguments", actual=len(phase.parameters)
            )
        )
    return _use(phase, "start", "start", {}, replace(scope, part="start"))


def schedule(game: Composition, scope: Scope) -> tuple[ir.Turn, ...]:
    """Returns the turns of a step in order."""
    if game.schedule is None:
        scope.problems.add(
            errors.MissingPart(
                game.span,
                part="schedule",
                example="`schedule phase -> phase` with its phases in order",
            )
        )
        return ()
    if len(game.schedule.turns) > limits.MAX_TURNS:
        what = f"a schedule of more than {limits.MAX_TURNS} turns"
        scope.problems.add(errors.Unsupported(game.schedule.span, feature=what))
        return ()
    _check_written(game, game.schedule, scope)
    written = [
        turn
        for turn in game.schedule.turns
        if turn.name.text in game.phases or turn.name.text == "tick"
    ]
    labels, functions = list[str](), Names({"start"})
    turns = scope.problems.each(written, lambda turn: _turn(turn, game, scope, labels, functions))
    scheduled = {t.name.text for t in game.schedule.turns} | {"start"}
    for phase in game.phases.values():
        if phase.name.text not in scheduled:
            scope.problems.add(errors.PhaseNotScheduled(phase.name.span, name=phase.name.text))
            _use(
                phase,
                phase.name.text,
                "",
                {parameter.text: None for parameter in phase.parameters},
                scope,
            )  # for its mistakes
    return tuple(turns)


def _check_written(game: Composition, schedule: ast.Schedule, scope: Scope) -> None:
    """Reports the phases that a schedule names and nobody has written: each that is like another one alone, the rest together."""
    known = [*game.phases, "tick"]
    missing = {
        turn.name.text: turn.name.span
        for turn in reversed(schedule.turns)
        if turn.name.text not in known
    }
    alike = {name: nearest(name, known) for name in reversed(missing)}
    others = tuple(name for name, like in alike.items() if not like)
    for name, like in alike.items():
        if like or len(others) == 1:
            scope.problems.add(errors.PhaseNotWritten(missing[name], name=name, nearest=like))
    if len(others) > 1:
        scope.problems.add(
            errors.PhasesNotWritten(missing[others[0]], name=others[0], names=others)
        )


def _turn(
    turn: ast.Turn, game: Composition, scope: Scope, labels: list[str], functions: Names
) -> ir.Turn:
    name = turn.name.text
    if name == "tick":
        if turn.arguments:
            scope.problems.add(
                errors.WrongArguments(
                    turn.span, name="tick", wanted="no arguments", actual=len(turn.arguments)
                )
            )
        return ir.Tick(origin=turn.span)
    phase = game.phases[name]
    scope.static.refer(turn.name, Symbol("phase", name))
    if name == "start":
        raise scope.fail(errors.StartScheduled(turn.name.span, name=name))
    check_arguments(name, turn.span, len(turn.arguments), len(phase.parameters), scope)
    values: dict[str, ir.Expr | str | None] = {}
    shown = []
    for parameter, argument in zip(phase.parameters, turn.arguments, strict=True):
        if parameter.text in scope.static.names() and not scope.static.is_word(parameter.text):
            scope.problems.add(
                errors.NameTaken(parameter.span, name=parameter.text, taken_by="something else")
            )
        value = _argument(argument, scope)
        values[parameter.text] = value
        shown.append(value if isinstance(value, str) else text(value))
    label = f"{name}({', '.join(shown)})" if shown else name
    times = labels.count(label)
    labels.append(label)
    if times:
        label = f"{label} #{times + 1}"
    identifier = "_".join([name, *("".join(c if c.isalnum() else "_" for c in s) for s in shown)])
    identifier += f"_{times + 1}" if times else ""
    return _use(phase, label, functions.fresh(phase_function(identifier)), values, scope)


def _argument(argument: ast.Expr, scope: Scope) -> ir.Expr | str:
    """Returns a word, something made of numbers alone (params too, which may change from run to run), or the name of an action."""
    if (
        isinstance(argument, ast.Path)
        and not argument.steps
        and argument.name.text in scope.static.action_names
    ):
        if not scope.static.is_word(argument.name.text):
            scope.static.refer(argument.name, Symbol("action", argument.name.text))
            return argument.name.text
    value = scope.expression(argument)
    if not all(isinstance(node, ALIKE) for node in ir.walk(value)):
        raise scope.fail(
            errors.NotFixed(argument.span, quantity="what a phase is used with", help=USED_WITH)
        )
    return value


def _use(
    phase: ast.Phase, label: str, name: str, values: dict[str, ir.Expr | str | None], scope: Scope
) -> ir.Phase:
    use = PhaseUse(Streams(label, scope.static.sources))
    locals_ = {p.text: local_symbol(p) for p in phase.parameters}
    inner = replace(
        scope,
        variables=values,
        locals=locals_,
        never=scope.static.never_in(f"phase {phase.name.text}"),
    )
    body = block(phase.block, inner, use)
    marks = dict.fromkeys(n.shape for s in body for n in ir.walk(s) if isinstance(n, ir.Mark))
    return ir.Phase(label=label, name=name, body=body, marks=tuple(marks), origin=phase.span)
