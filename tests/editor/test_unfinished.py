"""Whatever is typed, every question gets an answer: texts cut off, with parts missing, and with signs of no meaning."""

import random
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress

import pytest
from lsprotocol import types

from sjdsl.editor.navigation import Refused
from sjdsl.editor.session import Session
from tests.editor.asked import ORCHARD

NOISE = (
    "{",
    "}",
    '"',
    "(",
    ".",
    "\n",
    "é",
    "😀",
    "\r",
    "\0",
    "#",
    "=",
    " each ",
    " set a.",
    "[",
    "sj 2",
    "extends",
    "\u2028",
    "of ",
)
URI = "untitled:orchard.sj"


def damaged(number: int) -> Iterator[str]:
    """Yields texts as they are while one types, and worse ones; the same ones each time."""
    chance = random.Random(7)
    for at in range(0, len(ORCHARD), len(ORCHARD) // number):
        yield ORCHARD[:at]
        start, end = sorted((chance.randrange(len(ORCHARD)), chance.randrange(len(ORCHARD))))
        yield ORCHARD[:start] + ORCHARD[min(end, start + 40) :]
        yield ORCHARD[:start] + chance.choice(NOISE) + ORCHARD[start:]


def ask_everything(session: Session, position: types.Position) -> None:
    session.diagnostics(URI)
    session.completion(URI, position)
    session.hover(URI, position)
    session.definition(URI, position)
    session.references(URI, position)
    session.formatting(URI)
    session.symbols(URI)
    with suppress(Refused):
        session.rename(URI, position, "other_name")


def test_every_question_about_an_unfinished_text_is_answered() -> None:
    session, chance = Session(), random.Random(8)
    for version, text in enumerate(damaged(12)):
        session.open(URI, text, version)
        document = session.documents.get(URI)
        assert document is not None
        ask_everything(session, document.lines.position(chance.randrange(len(text) + 1)))
        ask_everything(session, types.Position(chance.randrange(60), chance.randrange(200)))


@pytest.mark.parametrize(
    "text",
    [
        "",
        " ",
        "\n",
        "#",
        '"',
        "\0",
        "sj",
        "sj 1",
        "sj 2\ngame",
        "\ud800",
        "😀" * 9,
        "\r\r",
        "x" * 5000,
        "{" * 200,
    ],
)
def test_texts_that_are_no_games_are_answered_too(text: str) -> None:
    session = Session()
    session.open(URI, text, 1)
    assert session.diagnostics(URI)
    ask_everything(session, types.Position(0, len(text)))


def test_a_text_that_is_not_open_has_no_answers() -> None:
    session = Session()
    ask_everything(session, types.Position(0, 0))
    assert session.diagnostics(URI) == []


def test_answers_need_no_jax() -> None:
    program = (
        "import sys\n"
        "from tests.editor.asked import ORCHARD\n"
        "from tests.editor.test_unfinished import URI, ask_everything\n"
        "from sjdsl.editor.session import Session\n"
        "from lsprotocol import types\n"
        "import sjdsl.editor.server\n"
        "session = Session()\n"
        "session.open(URI, ORCHARD, 1)\n"
        "ask_everything(session, types.Position(26, 74))\n"
        "print(sorted(name for name in sys.modules if name.partition('.')[0] in ('jax', 'jaxlib', 'flax', 'matplotlib')))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout == "[]\n"
