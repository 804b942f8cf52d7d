"""ARCHITECTURE.md is a map: the files it names are there, and every package is on it."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
LINES = (ROOT / "ARCHITECTURE.md").read_text("utf-8").splitlines()
NAMED = re.compile(r"`([\w./]+(?:\.(?:py|lark|toml|txt|j2|json)|/))`|\]\(([\w./]+)\)")
USUAL = ("sjdsl/compiler", "sjdsl", "tests")


def missing(line: str) -> list[str]:
    """Returns what a line names and what is not there: from the root, or in a folder that the line has named before, or a usual one."""
    folders = [ROOT / folder for folder in ("", *USUAL)]
    absent = []
    for code, link in NAMED.findall(line):
        name = code or link
        found = [folder / name for folder in folders if (folder / name).exists()]
        if found:
            folders += [path if path.is_dir() else path.parent for path in found]
        else:
            absent.append(name)
    return absent


def test_what_is_named_is_there() -> None:
    assert [(number, name) for number, line in enumerate(LINES, 1) for name in missing(line)] == []
    assert missing("`sjdsl/trace/`, `effects.py`, `nosuch.py`, [none](docs/none.md)") == [
        "nosuch.py",
        "docs/none.md",
    ]


def test_every_package_is_on_the_map() -> None:
    """The folders of `sjdsl/` stand in the first picture, or are the compiler's own."""
    folders = {
        path.name for path in (ROOT / "sjdsl").iterdir() if path.is_dir() and any(path.glob("*.*"))
    } - {"__pycache__", "grammar"}
    assert folders - {name for line in LINES for name in re.findall(r"sjdsl/(\w+)", line)} == set()
