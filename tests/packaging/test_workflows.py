"""The workflows on GitHub run only what exists, and may do no more than they must."""

import re
from pathlib import Path
from typing import Any

import pytest
import yaml

REPOSITORY = Path(__file__).parents[2]
GITHUB = REPOSITORY / ".github"
WORKFLOWS = sorted((GITHUB / "workflows").glob("*.yml"))
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
