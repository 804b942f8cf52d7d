"""`sjdsl test`: what it prints of passed and of failed checks, its options, and its exit statuses."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from command_line import GAME, Sjdsl

HERE = Path(__file__).parent
PASSING = """require apple >= 0
    conserved count(agent)
    always count(soil where soil.fruit is ripe) <= count(soil)
    always count(agent on wall) == 0
    symmetric agents
    expect eaten == 0 with never(forward) over 3 episodes"""
FAILING = """require apple < 9.5
    always count(agent on soil where soil.fruit is ripe) == 0
    symmetric agents
    expect eaten > 0 with seek soil, random over 2 episodes
    expect eaten == 0 with seek soil, random over 2 episodes"""


def with_checks(checks: str, game: str = GAME) -> str:
    return game.replace("  variant rich", f"  checks {{\n    {checks}\n  }}\n  variant rich")


@pytest.fixture
def games(folder: Path) -> Path:
    """The folder, with a game whose checks pass, one with failing checks, one without checks, and one with a mistake."""
    (folder / "passing.sj").write_text(with_checks(PASSING))
    (folder / "failing.sj").write_text(with_checks(FAILING))
    (folder / "wrong.sj").write_text(with_checks("always cuont(agent) > 0"))
    return folder


@pytest.mark.usefixtures("games")
def test_checks_that_pass(sjdsl: Sjdsl, golden: Callable[[Path, str], None]) -> None:
    shown = sjdsl("test passing.sj --examples 30")
    assert shown.status == 0
    assert shown.err == "testing the checks of passing.sj\n"
    golden(HERE / "checks_passed.txt", shown.out)


@pytest.mark.usefixtures("games")
def test_checks_that_fail(sjdsl: Sjdsl, golden: Callable[[Path, str], None]) -> None:
    shown = sjdsl("test failing.sj")
    assert shown.status == 1
    assert shown.err == "testing the checks of failing.sj\n"
    golden(HERE / "checks_failed.txt", shown.out)


@pytest.mark.usefixtures("games")
def test_all_files_are_tested_though_one_fails(sjdsl: Sjdsl) -> None:
    shown = sjdsl("test wrong.sj orchard.sj passing.sj --examples 5")
    assert shown.status == 1
    assert "`cuont` is not known here" in shown.text
    assert "Traceback" not in shown.text
    assert "orchard.sj: 0 checks (write them in `checks { … }`)" in shown.out
    assert "passing.sj: 6 checks passed" in shown.out


@pytest.mark.thorough
@pytest.mark.usefixtures("games")
def test_examples_and_seed(sjdsl: Sjdsl) -> None:
    def steps(*options: str) -> str:
        found = json.loads(sjdsl("test passing.sj --json", *options).out)
        return next(p["reason"] for p in found[0]["checks"] if p["how"] == "examples")

    few, more = (
        int(steps("--examples", number).split()[0].replace(",", "")) for number in ("7", "20")
    )
    assert 2 * few < more < 4 * few
    shown = [sjdsl("test failing.sj --examples 40 --seed", seed).out for seed in ("5", "5", "6")]
    assert shown[0] == shown[1]
    assert shown[0] != shown[2]  # the mean over other episodes


@pytest.mark.usefixtures("games")
def test_json_has_verdicts_and_traces(sjdsl: Sjdsl) -> None:
    shown = sjdsl("test failing.sj --examples 60 --json")
    assert shown.status == 1
    (document,) = json.loads(shown.out)
    assert document["file"] == "failing.sj"
    assert [(p["verdict"], p["how"]) for p in document["checks"]] == [
        ("passed", "decided"),
        ("failed", "examples"),
        ("passed", "proved"),
        ("passed", "episodes"),
        ("failed", "episodes"),
    ]
    assert "  because chance growth[soil.fruit]" in "\n".join(document["checks"][1]["trace"])
    lines = with_checks(FAILING).splitlines()
    assert all(p["check"] in lines[p["line"] - 1] for p in document["checks"])


def test_a_variant_has_its_own_checks(sjdsl: Sjdsl, folder: Path) -> None:
    game = with_checks("always true").replace(
        "checks {\n    always true", "checks worth {\n    always eaten >= 0"
    )
    (folder / "two.sj").write_text(
        game.replace("{ set apple = 2 }", "{ set apple = 2  checks worth { always eaten < 0 } }")
    )
    assert sjdsl("test two.sj --examples 5").status == 0
    shown = sjdsl("test two.sj --examples 5 --variant rich")
    assert shown.status == 1
    assert "two.sj, variant rich: 1 check, 1 not passed" in shown.out
    none = sjdsl("test two.sj --variant poor")
    assert none.status == 1
    assert "no variant `poor`" in none.text
    assert "Traceback" not in none.text
