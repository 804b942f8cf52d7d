"""`sjdsl evaluate POLICY --game GAME`: policies that are no runs, with the figures that runs and cross-play have; and what is refused."""

import json
import shlex
from pathlib import Path
from typing import Any

import pytest
from command_line import Sjdsl

from sjdsl.cli.environment_options import EnvironmentOptions, make_environment
from tests.experiments.stored_policies import store

PLAYED = ("--game", "grove.sj", "--episodes", "3", "--seed", "4")

pytestmark = pytest.mark.usefixtures("grove")


@pytest.fixture
def described() -> dict[str, Any]:
    return EnvironmentOptions().describe("grove.sj")


@pytest.fixture
def file(folder: Path, grove: None, described: dict[str, Any]) -> Path:
    """A policy, stored as that of a run."""
    del grove
    stored = store(folder / "runs/one", make_environment(described), 0)
    manifest = {"game": {}, "config": {}, "versions": {}, "provenance": described}
    (folder / "runs/one/manifest.json").write_text(json.dumps(manifest))
    return stored


@pytest.mark.thorough
def test_a_stored_policy_is_the_evaluation_of_its_run(
    sjdsl: Sjdsl, folder: Path, file: Path, described: dict[str, Any]
) -> None:
    alone = sjdsl("evaluate", file, *PLAYED, "--drawn", "-o", "alone.json")
    run = sjdsl("evaluate runs/one --drawn --episodes 3 --seed 4")
    assert (alone.status, run.status) == (0, 0), alone.text + run.text
    shown_alone, shown_run = (
        [line.split() for line in shown.out.splitlines() if line.startswith("  event")]
        for shown in (alone, run)
    )
    assert shown_alone == shown_run
    there, here = (
        json.loads((folder / name).read_text())
        for name in ("runs/one/evaluation.json", "alone.json")
    )
    assert there["per_episode"] == here["per_episode"]
    fewer = sjdsl("evaluate runs/one --episodes 2")
    assert (
        fewer.status,
        "already holds an evaluation of this policy in 3 episodes" in fewer.err,
    ) == (0, True), fewer.text
    assert json.loads((folder / "runs/one/evaluation.json").read_text()) == there
    assert sjdsl("evaluate runs/one --episodes 3").status == 0
    assert json.loads((folder / "runs/one/evaluation.json").read_text()) != there
    store(folder / "runs/one", make_environment(described), 0, update=7)
    assert sjdsl("evaluate runs/one --episodes 2").status == 0
    later = json.loads((folder / "runs/one/evaluation.json").read_text())
    assert (later["episodes"], later["update"]) == (2, 7)
    assert here["digest"]


def test_what_cannot_be_evaluated_is_refused(sjdsl: Sjdsl, folder: Path, file: Path) -> None:
    (folder / "orchard.sj").write_text(
        (folder / "grove.sj").read_text().replace("game grove", "game orchard")
    )
    other = sjdsl("evaluate", file, "--game", "orchard.sj")
    assert (
        other.status,
        "was trained on another game: grove there, orchard here" in other.err,
    ) == (1, True), other.text
    again = sjdsl("evaluate runs/one --game grove.sj --agents 2")
    assert (again.status, "a run is evaluated in its own game" in again.err) == (2, True), (
        again.text
    )
    for missing in (file, folder / "runs/one/kept.safetensors"):
        missing.touch()
        shown = sjdsl("evaluate", missing)
        assert (shown.status, "add --game GAME for a policy that isn't a run" in shown.err) == (
            1,
            True,
        ), shown.text


@pytest.mark.usefixtures("no_code_allowed")
def test_the_end_names_two_commands_for_the_same_game(sjdsl: Sjdsl, folder: Path) -> None:
    shown = sjdsl("evaluate eater --param 'growth[ripe]=0.5' --agents 2", *PLAYED)
    assert shown.status == 0, shown.text
    head, *commands = shown.out.splitlines()[-3:]
    game = "--game grove.sj --agents 2 --param 'growth[ripe]=0.5'"
    assert head == "next:"
    assert [command.strip().split("  ")[0] for command in commands] == [
        f"sjdsl evaluate eater {game} --film eater.gif",
        f"sjdsl evaluate eater --scenario all {game}",
    ]
    for command in commands:
        arguments = shlex.split(command.strip().split("  ")[0])[1:]
        again = sjdsl(*arguments, "--episodes", "2")
        assert again.status == 0, again.text
    assert (folder / "eater.gif").is_file()


def test_random_is_compared_with_nothing(sjdsl: Sjdsl, folder: Path) -> None:
    shown = sjdsl("evaluate random", *PLAYED)
    assert shown.status == 0, shown.text
    assert shown.out.splitlines()[2].split() == ["random"]
    assert "of a random policy" not in shown.out
    assert sorted(path.name for path in folder.iterdir()) == ["grove.sj", "orchard.sj"], (
        "nothing is written that was not asked for"
    )
