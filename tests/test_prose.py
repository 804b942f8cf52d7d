"""The prose of README, docs and other pages, and of opening lines: none of the words that the project has retired."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGES = [
    "README.md",
    "CONTRIBUTING.md",
    "CODE_OF_CONDUCT.md",
    "SECURITY.md",
    "ARCHITECTURE.md",
    *sorted(str(path.relative_to(ROOT)) for path in (ROOT / "docs").rglob("*.md")),
]
MODULES = sorted(path for folder in ("sjdsl", "trainers") for path in (ROOT / folder).rglob("*.py"))
RETIRED = {  # a private word -> the field's
    r"promises?": "check, property",
    r"courses? of (play|events)|guided courses?|random courses?": "trajectory",
    r"errands?": "goal",
    r"upkeep": "timers, unused names",
    r"luck": "random draw",
    r"random words?|words? of randomness|threefry words?": "random number, random bits",
    r"sentences? of (a|the) phase": "statement",
}
TERMS = {  # what a stranger searches for -> the file whose opening line has it
    "precedence": "sjdsl/compiler/syntax/__init__.py",
    "error recovery": "sjdsl/compiler/syntax/recovery/__init__.py",
    "symbol table": "sjdsl/compiler/elaborate/scope.py",
    "free variable": "sjdsl/compiler/ir/free_variables.py",
    "write conflict": "sjdsl/compiler/checks/write_conflicts.py",
    "constant folding": "sjdsl/compiler/elaborate/arithmetic.py",
    "broadcast": "sjdsl/compiler/lower/axes.py",
    "collision": "sjdsl/runtime/movement.py",
    "egocentric": "sjdsl/runtime/egocentric_windows.py",
    "respawn": "sjdsl/runtime/placing.py",
    "line of sight": "sjdsl/runtime/line_of_sight.py",
    "beam": "sjdsl/interpreter/shapes.py",
    "auto-reset": "sjdsl/runtime/auto_reset.py",
    "ragged": "sjdsl/compiler/elaborate/world_map.py",
    "clipped loss": "trainers/algorithms/ppo.py",
    "wall": "sjdsl/runtime/geometry.py",
    "replay buffer": "trainers/algorithms/replay_buffer.py",
    "bootstrap": "trainers/algorithms/advantage.py",
    "credit": "trainers/algorithms/advantage.py",
    "discount": "trainers/algorithms/advantage.py",
    "epsilon-greedy": "trainers/algorithms/vdn.py",
    "target network": "trainers/algorithms/vdn.py",
}
MOST_FILES = 8  # that may share a term: more would be no answer
FENCE = re.compile(r"^( *)(`{3,}).*?^\1\2 *$", re.DOTALL | re.MULTILINE)


def paragraphs(text: str) -> Iterator[str]:
    """Yields the paragraphs and list items of a page, without its code blocks, tables, headings and comments."""
    text = FENCE.sub("", re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL))
    for block in re.split(r"\n\s*\n", text):
        lines = [line for line in block.splitlines() if not re.match(r"\s*(\||#|<)", line)]
        for item in re.split(r"\n(?=\s*(?:[*-]|\d+\.)\s)", "\n".join(lines)):
            if item.strip():
                yield " ".join(item.split())


def retired(prose: str) -> list[str]:
    """Returns the retired words of a paragraph, each with what to say instead."""
    prose = re.sub(r"(`+)(?:.+?)\1", "CODE", prose)
    return [
        f"{m[0]} ({say})"
        for word, say in RETIRED.items()
        for m in re.finditer(rf"\b({word})\b", prose, re.IGNORECASE)
    ]


def opening(path: Path) -> str:
    """Returns the first paragraph of a module's docstring."""
    return " ".join(
        (ast.get_docstring(ast.parse(path.read_text("utf-8"))) or "").split("\n\n")[0].split()
    )


@pytest.mark.parametrize("page", PAGES)
def test_pages_use_the_words_of_the_field(page: str) -> None:
    text = (ROOT / page).read_text("utf-8")
    assert [word for paragraph in paragraphs(text) for word in retired(paragraph)] == []


def test_opening_lines_are_in_the_words_of_the_field() -> None:
    lines = {str(path.relative_to(ROOT)): opening(path) for path in MODULES}
    assert [name for name, line in lines.items() if not line] == []
    assert {name: found for name, line in lines.items() if (found := retired(line))} == {}


def test_terms_of_the_field_lead_to_the_file_in_one_search() -> None:
    lines = {str(path.relative_to(ROOT)): opening(path).lower() for path in MODULES}
    for term, file in TERMS.items():
        found = [name for name, line in lines.items() if term in line]
        assert file in found, term
        assert len(found) <= MOST_FILES, (term, found)


def test_what_is_found() -> None:
    assert list(paragraphs("# A\n\n```py\nx\n```\n\n| a | b |\n\n* one\n  two\n* three\n")) == [
        "* one two",
        "* three",
    ]
    assert retired("It keeps its promises, as a random word of luck.") != []
    assert retired("`promises` are code") == []
