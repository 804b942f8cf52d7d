"""Suggests repairs for mistakes other than write conflicts: the change that a hint speaks of, as edits of the text, each tried before it is offered."""

from collections.abc import Callable, Iterator

from sjdsl.compiler import ast
from sjdsl.compiler.ast.node import Node
from sjdsl.compiler.checks.ways_out import Edit, Way, way
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.syntax.parse import parse

Change = tuple[str, tuple[Edit, ...]]  # how it is named, and its edits
SIMPLE = (ast.Let, ast.Draw)


def repairs(d: Diagnostic, game: Composition) -> Iterator[Way]:
    """Yields the changes of the game's own text that a message's hint speaks of."""
    source = game.sources[game.file]
    found = next((change for kind, change in CHANGES.items() if isinstance(d, kind)), None)
    for says, edits in found(d, parse(source), source) if found is not None else ():
        yield way(says, edits, source)


def _within(file: ast.File, span: Span) -> list[Node]:
    """Returns the nodes around a span, the outermost first."""
    return [n for n in walk(file) if n.span.start <= span.start and span.end <= n.span.end]  # type: ignore[attr-defined]


def _guarded(test: str, span: Span, file: ast.File) -> Iterator[Change]:
    """Yields where a condition can stand that makes sure of something: in the `where` or `when` around, or as a `when` of its own."""
    says = f"guard it with `{test}`"
    around = _within(file, span)
    for node in reversed(around):
        match node:
            case ast.Domain(where=where) if where is not None and _holds(where.span, span):
                yield says, ((where.span.start, where.span.start, f"{test} and "),)
            case ast.When(condition=condition) if _holds(condition.span, span):
                yield says, ((condition.span.start, condition.span.start, f"{test} and "),)
    for node in reversed(around):
        if isinstance(node, ast.Domain) and node.where is not None and node.where.span.end <= span.start:
            yield says, ((node.where.span.end, node.where.span.end, f" and {test}"),)
        if isinstance(node, ast.Stmt) and not isinstance(node, SIMPLE):
            yield says, ((node.span.start, node.span.start, f"when {test} {{ "), (node.span.end, node.span.end, " }"))


def _holds(around: Span, span: Span) -> bool:
    return around.start <= span.start and span.end <= around.end


def _somebody(d: Diagnostic, file: ast.File, source: Source) -> Iterator[Change]:
    del source
    assert isinstance(d, errors.CanBeNobody)
    nothing = "nowhere" if isinstance(d, errors.CanBeNowhere) else "nobody"
    yield from _guarded(f"{d.path} is not {nothing}", d.span, file)


def _not_empty(d: Diagnostic, file: ast.File, source: Source) -> Iterator[Change]:
    del source
    assert isinstance(d, errors.EmptyMix)
    yield from _guarded(f"sum({d.row}) > 0", d.span, file)


def _chosen(d: Diagnostic, file: ast.File, source: Source) -> Iterator[Change]:
    del source
    assert isinstance(d, errors.NotChosen)
    yield from _guarded(f"{d.agent} chose {d.action}", d.span, file)


def _if_none(d: Diagnostic, file: ast.File, source: Source) -> Iterator[Change]:
    assert isinstance(d, errors.ExtremeOfNothing)
    end = source.text.rfind(")", d.span.start, d.span.end)
    yield "write `otherwise 0` for a domain without members", ((end, end, " otherwise 0"),)
    yield from _guarded(f"count({d.domain}) > 0", d.span, file)


def _stays(d: Diagnostic, file: ast.File, source: Source) -> Iterator[Change]:
    del source
    for node in reversed(_within(file, d.span)):
        if isinstance(node, ast.Send | ast.Shift) and node.stay is None:
            yield "write `otherwise stay` after it", ((node.span.end, node.span.end, " otherwise stay"),)


def _capped(d: Diagnostic, file: ast.File, source: Source) -> Iterator[Change]:
    del source
    assert isinstance(d, errors.FieldRange)
    for node in walk(file):
        if isinstance(node, ast.Field) and node.name.text == d.declared and isinstance(node.type, ast.Range) and not node.type.capped:
            end = node.type.span.end
            yield f"write `capped` after the range of `{d.declared}`", ((end, end, " capped"),)


def _as_size(d: Diagnostic, file: ast.File, source: Source) -> Iterator[Change]:
    assert isinstance(d, errors.ShapeParam)
    for node in walk(file):
        if isinstance(node, ast.Constant) and node.name.text == d.name and not node.is_size:
            start = node.span.start
            width = source.text[start:].index("param")
            yield f"write `size {d.name}`", ((start + width, start + width + len("param"), "size "),)


def _scheduled(d: Diagnostic, file: ast.File, source: Source) -> Iterator[Change]:
    del source
    assert isinstance(d, errors.PhaseNotScheduled)
    for section in file.game.sections:
        if isinstance(section, ast.Schedule):
            yield f"add `{d.name}` to the schedule", ((section.span.end, section.span.end, f" -> {d.name}"),)


def _ticking(d: Diagnostic, file: ast.File, source: Source) -> Iterator[Change]:
    del d, source
    for section in file.game.sections:
        if isinstance(section, ast.Schedule):
            start = section.turns[0].span.start
            yield "write `tick` first in the schedule", ((start, start, "tick -> "),)


def _declared_event(d: Diagnostic, file: ast.File, source: Source) -> Iterator[Change]:
    assert isinstance(d, errors.NoEvent)
    yield _in_block(ast.Metrics, "metrics", f"event {d.name}", f"write `event {d.name}` in `metrics`", file, source)


def _required(d: Diagnostic, file: ast.File, source: Source) -> Iterator[Change]:
    assert isinstance(d, errors.Crossed)
    test = f"require {d.low} <= {d.high}"
    yield _in_block(ast.Checks, "checks", test, f"write `{test}` in `checks`", file, source)


def _in_block(kind: type[ast.Metrics | ast.Checks], word: str, line: str, says: str, file: ast.File, source: Source) -> Change:
    """Returns a line put into the first block of its sort, or into a new one at the end of the game."""
    for section in file.game.sections:
        if isinstance(section, kind):
            end = source.text.index("{", section.span.start) + 1
            return says, ((end, end, f" {line} "),)
    end = file.game.span.end - 1
    return says, ((end, end, f"  {word} {{ {line} }}\n"),)


def _started(d: Diagnostic, file: ast.File, source: Source) -> Iterator[Change]:
    del source
    if isinstance(d, errors.NotSentAtStart):
        return
    end = file.game.span.end - 1
    for section in file.game.sections:
        if isinstance(section, ast.Kind):
            rule = f"phase start {{ each agent {{ send agent to {section.name.text} }} }}"
            yield f"write `{rule}`", ((end, end, f"  {rule}\n"),)


# ---- what makes no difference


def _left_out(d: Diagnostic, file: ast.File, source: Source) -> Iterator[Change]:
    """Takes away a declaration, with the comment behind it if nothing else is on its line."""
    for node in reversed(_within(file, d.span)):
        if isinstance(node, ast.Constant | ast.Define | ast.Shape | ast.Field | ast.Timer | ast.Event | ast.Movers | ast.Kind):
            yield "take it out", (_whole_lines(node.span, source),)
            return


def _whole_lines(span: Span, source: Source) -> Edit:
    text = source.text
    start, stop = text.rfind("\n", 0, span.start) + 1, text.find("\n", span.end)
    stop = len(text) if stop < 0 else stop + 1
    rest = text[span.end : stop].strip()
    if not text[start : span.start].strip() and (not rest or rest.startswith("#")):
        return (start, stop, "")
    behind = len(text[span.end : stop]) - len(text[span.end : stop].lstrip(" "))
    return (span.start, span.end + behind, "")


def _not_an_action(d: Diagnostic, file: ast.File, source: Source) -> Iterator[Change]:
    del source
    for node in walk(file):
        if isinstance(node, ast.Acts):
            names = [action.name.text for action in node.actions]
            at = next((i for i, action in enumerate(node.actions) if action.name.span == d.span), None)
            if at is not None and len(names) > 1:
                other = node.actions[at - 1] if at else node.actions[1]
                edit = (other.span.end, node.actions[at].span.end, "") if at else (node.actions[0].span.start, other.span.start, "")
                yield f"take `{names[at]}` out of `acts`", (edit,)


CHANGES: dict[type[Diagnostic], Callable[[Diagnostic, ast.File, Source], Iterator[Change]]] = {
    errors.CanBeNobody: _somebody,
    errors.EmptyMix: _not_empty,
    errors.NotChosen: _chosen,
    errors.ExtremeOfNothing: _if_none,
    errors.NoFreeCell: _stays,
    errors.NoWayFree: _stays,
    errors.FieldRange: _capped,
    errors.ShapeParam: _as_size,
    errors.PhaseNotScheduled: _scheduled,
    errors.NoTick: _ticking,
    errors.NoEvent: _declared_event,
    errors.Crossed: _required,
    errors.NoStart: _started,
    errors.Unused: _left_out,
    errors.NeverCounted: _left_out,
    errors.KindAbsent: _left_out,
    errors.IdleAction: _not_an_action,
}
REPAIRED = tuple(CHANGES)
