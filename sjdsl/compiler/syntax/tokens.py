"""The lexer: cuts a text into tokens, and reports mistaken characters.

Source -> tokens, problems
"""

from dataclasses import dataclass, field

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
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.syntax.characters import CONTROL, bad_character, control_characters
from sjdsl.compiler.syntax.soft_words import names_in_place

OPENING = ("LBRACE", "LPAR", "LSQB")
CLOSING = ("RBRACE", "RPAR", "RSQB")
PREFIX = ("NOT", "SIGN")
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
    """Returns the tokens of a text and what is wrong with its characters.

    It stops at a limit of the compiler, and leaves out the rest of a line after a wrong character.
    """
    result = Scan(source, problems=control_characters(source))
    text = CONTROL.sub(" ", source.text) if result.problems else source.text
    thread = parser.parse_interactive(text).lexer_thread
    assert thread.state is not None, "the lexer has a text"
    reading = True
    while reading:
        try:
            for token in thread.lex(None):
                result.tokens.append(token)
                reading = _check_limits(result, token)
                if not reading:
                    break
            else:
                break
        except UnexpectedCharacters as error:
            at = error.pos_in_stream or 0
            result.problems.append(bad_character(source, text, at))
            thread.state.line_ctr.feed(text[at:].split("\n", 1)[0])
            reading = len(result.problems) < MAX_PROBLEMS
    for at in names_in_place([token.type for token in result.tokens]):
        token = result.tokens[at]
        result.tokens[at] = Token.new_borrow_pos("NAME", token, token)
    return result


def is_too_large(digits: str) -> bool:
    """Returns whether a whole number is larger than those of the language.

    A number of very many digits is not computed.
    """
    return len(digits) >= LONG and (len(digits.lstrip("0")) > LONG or int(digits) > MAX_INTEGER)


def _check_limits(result: Scan, token: Token) -> bool:
    """Reports a number too large, tokens too many or nested too deeply.

    Returns whether reading may go on: not after the latter two.
    """

    def span() -> Span:  # counts lines, so it is computed for mistakes alone
        return result.source.span(token.start_pos or 0, token.end_pos or 0)

    match token.type:
        case "INT" if is_too_large(token):
            shown = token if len(token) < 20 else f"{token[:8]}... ({len(token)} digits)"
            result.problems.append(too_much(f"{shown} is too large a number", MAX_INTEGER, span()))
        case "DEC" if len(token) > MAX_DIGITS:
            problem = f"this number has {len(token)} characters"
            result.problems.append(too_much(problem, MAX_DIGITS, span()))
    result.brackets += BRACKETS.get(token.type, 0)
    result.prefixes = result.prefixes + 1 if token.type in PREFIX else 0
    if result.brackets + result.prefixes > MAX_DEPTH:
        result.problems.append(errors.TooDeep(span(), limit=MAX_DEPTH))
        return False
    if len(result.tokens) > MAX_TOKENS:
        result.problems.append(too_much("the file has more words and signs", MAX_TOKENS, span()))
        return False
    return True
