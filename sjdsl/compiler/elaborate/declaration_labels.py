"""Adds "declared here" labels to diagnostics: a second place for messages about a name, a word or a number from elsewhere.

Often the mistake is there: the declaration is misspelt, and the use is right.
"""

from dataclasses import replace

from sjdsl.compiler import ast, ir
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic, Label, Near
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.scope import Static

MANY = 4  # numbers shown beside a requirement


def with_declaration_labels(found: list[Diagnostic], game: Composition) -> list[Diagnostic]:
    """Returns the diagnostics, those about a name or a word from another line with the place where it is declared."""
    named, ranges = _places(game)
    number = game.number  # of agents: the value of the size that it names, or the number itself
    if isinstance(number, ast.Path) and number.name.text in game.constants:
        agents: Span | None = game.constants[number.name.text].value.span
    else:
        agents = None if number is None else number.span
    labelled = []
    for d in found:
        span, text = None, ""
        match d:
            case errors.WordOutside():
                span, text = ranges.get(d.declared), "its words are declared here"
            case errors.FieldRange():
                span, text = ranges.get(d.declared), "its range is declared here"
            case errors.TooFewCells() | errors.NoFreeCell() | errors.TakenOrNowhere():
                span, text = agents, "so many agents"
            case errors.NotKnown(near=Near(nearest=(name,))):
                span, text = named.get(name), f"`{name}` is declared here"
        elsewhere = span is not None and (span.file, span.line) != (d.span.file, d.span.line)
        labelled.append(
            replace(d, labels=(Label(span, text),))
            if span is not None and elsewhere and not d.labels
            else d
        )
    return labelled


def _places(game: Composition) -> tuple[dict[str, Span], dict[str, Span]]:
    """Returns where each name, word and action is declared, and where the words or the range of each field, event and action are."""
    attributes = [
        a
        for kind in game.kinds.values()
        for a in kind.attributes
        if isinstance(a, ast.Field | ast.Timer)
    ]
    attributes += [*game.agent_fields.values(), *game.fields.values()]
    fields = [a for a in attributes if isinstance(a, ast.Field)]
    actions = () if game.acts is None else game.acts.actions
    tables = (
        game.constants,
        game.kinds,
        game.groups,
        game.shapes,
        game.defines,
        game.phases,
        game.metrics,
    )
    names = [node.name for table in tables for node in table.values()] + [
        node.name for node in (*attributes, *actions)
    ]
    names += [
        name for field in fields if isinstance(field.type, ast.Words) for name in field.type.names
    ]
    ranges = {field.name.text: field.type.span for field in fields}
    for metric in game.metrics.values():
        if isinstance(metric, ast.Event) and metric.by is not None:
            ranges[metric.name.text] = (
                metric.by.names[0].span if isinstance(metric.by, ast.Words) else metric.by.span
            )
    ranges |= {action.name.text: action.span for action in actions if action.arguments}
    return {name.text: name.span for name in reversed(names)}, ranges


def parameters_read(static: Static, *values: ir.Expr) -> tuple[Label, ...]:
    """Returns the places where the parameters are declared that values are made of; none if there are too many."""
    names = dict.fromkeys(
        n.name for value in values for n in ir.walk(value) if isinstance(n, ir.ParamRef)
    )
    places = {name: static.params[name].origin for name in names}
    labels = tuple(Label(span, f"`{name}`") for name, span in places.items() if span is not None)
    return labels if len(labels) <= MANY else ()
