"""The cheat sheet names every word of the language and every function, and nothing that is not there."""

import re

from sjdsl.compiler.syntax.parse import parser

from .blocks import MANUAL
from .test_coverage import WORDS_OF_RULES

TEXT = (MANUAL.parent / "cheatsheet.md").read_text(encoding="utf-8")
SEEN = set(
    re.findall(
        r"[a-z_]+", "\n".join(re.findall(r"^```text\n(.*?)^```", TEXT, re.MULTILINE | re.DOTALL))
    )
)


def test_every_word_of_the_language_is_on_the_sheet():
    words = {
        t.pattern.value
        for t in parser().terminals
        if t.pattern.type == "str" and t.pattern.value.isalpha()
    }
    assert sorted(words - SEEN) == []


def test_every_name_with_a_meaning_is_on_the_sheet():
    left_out = {"same", "ahead", "centre", "everyone"}  # details of one construct each
    for sort, names in WORDS_OF_RULES.items():
        assert sorted(set(names) - SEEN - left_out) == [], sort
