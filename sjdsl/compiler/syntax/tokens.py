"""The lexer: cuts a text into tokens, and reports mistaken characters.

Source -> tokens, problems
"""

from dataclasses import dataclass, field
from functools import partial

from lark import Lark, Token, UnexpectedCharacters

from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic
from sjdsl.compiler.diagnostics.limits import (
    MAX_DEPTH,
    MAX_DIGITS,
    MAX_INTEGER,
    MAX_PROBLEMS,
    MAX_TOKENS,
    too_much,
)
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.characters import CONTROL, bad_character, control_characters
from sjdsl.compiler.syntax.soft_words import names_in_place

OPENING, CLOSING, PREFIX = ("LBRACE", "LPAR", "LSQB"), ("RBRACE", "RPAR", "RSQB"), ("NOT", "SIGN")
BRACKETS = dict.fromkeys(OPENING, 1) | dict.fromkeys(CLOSING, -1)  # how much deeper each goes
LONG = len(str(MAX_INTEGER))


@dataclass
class Scan:
    """The tokens of a text, and what is wrong with its characters, its numbers and its size."""

    source: Source
    tokens: list[Token] = field(default_factory=list)
    problems: list[Diagnostic] = field(default_factory=list)
    brackets: int = 0
    prefixes: int = 0


def scan(source: Source, parser: Lark) -> Scan:
    """Returns the tokens of a text and what is wrong with its characters; stops at a limit of the compiler.

    What stands behind a wrong character in its line is left out.
    """
    found = Scan(source, problems=control_characters(source))
    text = CONTROL.sub(" ", source.text) if found.problems else source.text
    thread = parser.parse_interactive(text).lexer_thread
    assert thread.state is not None, "a text was given"
    reading = True
    while reading:
        try:
            for token in thread.lex(None):
                found.tokens.append(token)
                reading = _is_within_limits(found, token)
                if not reading:
                    break
            else:
                break
        except UnexpectedCharacters as error:
            at = error.pos_in_stream or 0
            found.problems.append(bad_character(source, text, at))
            thread.state.line_ctr.feed(text[at:].split("\n", 1)[0])
            reading = len(found.problems) < MAX_PROBLEMS
    for at in names_in_place([token.type for token in found.tokens]):
        found.tokens[at] = Token.new_borrow_pos("NAME", found.tokens[at], found.tokens[at])
    return found


def is_too_large(digits: str) -> bool:
    """Returns whether a whole number is larger than those of the language; one of very many digits is not computed."""
    return len(digits) >= LONG and (len(digits.lstrip("0")) > LONG or int(digits) > MAX_INTEGER)


def _is_within_limits(found: Scan, token: Token) -> bool:
    """Reports a number too large, and too many or too deeply nested tokens; the latter two end the reading."""
    span = partial(
        found.source.span, token.start_pos or 0, token.end_pos or 0
    )  # counts lines: called for mistakes alone
    match token.type:
        case "INT" if is_too_large(token):
            shown = token if len(token) < 20 else f"{token[:8]}... ({len(token)} digits)"
            found.problems.append(too_much(f"{shown} is too large a number", MAX_INTEGER, span()))
        case "DEC" if len(token) > MAX_DIGITS:
            found.problems.append(
                too_much(f"this number has {len(token)} characters", MAX_DIGITS, span())
            )
    found.brackets += BRACKETS.get(token.type, 0)
    found.prefixes = found.prefixes + 1 if token.type in PREFIX else 0
    if found.brackets + found.prefixes > MAX_DEPTH:
        found.problems.append(errors.TooDeep(span(), limit=MAX_DEPTH))
        return False
    if len(found.tokens) > MAX_TOKENS:
        found.problems.append(too_much("the file has more words and signs", MAX_TOKENS, span()))
        return False
    return True
