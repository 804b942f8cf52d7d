"""Elaborates statements: from AST to typed IR."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from typing import assert_never

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.diagnostic import near
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.elaborate.assignments import add, set_
from sjdsl.compiler.elaborate.declaration_labels import parameters_read
from sjdsl.compiler.elaborate.domains import domain, with_member
from sjdsl.compiler.elaborate.domains import near as near_shape
from sjdsl.compiler.elaborate.effects import body, give, send, shift, tally
from sjdsl.compiler.elaborate.lookup import check_free
from sjdsl.compiler.elaborate.movers import move
from sjdsl.compiler.elaborate.possible import check_possible, warn_never
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.elaborate.streams import PhaseUse
from sjdsl.compiler.ir.equivalence import form
from sjdsl.compiler.ir.implications import compares, narrow_word, narrowed
from sjdsl.compiler.ir.printer import expression as text
from sjdsl.compiler.ir.types import INTEGER_UNITS, integer, is_number, join_units, real, words


def block(b: ast.Block, scope: Scope, use: PhaseUse) -> tuple[ir.Stmt, ...]:
    """Returns the statements of a block; `let` and `draw` bind to its end."""
    built: list[ir.Stmt] = []
    for statement in b.statements:
        try:
            typed, scope = stmt(statement, scope, use)
            built.append(typed)
        except Poisoned:
            if isinstance(statement, ast.Let | ast.Draw):
                scope = scope.bind_named(statement.name, None)
    return tuple(built)


def stmt(s: ast.Stmt, scope: Scope, use: PhaseUse) -> tuple[ir.Stmt, Scope]:
    """Returns one statement and the scope after it."""
    match s:
        case ast.Let():
            value = narrow_word(scope.expression(s.value), scope.facts)
            check_free(s.name, scope, chosen=True)
            if isinstance(value, ir.Member):
                raise wrong_type(
                    scope, s.value, "a value", value.type, "the variable has a name already"
                )
            local = ir.Local(type=value.type, name=s.name.text, origin=s.name.span)
            inner = scope.bind_named(s.name, local)
            if isinstance(value, ir.ArgumentOf) and value.type.kind == "agent":  # always somebody
                inner = inner.knowing([ir.Not(value=ir.Same(left=local, right=ir.Nobody()))])
            return ir.Let(name=s.name.text, value=value, origin=s.span), inner
        case ast.Draw():
            return draw(s, scope, use)
        case ast.Each() | ast.Pick() | ast.First():
            return quantifier(s, scope, use), scope
        case ast.Match():
            return match_(s, scope, use), scope
        case ast.When() | ast.Chance():
            return branched(s, scope, use), scope
        case ast.Set():
            return set_(s, scope, use), scope
        case ast.Add():
            return add(s, scope), scope
        case ast.Give():
            return give(s, scope), scope
        case ast.Tally():
            return tally(s, scope), scope
        case ast.Send():
            return send(s, scope, use), scope
        case ast.Shift():
            return shift(s, scope, use), scope
        case ast.Remove():
            return ir.Remove(who=body(s.who, scope), origin=s.span), scope
        case ast.Move():
            return move(s, scope, use), scope
        case ast.Mark():
            place = near_shape(s.shape, s.anchor, scope)
            return ir.Mark(shape=place.shape, anchor=place.anchor, origin=s.span), scope
        case ast.End():
            return ir.End(origin=s.span), scope
        case _:
            assert_never(s)


def inside(b: ast.Block, header: str, scope: Scope, use: PhaseUse) -> tuple[ir.Stmt, ...]:
    """Returns a block inside a statement; the statement's text becomes part of the inner streams' names."""
    use.streams.around.append(header)
    built = block(b, scope, use)
    use.streams.around.pop()
    return built


def draw(s: ast.Draw, scope: Scope, use: PhaseUse) -> tuple[ir.Stmt, Scope]:
    check_free(s.name, scope, chosen=True)
    stream = use.streams.of_statement(use.streams.header(s.span, s.span.end))
    name = s.name.text
    match s.source:
        case ast.Words():
            _check_declared(s.source.names, scope)
            names = tuple(n.text for n in s.source.names)
            statement = ir.Draw(
                name=name, type=words(names), words=names, stream=stream, origin=s.span
            )
        case ast.Table():
            statement = _weighted(s, s.source, scope, stream)
        case _:
            assert s.high is not None
            low, high = scope.expressions((s.source, s.high))
            if "real" not in (low.type.kind, high.type.kind):
                low, high = (
                    scope.number(e, ("count", "steps", "cells"), "a whole number")
                    for e in (s.source, s.high)
                )
            type_ = _draw_range(s, low, high, scope)
            statement = ir.Draw(
                name=name, type=type_, low=low, high=high, stream=stream, origin=s.span
            )
    local = ir.Local(type=statement.type, name=name, origin=s.name.span)
    return statement, scope.bind_named(s.name, local)


def _check_declared(names: Sequence[ast.Name], scope: Scope) -> None:
    _check_different(names, "word", scope)
    for name in names:
        if not name.text.isidentifier():
            help_ = "one `draw` has words alone, `{ red: 0.5, blue: 0.5 }`, or whole numbers alone, each for itself, `{ 1: 0.5, 3: 0.5 }`"
            raise scope.expected(name.span, "a word", f"`{name.text}`", help_)
        if not scope.static.is_word(name.text):
            meant = near(name.text, [w for ws in scope.static.word_sets for w in ws])
            declare = f"declare some, `field NAME : {{ {', '.join(n.text for n in names)} }} = {names[0].text}`"
            how = (
                ""
                if meant.nearest
                else f"the words of a `draw` are those of a field, a row (`by`) or an event: {declare}"
            )
            raise scope.fail(errors.UnknownName(name.span, name=name.text, near=meant, help=how))
        scope.static.refer(name, Symbol("word", name.text))


def _check_different(names: Sequence[ast.Name], what: str, scope: Scope) -> None:
    for i, name in enumerate(names):
        if name.text in [n.text for n in names[:i]]:
            raise scope.fail(errors.WrittenTwice(name.span, part=f"the {what} `{name.text}`"))


def _draw_range(s: ast.Draw, low: ir.Expr, high: ir.Expr, scope: Scope) -> ir.Type:
    """Returns the type of a number drawn between two others."""
    unit = low.type.unit if low.type.unit != "number" else high.type.unit
    if "number" not in (low.type.unit, high.type.unit) and low.type.unit != high.type.unit:
        raise scope.fail(
            errors.UnitMismatch(
                s.span, verb="draw between", left=low.type.unit, right=high.type.unit
            )
        )
    known = scope.facts_and_requires
    if low.type.high > high.type.low and not (
        compares(high, ">=", low, known) or compares(high, ">", low, known)
    ):
        raise scope.fail(
            errors.Crossed(
                s.span,
                labels=parameters_read(scope.static, low, high),
                low=text(low),
                high=text(high),
            )
        )
    if "real" in (low.type.kind, high.type.kind):
        for tree, bound in ((s.source, low), (s.high, high)):
            if not is_number(bound.type):
                raise wrong_type(scope, tree, "a number", bound.type)  # type: ignore[arg-type]
        joined = join_units(low.type.unit, high.type.unit)
        return real(
            low.type.low, high.type.high, "number" if joined in (None, *INTEGER_UNITS) else joined
        )
    most = high.type.high - low.type.low + 1
    if most > limits.MAX_DRAWN:
        problem = (
            f"this draw is from {f'{most:g}' if most < float('inf') else 'endlessly many'} numbers"
        )
        raise scope.fail(
            limits.too_much(
                problem, limits.MAX_DRAWN, s.span, "give the parameters limits, `in a .. b`"
            )
        )
    return integer(low.type.low, high.type.high, unit)


def _weighted(s: ast.Draw, table: ast.Table, scope: Scope, stream: int) -> ir.Draw:
    keys = tuple(e.key for e in table.entries)
    are_numbers = all(key.text.isdigit() for key in keys)
    if are_numbers:
        _check_different(
            tuple(ast.Name(key.span, str(int(key.text))) for key in keys), "number", scope
        )
    else:
        _check_declared(keys, scope)
    weights = []
    for entry in table.entries:
        if isinstance(entry.value, ast.Table):
            raise scope.expected(entry.span, "a probability", "a table")
        weights.append(probability(entry.value, scope))
    values = [w.value for w in weights if isinstance(w, ir.Number)]
    if len(values) == len(weights):
        total = sum(values)
        if abs(total - 1) > 1e-6:
            raise scope.fail(errors.Weights(table.span, total=total))
    else:  # weights from parameters need `require a + b + c == 1`, or the form p, q, 1 - p - q
        one = ir.Number(type=weights[0].type, value=1)
        rest: ir.Expr = one
        for weight in weights[:-1]:
            rest = ir.Arithmetic(type=one.type, fn="-", args=(rest, weight))
        sum_ = weights[0]
        for weight in weights[1:]:
            sum_ = ir.Arithmetic(type=one.type, fn="+", args=(sum_, weight))
        if form(weights[-1]) != form(rest) and not compares(
            sum_, "==", one, scope.facts_and_requires
        ):
            raise scope.fail(errors.Weights(table.span, total="something known only when it runs"))
    if are_numbers:
        numbers = tuple(int(key.text) for key in keys)
        type_ = integer(min(numbers), max(numbers), "number")
        return ir.Draw(
            name=s.name.text,
            type=type_,
            numbers=numbers,
            weights=tuple(weights),
            stream=stream,
            origin=s.span,
        )
    names = tuple(key.text for key in keys)
    return ir.Draw(
        name=s.name.text,
        type=words(names),
        words=names,
        weights=tuple(weights),
        stream=stream,
        origin=s.span,
    )


def quantifier(s: ast.Each | ast.Pick | ast.First, scope: Scope, use: PhaseUse) -> ir.Stmt:
    header = use.streams.header(s.span, s.block.span.start)
    how_many = scope.number(s.number, ("count",), "a count") if isinstance(s, ast.Pick) else None
    if isinstance(s, ast.Pick) and how_many is not None and how_many.type.low < 0:
        raise scope.fail(errors.Negative(s.number.span, name="the number picked"))
    is_literal = how_many is not None and how_many.type.unit == "number"  # a size may be another
    if isinstance(s, ast.Pick) and how_many is not None and is_literal and how_many.type.high <= 0:
        warn_never(s.number.span, "none is picked", scope)
    built, inner = _domain(s.domain, scope)
    if built is None:
        inside(s.block, header, inner, use)
        raise Poisoned
    stream = use.streams.of_statement(header)
    if isinstance(s, ast.First) and not isinstance(built.restriction, ir.Near):
        raise scope.expected(
            s.domain.span, "`in SHAPE of x` after `first`", "a domain without a shape"
        )
    body = inside(s.block, header, inner, use)
    match s:
        case ast.Each():
            return ir.Each(domain=built, body=body, origin=s.span)
        case ast.First():
            return ir.First(domain=built, body=body, origin=s.span)
        case ast.Pick():
            assert how_many is not None
            otherwise = () if s.otherwise is None else other_branch(s.otherwise, header, scope, use)
            most = int(min(max(how_many.type.high, 0), limits.MAX_DRAWN))
            return ir.Pick(
                number=how_many,
                most=most,
                domain=built,
                body=body,
                otherwise=otherwise,
                stream=stream,
                origin=s.span,
            )


def _domain(d: ast.Domain, scope: Scope) -> tuple[ir.Domain | None, Scope]:
    """Returns a domain and the scope inside it. Of one that is wrong only the scope: what is inside is read for its own mistakes."""
    try:
        return domain(d, scope)
    except Poisoned:
        kinds = [d.kind.text] + ([] if d.on is None else [d.on.kind.text])
        if not all(
            k == "agent" or k in scope.static.movers or scope.static.kinds_of(k) for k in kinds
        ):
            raise  # a misspelt kind would make every use of its variable one more mistake
        if d.where is not None:
            scope = scope.after_unreadable_guard()
            with suppress(Poisoned):
                return None, domain(replace(d, where=None), scope)[1]
        inner = with_member(d.bind, d.kind, None, scope)
        return None, inner if d.on is None else with_member(d.on.bind, d.on.kind, None, inner)


def other_branch(b: ast.Otherwise, header: str, scope: Scope, use: PhaseUse) -> tuple[ir.Stmt, ...]:
    """Returns what happens otherwise: a block, or one more `when` or `chance`."""
    header = f"{header} otherwise"
    if isinstance(b, ast.Block):
        return inside(b, header, scope, use)
    use.streams.around.append(header)
    statement = branched(b, scope, use)
    use.streams.around.pop()
    return (statement,)


def match_(s: ast.Match, scope: Scope, use: PhaseUse) -> ir.Stmt:
    header = use.streams.header(s.span, s.block.span.start)
    stream = use.streams.of_statement(header)
    left, inner = _domain(s.left, scope)
    right, inner = _domain(s.right, inner)
    if left is None or right is None:
        inside(s.block, header, inner, use)
        raise Poisoned
    if s.first and not isinstance(right.restriction, ir.Near):
        wanted, given = "`in SHAPE of x` after `with first`", "a domain without a shape"
        raise scope.expected(s.right.span, wanted, given)
    body = inside(s.block, header, inner, use)
    return ir.Match(left=left, right=right, first=s.first, body=body, stream=stream, origin=s.span)


def branched(s: ast.When | ast.Chance, scope: Scope, use: PhaseUse) -> ir.Stmt:
    """Returns `when` or `chance` with all its branches: a chain of `otherwise when`, or of `otherwise chance`, is one statement."""
    header = use.streams.header(s.span, s.block.span.start)
    stream = use.streams.of_statement(header) if isinstance(s, ast.Chance) else 0
    branches: list[ir.Branch] = []
    otherwise: tuple[ir.Stmt, ...] = ()
    current: ast.When | ast.Chance = s
    while True:
        try:
            if isinstance(current, ast.When):
                test = scope.condition(current.condition)
                check_possible(test, scope)
                body = inside(current.block, header, scope.knowing([test]), use)
            else:
                test = probability(current.probability, scope)
                if test.type.high <= 0:
                    warn_never(current.probability.span, "its probability is 0", scope)
                body = inside(current.block, header, scope, use)
            branches.append(ir.Branch(test=test, body=body, origin=current.span))
            if isinstance(current, ast.When):
                scope = scope.knowing([ir.Not(value=test)])
        except Poisoned:
            inside(current.block, header, scope.after_unreadable_guard(), use)
            if isinstance(current, ast.When):
                scope = scope.after_unreadable_guard()
        header = f"{header} otherwise"
        following = current.otherwise
        if isinstance(following, ast.When | ast.Chance) and isinstance(following, type(s)):
            header = f"{header} {use.streams.header(following.span, following.block.span.start)}"
            current = following
            continue
        if following is not None:
            otherwise = other_branch(following, header, scope, use)
        break
    if not branches:
        raise Poisoned
    if isinstance(s, ast.When):
        return ir.When(branches=tuple(branches), otherwise=otherwise, origin=s.span)
    return ir.Chance(branches=tuple(branches), otherwise=otherwise, stream=stream, origin=s.span)


def probability(e: ast.Expr, scope: Scope) -> ir.Expr:
    """Returns a probability that provably stays in 0 .. 1."""
    p = scope.number(e, ("probability",), "a probability")
    low, high = narrowed(p, scope.facts_and_requires)
    if high > 1 + 1e-9 or low < -1e-9:
        raise scope.fail(
            errors.ProbabilityRange(
                e.span, labels=parameters_read(scope.static, p), low=low, high=high
            )
        )
    return p
