"""What is generated for editors is up to date, and every word of the language has a colour."""

import re
import runpy
from pathlib import Path

import pytest

from sjdsl.compiler.elaborate.constants import UNITS
from sjdsl.compiler.ir.operations import FUNCTIONS
from sjdsl.compiler.syntax.parse import automaton
from sjdsl.editor.highlighting import VALUES, word_groups

ROOT = Path(__file__).parents[2]
GENERATE = runpy.run_path(str(ROOT / "editors" / "generate.py"))


@pytest.mark.parametrize("path", GENERATE["files"](), ids=lambda path: path.name)
def test_what_is_generated_is_up_to_date(path: Path) -> None:
    assert path.read_text("utf-8") == GENERATE["files"]()[path], "run `python editors/generate.py`"


def test_every_word_of_the_language_has_one_colour() -> None:
    groups = word_groups()
    listed = [word for words in groups.values() for word in words]
    words = {word for word in automaton().words.values() if word.isalpha()}
    assert len(listed) == len(set(listed))
    assert set(listed) | set(VALUES) >= words
    assert set(listed) <= words
    assert all(groups.values())


def test_every_keyword_function_and_unit_is_in_the_syntax_file_of_vim() -> None:
    keywords = {word for word in automaton().words.values() if word.isalpha()}
    named = set(re.findall(r"[a-z_]+", GENERATE["VIM_SYNTAX"].read_text("utf-8")))
    assert keywords | set(FUNCTIONS) | set(UNITS) <= named
