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
from sjdsl.compiler.elaborate.world_map import check_glyph
from sjdsl.compiler.ir.implications import narrow_word
from sjdsl.compiler.ir.types import words
from sjdsl.runtime.actions import HEADINGS

POSES = "^>v<"  # how agents are drawn


def declare_movers(game: Composition, scope: Scope) -> None:
    """Adds the sorts of movers to the tables. Each has a field `heading`, which rules may set as any other."""
    static = scope.static
    for declared in game.movers.values():
        name = declared.name.text
        with scope.problems.survive(static.broken, Symbol("name", name)):
            sort = ir.Sort("mover", (name,))
            heading = ir.VarField(name="heading", held_by=sort, type=words(HEADINGS), start="north", origin=declared.name.span)
            fields = {"heading": heading} | fields_of(declared.attributes, scope, sort)
            _check_glyph(declared, scope)
            number = _number(declared, scope)
            static.movers[name] = ir.Movers(
                name=name, number=number, glyph=declared.glyph.text, fields=tuple(fields.values()), origin=declared.span
            )


def _number(declared: ast.Movers, scope: Scope) -> int:
    what = f"the number of movers `{declared.name.text}`"
    value = scope.fixed(declared.number, what)
    if value != int(value) or not 1 <= value <= limits.MAX_MOVERS:
        raise scope.problems.fail(errors.OutOfLimits(declared.number.span, name=what, value=value, low=1, high=limits.MAX_MOVERS))
    return int(value)


def _check_glyph(declared: ast.Movers, scope: Scope) -> None:
    glyph, static = declared.glyph.text, scope.static
    problem = check_glyph(glyph)
    taken = {meaning.glyph: meaning.kind for _, meaning in static.glyphs} | {sort.glyph: name for name, sort in static.movers.items()}
    if problem or glyph in POSES:
        problem = problem or "agents are drawn with it"
        scope.problems.add(errors.BadGlyph(declared.glyph.span, glyph=glyph.encode("unicode_escape").decode(), problem=problem))
    elif glyph in taken:
        scope.problems.add(errors.GlyphTwice(declared.glyph.span, glyph=glyph, first=taken[glyph], second=declared.name.text))


def move(s: ast.Move, scope: Scope, use: PhaseUse) -> ir.Stmt:
    """Returns `move each agent`, or `move each SORT` with the way that movers go."""
    members, inner = domain(s.domain, scope)
    name, var = s.domain.kind.text, members.var
    if var.sort.what == "cell":
        wanted = "`agent`, or a sort of movers" if scope.static.movers else "`agent`"
        raise scope.problems.fail(errors.WrongSort(s.domain.kind.span, name=name, what="a kind of cell", wanted=wanted))
    text = use.streams.header(s.span, s.span.end)
    course = None
    if var.sort.what == "agent" and s.course is not None:
        help_ = "which way agents go, they choose: write `move each agent`"
        raise scope.problems.fail(errors.WrongType(s.course.span, wanted="no way to go", given="one", help=help_))
    if var.sort.what == "mover":
        if s.course is None:
            help_ = f"write `move each {name} ahead`, or `at random`, `along h`, `toward D`, `away from D`"
            raise scope.problems.fail(errors.WrongType(s.span, wanted="the way that movers go", given="none", help=help_))
        course = _course(s.course, var, inner, use.streams.of_statement(f"{text}\nwhich way"))
    return ir.Move(domain=members, course=course, stream=use.streams.of_statement(text), origin=s.span)


def _course(c: ast.Course, var: ir.Member, scope: Scope, stream: int) -> ir.Wander | ir.Along:
    match c:
        case ast.Toward() | ast.AwayFrom():
            goal, _ = domain(c.domain, scope)
            away = isinstance(c, ast.AwayFrom)
            return ir.Wander(goal=goal, away=away, avoided=_avoided(c.avoided, scope), stream=stream, origin=c.span)
        case ast.AtRandom():
            return ir.Wander(avoided=_avoided(c.avoided, scope), stream=stream, origin=c.span)
        case ast.Ahead():
            own = ir.FieldRead(type=words(HEADINGS), owner=var, held_by=var.sort, name="heading", origin=c.span)
            return ir.Along(heading=own, origin=c.span)
        case ast.Along():
            heading = narrow_word(scope.expression(c.heading), scope.facts)
            if heading.type.kind != "word" or heading.type.by or not set(heading.type.words) <= set(HEADINGS):
                raise wrong_type(scope, c.heading, "a heading (`north`, `east`, `south` or `west`)", heading.type)
            return ir.Along(heading=heading, origin=c.span)
        case _:
            assert_never(c)


def _avoided(avoided: ast.Domain | None, scope: Scope) -> ir.Domain | None:
    return None if avoided is None else domain(avoided, scope)[0]
