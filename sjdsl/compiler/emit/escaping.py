"""Escapes text that goes into generated Python.

Every text of a game, and every name of a file, becomes part of generated code here alone.
"""


def quoted(text: str) -> str:
    """Returns a text as a Python literal."""
    return f'"{text}"' if text.isprintable() and not set(text) & set('\\"') else repr(text)


def remark(text: str) -> str:
    """Returns a text for a comment or a docstring: one line of printable ASCII.

    Each backslash, double quote and other character is a question mark.
    """
    return "".join(c if c.isascii() and c.isprintable() and c not in '\\"' else "?" for c in text)
