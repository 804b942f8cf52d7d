"""Soft words: words of the language only where the grammar has them, and names everywhere else.

A word that is added to the language is soft, so that no file loses a name.
"""

from collections.abc import Sequence
from itertools import pairwise

from lark import Token

from sjdsl.compiler.syntax.recovery.automaton import Automaton, Stack

SOFT = frozenset((  # kinds of tokens, as in the parser's table
    "POLICY", "SCENARIO", "CHOOSE", "AVOIDING", "AIM", "AT", "SLOTS", "FOCAL", "MOVERS", "TOWARD",
    "AWAY", "RANDOM", "AHEAD", "ALONG", "WRAPS", "ANY", "TRIALS", "KEEP", "DIFFERENT", "TASK",
    "TRAIN", "SEED", "HOLD", "OUT",
))  # fmt: skip
CALLED = frozenset({"ANY"})  # those that stand where names can as well: words only before `(`


def names_in_place(kinds: Sequence[str]) -> list[int]:
    """Returns the places of the tokens of `CALLED`, such as `any`, that are names here.

    They are those without `(` after them, and all of a word that a `define` of the text has as its
    name.

    kinds: of all tokens of a text, in order.
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
    stack = table.stack()
    for at, token in enumerate(tokens):
        resolved[at] = as_name(stack, token)
        after = stack.read(resolved[at].type)
        if after is None:
            break
        stack = after
    return resolved


def as_name(stack: Stack, token: Token) -> Token:
    """Returns a token, as a name if it is a soft word that cannot come here and a name can."""
    if token.type in SOFT and stack.read_as(token.type) is None:
        if stack.read_as("NAME") is not None:
            return Token.new_borrow_pos("NAME", token, token)
    return token
