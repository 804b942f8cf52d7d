"""What others see of the project first: addresses, classifiers, citation, how to take part and how to report."""

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml

from sjdsl.version import HOMEPAGE, __version__

REPOSITORY = Path(__file__).parents[2]
PROJECT: dict[str, Any] = tomllib.loads((REPOSITORY / "pyproject.toml").read_text("utf-8"))[
    "project"
]
CITATION: dict[str, Any] = yaml.safe_load((REPOSITORY / "CITATION.cff").read_text("utf-8"))
FORMS = sorted((REPOSITORY / ".github/ISSUE_TEMPLATE").glob("*.yml"))


def test_there_is_one_address() -> None:
    assert PROJECT["urls"]["Homepage"] == PROJECT["urls"]["Repository"] == HOMEPAGE
    owner, name = HOMEPAGE.removeprefix("https://github.com/").split("/")
    assert PROJECT["urls"]["Documentation"] == f"https://{owner}.github.io/{name}/"
    assert CITATION["repository-code"] == CITATION["url"] == HOMEPAGE
    contact = (REPOSITORY / ".github/ISSUE_TEMPLATE/config.yml").read_text("utf-8")
    assert all(url.startswith(f"{HOMEPAGE}/") for url in re.findall(r"url: (\S+)", contact))
    assert all(
        url.startswith(HOMEPAGE) for name, url in PROJECT["urls"].items() if name != "Documentation"
    )


def test_there_is_one_version() -> None:
    assert PROJECT["version"] == __version__ == str(CITATION["version"])


def test_classifiers_are_those_of_the_project() -> None:
    classifiers = PROJECT["classifiers"]
    pythons = [text.rsplit(" ", 1)[1] for text in classifiers if re.search(r":: 3\.\d+$", text)]
    low, high = re.fullmatch(r">=3\.(\d+)(?:,<3\.(\d+))?", PROJECT["requires-python"]).groups()  # type: ignore[union-attr]
    assert pythons[0] == f"3.{low}"
    assert high is None or int(pythons[-1].removeprefix("3.")) < int(high)
    assert "Typing :: Typed" in classifiers
    assert (REPOSITORY / "sjdsl/py.typed").is_file()
    assert not [text for text in classifiers if text.startswith("License ::")], (
        "the licence is an expression: PyPI refuses both"
    )


def test_the_citation_is_complete() -> None:
    for key in (
        "cff-version",
        "message",
        "title",
        "type",
        "authors",
        "version",
        "license",
        "repository-code",
        "keywords",
        "abstract",
    ):
        assert CITATION[key], key
    assert CITATION["license"] == PROJECT["license"]
    for reference in CITATION["references"]:
        assert {"type", "title", "authors", "year", "url"} <= reference.keys()


@pytest.mark.parametrize(
    "path", [form for form in FORMS if form.stem != "config"], ids=lambda path: path.stem
)
def test_a_form_can_be_shown(path: Path) -> None:
    form = yaml.safe_load(path.read_text("utf-8"))
    assert {"name", "description", "body"} <= form.keys()
    inputs = [part for part in form["body"] if part["type"] != "markdown"]
    assert len({part["id"] for part in inputs}) == len(inputs)
    assert {part["type"] for part in inputs} <= {"input", "textarea", "dropdown", "checkboxes"}
    assert all(part["attributes"]["label"] for part in inputs)
    assert any(part.get("validations", {}).get("required") for part in inputs)


def test_there_are_forms_for_games_faults_and_the_language() -> None:
    assert {path.stem for path in FORMS} == {"config", "rule", "bug", "language"}


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
