"""Suggests repairs for a write conflict: small changes of the text, each tried before a message names it."""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise

from sjdsl.compiler import ast
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic, Fix, Suggestion
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.source import Source, Span

CONFLICTS = (errors.WriteConflict, errors.AddAndSet, errors.TwoDestinations)
MOST_NAMED = 3

Edit = tuple[int, int, str]
Change = tuple[str, tuple[Edit, ...]]  # how it is named, and its edits
Chain = list[tuple[ast.Block, int]]  # the blocks around a statement, outermost first, and which of its statements leads to it


class Way(Record):
    """A change and the text that it makes."""

    suggestion: Suggestion
    text: str


def ways_out(d: Diagnostic, game: Composition) -> Iterator[Way]:
    """Yields small changes of the text that could make the two writes of a conflict acceptable, the smallest first."""
    source = game.sources[game.file]
    for says, edits in _ways(d, source, game):
        yield way(says, edits, source)


def way(says: str, edits: tuple[Edit, ...], source: Source) -> Way:
    """Returns a change of a text. An edit: from, to, the text in its place."""
    return Way(Suggestion(says, tuple(Fix(source.span(start, end), new) for start, end, new in edits)), _edited(source.text, edits))


def accepted_ways(d: Diagnostic, found: Sequence[Diagnostic], tried: Iterable[tuple[Way, Sequence[Diagnostic]]]) -> list[Suggestion]:
    """Returns the first few changes that leave nothing wrong but what was found beside this message.

    `tried`: each change with what is wrong with its text; read only as far as needed.
    """
    before = Counter((e.code, e.message) for e in found if e.severity == "error" or e.code == d.code)
    before[d.code, d.message] -= 1
    named: list[Suggestion] = []
    for made, wrong in tried:
        left = Counter((e.code, e.message) for e in wrong if e.severity == "error" or e.code == d.code)
        if left <= before and all(made.suggestion.says != other.says for other in named):
            named.append(made.suggestion)
        if len(named) == MOST_NAMED:
            break
    return named


def _edited(text: str, edits: tuple[Edit, ...]) -> str:
    for start, end, new in sorted(edits, reverse=True):
        text = text[:start] + new + text[end:]
    return text


def _ways(d: Diagnostic, source: Source, game: Composition) -> Iterator[Change]:
    spans = [d.span, *(label.span for label in d.labels)]
    if any(span.file != source.name for span in spans):
        return
    phase = next((p for p in game.phases.values() if p.span.file == source.name and _contains(p.span, d.span)), None)
    if phase is None:
        return
    chains = sorted((_chain(phase.block, span) for span in spans), key=lambda c: [at for _, at in c])
    yield from _adding(chains, source)
    if len(chains) == 1:
        yield from _choosing(chains[0], source)
    elif chains[0] != chains[1]:
        yield from _excluding(chains[0], chains[1], source)
        yield from _separating(phase, chains[0], chains[1], source, game)


def _contains(around: Span, span: Span) -> bool:
    return around.start <= span.start and span.end <= around.end


def _chain(block: ast.Block, span: Span) -> Chain:
    for at, statement in enumerate(block.statements):
        if _contains(statement.span, span):
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


def _text(source: Source, span: Span) -> str:
    return " ".join(source.text[span.start : span.end].split())


def _head(source: Source, s: ast.Each | ast.When | ast.Chance) -> str:
    """Returns a statement up to its block."""
    return " ".join(source.text[s.span.start : s.block.span.start].split())


def _adding(chains: list[Chain], source: Source) -> Iterator[Change]:
    """`set x = x + e` becomes `add e to x`."""
    edits, says = [], ""
    for chain in chains:
        match _at(chain):
            case ast.Set(target=target, value=ast.Binary(op="+" | "-" as op, left=left, right=right)) as s:
                if _text(source, left.span) != _text(source, target.span):
                    return
                amount = _text(source, right.span)
                amount = amount if op == "+" else f"-{amount}" if isinstance(right, ast.Int | ast.Path) else f"-({amount})"
                says = f"add {amount} to {_text(source, target.span)}"
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
        domain, start = _text(source, s.domain.span), s.span.start
        if isinstance(s.domain.restriction, ast.Near):
            yield (f"write `first {domain}`, for the nearest alone", ((start, start + len("each"), "first"),))
        yield (f"write `pick 1 {domain}`, for one of them at random", ((start, start + len("each"), "pick 1"),))
    for outer, inner in pairwise(quantifiers):
        if outer.block.statements == (inner,):
            left, right = (_text(source, s.domain.span) for s in (outer, inner))
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
        otherwise = f"otherwise {{ {_text(source, first.span)} }}"
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
    who = [_without_where(s.domain, source) for s in (a, b)]
    if who[0] != who[1]:
        return
    tests = [None if s.domain.where is None else _text(source, s.domain.where.span) for s in (a, b)]
    bodies = [source.text[s.block.span.start : s.block.span.end] for s in (a, b)]
    then = "otherwise" if tests[1] is None else f"otherwise when {tests[1]}"
    says = f"write one statement, `each {who[0]} {{ when {tests[0]} {{ … }} {then} {{ … }} }}`"
    made = f"each {who[0]} {{ when {tests[0]} {bodies[0]} {then} {bodies[1]} }}"
    yield (says, ((a.span.start, a.span.end, made), (b.span.start, b.span.end, "")))


def _without_where(d: ast.Domain, source: Source) -> str:
    end = d.span.end if d.where is None else d.where.span.start
    return " ".join(source.text[d.span.start : end].split()).removesuffix(" where")


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
