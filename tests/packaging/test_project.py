"""One version everywhere, and links for contributors that lead somewhere."""

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml

from sjdsl.version import __version__

REPOSITORY = Path(__file__).parents[2]
PROJECT: dict[str, Any] = tomllib.loads((REPOSITORY / "pyproject.toml").read_text("utf-8"))[
    "project"
]
CITATION: dict[str, Any] = yaml.safe_load((REPOSITORY / "CITATION.cff").read_text("utf-8"))


def test_there_is_one_version() -> None:
    assert PROJECT["version"] == __version__ == str(CITATION["version"])


@pytest.mark.parametrize(
    "page",
    ["CONTRIBUTING.md", "CODE_OF_CONDUCT.md", "SECURITY.md", ".github/pull_request_template.md"],
)
def test_links_of_the_pages_for_contributors_lead_somewhere(page: str) -> None:
    text = (REPOSITORY / page).read_text("utf-8")
    for link in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", text):
        assert (REPOSITORY / page).parent.joinpath(link).exists(), link
    for command in re.findall(r"`make ([\w-]+)`", text):
        assert re.search(
            rf"^{command}:", (REPOSITORY / "Makefile").read_text("utf-8"), re.MULTILINE
        ), command
    assert "@" not in re.sub(r"`[^`]*`", "", text), (
        "reports go through the project's page, not to an address"
    )
