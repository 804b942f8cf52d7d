"""Characters outside the language: what they were meant to be, and the message about them."""

import re
import unicodedata
from itertools import islice

from lark import Token

from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic, Fix
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.limits import MAX_PROBLEMS
from sjdsl.compiler.diagnostics.source import Source

# Signs people write by habit, or that a word processor writes for them, with the sign of the language and its token.
SIGNS = {
    "–": ("-", "SIGN"), "—": ("-", "SIGN"), "−": ("-", "SIGN"), "→": ("->", "ARROW"), "…": ("..", "DOTS"),
    "×": ("*", "TIMES"), "·": ("*", "TIMES"), "÷": ("/", "TIMES"), "≤": ("<=", "CMP"), "≥": (">=", "CMP"), "≠": ("!=", "CMP"),
    "&": ("and", "AND"), "∧": ("and", "AND"), "|": ("or", "OR"), "∨": ("or", "OR"), "!": ("not", "NOT"), "¬": ("not", "NOT"),
}  # fmt: skip
QUOTES = "“”„«»‘’'`"
# Letters of other scripts that look like ours.
LETTERS = dict(zip("аеорсухіјѕԁԛԝαορνικτ", "aeopcyxijsdqwaopvikt", strict=True))
NO_NAME = "name"  # what a word is read as of which no letter is known
CONTROL = re.compile(r"[\x01-\x08\x0b\x0e-\x1f\x7f-\x9f\u200b-\u200f\u2028-\u202e\u2060-\u2069\ufeff\ud800-\udfff]")


class Mended(Record):
    """What was wrong, the token it is read as (None: nothing), and where reading resumes."""

    problem: Diagnostic
    token: Token | None
    end: int


def describe(character: str) -> str:
    """Returns a character as messages show it: itself, and its code and name where it could be taken for another."""
    name = unicodedata.name(character, "a control character").lower()
    if not character.isprintable():
        return f"U+{ord(character):04X} ({name})"
    return f"`{character}`" if character.isascii() else f"`{character}` (U+{ord(character):04X}, {name})"


def without_controls(source: Source) -> tuple[str, list[Diagnostic]]:
    """Reports control and invisible characters, also in comments and texts; returns the text, as long, without them."""
    text = source.text
    problems: list[Diagnostic] = []
    for match in islice(CONTROL.finditer(text), MAX_PROBLEMS):
        span = source.span(*match.span())
        problems.append(errors.BadCharacter(span, character=describe(match.group()), help="delete it", fix=Fix(span, "")))

    def blank(match: re.Match[str]) -> str:  # inside a name a letter, so that it stays one name
        return "_" if text[match.start() - 1 : match.start()].isalnum() and text[match.end() : match.end() + 1].isalnum() else " "

    return (CONTROL.sub(blank, text) if problems else text), problems


def mend(source: Source, text: str, at: int, last: Token | None, keywords: dict[str, str]) -> Mended:
    """Returns what to make of the character at `at`, which begins no token; `last` is the token before it."""
    character = text[at]
    if character == '"':  # without a partner: the text is taken to end before a brace, or with the line
        end = re.compile(r'"[^\n{}]*').match(text, at).end()  # type: ignore[union-attr]
        end = at + len(text[at:end].rstrip())
        help_ = r"`\"` is a quote inside a text; the sign `\` itself is written twice: `\\`" if text[at:end].endswith('\\"') else ""
        problem: Diagnostic = errors.OpenString(source.span(at, end), fix=Fix(source.span(end, end), '"'), help=help_)
        return Mended(problem, _token(source, "STRING", text[at:end] + '"', at, end), end)
    if character in QUOTES:  # a text in quotes of another sort
        whole = re.compile(rf'[{QUOTES}]([^\n{QUOTES}"]*)([{QUOTES}"]?)').match(text, at)
        assert whole is not None
        inside, close = whole.groups()
        if not close:
            return Mended(_bad(source, at, at + 1, character, '"', 'write `"`'), None, at + 1)
        problem = _bad(source, at, whole.end(), character, f'"{inside}"', 'write `"`')
        return Mended(problem, _token(source, "STRING", f'"{inside}"', at, whole.end()), whole.end())
    if character.isalnum() or character == "_":
        return _word(source, text, at, last, keywords)
    end = at + 1
    while text[end : end + 1] == character:
        end += 1
    instead, type_ = SIGNS.get(character, ("", ""))
    help_ = f"write `{instead}`" if instead else "write an ordinary space" if character.isspace() else ""
    if character == ";":
        help_ = "statements need nothing between them"
    problem = _bad(source, at, end, character, instead or " ", help_)
    return Mended(problem, _token(source, type_, instead, at, end) if instead else None, end)


def _bad(source: Source, start: int, end: int, character: str, fix: str, help_: str) -> Diagnostic:
    span = source.span(start, end)
    return errors.BadCharacter(span, character=describe(character), help=help_, fix=Fix(span, fix) if help_ else None)


def _token(source: Source, type_: str, value: str, start: int, end: int) -> Token:
    span = source.span(start, end)
    return Token(type_, value, start, span.line, span.column, span.line, span.column + end - start, end)


def _word(source: Source, text: str, at: int, last: Token | None, keywords: dict[str, str]) -> Mended:
    """A name with capitals, accents or look-alike letters: the whole of it is read in plain letters."""
    start = at
    if last is not None and last.end_pos == at and (last.type == "NAME" or str(last) in keywords):
        start = last.start_pos or 0
    end = re.compile(r"\w*").match(text, at).end()  # type: ignore[union-attr]
    # in the letters of the language: capitals small, accents dropped, look-alikes replaced
    letters = unicodedata.normalize("NFKD", "".join(LETTERS.get(c, c) for c in text[start:end].lower()))
    plain = re.sub(r"[^a-z0-9_]", "", "".join(LETTERS.get(c, c) for c in letters)).lstrip("0123456789_") or NO_NAME
    help_ = "names are written in small letters `a` to `z`, digits and `_`" + (f": `{plain}`" if plain != NO_NAME else "")
    problem = _bad(source, start, end, text[at], plain, help_)
    return Mended(problem, _token(source, keywords.get(plain, "NAME"), plain, start, end), end)
