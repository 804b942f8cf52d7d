"""Elaborates what rows and tables are indexed by: the sort after `by`, the key in square brackets, and the entries that a table lists.

by { raw, cut }   ->   raw, cut              row[agent.grade]   ->   a key of type word
by agent          ->   agent 0, agent 1      row[b]             ->   a key that is an agent
by 0 .. 2         ->   0, 1, 2               row[agent.turns]   ->   a key that is a number from 0 to 2
"""

from collections.abc import Iterator

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.elaborate.lookup import (
    as_agent,
    check_known_word,
    check_somebody,
    check_words,
    interval_text,
    not_a_word,
)
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.ir.implications import narrow_word, narrowed
from sjdsl.compiler.ir.sorts import Level, level_of_agents, level_of_numbers
from sjdsl.compiler.ir.types import describe

SORTS = ("agent", "{ a, b }", "0 .. 4")
OTHERWISE = "otherwise"
Tree = ast.Expr | ast.Table


def level_of(by: ast.By, scope: Scope) -> Level:
    """Returns the entries that a row has."""
    match by:
        case ast.Words():
            return Level("word", tuple(dict.fromkeys(name.text for name in by.names)))
        case ast.Numbers():
            low, high = (scope.fixed(e, "the entries of a row") for e in (by.low, by.high))
            if low != int(low) or high != int(high) or low > high:
                wanted, given = (
                    "a range of whole numbers, the smaller first",
                    f"{low:g} .. {high:g}",
                )
                raise scope.fail(errors.WrongType(by.span, wanted=wanted, actual=given))
            if high - low >= limits.MAX_WORDS:
                raise scope.fail(
                    errors.Unsupported(
                        by.span, feature=f"a row of more than {limits.MAX_WORDS} entries"
                    )
                )
            return level_of_numbers(int(low), int(high))
        case ast.Name(text="agent"):
            return level_of_agents(scope.static.num_agents)
        case ast.Name():
            instead = ""
            if by.text in ("agents", "players"):
                instead = "write `by agent`: one entry for each agent"
            elif scope.static.kinds_of(by.text):
                instead = f"cells keep what belongs to them in fields of their own: `kind {by.text} … {{ field … }}`"
            raise scope.problems.unknown(by, SORTS, "what a row can be by", instead)


def key_of(tree: ast.Expr, row: ir.Expr | str, level: Level, scope: Scope) -> ir.Expr:
    """Returns the key of an entry of a row (given as an expression, or by its name), of the sort that the row is by."""
    wanted = {
        "word": "a word",
        "agent": "an agent",
        "number": f"a number from {level.names[0]} to {level.names[-1]}",
    }[level.sort]
    if level.sort == "word":
        check_known_word(tree, row, level.names, scope)
    key = narrow_word(scope.expression(tree), scope.facts)
    if key.type.by or (key.type.kind == "mix" and isinstance(row, str)):
        raise wrong_type(scope, tree, wanted, key.type)
    if key.type.kind == "mix":
        if key.type.words != level.names:
            raise not_a_word(tree.span, "mix", row, level.names, scope)
        return key
    match level.sort:
        case "word":
            if key.type.kind != "word":
                raise wrong_type(scope, tree, wanted, key.type)
            check_words(key.type.words, level.names, tree.span, row, scope)
        case "agent":
            if isinstance(key, ir.Nobody) or not as_agent(key):
                given = "nobody" if isinstance(key, ir.Nobody) else describe(key.type)
                help_ = (
                    "rules name agents by variables, not by their numbers: `each agent as b`"
                    if isinstance(key, ir.Number)
                    else ""
                )
                raise scope.fail(
                    errors.WrongType(tree.span, wanted=wanted, actual=given, help=help_)
                )
            check_somebody(key, tree.span, scope)
        case "number":
            if key.type.kind != "int":
                raise wrong_type(scope, tree, wanted, key.type)
            low, high = narrowed(key, scope.facts_and_requires)
            if low < level.first or high > level.first + len(level) - 1:
                given = f"a number that can be {interval_text(low, high)}"
                help_ = (
                    ""
                    if isinstance(key, ir.Number)
                    else "guard it with `when` or `where`, or bound it with `min` and `max`"
                )
                raise scope.fail(
                    errors.WrongType(tree.span, wanted=wanted, actual=given, help=help_)
                )
    return key


def entries_of(tree: Tree, level: Level, scope: Scope) -> list[Tree]:
    """Returns what is written for each entry of a level, with ranges and `otherwise` spelt out.

    param taste by agent : reward = { 0: 2, 1 .. 3: 1, otherwise: 0 }   ->   the value of each agent, as written

    Anything but a table over the entries is the value of all of them.
    """

    def is_key(text: str) -> bool:  # right or wrong
        return text == OTHERWISE or (
            text in level.names if level.sort == "word" else text[0].isdigit()
        )

    if not isinstance(tree, ast.Table) or not any(is_key(entry.key.text) for entry in tree.entries):
        return [tree] * len(level)
    found: dict[int, Tree] = {}
    rest: ast.Entry | None = None
    for entry in tree.entries:
        if entry.key.text == OTHERWISE:
            rest = entry
            continue
        for place in _places(entry, level, scope):
            if place in found:
                raise scope.fail(errors.TableRepeats(entry.key.span, name=entry.key.text))
            found[place] = entry.value
    if rest is not None and rest is not tree.entries[-1]:
        raise scope.fail(errors.OtherwiseNotLast(rest.span))
    if rest is not None and len(found) == len(level) and level.sort != "agent":
        raise scope.fail(errors.NothingForOtherwise(rest.span))
    lacking = tuple(name for place, name in enumerate(level.names) if place not in found)
    if rest is None and lacking:
        raise scope.fail(errors.TableLacks(tree.span, words=lacking))
    return [
        found[place] if place in found or rest is None else rest.value
        for place in range(len(level))
    ]


def _places(entry: ast.Entry, level: Level, scope: Scope) -> Iterator[int]:
    """Yields the places in a level that a key stands for."""
    text, first = entry.key.text, level.first
    if level.sort == "word":
        if text not in level.names:
            raise not_a_word(entry.key.span, text, "this table", level.names, scope)
        scope.static.refer(entry.key, Symbol("word", text))
        yield level.names.index(text)
        return
    if not text[0].isdigit():
        raise scope.fail(errors.WordForNumber(entry.key.span, name=text))
    ends = [int(part) for part in text.replace("..", " ").split()]
    last = first + len(level) - 1 if text.endswith("..") else ends[-1]
    if level.sort == "agent" and ends[0] <= ends[-1]:  # a table fits variants with fewer agents
        if last >= len(level) and scope.static.own_number:
            scope.problems.add(
                errors.NeverHappens(entry.key.span, problem=f"the agents are 0 .. {len(level) - 1}")
            )
        last = min(last, len(level) - 1)
    elif not first <= ends[0] <= last < first + len(level):
        known = (f"{first} .. {first + len(level) - 1}",)
        raise scope.fail(
            errors.WordOutside(entry.key.span, word=text, owner="this table", words=known)
        )
    yield from range(ends[0] - first, last - first + 1)
