"""The title of a game, read from its text without compiling it."""

import re

_TITLE = re.compile(r'^\s*game\s+\w+\s+"((?:[^"\\\n]|\\.)*)"', re.MULTILINE)


def title_of(text: str) -> str:
    """Returns the title that the text of a game begins with, "" if there is none."""
    found = _TITLE.search(text)
    return found[1].replace('\\"', '"') if found else ""
