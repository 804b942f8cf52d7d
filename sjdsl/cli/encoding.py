"""Prints any text in any encoding: what an encoding lacks is spelt with characters that it has."""

import codecs
import io
import sys
import unicodedata
from typing import TextIO

SPELL_OUT = "sjdsl.spell_out"  # the name of the error handler
SPELT = {
    "…": "...", "×": "x", "±": "+-", "°": " degrees", "→": "->", "−": "-", "–": "-", "—": "-", "“": '"', "”": '"', "‘": "'", "’": "'",
}  # fmt: skip


def accept_any_text() -> None:
    """Has this process print every text to standard output and standard error, whatever their encoding."""
    codecs.register_error(SPELL_OUT, spell_out)
    sys.stdout = _accepting(sys.stdout)
    sys.stderr = _accepting(sys.stderr)


def spell_out(error: UnicodeError) -> tuple[str, int]:
    """Returns ASCII for what could not be encoded, and where to go on: an error handler for `codecs`.

    Signs are spelt, accents left out; any other character becomes its number, as in `\\u30b3`.
    """
    assert isinstance(error, UnicodeEncodeError)
    missing = error.object[error.start : error.end]
    return "".join(map(_spelt, missing)), error.end


def _spelt(character: str) -> str:
    if character in SPELT:
        return SPELT[character]
    base = unicodedata.normalize("NFD", character)[0]  # of a letter with accents that without them
    if base.isascii() and base.isalpha():
        return base
    return character.encode("ascii", "backslashreplace").decode()


def _accepting(stream: TextIO) -> TextIO:
    if not isinstance(stream, io.TextIOWrapper):  # None without a console
        return stream
    if codecs.lookup(stream.encoding).name == "ascii":
        return _Ascii(stream)
    stream.reconfigure(errors=SPELL_OUT)
    return stream


class _Ascii(io.TextIOWrapper):
    """Standard output or error in ASCII, named otherwise: click takes a stream of that name for a mistake, and writes UTF-8 to it."""

    def __init__(self, stream: io.TextIOWrapper) -> None:
        self._replaced = stream  # which closes the buffer when nothing refers to it
        super().__init__(
            stream.buffer,
            "latin-1",
            line_buffering=stream.line_buffering,
            write_through=stream.write_through,
        )

    def write(self, text: str) -> int:
        return super().write(text.encode("ascii", SPELL_OUT).decode("ascii"))
