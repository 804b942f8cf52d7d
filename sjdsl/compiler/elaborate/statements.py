"""Elaborates statements: from AST to typed IR.

A statement's random stream is a hash of its header, its text up to its block, and of the headers of
the statements around it (`streams.py`).
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from math import inf
from typing import assert_never

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.assignments import add, set_
from sjdsl.compiler.elaborate.declaration_labels import parameters_read
from sjdsl.compiler.elaborate.domains import domain, with_member
from sjdsl.compiler.elaborate.domains import near as near_shape
from sjdsl.compiler.elaborate.effects import body, give, send, shift, tally
from sjdsl.compiler.elaborate.keys import index_set_of
from sjdsl.compiler.elaborate.lookup import check_free, no_word, repeated
from sjdsl.compiler.elaborate.movers import move
from sjdsl.compiler.elaborate.possible import possible_condition, warn_never
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.elaborate.streams import Streams
from sjdsl.compiler.ir.equivalence import form
from sjdsl.compiler.ir.implications import compares, narrowed
from sjdsl.compiler.ir.printer import expression_text as text
from sjdsl.compiler.ir.range_arithmetic import Range, rounded, to_float32
from sjdsl.compiler.ir.types import INTEGER_UNITS, integer, join_units, real, words


def block(b: ast.Block, scope: Scope, streams: Streams) -> tuple[ir.Stmt, ...]:
    """Returns the statements of a block, in which what `let` and `draw` name is known to its end.

    One with a mistake, which is reported, is left out, and the next ones are read for their own.
    """
    built: list[ir.Stmt] = []
    for statement in b.statements:
        try:
            typed, scope = stmt(statement, scope, streams)
            built.append(typed)
        except Poisoned:
            if isinstance(statement, ast.Let | ast.Draw):
                scope = scope.bind_named(statement.name, None)
    return tuple(built)


def stmt(s: ast.Stmt, scope: Scope, streams: Streams) -> tuple[ir.Stmt, Scope]:
    """Returns one statement and the scope after it."""
    match s:
        case ast.Let():
            return let(s, scope)
        case ast.Draw():
            return draw(s, scope, streams)
        case ast.Each() | ast.Pick() | ast.First():
            return quantifier(s, scope, streams), scope
        case ast.Match():
            return match_(s, scope, streams), scope
        case ast.When() | ast.Chance():
            return branched(s, scope, streams), scope
        case ast.Set():
            return set_(s, scope, streams), scope
        case ast.Add():
            return add(s, scope), scope
        case ast.Give():
            return give(s, scope), scope
        case ast.Tally():
            return tally(s, scope), scope
        case ast.Send():
            return send(s, scope, streams), scope
        case ast.Shift():
            return shift(s, scope, streams), scope
        case ast.Remove():
            return ir.Remove(who=body(s.who, scope), origin=s.span), scope
        case ast.Move():
            return move(s, scope, streams), scope
        case ast.Mark():
            place = near_shape(s.shape, s.anchor, scope)
            return ir.Mark(shape=place.shape, anchor=place.anchor, origin=s.span), scope
        case ast.End():
            return ir.End(origin=s.span), scope
        case _:
            assert_never(s)


def let(s: ast.Let, scope: Scope) -> tuple[ir.Stmt, Scope]:
    """Returns a typed `let`, and the scope after it."""
    value = scope.narrowed(s.value)
    check_free(s.name, scope, chosen=True)
    if isinstance(value, ir.Member):
        described = "the variable has a name already"
        raise wrong_type(scope, s.value, "a value", value.type, described)
    local = ir.Local(type=value.type, name=s.name.text, origin=s.name.span)
    inner = scope.bind_named(s.name, local)
    if value.type.kind == "real":
        inner = inner.but(ranges={**scope.ranges, local.name: scope.computed_range(value)})
    if isinstance(value, ir.ArgumentOf) and value.type.kind == "agent":  # always somebody
        is_nobody = ir.Same(left=local, right=ir.Nobody())
        inner = inner.knowing([ir.Not(value=is_nobody)])
    return ir.Let(name=s.name.text, value=value, origin=s.span), inner


def draw(s: ast.Draw, scope: Scope, streams: Streams) -> tuple[ir.Stmt, Scope]:
    """Returns a typed `draw`, and the scope after it."""
    check_free(s.name, scope, chosen=True)
    stream = streams.of_line(s.span)
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
            statement = _between(s, s.source, scope, stream)
    if s.by is not None:
        statement = _of_row(s, s.by, statement, scope)
    elif s.different:
        wanted = "`by` and the entries of a row, which are all different"
        raise scope.expected(s.name.span, wanted, "one value", "write `draw x by { a, b } from …`")
    local = ir.Local(type=statement.type, name=name, origin=s.name.span)
    inner = scope.bind_named(s.name, local)
    if local.type.kind == "real":
        inner = inner.but(ranges={**scope.ranges, name: _range_of_drawn(statement, scope)})
    return statement, inner


def _range_of_drawn(s: ir.Draw, scope: Scope) -> Range:
    """Returns the range of a real that is drawn between two numbers, as it is computed."""
    assert s.low is not None
    assert s.high is not None
    low = to_float32(scope.computed_range(s.low))
    high = to_float32(scope.computed_range(s.high))
    largest = max(low.largest, high.largest)
    return rounded(Range(low.low, high.high, terms=largest, sound=low.sound and high.sound))


def _of_row(s: ast.Draw, by: ast.By, one: ir.Draw, scope: Scope) -> ir.Draw:
    """Returns the draw of a row `by` something; `one` is the draw of a single entry."""
    if isinstance(by, ast.Words):
        _check_declared(by.names, scope)
    index_set = index_set_of(by, scope)
    type_ = one.type.changed(indexed_by=(index_set,))
    drawn = one.changed(type=type_, by=index_set, different=s.different)
    if s.different:
        if one.weights:
            raise scope.expected(s.source.span, "values without weights", "a table of weights")
        if one.type.kind == "real":
            raise scope.expected(s.source.span, "whole numbers or words", "real numbers")
        for bound in (one.low, one.high):
            if bound is not None and not isinstance(bound, ir.Number):
                _refuse_unknown(bound, scope)
        check_deal(drawn, s.span, scope)
    return drawn


def _refuse_unknown(bound: ir.Expr, scope: Scope) -> None:
    """Reports a bound of `draw different` that isn't known when the game is compiled."""
    quantity = "what different values are drawn from"
    for node in ir.walk(bound):
        if isinstance(node, ir.ParamRef):
            raise scope.fail(errors.ShapeParam(bound.span, name=node.name, quantity=quantity))
    raise scope.fail(errors.NotFixed(bound.span, quantity=quantity))


def check_deal(drawn: ir.Draw, span: Span, scope: Scope) -> None:
    """Reports a draw of different values that is of no row, or of too many or too few values.

    span: where it is reported.
    """
    if drawn.by is None:
        wanted = "`by` and the entries of a row, which are all different"
        raise scope.expected(span, wanted, "one value")
    values = len(drawn.words) or int(drawn.type.high - drawn.type.low) + 1
    if values > limits.MAX_DEALT:
        problem = f"different values are drawn from {values}"
        raise scope.fail(limits.too_much(problem, limits.MAX_DEALT, span))
    if values < len(drawn.by):
        raise scope.fail(errors.TooFewToDeal(span, entries=len(drawn.by), values=values))


def _check_declared(names: Sequence[ast.Name], scope: Scope) -> None:
    """Reports names to draw from that are no words of the game."""
    _check_different(names, "word", scope)
    for name in names:
        if not name.text.isidentifier():
            help_ = (
                "a `draw` has only words, `{ red: 0.5, blue: 0.5 }`, "
                "or only whole numbers, each by itself, `{ 1: 0.5, 3: 0.5 }`"
            )
            raise scope.expected(name.span, "a word", f"`{name.text}`", help_)
        if not scope.static.is_word(name.text):
            raise no_word(name, [n.text for n in names], "`draw`", scope)
        scope.static.refer(name, Symbol("word", name.text))


def _check_different(names: Sequence[ast.Name], noun: str, scope: Scope) -> None:
    """Reports a name that is written twice. noun: what the names are."""
    for name in repeated(names):
        raise scope.fail(errors.WrittenTwice(name.span, part=f"the {noun} `{name.text}`"))


def _between(s: ast.Draw, source: ast.Expr, scope: Scope, stream: int) -> ir.Draw:
    """Returns `draw n from low .. high`."""
    assert s.high is not None
    low, high = scope.expressions((source, s.high))
    if "real" in (low.type.kind, high.type.kind):
        low = scope.any_number(source)
        high = scope.any_number(s.high)
    else:
        units: tuple[ir.Unit, ...] = ("count", "steps", "cells")
        low = scope.number(source, units, "a whole number")
        high = scope.number(s.high, units, "a whole number")
    type_ = _draw_range(s, low, high, scope)
    return ir.Draw(name=s.name.text, type=type_, low=low, high=high, stream=stream, origin=s.span)


def _draw_range(s: ast.Draw, low: ir.Expr, high: ir.Expr, scope: Scope) -> ir.Type:
    """Returns the type of a number drawn between two others; reports ends that may be crossed."""
    unit = join_units(low.type.unit, high.type.unit)
    if unit is None:
        raise scope.fail(
            errors.UnitMismatch(
                s.span, verb="draw between", left=low.type.unit, right=high.type.unit
            )
        )
    known = scope.facts_and_requires
    is_known_order = compares(high, ">=", low, known) or compares(high, ">", low, known)
    if low.type.high > high.type.low and not is_known_order:
        labels = parameters_read(scope.static, low, high)
        raise scope.fail(errors.Crossed(s.span, labels=labels, low=text(low), high=text(high)))
    if "real" in (low.type.kind, high.type.kind):
        real_unit = "number" if unit in INTEGER_UNITS else unit
        return real(low.type.low, high.type.high, real_unit)
    type_ = integer(low.type.low, high.type.high, unit)
    check_number_of_values(type_, s.span, scope, "give the parameters limits, `in a .. b`")
    return type_


def check_number_of_values(type_: ir.Type, span: Span, scope: Scope, help_: str) -> None:
    """Reports a range of more whole numbers than can be drawn from."""
    values = type_.high - type_.low + 1
    if values > limits.MAX_DRAWN:
        number = f"{values:g}" if values < inf else "endlessly many"
        problem = f"this draw is from {number} numbers"
        raise scope.fail(limits.too_much(problem, limits.MAX_DRAWN, span, help_))


def _weighted(s: ast.Draw, table: ast.Table, scope: Scope, stream: int) -> ir.Draw:
    """Returns `draw x from { a: p, b: q }`, of words or of whole numbers."""
    keys = [entry.key for entry in table.entries]
    names: tuple[str, ...] = ()
    numbers: tuple[int, ...] = ()
    if all(key.text.isdigit() for key in keys):
        numbers = tuple(int(key.text) for key in keys)
        without_zeros = [ast.Name(key.span, f"{int(key.text)}") for key in keys]  # 01 is 1
        _check_different(without_zeros, "number", scope)
        type_ = integer(min(numbers), max(numbers), "number")
    else:
        names = tuple(key.text for key in keys)
        _check_declared(keys, scope)
        type_ = words(names)
    weights = []
    for entry in table.entries:
        if isinstance(entry.value, ast.Table):
            raise scope.expected(entry.span, "a probability", "a table")
        weights.append(probability(entry.value, scope))
    _check_sum(weights, table.span, scope)
    return ir.Draw(
        name=s.name.text,
        type=type_,
        words=names,
        numbers=numbers,
        weights=tuple(weights),
        stream=stream,
        origin=s.span,
    )


def _check_sum(weights: Sequence[ir.Expr], span: Span, scope: Scope) -> None:
    """Reports weights that don't sum to 1.

    Weights from parameters need `require a + b + c == 1`, or the form p, q, 1 - p - q.
    """
    values = [weight.value for weight in weights if isinstance(weight, ir.Number)]
    if len(values) == len(weights):
        if abs(sum(values) - 1) > 1e-6:
            raise scope.fail(errors.Weights(span, total=sum(values)))
        return
    first, *others = weights
    total = first
    for weight in others:
        total = ir.Arithmetic(type=first.type, fn="+", args=(total, weight))
    rest: ir.Expr = ir.Number(type=first.type, value=1)
    for weight in weights[:-1]:
        rest = ir.Arithmetic(type=first.type, fn="-", args=(rest, weight))
    is_required = compares(total, "==", 1, scope.facts_and_requires)
    if not is_required and form(weights[-1]) != form(rest):
        raise scope.fail(errors.Weights(span, total="something known only when it runs"))


def quantifier(s: ast.Each | ast.Pick | ast.First, scope: Scope, streams: Streams) -> ir.Stmt:
    """Returns a typed `each`, `pick` or `first`."""
    header = streams.header(s.span, s.block)
    number = _number_picked(s, scope) if isinstance(s, ast.Pick) else None
    members, inner = _domain(s.domain, scope)
    if members is None:
        block(s.block, inner, streams.inside(header))
        raise Poisoned
    stream = streams.of_statement(header)
    if isinstance(s, ast.First) and not isinstance(members.restriction, ir.Near):
        wanted = "`in SHAPE of x` after `first`"
        raise scope.expected(s.domain.span, wanted, "a domain without a shape")
    body = block(s.block, inner, streams.inside(header))
    match s:
        case ast.Each():
            return ir.Each(domain=members, body=body, origin=s.span)
        case ast.First():
            return ir.First(domain=members, body=body, origin=s.span)
        case ast.Pick():
            assert number is not None
            otherwise: tuple[ir.Stmt, ...] = ()
            if s.otherwise is not None:
                otherwise = other_branch(s.otherwise, header, scope, streams)
            return ir.Pick(
                number=number,
                most=int(min(max(number.type.high, 0), limits.MAX_DRAWN)),
                domain=members,
                body=body,
                otherwise=otherwise,
                stream=stream,
                origin=s.span,
            )


def _number_picked(s: ast.Pick, scope: Scope) -> ir.Expr:
    """Returns the number of members that a `pick` takes."""
    number = scope.not_negative(s.number, ("count",), "a count", "the number picked")
    is_literal = number.type.unit == "number"  # the value of a size can be changed
    if is_literal and number.type.high <= 0:
        warn_never(s.number.span, "none is picked", scope)
    return number


def _domain(d: ast.Domain, scope: Scope) -> tuple[ir.Domain | None, Scope]:
    """Returns a domain and the scope inside it.

    Of a domain with a mistake it returns None, and a scope in which the block can be read for its
    own mistakes. Raises Poisoned if not even its kinds are known.
    """
    try:
        return domain(d, scope)
    except Poisoned:
        kinds = [d.kind] if d.on is None else [d.kind, d.on.kind]
        if any(scope.static.entity_type_of(kind.text) is None for kind in kinds):
            raise  # a misspelt kind would make every use of its variable one more mistake
        if d.where is not None:
            scope = scope.after_unreadable_guard()
            with suppress(Poisoned):
                _, inner = domain(replace(d, where=None), scope)
                return None, inner
        inner = with_member(d, None, scope)
        if d.on is not None:
            inner = with_member(d.on, None, inner)
        return None, inner


def other_branch(
    b: ast.Otherwise, header: str, scope: Scope, streams: Streams
) -> tuple[ir.Stmt, ...]:
    """Returns the statements of an `otherwise`: its block, or one more `when` or `chance`.

    header: of the statement that it belongs to.
    """
    streams = streams.inside(f"{header} otherwise")
    if isinstance(b, ast.Block):
        return block(b, scope, streams)
    return (branched(b, scope, streams),)


def match_(s: ast.Match, scope: Scope, streams: Streams) -> ir.Stmt:
    """Returns a typed `match`."""
    header = streams.header(s.span, s.block)
    stream = streams.of_statement(header)
    left, inner = _domain(s.left, scope)
    right, inner = _domain(s.right, inner)
    if left is None or right is None:
        block(s.block, inner, streams.inside(header))
        raise Poisoned
    if s.first and not isinstance(right.restriction, ir.Near):
        wanted = "`in SHAPE of x` after `with first`"
        raise scope.expected(s.right.span, wanted, "a domain without a shape")
    body = block(s.block, inner, streams.inside(header))
    return ir.Match(left=left, right=right, first=s.first, body=body, stream=stream, origin=s.span)


def branched(s: ast.When | ast.Chance, scope: Scope, streams: Streams) -> ir.Stmt:
    """Returns `when a {} otherwise when b {} otherwise {}`, or of `chance`, as one statement.

    A branch of `when` is read knowing that those before it don't hold. A branch with a mistake is
    left out, and its block is read for its own mistakes.
    """
    trees = _with_following(s)
    headers = [streams.header(tree.span, tree.block) for tree in trees]
    stream = streams.of_statement(headers[0]) if isinstance(s, ast.Chance) else 0
    branches: list[ir.Branch] = []
    for number, tree in enumerate(trees, 1):
        header = " otherwise ".join(headers[:number])
        try:
            branch = _branch(tree, header, scope, streams)
            branches.append(branch)
            if isinstance(tree, ast.When):
                scope = scope.knowing([ir.Not(value=branch.test)])
        except Poisoned:
            block(tree.block, scope.after_unreadable_guard(), streams.inside(header))
            if isinstance(tree, ast.When):
                scope = scope.after_unreadable_guard()
    otherwise: tuple[ir.Stmt, ...] = ()
    if trees[-1].otherwise is not None:
        header = f"{' otherwise '.join(headers)} otherwise"
        otherwise = other_branch(trees[-1].otherwise, header, scope, streams)
    if not branches:
        raise Poisoned
    if isinstance(s, ast.When):
        return ir.When(branches=tuple(branches), otherwise=otherwise, origin=s.span)
    return ir.Chance(branches=tuple(branches), otherwise=otherwise, stream=stream, origin=s.span)


def _with_following(s: ast.When | ast.Chance) -> list[ast.When | ast.Chance]:
    """Returns a statement and those that follow it by `otherwise` with the same keyword."""
    trees = [s]
    following = s.otherwise
    while isinstance(following, ast.When | ast.Chance) and isinstance(following, type(s)):
        trees.append(following)
        following = following.otherwise
    return trees


def _branch(s: ast.When | ast.Chance, header: str, scope: Scope, streams: Streams) -> ir.Branch:
    """Returns a branch: the test and the block of a `when` or `chance`, without its `otherwise`.

    header: of this branch, after those of the branches before it.
    """
    if isinstance(s, ast.When):
        test = possible_condition(s.condition, scope)
        scope = scope.knowing([test])
    else:
        test = probability(s.probability, scope)
        if test.type.high <= 0:
            warn_never(s.probability.span, "its probability is 0", scope)
    return ir.Branch(test=test, body=block(s.block, scope, streams.inside(header)), origin=s.span)


def probability(e: ast.Expr, scope: Scope) -> ir.Expr:
    """Returns a probability that provably stays in 0 .. 1."""
    p = scope.number(e, ("probability",), "a probability")
    low, high = narrowed(p, scope.facts_and_requires)
    if high > 1 + 1e-9 or low < -1e-9:
        labels = parameters_read(scope.static, p)
        raise scope.fail(errors.ProbabilityRange(e.span, labels=labels, low=low, high=high))
    return p
