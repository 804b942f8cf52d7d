"""Refuses a tag that does not belong to what is released: `release.py v0.2.0`, before anything is built."""

import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]


def problems(tag: str, root: Path = ROOT) -> list[str]:
    """Returns where the version is not that of the tag, a sentence each."""
    version = tag.removeprefix("v")
    citation = re.search(
        r"^version: (\S+)$", (root / "CITATION.cff").read_text("utf-8"), re.MULTILINE
    )
    written = re.search(
        r'^__version__ = "(.*)"$', (root / "sjdsl/version.py").read_text("utf-8"), re.MULTILINE
    )
    said = {
        "pyproject.toml": tomllib.loads((root / "pyproject.toml").read_text("utf-8"))["project"][
            "version"
        ],
        "CITATION.cff": citation[1] if citation else "",
        "sjdsl/version.py": written[1] if written else "",
    }
    found = [
        f"{file} says version {theirs or 'nothing'}, and the tag is {tag}"
        for file, theirs in said.items()
        if theirs != version
    ]
    heading = re.compile(rf"^## {re.escape(version)} \((\d{{4}}-\d{{2}}-\d{{2}})\)$", re.MULTILINE)
    if not heading.search((root / "CHANGELOG.md").read_text("utf-8")):
        found.append(f"CHANGELOG.md has no heading `## {version} (YEAR-MONTH-DAY)`")
    return found


if __name__ == "__main__":
    sys.exit("\n".join(problems(sys.argv[1])) or None)
