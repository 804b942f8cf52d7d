"""Texts with the same words and other spaces, line ends and comments: what a formatter must undo."""

import re
from collections.abc import Sequence

from hypothesis import strategies as st

LONG = " ".join(f"word{n}" for n in range(40))
QUIET = (" ", "  ", "\t", " \n", "\r\n", "\n\n", "\n \n\n\t")
LOUD = (
    " # said\n",
    "\n# alone\n",
    " #tight\n\n# two\n",
    "\n\n#\n",
    f" # {LONG}\n",
    f"\n#   {LONG}{LONG}\n",
    "#" * 150 + "\n",
    " # \r\n",
)


TOKEN = re.compile(r'"(?:\\.|[^"\\\n])*"|#[^\n]*|[a-z][a-z0-9_]*|\d+\.\d+|\d+|\.\.|->|[<>=!]=|\S')


def words_of(text: str) -> list[str]:
    return [word for word in TOKEN.findall(text) if not word.startswith("#")]


def comments_of(text: str) -> list[str]:
    """Returns the words of the comments in order; `#` only separates them, because a long comment goes on in a new line."""
    comments = (word for word in TOKEN.findall(text) if word.startswith("#"))
    return " ".join(comments).replace("#", " ").split()


def parts_of(text: str) -> tuple[list[str], list[str]]:
    """Returns the words of a text and what stands between them: before each, and behind the last."""
    words, gaps, end = [], [], 0
    for match in TOKEN.finditer(text):
        if not match.group().startswith("#"):
            words.append(match.group())
            gaps.append(text[end : match.start()])
            end = match.end()
    return words, [*gaps, text[end:]]


@st.composite
def damaged(draw: st.DrawFn, texts: Sequence[str]) -> str:
    """A text with some of its gaps replaced; comments that were there are lost, others come."""
    words, gaps = parts_of(draw(st.sampled_from(texts)))
    kept = draw(st.sampled_from((0.0, 0.5, 0.9, 0.98)))
    choice = draw(st.randoms(use_true_random=False))
    fresh = QUIET * draw(st.sampled_from((1, 5))) + LOUD
    new = [gap if choice.random() < kept else choice.choice(fresh) for gap in gaps]
    return "".join(gap + word for gap, word in zip(new, [*words, ""], strict=True))
