"""Soft words: words of the language only where the grammar has them, and names everywhere else.

A word that is added to the language is soft, so that no file loses a name.
"""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

from lark import Token

from sjdsl.compiler.syntax.recovery.automaton import Automaton, Stack, read, read_as

SOFT = frozenset((  # kinds of tokens, as in the parser's table
    "POLICY", "SCENARIO", "CHOOSE", "AVOIDING", "AIM", "AT", "SLOTS", "FOCAL", "MOVERS", "TOWARD",
    "AWAY", "RANDOM", "AHEAD", "ALONG", "WRAPS", "ANY", "TRIALS", "KEEP", "DIFFERENT", "TASK",
    "TRAIN", "SEED", "HOLD", "OUT",
))  # fmt: skip
CALLED = frozenset({"ANY"})  # those that stand where names can as well: words only before `(`


def names_in_place(kinds: Sequence[str]) -> list[int]:
    """Returns which tokens of `CALLED` are names.

    They are those without `(`, and all of a word that the text gives to a `define`.
    """
    if CALLED.isdisjoint(kinds):
        return []
    defined = {kind for before, kind in pairwise(kinds) if before == "DEFINE"}
    following = [*kinds[1:], ""]
    return [
        at
        for at, kind in enumerate(kinds)
        if kind in CALLED and (kind in defined or following[at] != "LPAR")
    ]


def as_names(table: Automaton, tokens: list[Token]) -> list[Token]:
    """Returns the tokens up to the first error, soft words as names where only a name can come."""
    resolved = list(tokens)
    stack = Stack(table.start, None)
    for at, token in enumerate(tokens):
        resolved[at] = as_name(table, stack, token)
        after = read(table, stack, resolved[at].type)
        if after is None:
            break
        stack = after
    return resolved


def as_name(table: Automaton, stack: Stack, token: Token) -> Token:
    """Returns a token, as a name if it is a soft word that cannot come here and a name can."""
    if token.type in SOFT and read_as(table, stack, token.type) is None:
        if read_as(table, stack, "NAME") is not None:
            return Token.new_borrow_pos("NAME", token, token)
    return token


def can_come(
    states: Mapping[int, Mapping[str, tuple[Any, Any]]], stack: Sequence[int], kind: str
) -> bool:
    """Returns whether a token of this kind can be the next.

    states: the parser's table. stack: the states that it is in.
    """
    stack = list(stack)
    while True:
        _, argument = states[stack[-1]].get(kind, (None, None))
        if not hasattr(argument, "expansion"):
            return argument is not None
        if argument.expansion:
            del stack[-len(argument.expansion) :]
        stack.append(states[stack[-1]][argument.origin.name][1])
