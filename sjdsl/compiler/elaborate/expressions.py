"""Elaborates expressions: from AST to typed IR, with units, intervals and guards checked.

Every function takes the tree and the scope and returns IR, or reports what is wrong and raises
`Poisoned`.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Literal, assert_never

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate import actions
from sjdsl.compiler.elaborate.arithmetic import calculation, compare, join_types, power
from sjdsl.compiler.elaborate.cases import case
from sjdsl.compiler.elaborate.domains import can_be_empty, domain, most_members
from sjdsl.compiler.elaborate.lookup import (
    bound_cell,
    check_arguments,
    check_known_word,
    check_placed,
    check_words,
    is_agent,
    is_member,
    kinds_named,
    kinds_of_cell,
    named_agent,
    not_named,
    or_nowhere,
    read_beside,
    use_define,
)
from sjdsl.compiler.elaborate.paths import bearing, distance, path
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

WHERE_BEFORE_STANDS = (
    "`before` stands in `always` and `once` of `checks`, not inside another; "
    "a rule keeps what it needs later in a field"
)


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
        case ast.Unary() if e.op in PREFIX:
            return calculation(PREFIX[e.op], e, [e.operand], scope)
        case ast.Unary():
            return scope.any_number(e.operand)
        case ast.Binary(op="and" | "or"):
            return logic(e, scope)
        case ast.Binary(op="is" | "is not"):
            same = identity(e, scope)
            return ir.Not(value=same, origin=e.span) if e.op == "is not" else same
        case ast.Binary(op="*" | "/"):
            return product(e, scope)
        case ast.Binary(op="^"):
            return power(e, scope)
        case ast.Binary() if e.op in COMPARISONS:
            return compare(e, scope)
        case ast.Binary():
            return calculation(INFIX[e.op], e, [e.left, e.right], scope)
        case ast.Chose():
            return chose(e, scope)
        case ast.Standing():
            return standing(e, scope)
        case ast.Within():
            return within(e, scope)
        case _:
            assert_never(e)


def product(e: ast.Binary, scope: Scope) -> ir.Expr:
    """Returns `a * b` or `a / b`; a message about its units suggests an order in which they mix."""
    try:
        return calculation(INFIX[e.op], e, [e.left, e.right], scope)
    except Poisoned:
        add_regrouped(e, scope)
        raise


def logic(e: ast.Binary, scope: Scope) -> ir.Expr:
    """Returns `a and b`, where b is read knowing a, or `a or b`, where b is read knowing not a.

    All operands are read, also if one of them is wrong.
    """
    args: list[ir.Expr] = []
    is_wrong = False
    for operand in _operands(e):
        try:
            condition = scope.condition(operand)
        except Poisoned:
            is_wrong = True
            scope = scope.after_unreadable_guard()
            continue
        if isinstance(condition, ir.Logic) and condition.fn == e.op:
            args += condition.args
        else:
            args.append(condition)
        known = condition if e.op == "and" else ir.Not(value=condition)
        scope = scope.knowing([known])
    if is_wrong:
        raise Poisoned
    fn: Literal["and", "or"] = "and" if e.op == "and" else "or"
    return ir.Logic(fn=fn, args=tuple(args), origin=e.span)


def _operands(e: ast.Binary) -> list[ast.Expr]:
    """Returns the operands of `a and b and c`, whose tree is `(a and b) and c`, or of `or`."""
    last = [e.right]
    left = e.left
    while isinstance(left, ast.Binary) and left.op == e.op:
        last.append(left.right)
        left = left.left
    return [left, *reversed(last)]


def identity(e: ast.Binary, scope: Scope) -> ir.Expr:
    """Returns `x is y` between words, agents, movers, cells, or a set of agents and nobody."""
    try:
        left = scope.expression(e.left)
    except Poisoned:
        read_beside(e.right, scope)
        raise
    if left.type.is_single("word"):
        check_known_word(e.right, left, left.type.words, scope)
    right = scope.expression(e.right)
    for tree, side in ((e.left, left), (e.right, right)):
        if side.type.indexed_by:
            raise wrong_type(scope, tree, "a single value", side.type)
    if isinstance(left, ir.Word) and isinstance(right, ir.Word):  # a phase's argument
        return ir.Truth(value=left.value == right.value, origin=e.span)
    kinds = {left.type.kind, right.type.kind}
    if kinds == {"agents", "agent"} and isinstance(right, ir.Nobody):
        return ir.IsEmpty(container=left, origin=e.span)
    if "cell" in kinds:
        left = or_nowhere(left)
        right = or_nowhere(right)
    left_kinds = kinds_of_cell(left)
    right_kinds = kinds_of_cell(right)
    are_like_movers = (
        is_member(left, "mover")
        and is_member(right, "mover")
        and left.entity_type == right.entity_type
    )
    if kinds == {"word"}:
        _check_common_words(e, left, right, scope)
    elif left_kinds is not None and right_kinds is not None:
        if left_kinds and right_kinds and not set(left_kinds) & set(right_kinds):
            raise scope.fail(errors.NeverOneCell(e.span))
    elif not are_like_movers and not (is_agent(left) and is_agent(right)):
        raise _not_identical(e, left, right, scope)
    return ir.Same(left=left, right=right, origin=e.span)


def _check_common_words(e: ast.Binary, left: ir.Expr, right: ir.Expr, scope: Scope) -> None:
    """Reports two values that have no word in common."""
    for side, other, tree in ((right, left, e.right), (left, right, e.left)):
        if isinstance(side, ir.Word):
            check_words((side.value,), other.type.words, tree.span, other, scope)
    if not set(left.type.words) & set(right.type.words):
        raise scope.fail(errors.NeverEqual(e.span))


def _not_identical(e: ast.Binary, left: ir.Expr, right: ir.Expr, scope: Scope) -> Poisoned:
    """Reports the side of `x is y` that can't be compared with the other."""
    if is_member(left, "mover"):
        return wrong_type(scope, e.right, f"a mover `{left.entity_type.name}`", right.type)
    left_is_one = (
        left.type.kind in ("word", "agent", "agents", "cell")
        or is_agent(left)
        or kinds_of_cell(left) is not None
    )
    help_ = ""
    if is_number(left.type) or is_number(right.type):
        help_ = "compare numbers with `==`"
    tree = e.right if left_is_one else e.left
    wrong = right if left_is_one else left
    return wrong_type(scope, tree, "a word, an agent or a cell", wrong.type, help_)


def chose(e: ast.Chose, scope: Scope) -> ir.Expr:
    """Returns `x chose ACTION`."""
    agent = named_agent(scope.expression(e.agent), e.agent, scope)
    name = e.action.name.text
    argument = scope.variables.get(name)
    if isinstance(argument, str):  # a parameter of the phase
        name = argument
    actions.check_in_step(f"{agent.name} chose {name}", e.span, scope)
    if agent.name == scope.returning:
        check_placed(agent, e.span, f"{agent.name} chose {name}", scope)
    return actions.chose(e, agent, name, scope)


def standing(e: ast.Standing, scope: Scope) -> ir.Expr:
    """Returns `nobody on CELL`, or `x on NAME`.

    NAME is a cell that a statement around has bound, or else a kind or group.
    """
    cell = bound_cell(e.kind, scope)
    if isinstance(e.who, ast.Nobody):
        if cell is None:
            actual = "a kind" if scope.static.kinds_of(e.kind.text) else "not known here"
            wanted = "a cell of a statement around"
            raise scope.misused(e.kind, actual, wanted)
        return ir.Unoccupied(cell=cell, origin=e.span)
    agent = scope.expression(e.who)
    if not (is_member(agent, "agent") or is_member(agent, "mover")):
        raise not_named(agent, e.who, scope)
    if agent.name == scope.returning:
        check_placed(agent, e.span, f"{agent.name} on {e.kind.text}", scope)
    if cell is not None:
        return ir.StandsAt(agent=agent, cell=cell, origin=e.span)
    return ir.StandsOn(agent=agent, kinds=kinds_named(e.kind, scope), origin=e.span)


def within(e: ast.Within, scope: Scope) -> ir.Expr:
    """Returns `x in { a, b }`, `x in low .. high`, or `x in` a set of agents."""
    try:
        value = scope.expression(e.value)
    except Poisoned:
        _read_container(e, scope)
        raise
    if isinstance(e.container, ast.Words):
        return _in_words(e, e.container, value, scope)
    if e.high is not None:
        low, high = scope.expressions((e.container, e.high))
        for bound, tree in ((low, e.container), (high, e.high)):
            join_types([value.type, bound.type], scope, "compare", tree)
        return ir.InRange(value=value, low=low, high=high, origin=e.span)
    container = scope.expression(e.container)
    if not is_agent(value):
        raise wrong_type(scope, e.value, "an agent", value.type)
    if container.type.kind != "agents":
        raise wrong_type(scope, e.container, "a set of agents", container.type)
    return ir.InSet(value=value, container=container, origin=e.span)


def _read_container(e: ast.Within, scope: Scope) -> None:
    """Reports the mistakes behind `in`, where what stands before it could not be read."""
    if isinstance(e.container, ast.Words):
        for name in e.container.names:
            read_beside(ast.Path(name.span, name, ()), scope)
    else:
        read_beside(e.container, scope)
    if e.high is not None:
        read_beside(e.high, scope)


def _in_words(e: ast.Within, container: ast.Words, value: ir.Expr, scope: Scope) -> ir.Expr:
    """Returns `value in { a, b }`."""
    if value.type.kind != "word":
        raise wrong_type(scope, e.value, "a word", value.type)
    names = tuple(name.text for name in container.names)
    if isinstance(value, ir.Word) and all(map(scope.static.is_word, names)):  # a phase's argument
        return ir.Truth(value=value.value in names, origin=e.span)
    for name in container.names:
        check_words((name.text,), value.type.words, name.span, value, scope)
        scope.static.refer(name, Symbol("word", name.text))
    return ir.InWords(value=value, words=names, origin=e.span)


def count(d: ast.Domain, span: Span, scope: Scope, warns: bool = True) -> ir.Expr:
    """Returns `count(D)`. warns: whether a `where` that never holds is reported."""
    members, _ = domain(d, scope, warns)
    type_ = integer(0, most_members(members, scope.static), "count")
    return ir.Count(type=type_, domain=members, origin=span)


def quantified(e: ast.Quantified, scope: Scope) -> ir.Expr:
    """Returns `any(D)` as `count(D) > 0`, and `all(D where c)` as `count(D where not c) == 0`."""
    zero = ir.Number(type=integer(0, 0, "number"), value=0)
    if e.word == "any":
        members = count(e.domain, e.span, scope)
        return ir.Compare(fn=">", left=members, right=zero, origin=e.span)
    condition = e.domain.where
    if condition is None:
        example = f"`all({scope.static.written(e.domain.span)} where …)`"
        raise scope.expected(
            e.span,
            "a condition after `where`",
            "`all` without one",
            f"write what holds for all of them: {example}",
        )
    exceptions = replace(e.domain, where=ast.Unary(condition.span, "not", condition))
    members = count(exceptions, e.span, scope, warns=False)
    return ir.Compare(fn="==", left=members, right=zero, origin=e.span)


def total(e: ast.Total, scope: Scope) -> ir.Expr:
    """Returns `sum(row)` or `sum(e over D)`."""
    if e.domain is None:
        help_ = "write `sum(e over D)` to add over a domain"
        return sum_of_row(row_of_numbers(e.value, scope, help_=help_), e.span)
    built, inner = domain(e.domain, scope)
    value = inner.any_number(e.value)
    most = most_members(built, scope.static)
    low = times(min(value.type.low, 0), most)
    high = times(max(value.type.high, 0), most)
    type_ = beyond_one(value.type.changed(low=low, high=high))
    return ir.Sum(type=type_, value=value, domain=built, origin=e.span)


def call(e: ast.Call, scope: Scope) -> ir.Expr:
    """Returns `name(arguments)`: a function of the language, or a `define` with its body in place.

    A `define` hides a function that came into the language later (`Function.yields`).
    """
    name = e.name.text
    function = FUNCTIONS.get(name)
    if name in scope.static.defines and (function is None or function.yields):
        return use_define(e.name, e.arguments, scope)
    if function is None:
        functions = [f.name for f in FUNCTIONS.values() if scope.part == "checks" or not f.checks]
        known = [*functions, *scope.static.defines]
        raise scope.problems.unknown(e.name, known, "the functions and defines")
    if function.reduces is not None and len(e.arguments) == 1:
        values = row_of_numbers(e.arguments[0], scope, "a row of numbers, or several numbers")
        return ir.SumRow(type=element(values.type), row=values, fn=name, origin=e.span)  # type: ignore[arg-type]
    number = len(e.arguments)
    if function.most == function.least:
        check_arguments(name, e.span, number, function.least, scope)
    elif not function.least <= number <= function.most:
        wanted = f"{function.least} or more arguments"
        raise scope.fail(errors.WrongArguments(e.span, name=name, wanted=wanted, actual=number))
    return BUILDERS[function.builds](function, e, scope)


# The builders of calls, by the class of the node they build.
def calculated(function: Function, e: ast.Call, scope: Scope) -> ir.Expr:
    """Returns a function of numbers, such as `abs(x)`."""
    assert isinstance(function, Calculation)
    return calculation(function, e, e.arguments, scope)


def matrix_class(function: Function, e: ast.Call, scope: Scope) -> ir.Expr:
    """Returns whether a payoff matrix is of a class of games, which only checks may ask."""
    table = scope.expression(e.arguments[0])
    if scope.part != "checks":
        raise scope.misused(e.name, "a class of games", "a value")
    index_sets = table.type.indexed_by
    is_matrix = len(index_sets) == 2 and len(index_sets[0]) == 2 and index_sets[0] == index_sets[1]
    if not isinstance(table, ir.ParamRef) or not is_matrix:
        wanted = "a table of two words by the same two words"
        raise wrong_type(scope, e.arguments[0], wanted, table.type)
    return ir.MatrixClass(name=function.name, table=table, origin=e.span)


def extreme(e: ast.Extreme, scope: Scope) -> ir.Expr:
    """Returns the least or greatest value over a domain."""
    reduction = REDUCTIONS.get(e.name.text)
    if reduction is None or reduction.adds:  # a sum is `ast.Total`
        raise scope.problems.unknown(e.name, REDUCTIONS, "what there is over a domain")
    built, inner = domain(e.domain, scope)
    value = inner.any_number(e.value)
    types = [value.type]
    otherwise = None
    if e.if_none is not None:
        otherwise = scope.any_number(e.if_none)
        types.append(otherwise.type)
    elif can_be_empty(built, scope):
        written = scope.static.written(e.domain.span)
        raise scope.fail(errors.ExtremeOfNothing(e.span, name=e.name.text, domain=written))
    return ir.Extreme(
        type=join_types(types, scope, "compare", e),
        fn=e.name.text,  # type: ignore[arg-type]
        value=value,
        domain=built,
        otherwise=otherwise,
        origin=e.span,
    )


def before(_: Function, e: ast.Call, scope: Scope) -> ir.Expr:
    """Returns `before(e)`, which is read without what is known of the state now."""
    if not scope.about_steps:
        raise scope.expected(
            e.span, "a value of one state", "`before`, which is about a step", WHERE_BEFORE_STANDS
        )
    (tree,) = e.arguments
    elsewhere: frozenset[str] = frozenset()
    if scope.static.can_be_away:
        elsewhere = frozenset(m.name for m in scope.members if not is_member(m, "cell"))
    before_step = replace(scope, about_steps=False, facts=(), elsewhere=elsewhere)
    value = before_step.expression(tree)
    if value.type.kind in ("member", "mix"):
        raise wrong_type(scope, tree, "a value", value.type)
    return ir.Before(type=value.type, value=value, origin=e.span)


BUILDERS: dict[type[ir.Node], Callable[[Function, ast.Call, Scope], ir.Expr]] = {
    ir.Arithmetic: calculated,
    ir.Lowest: lowest,
    ir.Mix: mix,
    ir.ShiftRow: shifted,
    ir.Distance: distance,
    ir.Bearing: bearing,
    ir.Before: before,
    ir.MatrixClass: matrix_class,
}
