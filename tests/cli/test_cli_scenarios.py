"""`sjdsl evaluate --scenario`: a run of two seeds and a policy of the file in scenarios of a small game, and what is refused."""

import json
from pathlib import Path

import pytest
from command_line import Sjdsl

from sjdsl.cli.environment_options import EnvironmentOptions, make_environment
from tests.experiments.stored_policies import store_pool

SCRIPTED = ("evaluate", "eater", "--game", "grove.sj", "--scenario")

pytestmark = pytest.mark.usefixtures("grove")


@pytest.mark.thorough
def test_a_run_of_two_seeds(sjdsl: Sjdsl, folder: Path) -> None:
    described = EnvironmentOptions().describe(str(folder / "grove.sj"))
    store_pool(folder / "runs/grove", make_environment(described), (0, 1))
    (folder / "runs/grove/manifest.json").write_text(json.dumps({"provenance": described}))
    one = sjdsl("evaluate runs/grove --scenario guest --episodes 3")
    assert one.status == 0, one.text
    assert (
        "A Small Orchard: focal agents play runs/grove; mean returns of an agent, with 95 % intervals over 2 training seeds"
        in one.out
    )
    assert "guest     1 of 2" in one.out
    assert "pair" not in one.out
    assert "runs/grove/scenarios.json" in one.out
    both = sjdsl("evaluate runs/grove/ --scenario all --episodes 3")
    assert both.status == 0, both.text
    assert "pair      2 of 2" in both.out
    assert one.out.splitlines()[3] in both.out
    stored = json.loads((folder / "runs/grove/scenarios.json").read_text())
    assert (stored["unit"], stored["training_seeds"], stored["episodes"]) == (
        "training seed",
        [0, 1],
        3,
    )
    assert list(stored["scenarios"]) == ["guest", "pair"]
    assert stored["scenarios"]["guest"]["baselines"].keys() == {"random", "eater", "stay"}
    another = sjdsl("evaluate runs/grove --scenario all --episodes 4")
    assert another.status == 1
    assert (
        "scenarios holds another experiment: episodes 3 there, 4 here. Name another folder"
        in another.err
    )
    poorer = sjdsl("evaluate runs/grove --scenario pair --game orchard.sj")
    assert "orchard has no scenarios; write one into the game's file" in poorer.err
    (folder / "orchard.sj").write_text(
        (folder / "grove.sj").read_text().replace("game grove", "game orchard")
    )
    other = sjdsl("evaluate runs/grove --scenario pair --game orchard.sj")
    assert (
        other.status,
        "was trained on another game: grove there, orchard here" in other.err,
    ) == (1, True), other.text
    assert "runs/grove" in sjdsl("evaluate runs/grove/seed_0 --episodes 2").out, (
        "the run is evaluated alone as before"
    )


def test_a_policy_of_the_file(sjdsl: Sjdsl, folder: Path) -> None:
    shown = sjdsl(*SCRIPTED, "guest,pair", "--episodes", "3", "--param", "length=4")
    assert shown.status == 0, shown.text
    assert (
        "focal agents play eater; mean returns of an agent, with 95 % intervals over 3 episodes, of this policy only"
        in shown.out
    )
    stored = json.loads((folder / "grove_eater_scenarios/scenarios.json").read_text())
    assert (stored["focal_policy"], stored["game"]["params"]["length"]) == ("eater", 4)
    assert stored["scenarios"]["pair"]["score"] == 1.0
    assert "wordings" not in stored["scenarios"]["pair"]
