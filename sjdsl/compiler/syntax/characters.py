"""Characters outside the language, and the message about each."""

import re
import unicodedata
from itertools import islice

from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic, Fix
from sjdsl.compiler.diagnostics.limits import MAX_PROBLEMS
from sjdsl.compiler.diagnostics.slips import slip
from sjdsl.compiler.diagnostics.source import Source

CONTROL = re.compile(
    r"[\x01-\x08\x0b\x0e-\x1f\x7f-\x9f\u200b-\u200f\u2028-\u202e\u2060-\u2069\ufeff\ud800-\udfff]"
)
WORD = re.compile(r"\w+|.", re.DOTALL)
WORDS = re.compile(r"\w+|[^\w\s]")
NEAR = 12  # words before and behind a character that tell what it is meant for


def describe(character: str) -> str:
    """Returns a character as messages show it, with its code and name if it can be mistaken."""
    if character.isascii() and character.isprintable():
        return f"`{character}`"
    code = f"U+{ord(character):04X}"
    name = unicodedata.name(character, "a control character").lower()
    return f"`{character}` ({code}, {name})" if character.isprintable() else f"{code} ({name})"


def control_characters(source: Source) -> list[Diagnostic]:
    """Reports control and invisible characters, also in comments and texts."""
    problems: list[Diagnostic] = []
    for match in islice(CONTROL.finditer(source.text), MAX_PROBLEMS):
        span = source.span(*match.span())
        problems.append(
            errors.BadCharacter(
                span, character=describe(match.group()), help="delete it", fix=Fix(span, "")
            )
        )
    return problems


def bad_character(source: Source, text: str, at: int) -> Diagnostic:
    """Returns what is wrong with the character at `at`, which begins no word or sign."""
    line_before = text[text.rfind("\n", 0, at) + 1 : at]
    line_from_here = text[at:].split("\n", 1)[0]
    if text[at] == '"':  # without a partner in its line
        end = at + len(line_from_here.rstrip())
        help_ = ""
        if text[at:end].endswith('\\"'):
            help_ = r"`\"` is a quote inside a text; the sign `\` itself is written twice: `\\`"
        fix = Fix(source.span(end, end), '"')
        return errors.OpenString(source.span(at, end), fix=fix, help=help_)
    match = WORD.match(text, at)
    assert match is not None
    span = source.span(at, match.end())
    before = " ".join(WORDS.findall(line_before)[-NEAR:])
    written = " ".join(WORDS.findall(line_from_here)[:NEAR])
    hint, _ = slip(written, (), before)
    if not hint:
        hint, _ = slip(match.group(), ())
    small = match.group().lower()
    if hint or not small.isidentifier():
        return errors.BadCharacter(span, character=describe(text[at]), help=hint)
    help_ = "names are written in small letters `a` to `z`, digits and `_`"
    fix_case = Fix(span, small) if small.isascii() else None
    return errors.BadCharacter(span, character=describe(text[at]), help=help_, fix=fix_case)
