"""Elaborates expressions: from AST to typed IR, with units, intervals and guards checked.

Every function takes the tree and the scope and returns IR, or reports what is wrong and raises `Poisoned`.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import assert_never

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate import actions
from sjdsl.compiler.elaborate.arithmetic import calculation, compare, join_types
from sjdsl.compiler.elaborate.cases import case
from sjdsl.compiler.elaborate.domains import can_be_empty, domain, most_members
from sjdsl.compiler.elaborate.lookup import (
    as_agent,
    bound_cell,
    check_known_word,
    check_placed,
    check_words,
    kinds_named,
    kinds_of_cell,
    not_named,
    or_nowhere,
    read_beside,
    use_define,
)
from sjdsl.compiler.elaborate.paths import distance, path
from sjdsl.compiler.elaborate.regrouping import add_regrouped
from sjdsl.compiler.elaborate.row_functions import (
    beyond_one,
    lowest,
    mix,
    row_of_numbers,
    shifted,
    sum_of_row,
)
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.ir.operations import (
    COMPARISONS,
    FUNCTIONS,
    INFIX,
    PREFIX,
    REDUCTIONS,
    Calculation,
    Function,
)
from sjdsl.compiler.ir.types import element, integer, is_number, real, times

WHERE_BEFORE_STANDS = "`before` stands in `always` and `once` of `checks`, not inside another; a rule keeps what it needs later in a field"


def expression(e: ast.Expr, scope: Scope) -> ir.Expr:
    """Returns the typed form of any expression."""
    match e:
        case ast.Int():
            return ir.Number(type=integer(e.value, e.value, "number"), value=e.value, origin=e.span)
        case ast.Decimal():
            return ir.Number(type=real(e.value, e.value), value=e.value, origin=e.span)
        case ast.Nobody():
            return ir.Nobody(origin=e.span)
        case ast.Path():
            return path(e, scope)
        case ast.Call():
            return call(e, scope)
        case ast.Count():
            return count(e.domain, e.span, scope)
        case ast.Quantified():
            return quantified(e, scope)
        case ast.Total():
            return total(e, scope)
        case ast.Extreme():
            return extreme(e, scope)
        case ast.Case():
            return case(e, scope)
        case ast.Unary(op="not"):
            return ir.Not(value=scope.condition(e.operand), origin=e.span)
        case ast.Unary():
            operand = scope.expression(e.operand)
            if e.op in PREFIX:
                return calculation(PREFIX[e.op], e, [e.operand], [operand], scope)
            if not is_number(operand.type):
                raise wrong_type(scope, e.operand, "a number", operand.type)
            return operand
        case ast.Binary(op="and" | "or"):
            return logic(e, scope)
        case ast.Binary(op="is" | "is not"):
            same = identity(e, scope)
            return ir.Not(value=same, origin=e.span) if e.op == "is not" else same
        case ast.Binary(op="*" | "/"):
            return product(e, scope)
        case ast.Binary():
            left, right = scope.expressions((e.left, e.right))
            if e.op in COMPARISONS:
                return compare(e, left, right, scope)
            return calculation(INFIX[e.op], e, [e.left, e.right], [left, right], scope)
        case ast.Chose():
            return chose(e, scope)
        case ast.Standing():
            return standing(e, scope)
        case ast.Within():
            return within(e, scope)
        case _:
            assert_never(e)


def product(e: ast.Binary, scope: Scope) -> ir.Expr:
    """`a * b` or `a / b`; where units don't go together, the message tells of another order of the factors in which they do."""
    try:
        left, right = scope.expressions((e.left, e.right))
        return calculation(INFIX[e.op], e, [e.left, e.right], [left, right], scope)
    except Poisoned:
        add_regrouped(e, scope)
        raise


def logic(e: ast.Binary, scope: Scope) -> ir.Expr:
    """`a and b`: b is read knowing a; `a or b`: b is read knowing not a. All are read, also where one of them is wrong."""
    args: list[ir.Expr] = []
    is_wrong = False
    for operand in _operands(e):
        try:
            condition = scope.condition(operand)
        except Poisoned:
            is_wrong = True
            scope = scope.unsure()
            continue
        args.extend(
            condition.args
            if isinstance(condition, ir.Logic) and condition.fn == e.op
            else [condition]
        )
        scope = scope.knowing([condition if e.op == "and" else ir.Not(value=condition)])
    if is_wrong:
        raise Poisoned
    return ir.Logic(fn="and" if e.op == "and" else "or", args=tuple(args), origin=e.span)


def _operands(e: ast.Binary) -> list[ast.Expr]:
    """Returns the operands of `a and b and c`, or of several `or`, which is read as `(a and b) and c`."""
    last = [e.right]
    left = e.left
    while isinstance(left, ast.Binary) and left.op == e.op:
        last.append(left.right)
        left = left.left
    return [left, *reversed(last)]


def identity(e: ast.Binary, scope: Scope) -> ir.Expr:
    """`x is y` between words, agents, cells, or a set of agents and nobody; where x is a word, y is not any name."""
    try:
        left = scope.expression(e.left)
    except Poisoned:
        read_beside(e.right, scope)
        raise
    if left.type.kind == "word" and not left.type.by:
        check_known_word(e.right, left, left.type.words, scope)
    right = scope.expression(e.right)
    if left.type.by or right.type.by:
        raise wrong_type(
            scope,
            e.left if left.type.by else e.right,
            "a single value",
            left.type if left.type.by else right.type,
        )
    if isinstance(left, ir.Word) and isinstance(
        right, ir.Word
    ):  # one of them is what a phase is used with
        return ir.Truth(value=left.value == right.value, origin=e.span)
    kinds = {left.type.kind, right.type.kind}
    if kinds == {"agents", "agent"} and isinstance(right, ir.Nobody):
        return ir.IsEmpty(container=left, origin=e.span)
    if "cell" in kinds:
        left, right = or_nowhere(left), or_nowhere(right)
    cells = [kinds_of_cell(x) for x in (left, right)]
    movers = (
        isinstance(left, ir.Member)
        and isinstance(right, ir.Member)
        and left.sort.what == "mover"
        and left.sort == right.sort
    )
    if kinds == {"word"}:
        for literal, other, tree in ((right, left, e.right), (left, right, e.left)):
            if isinstance(literal, ir.Word):
                check_words((literal.value,), other.type.words, tree.span, other, scope)
        if not set(left.type.words) & set(right.type.words):
            raise scope.fail(errors.NeverEqual(e.span))
    elif None not in cells:
        if all(cells) and not set(cells[0] or ()) & set(cells[1] or ()):
            raise scope.fail(errors.NeverOneCell(e.span))
    elif not (movers or (as_agent(left) and as_agent(right))):
        if isinstance(left, ir.Member) and left.sort.what == "mover":
            raise wrong_type(scope, e.right, f"a mover `{left.sort.name}`", right.type)
        single = (
            left.type.kind in ("word", "agent", "agents", "cell")
            or as_agent(left)
            or cells[0] is not None
        )
        tree, wrong = (e.right, right) if single else (e.left, left)
        help_ = "compare numbers with `==`" if is_number(left.type) or is_number(right.type) else ""
        raise wrong_type(scope, tree, "a word, an agent or a cell", wrong.type, help_)
    return ir.Same(left=left, right=right, origin=e.span)


def chose(e: ast.Chose, scope: Scope) -> ir.Expr:
    agent = scope.expression(e.agent)
    if not (isinstance(agent, ir.Member) and agent.sort.what == "agent"):
        raise not_named(agent, e.agent, scope)
    bound = scope.variables.get(e.action.name.text)
    name = (
        bound if isinstance(bound, str) else e.action.name.text
    )  # what a phase's parameter stands for
    actions.check_in_step(f"{agent.name} chose {name}", e.span, scope)
    if agent.name == scope.returning:
        check_placed(agent, e.span, f"{agent.name} chose {name}", scope)
    return actions.chose(e, agent, name, scope)


def standing(e: ast.Standing, scope: Scope) -> ir.Expr:
    """`nobody on soil` asks a cell variable; `x on soil` an agent and that cell, or a kind or group if no statement around binds the name."""
    cell = bound_cell(e.kind, scope)
    if isinstance(e.who, ast.Nobody):
        if cell is None:
            what = "a kind" if scope.static.kinds_of(e.kind.text) else "not known here"
            raise scope.fail(
                errors.WrongSort(
                    e.kind.span,
                    name=e.kind.text,
                    actual=what,
                    wanted="a cell of a statement around",
                )
            )
        return ir.Unoccupied(cell=cell, origin=e.span)
    agent = scope.expression(e.who)
    if not (isinstance(agent, ir.Member) and agent.sort.what != "cell"):
        raise not_named(agent, e.who, scope)
    if agent.name == scope.returning:
        check_placed(agent, e.span, f"{agent.name} on {e.kind.text}", scope)
    if cell is not None:
        return ir.StandsAt(agent=agent, cell=cell, origin=e.span)
    return ir.StandsOn(agent=agent, kinds=kinds_named(e.kind, scope), origin=e.span)


def within(e: ast.Within, scope: Scope) -> ir.Expr:
    try:
        value = scope.expression(e.value)
    except Poisoned:
        if isinstance(e.container, ast.Words):
            for name in e.container.names:
                read_beside(ast.Path(name.span, name, ()), scope)
        else:
            read_beside(e.container, scope)
        if e.high is not None:
            read_beside(e.high, scope)
        raise
    if isinstance(e.container, ast.Words):
        if value.type.kind != "word":
            raise wrong_type(scope, e.value, "a word", value.type)
        names = tuple(n.text for n in e.container.names)
        if isinstance(value, ir.Word) and all(
            map(scope.static.is_word, names)
        ):  # what a phase is used with
            return ir.Truth(value=value.value in names, origin=e.span)
        for name in e.container.names:
            check_words((name.text,), value.type.words, name.span, value, scope)
            scope.static.refer(name, Symbol("word", name.text))
        return ir.InWords(value=value, words=names, origin=e.span)
    if e.high is not None:
        low, high = scope.expressions((e.container, e.high))
        for bound, tree in ((low, e.container), (high, e.high)):
            join_types([value.type, bound.type], scope, "compare", tree)
        return ir.InRange(value=value, low=low, high=high, origin=e.span)
    container = scope.expression(e.container)
    if not as_agent(value):
        raise wrong_type(scope, e.value, "an agent", value.type)
    if container.type.kind != "agents":
        raise wrong_type(scope, e.container, "a set of agents", container.type)
    return ir.InSet(value=value, container=container, origin=e.span)


def count(d: ast.Domain, span: Span, scope: Scope, warns: bool = True) -> ir.Expr:
    built, _ = domain(d, scope, warns)
    return ir.Count(type=integer(0, most_members(built, scope), "count"), domain=built, origin=span)


def quantified(e: ast.Quantified, scope: Scope) -> ir.Expr:
    """Returns `any(D)` and `all(D where c)` as counts: more than 0 members, and none for which c does not hold."""
    domain_ = e.domain
    if e.word == "all":
        if domain_.where is None:
            help_ = f"write what holds for all of them: `all({written(domain_, scope)} where …)`"
            raise scope.fail(
                errors.WrongType(
                    e.span,
                    wanted="a condition after `where`",
                    actual="`all` without one",
                    help=help_,
                )
            )
        domain_ = replace(domain_, where=ast.Unary(domain_.where.span, "not", domain_.where))
    members, none = (
        count(domain_, e.span, scope, warns=e.word == "any"),
        ir.Number(type=integer(0, 0, "number"), value=0),
    )
    return ir.Compare(fn=">" if e.word == "any" else "==", left=members, right=none, origin=e.span)


def total(e: ast.Total, scope: Scope) -> ir.Expr:
    """`sum(row)` and `sum(e over D)`."""
    if e.domain is None:
        return sum_of_row(
            row_of_numbers(e.value, scope, help_="write `sum(e over D)` to add over a domain"),
            e.span,
        )
    built, inner = domain(e.domain, scope)
    value = inner.expression(e.value)
    if not is_number(value.type):
        raise wrong_type(scope, e.value, "a number", value.type)
    most = most_members(built, scope)
    low, high = times(min(value.type.low, 0), most), times(max(value.type.high, 0), most)
    return ir.Sum(
        type=beyond_one(value.type.model_copy(update={"low": low, "high": high})),
        value=value,
        domain=built,
        origin=e.span,
    )


def call(e: ast.Call, scope: Scope) -> ir.Expr:
    """Returns what a function makes of its arguments, or a `define` with arguments written out."""
    name = e.name.text
    row = FUNCTIONS.get(name)
    if name in scope.static.defines and (row is None or row.yields):
        return use_define(e.name, e.arguments, scope)
    if row is None:
        found = [row.name for row in FUNCTIONS.values() if scope.part == "checks" or not row.checks]
        raise scope.problems.unknown(
            e.name, [*found, *scope.static.defines], "the functions and defines"
        )
    if row.reduces is not None and len(e.arguments) == 1:
        values = row_of_numbers(e.arguments[0], scope, "a row of numbers, or several numbers")
        return ir.SumRow(type=element(values.type), row=values, fn=name, origin=e.span)  # type: ignore[arg-type]
    if not row.least <= len(e.arguments) <= row.most:
        wanted = f"{row.least} arguments" if row.least != 1 else "1 argument"
        wanted = wanted if row.most == row.least else f"{row.least} or more arguments"
        raise scope.fail(
            errors.WrongArguments(e.span, name=name, wanted=wanted, actual=len(e.arguments))
        )
    return BUILDERS[row.builds](row, e, scope)


# What makes each class of node of a call.
def calculated(row: Function, e: ast.Call, scope: Scope) -> ir.Expr:
    assert isinstance(row, Calculation)
    return calculation(row, e, e.arguments, scope.expressions(e.arguments), scope)


def matrix_class(row: Function, e: ast.Call, scope: Scope) -> ir.Expr:
    table = scope.expression(e.arguments[0])
    if scope.part != "checks":
        raise scope.fail(
            errors.WrongSort(
                e.name.span, name=e.name.text, actual="a class of games", wanted="a value"
            )
        )
    if (
        not isinstance(table, ir.ParamRef)
        or len(table.type.by) != 2
        or len(table.type.by[0]) != 2
        or table.type.by[0] != table.type.by[1]
    ):
        raise wrong_type(
            scope, e.arguments[0], "a table of two words by the same two words", table.type
        )
    return ir.MatrixClass(name=row.name, table=table, origin=e.span)


def extreme(e: ast.Extreme, scope: Scope) -> ir.Expr:
    """Returns the least or greatest value over a domain."""
    reduction = REDUCTIONS.get(e.name.text)
    if reduction is None or reduction.adds:  # a sum is `ast.Total`
        raise scope.problems.unknown(e.name, REDUCTIONS, "what there is over a domain")
    built, inner = domain(e.domain, scope)
    value = inner.expression(e.value)
    otherwise = None if e.if_none is None else scope.expression(e.if_none)
    for tree, part in ((e.value, value), (e.if_none, otherwise)):
        if tree is not None and part is not None and not is_number(part.type):
            raise wrong_type(scope, tree, "a number", part.type)
    if otherwise is None and can_be_empty(built, scope):
        raise scope.fail(
            errors.ExtremeOfNothing(e.span, name=e.name.text, domain=written(e.domain, scope))
        )
    types = [value.type] if otherwise is None else [value.type, otherwise.type]
    type_ = join_types(types, scope, "compare", e)
    return ir.Extreme(
        type=type_, fn=e.name.text, value=value, domain=built, otherwise=otherwise, origin=e.span
    )  # type: ignore[arg-type]


def written(d: ast.Domain, scope: Scope) -> str:
    """Returns a domain as its author wrote it."""
    return " ".join(scope.static.sources[d.span.file].text[d.span.start : d.span.end].split())


def before(_: Function, e: ast.Call, scope: Scope) -> ir.Expr:
    """Returns `before(e)`; what is known of the state now, and who has a place now, says nothing of that state."""
    if not scope.about_steps:
        given = "`before`, which is about a step"
        raise scope.fail(
            errors.WrongType(
                e.span, wanted="a value of one state", actual=given, help=WHERE_BEFORE_STANDS
            )
        )
    (value,) = e.arguments
    bodies = {
        v.name
        for v in scope.variables.values()
        if isinstance(v, ir.Member) and v.sort.what != "cell"
    }
    elsewhere = frozenset(bodies if scope.static.can_be_away else ())
    inner = replace(scope, about_steps=False, facts=(), elsewhere=elsewhere).expression(value)
    if inner.type.kind in ("member", "mix"):
        raise wrong_type(scope, value, "a value", inner.type)
    return ir.Before(type=inner.type, value=inner, origin=e.span)


BUILDERS: dict[type[ir.Node], Callable[[Function, ast.Call, Scope], ir.Expr]] = {
    ir.Arithmetic: calculated,
    ir.Lowest: lowest,
    ir.Mix: mix,
    ir.ShiftRow: shifted,
    ir.Distance: distance,
    ir.Before: before,
    ir.MatrixClass: matrix_class,
}
