"""Suggests fixes for write conflicts and other mistakes: small changes of the text, each tried before a message names it."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise

from sjdsl.compiler import ast
from sjdsl.compiler.ast.node import Node
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic, Fix, LazyFixes, Suggestion
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.syntax.parse import parse

CONFLICTS = (errors.WriteConflict, errors.AddAndSet, errors.TwoDestinations)
FIXED_BY_HINT = (  # what `hinted_changes` has changes for
    errors.CanBeNobody, errors.EmptyMix, errors.NotChosen, errors.ExtremeOfNothing, errors.NoFreeCell, errors.NoWayFree, errors.FieldRange,
    errors.ShapeParam, errors.PhaseNotScheduled, errors.NoTick, errors.NoEvent, errors.Crossed, errors.NoStart, errors.Unused,
    errors.NeverCounted, errors.KindAbsent, errors.IdleAction,
)  # fmt: skip
MOST_CONFLICTS = 5  # for which changes are tried, which are compiled
MOST_NAMED = 3

Edit = tuple[int, int, str]  # from, to, the text in its place
Change = tuple[str, tuple[Edit, ...]]  # how it is named, and its edits
Chain = list[tuple[ast.Block, int]]  # the blocks around a statement, outermost first, and which of its statements leads to it


def with_fixes(found: list[Diagnostic], game: Composition, check: Callable[[Source], Sequence[Diagnostic]]) -> list[Diagnostic]:
    """Returns the diagnostics with the small changes that are accepted, which are compiled once somebody asks.

    Conflicts of writes name theirs in their messages; others suggest theirs by their hints. `check`: what is wrong with a changed text.
    """
    source = game.sources[game.file]

    def accepted(d: Diagnostic, changes: Callable[[Diagnostic, Composition], Iterator[Change]]) -> list[Suggestion]:
        """Returns the first few changes that leave nothing wrong but what was found beside this message."""
        before = Counter((e.code, e.message) for e in found if e.severity == "error" or e.code == d.code)
        before[d.code, d.message] -= 1
        named: list[Suggestion] = []
        for says, edits in changes(d, game):
            text = source.text
            for start, end, new in sorted(edits, reverse=True):
                text = text[:start] + new + text[end:]
            left = Counter((e.code, e.message) for e in check(replace(source, text=text)) if e.severity == "error" or e.code == d.code)
            if left <= before and all(says != other.says for other in named):
                named.append(Suggestion(says, tuple(Fix(source.span(start, end), new) for start, end, new in edits)))
            if len(named) == MOST_NAMED:
                break
        return named

    changed: list[Diagnostic] = []
    conflicts, named = 0, set[tuple[str, ...]]()
    for d in found:
        if isinstance(d, errors.WriteConflict | errors.AddAndSet):
            field = (d.code, d.phase, d.name.rpartition(".")[2])
            if field in named:  # who mends the first conflict of a field often mends the others
                continue
            named.add(field)
        if isinstance(d, CONFLICTS) and conflicts < MOST_CONFLICTS:
            conflicts += 1
            changed.append(replace(d, accepted=LazyFixes(partial(accepted, d, conflict_changes))))
        elif isinstance(d, FIXED_BY_HINT) and d.span.file == game.file:
            changed.append(replace(d, repairs=LazyFixes(partial(accepted, d, hinted_changes))))
        else:
            changed.append(d)
    return changed


# ---- write conflicts


def conflict_changes(d: Diagnostic, game: Composition) -> Iterator[Change]:
    """Yields small changes of the text that could make the two writes of a conflict acceptable, the smallest first."""
    source = game.sources[game.file]
    spans = [d.span, *(label.span for label in d.labels)]
    if any(span.file != source.name for span in spans):
        return
    phase = next((p for p in game.phases.values() if p.span.file == source.name and _holds(p.span, d.span)), None)
    if phase is None:
        return
    chains = sorted((_chain(phase.block, span) for span in spans), key=lambda c: [at for _, at in c])
    yield from _adding(chains, source)
    if len(chains) == 1:
        yield from _choosing(chains[0], source)
    elif chains[0] != chains[1]:
        yield from _excluding(chains[0], chains[1], source)
        yield from _separating(phase, chains[0], chains[1], source, game)


def _holds(around: Span, span: Span) -> bool:
    return around.start <= span.start and span.end <= around.end


def _chain(block: ast.Block, span: Span) -> Chain:
    for at, statement in enumerate(block.statements):
        if _holds(statement.span, span):
            inner = next((found for b in _blocks(statement) if (found := _chain(b, span))), [])
            return [(block, at), *inner]
    return []


def _blocks(s: ast.Stmt | ast.Otherwise | None) -> Iterator[ast.Block]:
    match s:
        case ast.Block():
            yield s
        case ast.Each() | ast.Match():
            yield s.block
        case ast.Pick() | ast.First() | ast.When() | ast.Chance():
            yield s.block
            yield from _blocks(s.otherwise)


def _at(chain: Chain, level: int = -1) -> ast.Stmt:
    block, at = chain[level]
    return block.statements[at]


def _on_one_line(source: Source, start: int, end: int) -> str:
    return " ".join(source.text[start:end].split())


def _written(source: Source, node: Node) -> str:
    return _on_one_line(source, node.span.start, node.span.end)


def _head(source: Source, s: ast.Each | ast.When | ast.Chance) -> str:
    """Returns a statement up to its block."""
    return _on_one_line(source, s.span.start, s.block.span.start)


def _adding(chains: list[Chain], source: Source) -> Iterator[Change]:
    """`set x = x + e` becomes `add e to x`."""
    edits, says = [], ""
    for chain in chains:
        match _at(chain):
            case ast.Set(target=target, value=ast.Binary(op="+" | "-" as op, left=left, right=right)) as s:
                if _written(source, left) != _written(source, target):
                    return
                amount = _written(source, right)
                amount = amount if op == "+" else f"-{amount}" if isinstance(right, ast.Int | ast.Path) else f"-({amount})"
                says = f"add {amount} to {_written(source, target)}"
                edits.append((s.span.start, s.span.end, says))
            case ast.Add():
                pass
            case _:
                return
    if edits:
        yield (f"write `{says}`, and all that is added is summed", tuple(edits))


def _choosing(chain: Chain, source: Source) -> Iterator[Change]:
    """One of several members: the nearest, any, or pairs."""
    quantifiers = [s for level in range(len(chain)) if isinstance(s := _at(chain, level), ast.Each)]
    for s in reversed(quantifiers):
        domain, start = _written(source, s.domain), s.span.start
        if isinstance(s.domain.restriction, ast.Near):
            yield (f"write `first {domain}`, for the nearest alone", ((start, start + len("each"), "first"),))
        yield (f"write `pick 1 {domain}`, for one of them at random", ((start, start + len("each"), "pick 1"),))
    for outer, inner in pairwise(quantifiers):
        if outer.block.statements == (inner,):
            left, right = (_written(source, s.domain) for s in (outer, inner))
            block = source.text[inner.block.span.start : inner.block.span.end]
            says = f"write `match {left} with {right}`, for pairs in which nobody is twice"
            yield (says, ((outer.span.start, outer.span.end, f"match {left} with {right} {block}"),))


def _excluding(a: Chain, b: Chain, source: Source) -> Iterator[Change]:
    """Two statements of one block of which only one shall happen."""
    level = next((k for k, (x, y) in enumerate(zip(a, b, strict=False)) if x != y), None)
    if level is None or a[level][0] is not b[level][0]:
        return
    first, second = _at(a, level), _at(b, level)
    start, end = second.span.start, second.span.end
    beside = b[level][1] == a[level][1] + 1
    if isinstance(first, ast.When | ast.Chance) and beside and _is_open(first):
        if isinstance(second, type(first)):
            says = f"write `otherwise {_head(source, second)}` for the second, and only one of the two happens"
            yield (says, ((start, start, "otherwise "),))
        elif not isinstance(second, ast.Let | ast.Draw):
            says = "put the second behind the first as `otherwise { … }`, and only one of the two happens"
            yield (says, ((start, start, "otherwise { "), (end, end, " }")))
    elif isinstance(second, ast.When | ast.Chance) and isinstance(first, ast.Set | ast.Send | ast.Shift | ast.Remove) and _is_open(second):
        otherwise = f"otherwise {{ {_written(source, first)} }}"
        edits = ((first.span.start, first.span.end, ""), (end, end, f" {otherwise}"))
        yield (f"put the first behind the second, `{otherwise}`, and only one of the two happens", edits)
    if isinstance(first, ast.Each) and isinstance(second, ast.Each):
        yield from _merged(first, second, source)


def _is_open(s: ast.When | ast.Chance) -> bool:
    """Whether an `otherwise` can follow."""
    while isinstance(s.otherwise, ast.When | ast.Chance):
        s = s.otherwise
    return s.otherwise is None


def _merged(a: ast.Each, b: ast.Each, source: Source) -> Iterator[Change]:
    """Two statements about the same members become one whose branches exclude each other."""
    if a.domain.where is None:
        a, b = b, a
    if a.domain.where is None:
        return
    ends = [s.domain.span.end if s.domain.where is None else s.domain.where.span.start for s in (a, b)]
    who, other = (_on_one_line(source, s.domain.span.start, end).removesuffix(" where") for s, end in zip((a, b), ends, strict=True))
    if who != other:
        return
    tests = ["" if s.domain.where is None else _written(source, s.domain.where) for s in (a, b)]
    bodies = [source.text[s.block.span.start : s.block.span.end] for s in (a, b)]
    then = f"otherwise when {tests[1]}" if tests[1] else "otherwise"
    says = f"write one statement, `each {who} {{ when {tests[0]} {{ … }} {then} {{ … }} }}`"
    made = f"each {who} {{ when {tests[0]} {bodies[0]} {then} {bodies[1]} }}"
    yield (says, ((a.span.start, a.span.end, made), (b.span.start, b.span.end, "")))


def _separating(phase: ast.Phase, a: Chain, b: Chain, source: Source, game: Composition) -> Iterator[Change]:
    """The second statement in a phase of its own, behind the first."""
    level = next((k for k, (x, y) in enumerate(zip(a, b, strict=False)) if x != y), None)
    turns = [] if game.schedule is None else [t for t in game.schedule.turns if t.name.text == phase.name.text]
    if level is None or phase.parameters or len(turns) != 1 or turns[0].span.file != source.name:
        return
    around = [_at(b, k) for k in range(level)]
    if not all(isinstance(s, ast.Each) or (isinstance(s, ast.When) and s.otherwise is None) for s in around):
        return
    second, name = _at(b, level), f"{phase.name.text}_after"
    opening = "".join(f"{_head(source, s)} {{ " for s in around)  # type: ignore[arg-type]
    body = opening + source.text[second.span.start : second.span.end] + " }" * len(around)
    edits = (
        (second.span.start, second.span.end, ""),
        (phase.span.end, phase.span.end, f"\nphase {name} {{ {body} }}"),
        (turns[0].span.end, turns[0].span.end, f" -> {name}"),
    )
    yield (f"put the second into a phase of its own, `schedule … {phase.name.text} -> {name}`", edits)


# ---- other mistakes


def hinted_changes(d: Diagnostic, game: Composition) -> Iterator[Change]:
    """Yields the changes of the game's own text that a message's hint speaks of."""
    source = game.sources[game.file]
    file = parse(source)
    around = [n for n in walk(file) if _holds(n.span, d.span)][::-1]  # the nodes around the mistake, the innermost first
    schedules = [section for section in file.game.sections if isinstance(section, ast.Schedule)]
    match d:
        case errors.CanBeNowhere():
            yield from _guarded(f"{d.path} is not nowhere", d.span, around)
        case errors.CanBeNobody():
            yield from _guarded(f"{d.path} is not nobody", d.span, around)
        case errors.EmptyMix():
            yield from _guarded(f"sum({d.row}) > 0", d.span, around)
        case errors.NotChosen():
            yield from _guarded(f"{d.agent} chose {d.action}", d.span, around)
        case errors.ExtremeOfNothing():
            bracket = source.text.rfind(")", d.span.start, d.span.end)
            yield "write `otherwise 0` for a domain without members", _at_place(bracket, " otherwise 0")
            yield from _guarded(f"count({d.domain}) > 0", d.span, around)
        case errors.NoFreeCell() | errors.NoWayFree():
            for node in around:
                if isinstance(node, ast.Send | ast.Shift) and node.stay is None:
                    yield "write `otherwise stay` after it", _at_place(node.span.end, " otherwise stay")
        case errors.FieldRange():
            for node in walk(file):
                if (
                    isinstance(node, ast.Field)
                    and node.name.text == d.declared
                    and isinstance(node.type, ast.Range)
                    and not node.type.capped
                ):
                    yield f"write `capped` after the range of `{d.declared}`", _at_place(node.type.span.end, " capped")
        case errors.ShapeParam():
            for node in walk(file):
                if isinstance(node, ast.Constant) and node.name.text == d.name and not node.is_size:
                    start = source.text.index("param", node.span.start)
                    yield f"write `size {d.name}`", ((start, start + len("param"), "size "),)
        case errors.PhaseNotScheduled():
            yield from ((f"add `{d.name}` to the schedule", _at_place(s.span.end, f" -> {d.name}")) for s in schedules)
        case errors.NoTick():
            yield from (("write `tick` first in the schedule", _at_place(s.turns[0].span.start, "tick -> ")) for s in schedules)
        case errors.NoEvent():
            line = f"event {d.name}"
            yield f"write `{line}` in `metrics`", _added_to_block(ast.Metrics, line, file, source)
        case errors.Crossed():
            line = f"require {d.low} <= {d.high}"
            yield f"write `{line}` in `checks`", _added_to_block(ast.Checks, line, file, source)
        case errors.NotSentAtStart():
            pass
        case errors.NoStart():
            for section in file.game.sections:
                if isinstance(section, ast.Kind):
                    rule = f"phase start {{ each agent {{ send agent to {section.name.text} }} }}"
                    yield f"write `{rule}`", _at_place(file.game.span.end - 1, f"  {rule}\n")
        case errors.Unused() | errors.NeverCounted() | errors.KindAbsent():
            declared = ast.Constant | ast.Define | ast.Shape | ast.Field | ast.Timer | ast.Event | ast.Movers | ast.Kind
            taken = next((node for node in around if isinstance(node, declared)), None)
            if taken is not None:
                yield "take it out", (_whole_lines(taken.span, source),)
        case errors.IdleAction():
            for acts in (node for node in walk(file) if isinstance(node, ast.Acts)):
                at = next((i for i, action in enumerate(acts.actions) if action.name.span == d.span), None)
                if at is not None and len(acts.actions) > 1:
                    it, other = acts.actions[at].span, acts.actions[at - 1 if at else 1].span
                    yield f"take `{d.name}` out of `acts`", ((other.end, it.end, "") if at else (it.start, other.start, ""),)


def _at_place(place: int, new: str) -> tuple[Edit, ...]:
    return ((place, place, new),)


def _guarded(test: str, span: Span, around: list[Node]) -> Iterator[Change]:
    """Yields where a condition can stand that makes sure of something: in the `where` or `when` around, or as a `when` of its own."""
    says = f"guard it with `{test}`"
    for node in around:
        match node:
            case ast.Domain(where=Node() as condition) | ast.When(condition=condition) if _holds(condition.span, span):
                yield says, _at_place(condition.span.start, f"{test} and ")
    for node in around:
        if isinstance(node, ast.Domain) and node.where is not None and node.where.span.end <= span.start:
            yield says, _at_place(node.where.span.end, f" and {test}")
        if isinstance(node, ast.Stmt) and not isinstance(node, ast.Let | ast.Draw):
            yield says, ((node.span.start, node.span.start, f"when {test} {{ "), (node.span.end, node.span.end, " }"))


def _added_to_block(kind: type[ast.Metrics | ast.Checks], line: str, file: ast.File, source: Source) -> tuple[Edit, ...]:
    """Returns a line put into the first block of its sort, or into a new one at the end of the game."""
    for section in file.game.sections:
        if isinstance(section, kind):
            return _at_place(source.text.index("{", section.span.start) + 1, f" {line} ")
    return _at_place(file.game.span.end - 1, f"  {kind.__name__.lower()} {{ {line} }}\n")


def _whole_lines(span: Span, source: Source) -> Edit:
    """Takes a declaration away, with the comment behind it if nothing else is on its line."""
    text = source.text
    start, stop = text.rfind("\n", 0, span.start) + 1, text.find("\n", span.end)
    stop = len(text) if stop < 0 else stop + 1
    rest = text[span.end : stop].strip()
    if not text[start : span.start].strip() and (not rest or rest.startswith("#")):
        return (start, stop, "")
    behind = len(text[span.end : stop]) - len(text[span.end : stop].lstrip(" "))
    return (span.start, span.end + behind, "")
