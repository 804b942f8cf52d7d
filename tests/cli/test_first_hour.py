"""What somebody meets in their first hour: help without an error, names that nearly fit, and no files that nobody asked for."""

import subprocess
import sys
from pathlib import Path

from command_line import Sjdsl


def test_sjdsl_alone_is_help(sjdsl: Sjdsl) -> None:
    sjdsl("list")  # a subcommand of the same name as something that help is made with
    shown = sjdsl()
    assert (shown.status, shown.err) == (0, "")
    assert shown.out.startswith("Usage: sjdsl [OPTIONS] COMMAND")
    assert shown.out == sjdsl("--help").out


def test_new_says_what_comes_next_and_what_it_needs(sjdsl: Sjdsl) -> None:
    said = sjdsl("new", "pond").out
    for line in (
        "sjdsl play pond.sj",
        "control an agent",
        "pytest test_pond.py",
        "pip install pytest",
        "sjdsl train pond.sj --preset two_cores",
    ):
        assert line in said
    assert "bundled" not in said
    assert "there is a bundled game clean_up as well" in sjdsl("new", "clean_up").out
    assert "19 rows of 28 cells" in sjdsl("doc", "clean_up").out, (
        "the name alone is the bundled game's"
    )
    assert "10 rows of 15 cells" in sjdsl("doc", "clean_up.sj").out


def test_testing_leaves_nothing_behind(folder: Path) -> None:
    script = """
import sys
from sjdsl.cli import run
assert run(["test", "orchard.sj", "--examples", "3"]) == 0
"""
    (folder / "orchard.sj").write_text(
        (folder / "orchard.sj")
        .read_text()
        .replace("  variant", "  checks { conserved count(agent) }\n  variant")
    )
    subprocess.run(
        [sys.executable, "-c", script],
        cwd=folder,
        check=True,
        env={"SJDSL_CACHE": str(folder / "cache"), "PATH": ""},
    )
    assert sorted(path.name for path in folder.iterdir()) == ["orchard.sj"]
