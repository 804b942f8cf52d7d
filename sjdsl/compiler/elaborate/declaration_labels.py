"""Adds "declared here" labels to diagnostics about a name, word or number declared elsewhere.

Often the mistake is in the declaration, and the use is right.
"""

from dataclasses import replace
from itertools import chain

from sjdsl.compiler import ast, ir
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic, Label, Near
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.scope import Static

MOST_LABELS = 4  # more parameters are not pointed at


def with_declaration_labels(diagnostics: list[Diagnostic], game: Composition) -> list[Diagnostic]:
    """Returns the diagnostics, some with a label: the place of a declaration in another line."""
    return [_with_label(diagnostic, game) for diagnostic in diagnostics]


def _with_label(diagnostic: Diagnostic, game: Composition) -> Diagnostic:
    """Returns a message with a label at the declaration that it is about."""
    span: Span | None
    match diagnostic:
        case errors.WordOutside():
            span = _type_span(diagnostic.declared, game)
            text = "its words are declared here"
        case errors.FieldRange():
            span = _type_span(diagnostic.declared, game)
            text = "its range is declared here"
        case errors.TooFewCells() | errors.NoFreeCell() | errors.TakenOrNowhere():
            span = _number_of_agents_span(game)
            text = "so many agents"
        case errors.NotKnown(near=Near(nearest=(name,))):
            span = _name_span(name, game)
            text = f"`{name}` is declared here"
        case _:
            return diagnostic
    if span is None or diagnostic.labels:
        return diagnostic
    if (span.file, span.line) == (diagnostic.span.file, diagnostic.span.line):
        return diagnostic
    return replace(diagnostic, labels=(Label(span, text),))


def _number_of_agents_span(game: Composition) -> Span | None:
    """Returns where the number of agents is written: as such, or as the value of a size."""
    number = game.number
    if number is None:
        return None
    if isinstance(number, ast.Path) and number.name.text in game.constants:
        return game.constants[number.name.text].value.span
    return number.span


def _name_span(name: str, game: Composition) -> Span | None:
    """Returns where a name, word or action is declared first."""
    tables = (
        game.constants,
        game.kinds,
        game.groups,
        game.shapes,
        game.defines,
        game.phases,
        game.metrics,
    )
    names = [node.name for table in tables for node in table.values()]
    fields = game.declared_fields()
    names += [field.name for field in fields]
    if game.acts is not None:
        names += [action.name for action in game.acts.actions]
    for field in fields:
        if isinstance(field, ast.Field) and isinstance(field.type, ast.Words):
            names += field.type.names
    return next((declared.span for declared in names if declared.text == name), None)


def _type_span(name: str, game: Composition) -> Span | None:
    """Returns where the words or the range of a field, event or action are."""
    if game.acts is not None:
        for action in game.acts.actions:
            if action.arguments and action.name.text == name:
                return action.span
    metric = game.metrics.get(name)
    if isinstance(metric, ast.Event) and isinstance(metric.by, ast.Words):
        return metric.by.names[0].span
    if isinstance(metric, ast.Event) and metric.by is not None:
        return metric.by.span
    for field in reversed(game.declared_fields()):
        if isinstance(field, ast.Field) and field.name.text == name:
            return field.type.span
    return None


def parameters_read(static: Static, *values: ir.Expr) -> tuple[Label, ...]:
    """Returns labels where the parameters in values are declared; none if there are too many."""
    labels: dict[str, Label] = {}
    for node in chain.from_iterable(map(ir.walk, values)):
        if isinstance(node, ir.ParamRef):
            span = static.params[node.name].origin
            if span is not None:
                labels[node.name] = Label(span, f"`{node.name}`")
    return tuple(labels.values()) if len(labels) <= MOST_LABELS else ()
