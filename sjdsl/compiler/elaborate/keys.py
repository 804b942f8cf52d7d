"""Elaborates what rows and tables are indexed by: `by`, keys in brackets, entries of a table.

by { raw, cut }   ->   raw, cut              row[agent.grade]   ->   a key of type word
by agent          ->   agent 0, agent 1      row[b]             ->   a key that is an agent
by 0 .. 2         ->   0, 1, 2               row[agent.turns]   ->   a key from 0 to 2
"""

from collections.abc import Iterator

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.elaborate.lookup import (
    check_agent,
    check_known_word,
    check_words,
    interval_text,
    not_a_word,
    not_among,
)
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.ir.entity_types import IndexSet, agent_indices, number_indices
from sjdsl.compiler.ir.implications import narrowed

ENTRIES = ("agent", "{ a, b }", "0 .. 4")
OTHERWISE = "otherwise"
Tree = ast.Expr | ast.Table


def index_set_of(by: ast.By, scope: Scope) -> IndexSet:
    """Returns the entries that a row has."""
    match by:
        case ast.Words():
            return IndexSet("word", tuple(dict.fromkeys(name.text for name in by.names)))
        case ast.Numbers():
            low = scope.fixed(by.low, "the entries of a row")
            high = scope.fixed(by.high, "the entries of a row")
            if low != int(low) or high != int(high) or low > high:
                wanted = "a range of whole numbers, the smaller first"
                actual = f"{low:g} .. {high:g}"
                raise scope.expected(by.span, wanted, actual)
            if high - low >= limits.MAX_WORDS:
                feature = f"a row of more than {limits.MAX_WORDS} entries"
                raise scope.fail(errors.Unsupported(by.span, feature=feature))
            return number_indices(int(low), int(high))
        case ast.Name(text="agent"):
            return agent_indices(scope.static.num_agents)
        case ast.Name():
            help_ = ""
            if by.text in ("agents", "players"):
                help_ = "write `by agent`: one entry for each agent"
            elif scope.static.kinds_of(by.text):
                help_ = (
                    "cells keep what belongs to them in fields of their own: "
                    f"`kind {by.text} … {{ field … }}`"
                )
            raise scope.problems.unknown(by, ENTRIES, "what a row can be by", help_)


def key_of(tree: ast.Expr, row: ir.Expr | str, index_set: IndexSet, scope: Scope) -> ir.Expr:
    """Returns the key of an entry of a row, one of those in `index_set`; reports any other.

    row: an expression, or the name of an event.
    """
    wanted = {
        "word": "a word",
        "agent": "an agent",
        "number": f"a number from {index_set.names[0]} to {index_set.names[-1]}",
    }[index_set.kind]
    if index_set.kind == "word":
        check_known_word(tree, row, index_set.names, scope)
    key = scope.narrowed(tree)
    if key.type.indexed_by or (key.type.kind == "mix" and isinstance(row, str)):
        raise wrong_type(scope, tree, wanted, key.type)
    if key.type.kind == "mix":
        if key.type.words != index_set.names:
            raise not_a_word(tree.span, "mix", row, index_set.names, scope)
        return key
    match index_set.kind:
        case "word":
            if key.type.kind != "word":
                raise wrong_type(scope, tree, wanted, key.type)
            check_words(key.type.words, index_set.names, tree.span, row, scope)
        case "agent":
            help_ = ""
            if isinstance(key, ir.Number):
                help_ = "rules name agents by variables, not by their numbers: `each agent as b`"
            check_agent(key, tree, wanted, scope, help_)
        case "number":
            if key.type.kind != "int":
                raise wrong_type(scope, tree, wanted, key.type)
            low, high = narrowed(key, scope.facts_and_requires)
            if low < index_set.first or high > index_set.last:
                actual = f"a number that can be {interval_text(low, high)}"
                help_ = ""
                if not isinstance(key, ir.Number):
                    help_ = "guard it with `when` or `where`, or bound it with `min` and `max`"
                raise scope.expected(tree.span, wanted, actual, help_)
    return key


def entries_of(tree: Tree, index_set: IndexSet, scope: Scope) -> list[Tree]:
    """Returns what is written for each entry, with ranges and `otherwise` spelt out.

    param taste by agent : reward = { 0: 2, 1 .. 3: 1, otherwise: 0 }   ->   the value of each agent

    Anything but a table over the entries is the value of all of them.
    """
    if not isinstance(tree, ast.Table) or not any(
        _is_key(e.key.text, index_set) for e in tree.entries
    ):
        return [tree] * len(index_set)
    values: dict[int, Tree] = {}
    otherwise: ast.Entry | None = None
    for entry in tree.entries:
        if entry.key.text == OTHERWISE:
            otherwise = entry
            continue
        for place in _places(entry, index_set, scope):
            if place in values:
                raise scope.fail(errors.TableRepeats(entry.key.span, name=entry.key.text))
            values[place] = entry.value
    lacking = [place for place in range(len(index_set)) if place not in values]
    if otherwise is not None:
        if otherwise is not tree.entries[-1]:
            raise scope.fail(errors.OtherwiseNotLast(otherwise.span))
        if not lacking and index_set.kind != "agent":
            raise scope.fail(errors.NothingForOtherwise(otherwise.span))
        values |= dict.fromkeys(lacking, otherwise.value)
    elif lacking:
        names = tuple(index_set.names[place] for place in lacking)
        raise scope.fail(errors.TableLacks(tree.span, words=names))
    return [values[place] for place in range(len(index_set))]


def _is_key(text: str, index_set: IndexSet) -> bool:
    """Returns whether the key of a table may be meant for an entry of an index set."""
    if index_set.kind == "word":
        return text == OTHERWISE or text in index_set.names
    return text == OTHERWISE or text[0].isdigit()


def _places(entry: ast.Entry, index_set: IndexSet, scope: Scope) -> Iterator[int]:
    """Yields the places in an index set that a key stands for: `cut`, `3`, `1 .. 3` or `2 ..`."""
    text = entry.key.text
    if index_set.kind == "word":
        if text not in index_set.names:
            raise not_among(entry.key, index_set.names, "this table", scope)
        scope.static.refer(entry.key, Symbol("word", text))
        yield index_set.names.index(text)
        return
    if not text[0].isdigit():
        raise scope.fail(errors.WordForNumber(entry.key.span, name=text))
    ends = [int(part) for part in text.replace("..", " ").split()]
    low = ends[0]
    high = index_set.last if text.endswith("..") else ends[-1]
    if index_set.kind == "agent" and low <= ends[-1]:  # a table fits variants with fewer agents
        if high > index_set.last and scope.static.number_from_file:
            problem = f"the agents are 0 .. {index_set.last}"
            scope.problems.add(errors.NeverHappens(entry.key.span, problem=problem))
        high = min(high, index_set.last)
    elif not index_set.first <= low <= high <= index_set.last:
        known = (f"{index_set.first} .. {index_set.last}",)
        raise not_among(entry.key, known, "this table", scope)
    yield from range(low - index_set.first, high - index_set.first + 1)
