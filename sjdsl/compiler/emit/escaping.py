"""Escapes text that goes into generated Python: every text of a game, and every name of a file, becomes part of it here alone."""


def quoted(text: str) -> str:
    """Returns a text as a Python literal."""
    return f'"{text}"' if text.isprintable() and not set(text) & set('\\"') else repr(text)


def remark(text: str) -> str:
    """Returns a text as it may stand in a comment or a docstring: one line of printable ASCII without backslashes and double quotes."""
    return "".join(c if c.isascii() and c.isprintable() and c not in '\\"' else "?" for c in text)
