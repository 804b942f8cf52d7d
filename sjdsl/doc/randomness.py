"""Lists every random draw of a game: where it is made, for whom, and its possible outcomes."""

from collections.abc import Iterator

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import body_sort, phases_of
from sjdsl.doc.phrases import condition, members
from sjdsl.doc.statements import chosen, drawn, one_cell, paired, probability
from sjdsl.doc.vocabulary import Vocabulary
from sjdsl.doc.wording import code, table, variable

HEAD = ("phase", "drawn for", "draw")


def draws(v: Vocabulary) -> list[str]:
    """Returns the section on random draws."""
    rows = [
        (code(phase.label), "; ".join(around) or "the game, once", text)
        for phase in phases_of(v.game)
        for statement in phase.body
        for around, text in _draws(statement, (), v)
    ]
    return [*table(HEAD, rows), ""] if rows else ["Nothing in this game is random.", ""]


Found = Iterator[tuple[tuple[str, ...], str]]


def _draws(s: ir.Stmt, around: tuple[str, ...], v: Vocabulary) -> Found:
    match s:
        case ir.Chance():
            chain = [probability(b.test, v) for b in s.branches]
            yield around, "yes with " + ", else ".join(chain)
        case ir.Draw():
            yield around, f"{variable(s.name)}: {drawn(s, v)}"
        case ir.Pick():
            yield around, chosen(s, v)
        case ir.Match():
            yield around, f"random pairs, each of {paired(s, v)}"
        case ir.Move():
            if isinstance(s.course, ir.Wander):
                yield (*around, f"each {members(s.domain, v)}"), "which of the cells beside it that it may take: all equally likely"
            yield around, f"who enters a cell that several {s.domain.var.sort.plural} want: one of them, all equally likely"
        case ir.Shift():
            yield around, f"who enters a cell that several {body_sort(s.who).plural} are sent to: one of them, all equally likely"
            if s.facing is None:
                yield around, "which way it looks there: one of four, all equally likely"
        case ir.Send():
            if one_cell(s.domain) is None:
                yield around, f"which free {members(s.domain, v)} it is sent to: all equally likely"
            if s.facing is None:
                yield around, "which way it looks there: one of four, all equally likely"
    for inner, body in _inside(s, v):
        for statement in body:
            yield from _draws(statement, (*around, *inner), v)


def _inside(s: ir.Stmt, v: Vocabulary) -> Iterator[tuple[tuple[str, ...], tuple[ir.Stmt, ...]]]:
    """Yields the blocks of a statement with what each of them is about."""
    match s:
        case ir.Each():
            yield (f"each {members(s.domain, v)}",), s.body
        case ir.Pick():
            yield ("each one chosen",), s.body
            yield ("no one to choose",), s.otherwise
        case ir.First():
            yield (f"the nearest {members(s.domain, v)}",), s.body
        case ir.Match():
            yield ("each pair",), s.body
        case ir.When():
            for branch in s.branches:
                yield (f"if {condition(branch.test, v)}",), branch.body
            yield ("otherwise",), s.otherwise
        case ir.Chance():
            for branch in s.branches:
                yield (f"where this happened ({probability(branch.test, v)})",), branch.body
            yield ("where none of this happened",), s.otherwise
