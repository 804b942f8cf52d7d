"""Soft words: words of the language only where the grammar has them, and names everywhere else.

Words that came to the language after its first version are soft, so that no older file loses a name.
"""

from lark import Token

from sjdsl.compiler.syntax.recovery.automaton import Automaton, Stack, read, read_as

SOFT = frozenset(
    {
        "POLICY",
        "SCENARIO",
        "CHOOSE",
        "AVOIDING",
        "AIM",
        "AT",
        "SLOTS",
        "FOCAL",
        "MOVERS",
        "TOWARD",
        "AWAY",
        "RANDOM",
        "AHEAD",
        "ALONG",
        "WRAPS",
    }
)  # fmt: skip  (kinds of tokens, as in the parser's table)


def as_names(table: Automaton, tokens: list[Token]) -> list[Token]:
    """Returns the tokens, with soft words as names where only a name can stand, up to the first error."""
    found, stack = list(tokens), Stack(table.start, None)
    for at, token in enumerate(tokens):
        found[at] = as_name(table, stack, token)
        after = read(table, stack, found[at].type)
        if after is None:
            return found
        stack = after
    return found


def as_name(table: Automaton, stack: Stack, token: Token) -> Token:
    """Returns a token, as a name if it is a soft word that cannot come here and a name can."""
    if token.type not in SOFT or read_as(table, stack, token.type) is not None or read_as(table, stack, "NAME") is None:
        return token
    return Token.new_borrow_pos("NAME", token, token)
