"""Elaborates movers: their declarations and fields, and the courses by which they go."""

from typing import assert_never

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.domains import domain
from sjdsl.compiler.elaborate.fields import fields_of
from sjdsl.compiler.elaborate.lookup import is_member
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.elaborate.streams import Streams
from sjdsl.compiler.elaborate.world_map import POSES, check_glyph
from sjdsl.compiler.ir.types import words
from sjdsl.runtime.actions import HEADINGS


def declare_movers(game: Composition, scope: Scope) -> None:
    """Adds the movers to the tables, each with a field `heading`, which rules may set."""
    for declared in game.movers.values():
        name = declared.name.text
        with scope.problems.skip_if_broken(scope.static.broken, Symbol("name", name)):
            entity_type = ir.EntityType("mover", (name,))
            heading = ir.VarField(
                name="heading",
                held_by=entity_type,
                type=words(HEADINGS),
                start="north",
                origin=declared.name.span,
            )
            fields = {"heading": heading} | fields_of(declared.attributes, scope, entity_type)
            _check_mover_glyph(declared, scope)
            quantity = f"the number of movers `{name}`"
            number = scope.whole(declared.number, quantity, quantity, 1, limits.MAX_MOVERS)
            scope.static.movers[name] = ir.Movers(
                name=name,
                number=number,
                glyph=declared.glyph.text,
                fields=tuple(fields.values()),
                origin=declared.span,
            )


def _check_mover_glyph(declared: ast.Movers, scope: Scope) -> None:
    """Reports a glyph that can't be one, or that something else has."""
    static = scope.static
    glyph = declared.glyph.text
    owners = {meaning.glyph: meaning.kind for _, meaning in static.glyphs}
    owners |= {movers.glyph: other for other, movers in static.movers.items()}
    problem = check_glyph(glyph)
    if glyph in POSES:
        problem = problem or "agents are drawn with it"
    if problem:
        shown = glyph.encode("unicode_escape").decode()
        scope.problems.add(errors.BadGlyph(declared.glyph.span, glyph=shown, problem=problem))
    elif glyph in owners:
        name = declared.name.text
        scope.problems.add(
            errors.GlyphTwice(declared.glyph.span, glyph=glyph, first=owners[glyph], second=name)
        )


def heading_of(who: ir.Expr, span: Span) -> ir.Expr:
    """Returns the heading of an agent, or of a mover, which has it as a field."""
    type_ = words(HEADINGS)
    if is_member(who, "mover"):
        return ir.FieldRead(
            type=type_, owner=who, held_by=who.entity_type, name="heading", origin=span
        )
    return ir.Attribute(type=type_, owner=who, name="heading", origin=span)


def check_heading(heading: ir.Expr, tree: ast.Expr, wanted: str, scope: Scope) -> None:
    """Reports a value that isn't a heading. wanted: what the message asks for."""
    type_ = heading.type
    if not type_.is_single("word") or not set(type_.words) <= set(HEADINGS):
        raise wrong_type(scope, tree, wanted, type_)


def move(s: ast.Move, scope: Scope, streams: Streams) -> ir.Stmt:
    """Returns `move each agent`, or `move each MOVER` with a course."""
    members, inner = domain(s.domain, scope)
    name = s.domain.kind.text
    var = members.var
    if var.entity_type.what == "cell":
        wanted = "`agent`, or a sort of movers" if scope.static.movers else "`agent`"
        raise scope.misused(s.domain.kind, "a kind of cell", wanted)
    if var.entity_type.what == "agent" and s.course is not None:
        help_ = "agents choose their direction: write `move each agent`"
        raise scope.expected(s.course.span, "nothing after the agents", "a course", help_)
    header = streams.header(s.span)
    course = None
    if var.entity_type.what == "mover":
        if s.course is None:
            help_ = (
                f"write `move each {name} ahead`, "
                "or `at random`, `along h`, `toward D`, `away from D`"
            )
            raise scope.expected(s.span, "the course of the movers", "none", help_)
        course = _course(s.course, var, inner, streams.of_statement(f"{header}\nwhich way"))
    return ir.Move(
        domain=members, course=course, stream=streams.of_statement(header), origin=s.span
    )


def _course(c: ast.Course, var: ir.Member, scope: Scope, stream: int) -> ir.Wander | ir.Along:
    """Returns the way that a mover goes."""

    def optional(d: ast.Domain | None) -> ir.Domain | None:
        if d is None:
            return None
        typed, _ = domain(d, scope)
        return typed

    match c:
        case ast.Toward() | ast.AwayFrom():
            return ir.Wander(
                goal=optional(c.domain),
                away=isinstance(c, ast.AwayFrom),
                avoided=optional(c.avoided),
                stream=stream,
                origin=c.span,
            )
        case ast.AtRandom():
            return ir.Wander(avoided=optional(c.avoided), stream=stream, origin=c.span)
        case ast.Ahead():
            return ir.Along(heading=heading_of(var, c.span), origin=c.span)
        case ast.Along():
            heading = scope.narrowed(c.heading)
            wanted = "a heading (`north`, `east`, `south` or `west`)"
            check_heading(heading, c.heading, wanted, scope)
            return ir.Along(heading=heading, origin=c.span)
        case _:
            assert_never(c)
