"""The workflows on GitHub: they can be read, name only what exists, and may do no more than they must."""

import re
import runpy
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
import yaml

REPOSITORY = Path(__file__).parents[2]
GITHUB = REPOSITORY / ".github"
WORKFLOWS = sorted((GITHUB / "workflows").glob("*.yml"))
PYTHONS = ["3.11", "3.12", "3.13", "3.14"]
# More than reading the repository: only these jobs, and only this.
ALLOWED = {
    ("release", "publish"): {"id-token": "write"},
    ("site", "publish"): {"pages": "write", "id-token": "write"},
}
every = pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)


def read(path: Path) -> dict[Any, Any]:
    """Returns a workflow. YAML takes its word `on` for the truth value."""
    workflow = yaml.safe_load(path.read_text("utf-8"))
    assert isinstance(workflow, dict)
    return workflow


def steps(path: Path) -> list[dict[str, Any]]:
    return [step for job in read(path)["jobs"].values() for step in job["steps"]]


def test_all_parts_are_there() -> None:
    assert {path.stem for path in WORKFLOWS} >= {
        "tests",
        "style",
        "interop",
        "browser",
        "site",
        "release",
    }


@every
def test_a_workflow_may_do_no_more_than_it_must(path: Path) -> None:
    workflow = read(path)
    assert workflow["name"] == path.stem
    assert workflow["permissions"] == {"contents": "read"}
    assert "group" in workflow["concurrency"]
    for name, job in workflow["jobs"].items():
        assert job.get("permissions", {}) == ALLOWED.get((path.stem, name), {})
        assert job["timeout-minutes"] <= 90
    assert "secrets." not in path.read_text("utf-8"), "nothing needs a token of ours"
    assert "pull_request_target" not in path.read_text("utf-8"), (
        "code of strangers would run with our rights"
    )


@every
def test_actions_are_pinned_to_commits(path: Path) -> None:
    lines = [
        line.strip().removeprefix("- ")
        for line in path.read_text("utf-8").splitlines()
        if "uses:" in line
    ]
    wrong = [
        line
        for line in lines
        if not re.fullmatch(r"uses: [\w.-]+/[\w.-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+", line)
    ]
    assert not wrong
    for step in steps(path):
        if step.get("uses", "").startswith("actions/checkout@"):
            assert step["with"] == {"persist-credentials": False}, (
                "later steps have no use for the token"
            )


def test_an_action_has_one_pin() -> None:
    used = {
        use
        for path in WORKFLOWS
        for use in re.findall(r"uses: (\S+@\S+ # \S+)", path.read_text("utf-8"))
    }
    assert len({use.split("@")[0] for use in used}) == len(used), (
        "the same action, twice in different releases"
    )


@every
def test_what_a_workflow_runs_exists(path: Path) -> None:
    makefile = (REPOSITORY / "Makefile").read_text("utf-8")
    targets = set(re.findall(r"^([\w-]+):", makefile, re.MULTILINE))
    packages = (REPOSITORY / "editors/vscode/package.json").read_text("utf-8")
    for command in (step["run"] for step in steps(path) if "run" in step):
        for target in re.findall(r"^make ([\w-]+)", command, re.MULTILINE):
            assert target in targets, command
        for script in re.findall(r"^python (\S+\.py)", command, re.MULTILINE):
            assert (REPOSITORY / script).is_file(), command
        for script in re.findall(r"^npm (?:run )?(test|package)$", command, re.MULTILINE):
            assert f'"{script}":' in packages, command
    for step in steps(path):
        given = str(step.get("with", {}).get("cache-dependency-path", ""))
        assert all((REPOSITORY / file).is_file() for file in given.split()), given


def test_every_python_is_tested_and_so_is_macos() -> None:
    for name, job in (("tests", "tests"), ("release", "test")):
        matrix = read(GITHUB / f"workflows/{name}.yml")["jobs"][job]["strategy"]["matrix"]
        assert matrix["python"] == PYTHONS
        assert {"system": "macos-latest", "python": "3.13"} in matrix["include"]


def test_what_is_published_is_what_was_tested() -> None:
    jobs = read(GITHUB / "workflows/release.yml")["jobs"]
    assert jobs["publish"]["needs"] == ["build", "test"]
    assert jobs["test"]["needs"] == "build"
    builds = [
        job
        for job, content in jobs.items()
        if any("python -m build" in step.get("run", "") for step in content["steps"])
    ]
    assert builds == ["build"], "the wheel is built once"
    (tested,) = (step["run"] for step in jobs["test"]["steps"] if "run" in step)
    assert "WHEEL=" in tested
    assert jobs["publish"]["environment"]["name"] == "pypi"
    assert not any("checkout" in step.get("uses", "") for step in jobs["publish"]["steps"]), (
        "what publishes runs no code of the tree"
    )
    assert not any("password" in step.get("with", {}) for step in jobs["publish"]["steps"]), (
        "PyPI trusts the workflow, by no token"
    )


def test_a_tag_has_to_be_that_of_the_release(tmp_path: Path) -> None:
    problems = runpy.run_path(str(GITHUB / "release.py"))["problems"]
    for name in ("pyproject.toml", "CITATION.cff", "sjdsl/version.py"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        shutil.copy(REPOSITORY / name, tmp_path / name)
    (tmp_path / "CHANGELOG.md").write_text("# Changelog\n\n## 0.1.0 (unreleased)\n")
    assert problems("v0.1.0", tmp_path) == [
        "CHANGELOG.md has no heading `## 0.1.0 (YEAR-MONTH-DAY)`"
    ]
    (tmp_path / "CHANGELOG.md").write_text("# Changelog\n\n## 0.1.0 (2026-12-01)\n")
    assert problems("v0.1.0", tmp_path) == []
    assert problems("v0.2.0", tmp_path)[:3] == [
        f"{name} says version 0.1.0, and the tag is v0.2.0"
        for name in ("pyproject.toml", "CITATION.cff", "sjdsl/version.py")
    ]


@pytest.mark.parametrize("name", ["chromium", "chromium-browser", "google-chrome", None])
def test_a_browser_that_is_there_is_not_installed(tmp_path: Path, name: str | None) -> None:
    """Each of the three names will do for the tests of pages; without a browser, and without apt-get, they say what they want."""
    make = shutil.which("make")
    assert make is not None
    (tmp_path / "more.mk").write_text("look:\n\t@$(CHROMIUM)\n")
    if name is not None:
        (tmp_path / name).write_text("#!/bin/sh\n")
        (tmp_path / name).chmod(0o755)
    asked = [make, "-s", "-f", "Makefile", "-f", str(tmp_path / "more.mk"), "look"]
    done = subprocess.run(
        asked,
        cwd=REPOSITORY,
        env={"PATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode == 0) == (name is not None), done.stderr
    assert ("these tests want Chromium" in done.stdout) == (name is None)


def test_every_suite_runs_somewhere() -> None:
    """A target of the Makefile that tests something is in a workflow, but for the one that takes hours."""
    makefile = (REPOSITORY / "Makefile").read_text("utf-8")
    suites = set(
        re.findall(r"^(test(?:-[a-z]+)?|[a-z]+-test|types|lint):", makefile, re.MULTILINE)
    ) - {"test-all"}
    commands = "\n".join(step["run"] for path in WORKFLOWS for step in steps(path) if "run" in step)
    assert suites == set(re.findall(r"^make ([\w-]+)", commands, re.MULTILINE)) & suites
    assert {"test", "test-playground", "wheel-test"} <= suites
