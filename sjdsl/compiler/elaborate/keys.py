"""Elaborates what rows and tables are indexed by: the sort after `by`, and the key in square brackets.

by { raw, cut }   ->   raw, cut              row[agent.grade]   ->   a key of type word
by agent          ->   agent 0, agent 1      row[b]             ->   a key that is an agent
by 0 .. 2         ->   0, 1, 2               row[agent.turns]   ->   a key that is a number from 0 to 2
"""

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.elaborate.lookup import as_agent, check_known_word, check_somebody, not_a_word
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.ir.implications import narrow_word, narrowed
from sjdsl.compiler.ir.sorts import Level, level_of_agents, level_of_numbers
from sjdsl.compiler.ir.types import describe

SORTS = ("agent", "{ a, b }", "0 .. 4")


def level_of(by: ast.By, scope: Scope) -> Level:
    """Returns the entries that a row has."""
    match by:
        case ast.Words():
            return Level("word", tuple(dict.fromkeys(name.text for name in by.names)))
        case ast.Numbers():
            return _range(by, scope)
        case ast.Name(text="agent"):
            return level_of_agents(scope.static.num_agents)
        case ast.Name():
            raise scope.problems.unknown(by, SORTS, "what a row can be by", {by.text: _instead(by, scope)})


def _instead(by: ast.Name, scope: Scope) -> str:
    """Returns what to write for a sort that rows are not kept by."""
    if by.text in ("agents", "players"):
        return "write `by agent`: one entry for each agent"
    if scope.static.kinds_of(by.text):
        return f"cells keep what belongs to them in fields of their own: `kind {by.text} … {{ field … }}`"
    return ""


def _range(by: ast.Numbers, scope: Scope) -> Level:
    low, high = (scope.fixed(e, "the entries of a row") for e in (by.low, by.high))
    if low != int(low) or high != int(high) or low > high:
        given = f"{low:g} .. {high:g}"
        raise scope.problems.fail(errors.WrongType(by.span, wanted="a range of whole numbers, the smaller first", given=given))
    if high - low >= limits.MAX_WORDS:
        raise scope.problems.fail(errors.Unsupported(by.span, what=f"a row of more than {limits.MAX_WORDS} entries"))
    return level_of_numbers(int(low), int(high))


def key_of(tree: ast.Expr, row: ir.Expr | str, level: Level, scope: Scope) -> ir.Expr:
    """Returns the key of an entry of a row (given as an expression, or by its name), of the sort that the row is by."""
    if level.sort == "word":
        check_known_word(tree, row, level.names, scope)
    key = narrow_word(scope.expression(tree), scope.facts)
    if key.type.by or (key.type.kind == "mix" and isinstance(row, str)):
        raise wrong_type(scope, tree, _wanted(level), key.type)
    if key.type.kind == "mix":
        if key.type.words != level.names:
            raise not_a_word(tree.span, "mix", row, level.names, scope)
        return key
    match level.sort:
        case "word":
            if key.type.kind != "word":
                raise wrong_type(scope, tree, _wanted(level), key.type)
            outside = [w for w in key.type.words if w not in level.names]
            if outside:
                raise not_a_word(tree.span, outside[0], row, level.names, scope)
        case "agent":
            _check_agent(tree, key, level, scope)
        case "number":
            _check_number(tree, key, level, scope)
    return key


def _wanted(level: Level) -> str:
    match level.sort:
        case "word":
            return "a word"
        case "agent":
            return "an agent"
        case "number":
            return f"a number from {level.names[0]} to {level.names[-1]}"


def _check_agent(tree: ast.Expr, key: ir.Expr, level: Level, scope: Scope) -> None:
    if isinstance(key, ir.Nobody) or not as_agent(key):
        given = "nobody" if isinstance(key, ir.Nobody) else describe(key.type)
        help_ = "rules name agents by variables, not by their numbers: `each agent as b`" if isinstance(key, ir.Number) else ""
        raise scope.problems.fail(errors.WrongType(tree.span, wanted=_wanted(level), given=given, help=help_))
    check_somebody(key, tree.span, scope)


def _check_number(tree: ast.Expr, key: ir.Expr, level: Level, scope: Scope) -> None:
    if key.type.kind != "int":
        raise wrong_type(scope, tree, _wanted(level), key.type)
    low, high = narrowed(key, scope.facts_and_requires)
    if low < level.first or high > level.first + len(level) - 1:
        reach = (
            f"{low:g}"
            if low == high
            else f"{'any number' if low == -float('inf') else f'{low:g}'} .. {'any number' if high == float('inf') else f'{high:g}'}"
        )
        help_ = "" if isinstance(key, ir.Number) else "guard it with `when` or `where`, or bound it with `min` and `max`"
        raise scope.problems.fail(errors.WrongType(tree.span, wanted=_wanted(level), given=f"a number that can be {reach}", help=help_))
