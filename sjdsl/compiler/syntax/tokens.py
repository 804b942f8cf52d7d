"""The lexer: cuts a text into tokens, and reports mistaken characters.

Source -> tokens, problems
"""

from dataclasses import dataclass, field
from functools import partial

from lark import Lark, Token, UnexpectedCharacters

from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic, Fix
from sjdsl.compiler.diagnostics.limits import MAX_DEPTH, MAX_DIGITS, MAX_INTEGER, MAX_PROBLEMS, MAX_TOKENS, too_much
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.characters import mend, without_controls
from sjdsl.compiler.syntax.soft_words import names_in_place

OPENING, CLOSING, PREFIX = ("LBRACE", "LPAR", "LSQB"), ("RBRACE", "RPAR", "RSQB"), ("NOT", "SIGN")
BRACKETS = dict.fromkeys(OPENING, 1) | dict.fromkeys(CLOSING, -1)  # how much deeper each goes
LONG = len(str(MAX_INTEGER))


@dataclass
class Scan:
    """`mended`: which tokens stand for something already reported; `complete`: whether the text was read to its end."""

    source: Source
    tokens: list[Token] = field(default_factory=list)
    problems: list[Diagnostic] = field(default_factory=list)
    mended: set[int] = field(default_factory=set)
    complete: bool = True
    brackets: int = 0
    prefixes: int = 0


def scan(source: Source, parser: Lark) -> Scan:
    """Returns the tokens of a text and what is wrong with its characters; stops at a limit of the compiler."""
    text, problems = without_controls(source)
    found = Scan(source, problems=problems)
    keywords = {t.pattern.value: t.name for t in parser.terminals if t.pattern.value.isalpha()}
    thread = parser.parse_interactive(text).lexer_thread
    assert thread.state is not None, "a text was given"
    while found.complete:
        try:
            for token in thread.lex(None):
                found.tokens.append(token)
                found.complete = _is_within_limits(found, token)
                if not found.complete:
                    break
                if _is_foreign_comment(found):
                    line_end = (text + "\n").index("\n", token.end_pos)
                    thread.state.line_ctr.feed(text[token.end_pos : line_end])
            else:
                break
        except UnexpectedCharacters as error:
            at = error.pos_in_stream or 0
            last = found.tokens[-1] if found.tokens else None
            mended = mend(source, text, at, last, keywords)
            found.problems.append(mended.problem)
            if mended.token is not None:
                if last is not None and mended.token.start_pos == last.start_pos:
                    found.tokens.pop()
                found.mended.add(len(found.tokens))
                found.tokens.append(mended.token)
            thread.state.line_ctr.feed(text[at : mended.end])
            found.complete = len(found.problems) < MAX_PROBLEMS
    for at in names_in_place([token.type for token in found.tokens]):
        found.tokens[at] = Token.new_borrow_pos("NAME", found.tokens[at], found.tokens[at])
    return found


def is_too_large(digits: str) -> bool:
    """Returns whether a whole number is larger than those of the language; one of very many digits is not computed."""
    return len(digits) >= LONG and (len(digits.lstrip("0")) > LONG or int(digits) > MAX_INTEGER)


def _is_within_limits(found: Scan, token: Token) -> bool:
    """Reports a number too large, and too many or too deeply nested tokens; the latter two end the reading."""
    span = partial(found.source.span, token.start_pos or 0, token.end_pos or 0)  # counts lines: called for mistakes alone
    match token.type:
        case "INT" if is_too_large(token):
            shown = token if len(token) < 20 else f"{token[:8]}... ({len(token)} digits)"
            found.problems.append(too_much(f"{shown} is too large a number", MAX_INTEGER, span()))
        case "DEC" if len(token) > MAX_DIGITS:
            found.problems.append(too_much(f"this number has {len(token)} characters", MAX_DIGITS, span()))
    found.brackets += BRACKETS.get(token.type, 0)
    found.prefixes = found.prefixes + 1 if token.type in PREFIX else 0
    if found.brackets + found.prefixes > MAX_DEPTH:
        found.problems.append(errors.TooDeep(span(), limit=MAX_DEPTH))
        return False
    if len(found.tokens) > MAX_TOKENS:
        found.problems.append(too_much("the file has more words and signs", MAX_TOKENS, span()))
        return False
    return True


def _is_foreign_comment(found: Scan) -> bool:
    """Takes back `//` and `/*`, which begin a comment elsewhere, and reports them."""
    if len(found.tokens) < 2 or found.tokens[-1].type != "TIMES":
        return False
    first, second = found.tokens[-2:]
    if first != "/" or second not in ("/", "*") or first.end_pos != second.start_pos:
        return False
    del found.tokens[-2:]
    span = found.source.span(first.start_pos or 0, second.end_pos or 0)
    help_ = "a comment begins with `#`"
    found.problems.append(errors.Unexpected(span, found=f"`{first}{second}`", expected="`#`", help=help_, fix=Fix(span, "#")))
    return True
