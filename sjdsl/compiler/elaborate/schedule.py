"""Elaborates the schedule: builds each use of a phase separately, with its arguments."""

import re
from collections.abc import Iterable
from dataclasses import replace
from itertools import chain

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol, local_symbol
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.diagnostic import Fix
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.lookup import check_arguments
from sjdsl.compiler.elaborate.possible import STEP
from sjdsl.compiler.elaborate.scope import Scope
from sjdsl.compiler.elaborate.statements import block
from sjdsl.compiler.elaborate.streams import Streams
from sjdsl.compiler.ir.names import Names, phase_function
from sjdsl.compiler.ir.printer import expression_text as text
from sjdsl.compiler.ir.types import integer
from sjdsl.near_names import nearest

# Expressions of these alone have the same value in all of an episode.
CONSTANT = (
    ir.Word | ir.Number | ir.ParamRef | ir.At | ir.Arithmetic | ir.SumRow | ir.Named | ir.Narrowed
)
ARGUMENTS = (
    "use words, numbers, `size`s, `param`s and names of actions; "
    "what changes in play, and who is meant, the phase says itself"
)


def start(game: Composition, scope: Scope) -> ir.Phase | None:
    """Returns the phase that runs at reset."""
    phase = game.phases.get("start")
    if phase is None:
        scope.problems.add(errors.NoStart(game.span))
        return None
    return _beginning(phase, "start", {}, replace(scope, part="start"))


def starting(game: Composition, scope: Scope) -> tuple[ir.Phase, ...]:
    """Returns the phases that follow `start` when an episode begins, in the order written."""
    functions = Names({"start", "draw_task"})
    no_step_yet = ir.Compare(fn="==", left=STEP, right=ir.Number(type=integer(0, 0), value=0))
    scope = scope.knowing([no_step_yet])
    typed: list[ir.Phase] = []
    for name, phase in game.phases.items():
        if name != "start" and phase.at is not None:
            unknown_values = dict.fromkeys(parameter.text for parameter in phase.parameters)
            function = functions.fresh(phase_function(name))
            typed.append(_beginning(phase, function, unknown_values, scope))
    return tuple(typed)


def _beginning(
    phase: ast.Phase, function: str, values: dict[str, ir.Expr | str | None], scope: Scope
) -> ir.Phase:
    """Returns a phase with which an episode begins; it has no parameters."""
    name = phase.name
    with scope.problems.skip_if_broken():
        _check_moment(phase, scope)
        check_arguments(name.text, name.span, len(phase.parameters), 0, scope)
    typed = _typed_phase(phase, name.text, function, values, scope)
    _check_before_steps(typed, scope)
    return typed


def _check_moment(phase: ast.Phase, scope: Scope) -> None:
    """Reports a moment other than `at start`."""
    if phase.at is not None and phase.at.text != "start":
        fix = Fix(phase.at.span, "start")
        help_ = "write `at start`: such a phase is played when an episode begins"
        raise scope.fail(errors.UnknownName(phase.at.span, name=phase.at.text, help=help_, fix=fix))


def _check_before_steps(phase: ir.Phase, scope: Scope) -> None:
    """Reports what only a step has, in a phase with which an episode begins."""
    for node in chain.from_iterable(map(ir.walk, phase.body)):
        match node:
            case ir.Give():
                what = "nobody can be paid"
            case ir.Tally():
                what = "nothing is counted"
            case ir.End():
                what = "nothing can end"
            case ir.Mark():
                what = "nothing is marked"
            case ir.Chose() | ir.ChoseWith() | ir.ArgumentOf() | ir.Move(course=None):
                what = "nobody has chosen an action"
            case _:
                continue
        scope.problems.add(errors.NotBeforeSteps(node.span, what=what, name=phase.label))


def schedule(
    game: Composition, functions_at_start: Iterable[str], scope: Scope
) -> tuple[ir.Turn, ...]:
    """Returns the turns of a step in order. functions_at_start: names of phases at the start."""
    if game.schedule is None:
        example = "`schedule phase -> phase` with its phases in order"
        scope.problems.add(errors.MissingPart(game.span, part="schedule", example=example))
        return ()
    if len(game.schedule.turns) > limits.MAX_TURNS:
        feature = f"a schedule of more than {limits.MAX_TURNS} turns"
        scope.problems.add(errors.Unsupported(game.schedule.span, feature=feature))
        return ()
    _check_phases_exist(game, game.schedule, scope)
    labels: list[str] = []
    functions = Names({"start", "draw_task", *functions_at_start})
    turns: list[ir.Turn] = []
    for turn in game.schedule.turns:
        with scope.problems.skip_if_broken():
            if turn.name.text == "tick":
                check_arguments("tick", turn.span, len(turn.arguments), 0, scope)
                turns.append(ir.Tick(origin=turn.span))
            elif turn.name.text in game.phases:
                turns.append(_phase_use(turn, game, scope, labels, functions))
    scheduled = {turn.name.text for turn in game.schedule.turns}
    for name, phase in game.phases.items():
        if name != "start" and phase.at is None and name not in scheduled:
            scope.problems.add(errors.PhaseNotScheduled(phase.name.span, name=name))
            unknown_values = dict.fromkeys(parameter.text for parameter in phase.parameters)
            _typed_phase(phase, name, "", unknown_values, scope)  # to report its mistakes
    return tuple(turns)


def _check_phases_exist(game: Composition, schedule: ast.Schedule, scope: Scope) -> None:
    """Reports the phases that a schedule names and nobody has written.

    One with a similar name is reported by itself, all others together.
    """
    known = [*game.phases, "tick"]
    missing: dict[str, Span] = {}
    for turn in schedule.turns:
        if turn.name.text not in known:
            missing.setdefault(turn.name.text, turn.name.span)
    similar = {name: nearest(name, known) for name in missing}
    others = tuple(name for name in missing if not similar[name])
    for name, span in missing.items():
        if similar[name] or len(others) == 1:
            scope.problems.add(errors.PhaseNotWritten(span, name=name, nearest=similar[name]))
    if len(others) > 1:
        span = missing[others[0]]
        scope.problems.add(errors.PhasesNotWritten(span, name=others[0], names=others))


def _phase_use(
    turn: ast.Turn, game: Composition, scope: Scope, labels: list[str], functions: Names
) -> ir.Phase:
    """Returns a use of a phase.

    labels, functions: those of the turns before, to which this adds its own. Equal labels are
    numbered.
    """
    name = turn.name.text
    phase = game.phases[name]
    scope.static.refer(turn.name, Symbol("phase", name))
    if name == "start" or phase.at is not None:
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
    labels.append(label)
    number = labels.count(label)
    if number > 1:
        label = f"{label} #{number}"
    function = re.sub(r"\W", "_", "_".join([name, *shown]))
    return _typed_phase(phase, label, functions.fresh(phase_function(function)), values, scope)


def _argument(argument: ast.Expr, scope: Scope) -> ir.Expr | str:
    """Returns a word, the name of an action, or an expression of numbers and parameters alone."""
    static = scope.static
    if isinstance(argument, ast.Path) and not argument.steps:
        name = argument.name
        if name.text in static.action_names and not static.is_word(name.text):
            static.refer(name, Symbol("action", name.text))
            return name.text
    value = scope.expression(argument)
    if not all(isinstance(node, CONSTANT) for node in ir.walk(value)):
        quantity = "what a phase is used with"
        raise scope.fail(errors.NotFixed(argument.span, quantity=quantity, help=ARGUMENTS))
    return value


def _typed_phase(
    phase: ast.Phase,
    label: str,
    function: str,
    values: dict[str, ir.Expr | str | None],
    scope: Scope,
) -> ir.Phase:
    """Returns a phase with values for its parameters. function: its name in generated code."""
    inner = replace(
        scope,
        variables=values,
        locals={parameter.text: local_symbol(parameter) for parameter in phase.parameters},
        never=scope.static.never_in(f"phase {phase.name.text}"),
    )
    body = block(phase.block, inner, Streams(label, scope.static.sources))
    nodes = chain.from_iterable(ir.walk(statement) for statement in body)
    marks = dict.fromkeys(node.shape for node in nodes if isinstance(node, ir.Mark))
    return ir.Phase(label=label, name=function, body=body, marks=tuple(marks), origin=phase.span)
