"""Prints any text in any encoding: a character that an encoding lacks is spelt out in ASCII."""

import codecs
import io
import sys
import unicodedata
from typing import TextIO

SPELL_OUT = "sjdsl.spell_out"  # the name of the error handler
ASCII_SPELLINGS = {
    "…": "...", "×": "x", "±": "+-", "°": " degrees", "→": "->", "−": "-", "–": "-", "—": "-",
    "“": '"', "”": '"', "‘": "'", "’": "'",
}  # fmt: skip


def accept_any_text() -> None:
    """Makes standard output and standard error print every text, whatever their encoding."""
    codecs.register_error(SPELL_OUT, spell_out)
    sys.stdout = _accepting(sys.stdout)
    sys.stderr = _accepting(sys.stderr)


def spell_out(error: UnicodeError) -> tuple[str, int]:
    """Returns ASCII for characters that can't be encoded, and the index behind them.

    An error handler for `codecs`: signs are spelt out, accents left out; any other character
    becomes its number, as in `\\u30b3`.
    """
    assert isinstance(error, UnicodeEncodeError)
    missing = error.object[error.start : error.end]
    return "".join(map(_in_ascii, missing)), error.end


def _in_ascii(character: str) -> str:
    """Returns a character spelt out, without its accent, or as its number."""
    if character in ASCII_SPELLINGS:
        return ASCII_SPELLINGS[character]
    without_accents = unicodedata.normalize("NFD", character)[0]
    if without_accents.isascii() and without_accents.isalpha():
        return without_accents
    return character.encode("ascii", "backslashreplace").decode()


def _accepting(stream: TextIO) -> TextIO:
    """Returns a stream to the same place that spells out what its encoding lacks."""
    if not isinstance(stream, io.TextIOWrapper):  # None without a console
        return stream
    if codecs.lookup(stream.encoding).name == "ascii":
        return _Ascii(stream)
    stream.reconfigure(errors=SPELL_OUT)
    return stream


class _Ascii(io.TextIOWrapper):
    """Standard output or error in ASCII, under the name of another encoding.

    click writes UTF-8 to a stream whose encoding is called ASCII: it thinks that is a mistake.
    """

    def __init__(self, stream: io.TextIOWrapper) -> None:
        self._replaced = stream  # without a reference to it, it would close the buffer
        super().__init__(
            stream.buffer,
            "latin-1",
            line_buffering=stream.line_buffering,
            write_through=stream.write_through,
        )

    def write(self, text: str) -> int:
        return super().write(text.encode("ascii", SPELL_OUT).decode("ascii"))
