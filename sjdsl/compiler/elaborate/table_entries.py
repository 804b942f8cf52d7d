"""Reads the table of a param whose sort is declared: which entry each key stands for, with ranges and `otherwise` spelt out.

param taste by agent : reward = { 0: 2, 1 .. 3: 1, otherwise: 0 }   ->   the value of each agent, as written
"""

from collections.abc import Iterator

from sjdsl.compiler import ast
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.elaborate.lookup import not_a_word
from sjdsl.compiler.elaborate.scope import Scope
from sjdsl.compiler.ir.sorts import Level

Tree = ast.Expr | ast.Table
OTHERWISE = "otherwise"


def entries_of(tree: Tree, level: Level, scope: Scope) -> list[Tree]:
    """Returns what is written for each entry; what is no table over the entries counts for all of them."""
    if not isinstance(tree, ast.Table) or not any(_is_key(entry.key.text, level) for entry in tree.entries):
        return [tree] * len(level)
    found: dict[int, Tree] = {}
    rest: ast.Entry | None = None
    for entry in tree.entries:
        if entry.key.text == OTHERWISE:
            rest = entry
            continue
        for place in _places(entry, level, scope):
            if place in found:
                raise scope.problems.fail(errors.TableRepeats(entry.key.span, name=entry.key.text))
            found[place] = entry.value
    if rest is not None and rest is not tree.entries[-1]:
        raise scope.problems.fail(errors.OtherwiseNotLast(rest.span))
    if rest is not None and len(found) == len(level) and level.sort != "agent":
        raise scope.problems.fail(errors.NothingForOtherwise(rest.span))
    lacking = tuple(name for place, name in enumerate(level.names) if place not in found)
    if rest is None and lacking:
        raise scope.problems.fail(errors.TableLacks(tree.span, words=lacking))
    return [found[place] if place in found or rest is None else rest.value for place in range(len(level))]


def _is_key(text: str, level: Level) -> bool:
    """Returns whether a key can only be one of this level, be it right or wrong."""
    return text == OTHERWISE or (text in level.names if level.sort == "word" else text[0].isdigit())


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
        raise scope.problems.fail(errors.WordForNumber(entry.key.span, name=text))
    ends = [int(part) for part in text.replace("..", " ").split()]
    last = first + len(level) - 1 if text.endswith("..") else ends[-1]
    if level.sort == "agent" and ends[0] <= ends[-1]:  # a table fits variants with fewer agents
        if last >= len(level) and scope.static.own_number:
            scope.problems.add(errors.NeverHappens(entry.key.span, problem=f"the agents are 0 .. {len(level) - 1}"))
        last = min(last, len(level) - 1)
    elif not first <= ends[0] <= last < first + len(level):
        known = (f"{first} .. {first + len(level) - 1}",)
        raise scope.problems.fail(errors.WordOutside(entry.key.span, word=text, owner="this table", words=known))
    yield from range(ends[0] - first, last - first + 1)
