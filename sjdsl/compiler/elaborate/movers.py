"""Elaborates movers: the sorts of them, their fields, and the way they go."""

from typing import assert_never

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.elaborate.domains import domain
from sjdsl.compiler.elaborate.fields import fields_of
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.elaborate.streams import PhaseUse
from sjdsl.compiler.elaborate.world_map import POSES, check_glyph
from sjdsl.compiler.ir.implications import narrow_word
from sjdsl.compiler.ir.types import words
from sjdsl.runtime.actions import HEADINGS


def declare_movers(game: Composition, scope: Scope) -> None:
    """Adds the sorts of movers to the tables. Each has a field `heading`, which rules may set as any other."""
    static = scope.static
    for declared in game.movers.values():
        name = declared.name.text
        with scope.problems.survive(static.broken, Symbol("name", name)):
            sort = ir.Sort("mover", (name,))
            heading = ir.VarField(
                name="heading",
                held_by=sort,
                type=words(HEADINGS),
                start="north",
                origin=declared.name.span,
            )
            fields = {"heading": heading} | fields_of(declared.attributes, scope, sort)
            problem, glyph = check_glyph(declared.glyph.text), declared.glyph.text
            taken = {meaning.glyph: meaning.kind for _, meaning in static.glyphs} | {
                m.glyph: other for other, m in static.movers.items()
            }
            if problem or glyph in POSES:
                problem, shown = (
                    problem or "agents are drawn with it",
                    glyph.encode("unicode_escape").decode(),
                )
                scope.problems.add(
                    errors.BadGlyph(declared.glyph.span, glyph=shown, problem=problem)
                )
            elif glyph in taken:
                scope.problems.add(
                    errors.GlyphTwice(
                        declared.glyph.span, glyph=glyph, first=taken[glyph], second=name
                    )
                )
            what = f"the number of movers `{name}`"
            number = scope.whole(declared.number, what, what, 1, limits.MAX_MOVERS)
            static.movers[name] = ir.Movers(
                name=name,
                number=number,
                glyph=glyph,
                fields=tuple(fields.values()),
                origin=declared.span,
            )


def check_heading(heading: ir.Expr, tree: ast.Expr, wanted: str, scope: Scope) -> None:
    """Reports a value that isn't a heading. `wanted`: what the message asks for."""
    if (
        heading.type.kind != "word"
        or heading.type.by
        or not set(heading.type.words) <= set(HEADINGS)
    ):
        raise wrong_type(scope, tree, wanted, heading.type)


def move(s: ast.Move, scope: Scope, use: PhaseUse) -> ir.Stmt:
    """Returns `move each agent`, or `move each SORT` with the way that movers go."""
    members, inner = domain(s.domain, scope)
    name, var = s.domain.kind.text, members.var
    if var.sort.what == "cell":
        wanted = "`agent`, or a sort of movers" if scope.static.movers else "`agent`"
        raise scope.fail(
            errors.WrongSort(s.domain.kind.span, name=name, actual="a kind of cell", wanted=wanted)
        )
    text = use.streams.header(s.span, s.span.end)
    course = None
    if var.sort.what == "agent" and s.course is not None:
        help_ = "which way agents go, they choose: write `move each agent`"
        raise scope.expected(s.course.span, "no way to go", "one", help_)
    if var.sort.what == "mover":
        if s.course is None:
            help_ = f"write `move each {name} ahead`, or `at random`, `along h`, `toward D`, `away from D`"
            raise scope.expected(s.span, "the way that movers go", "none", help_)
        course = _course(s.course, var, inner, use.streams.of_statement(f"{text}\nwhich way"))
    return ir.Move(
        domain=members, course=course, stream=use.streams.of_statement(text), origin=s.span
    )


def _course(c: ast.Course, var: ir.Member, scope: Scope, stream: int) -> ir.Wander | ir.Along:
    def one(d: ast.Domain | None) -> ir.Domain | None:
        return None if d is None else domain(d, scope)[0]

    match c:
        case ast.Toward() | ast.AwayFrom():
            away = isinstance(c, ast.AwayFrom)
            return ir.Wander(
                goal=one(c.domain), away=away, avoided=one(c.avoided), stream=stream, origin=c.span
            )
        case ast.AtRandom():
            return ir.Wander(avoided=one(c.avoided), stream=stream, origin=c.span)
        case ast.Ahead():
            own = ir.FieldRead(
                type=words(HEADINGS), owner=var, held_by=var.sort, name="heading", origin=c.span
            )
            return ir.Along(heading=own, origin=c.span)
        case ast.Along():
            heading = narrow_word(scope.expression(c.heading), scope.facts)
            check_heading(
                heading, c.heading, "a heading (`north`, `east`, `south` or `west`)", scope
            )
            return ir.Along(heading=heading, origin=c.span)
        case _:
            assert_never(c)
