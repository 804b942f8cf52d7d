"""A check passes only if the lines it depends on have run: which lines those are, how they are named, and the exit status."""

from pathlib import Path

import pytest

from sjdsl.cli import run
from sjdsl.properties import Effort, verify_properties
from sjdsl.properties.statements import leaf_statements, statements_needed_by

from .small_games import ORCHARD, small_game

FEW = Effort(examples=25, compiled=False)
NEVER = "each tree where step > 900 { set tree.fruit = ripe }"  # an episode has 20 steps


def lines_needed(checks: str, rule: str) -> set[str]:
    """Returns the statements that a check depends on, as written."""
    orchard = small_game(checks, rule)
    leaves = leaf_statements(orchard.own)
    needed = statements_needed_by(orchard.own.checks[0], orchard.own, leaves)
    return {orchard.text_of(leaf.statement) for leaf in leaves if leaf.statement_id in needed}


def test_a_check_depends_on_what_is_read_by_what_writes_what_it_reads() -> None:
    """`fruit` is written on trees that somebody is on; who is there is written by `move` and by the phase `start`."""
    moving = {"set tree.fruit = none", "move each agent", "send agent to grass"}
    assert (
        lines_needed("once fruit == 0 always fruit == 0", "each agent { add 1 to agent.wealth }")
        == moving
    )
    tired = "each agent where agent chose zap { set agent.tired = 2 }"
    assert lines_needed("always count(agent where agent.tired > 0) == 0", tired) == {
        "set agent.tired = 2"
    }
    through = "each tree where count(agent where agent.tired > 0) > 0 { set tree.fruit = ripe }  each agent { set agent.tired = 1 }"
    assert lines_needed("once fruit == 0 always fruit == 0", through) == moving | {
        "set tree.fruit = ripe",
        "set agent.tired = 1",
    }


def test_a_line_that_never_ran_makes_it_untested() -> None:
    report = verify_properties(
        small_game("once fruit == 0 always fruit == 0  always eaten <= 99", NEVER), FEW
    )
    fruit, eaten = report.verdicts
    assert fruit.status == "untested"
    assert fruit.untested == ("orchard.sj:29  set tree.fruit = ripe",)
    assert eaten.status == "untested"  # what is eaten depends on what is ripe
    assert "29" in map(str, report.idle)


def test_other_checks_are_not_touched_by_it() -> None:
    (verdict,) = verify_properties(
        small_game(
            "always count(agent on tree) <= count(agent)",
            f"{NEVER}  each agent {{ tally zaps for agent }}",
        ),
        FEW,
    ).verdicts
    assert verdict.status == "passed"


def test_a_first_condition_that_never_came_makes_it_untested() -> None:
    (verdict,) = verify_properties(small_game("once step > 900 always fruit == 0"), FEW).verdicts
    assert (verdict.passed, verdict.status) == (True, "untested")
    assert "the first condition never held: step > 900" in verdict.untested[-1]
    assert "never held" in verdict.reason


def test_an_expectation_depends_on_lines_too() -> None:
    """Of `zaps == 0 with never(zap)` nothing is known if no trajectory has ever counted a zap."""
    expects = "expect zaps == 0 with never(zap) over 2 episodes"
    (good,) = verify_properties(small_game(expects), FEW).verdicts
    assert good.status == "passed"
    rule = "each agent where agent chose zap and step > 900 { tally zaps for agent }"
    (dead,) = verify_properties(small_game(expects, rule), FEW).verdicts
    assert dead.status == "untested"
    assert dead.untested[0].endswith("tally zaps for agent")


def test_each_use_of_a_phase_is_a_line_of_its_own() -> None:
    text = ORCHARD.replace("-> rule", "-> rule(none) -> rule(ripe)").replace(
        "phase rule {{", "phase rule(what) {{"
    )
    rule = "each tree where tree.fruit is what and what is ripe and nobody on tree { set tree.fruit = none }"
    (verdict,) = verify_properties(
        small_game("always fruit <= count(tree) and eaten >= 0 and eaten < 99", rule, text=text),
        FEW,
    ).verdicts
    assert verdict.untested == ("orchard.sj:29  set tree.fruit = none  (in rule(none))",)


@pytest.mark.parametrize(("options", "status"), [((), 0), (("--strict",), 1)])
def test_strict(
    tmp_path: Path, options: tuple[str, ...], status: int, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "orchard.sj"
    path.write_text(ORCHARD.format(rule=NEVER, checks="once fruit == 0 always fruit == 0", more=""))
    assert run(["test", str(path), "--examples", "20", *options]) == status
    shown = capsys.readouterr().out
    assert "1 check, 1 untested" in shown
    assert (
        "depends on a line that never ran:\n                orchard.sj:29  set tree.fruit = ripe"
        in shown
    )


@pytest.mark.parametrize(
    ("policy", "status"),
    [("when step >= 0 choose zap", "passed"), ("when step > 99 choose zap", "untested")],
)
def test_a_line_that_only_a_policy_of_the_file_reaches_is_tested_by_it(
    policy: str, status: str
) -> None:
    """Twenty steps of the same action in a row: the few trajectories without the policy do not come there."""
    rule = "each agent { set agent.wealth = case agent chose zap { yes: min(agent.wealth + 1, 20), no: 0 } }"
    hit = "phase hit {{ each agent where agent.wealth == 20 {{ tally zaps for agent }} }}"
    text = (
        ORCHARD.replace("  add 1 to agent.wealth", "")
        .replace("-> rule", "-> rule -> hit")
        .replace("  metrics", f"  {hit}\n  metrics")
    )
    family = small_game(
        "always zaps <= eaten + 9", rule, f'policy hard "hits" {{ {policy} }}', text
    )
    assert [
        verdict.status
        for verdict in verify_properties(family, Effort(examples=3, compiled=False)).verdicts
    ] == [status]


@pytest.mark.parametrize(("other", "status"), [("stay", "passed"), ("zap", "untested")])
def test_policies_of_the_file_meet(other: str, status: str) -> None:
    """Trajectories by policies alone: what wants agents that follow different ones is seen, too."""
    rule = "each agent where agent chose zap and count(agent as idle where idle chose stay) > 0 { tally zaps for agent }"
    policies = f"policy one {{ when step >= 0 choose zap }}  policy other {{ when step >= 0 choose {other} }}"
    (verdict,) = verify_properties(
        small_game("always zaps <= 99", rule, policies), Effort(examples=0, compiled=False)
    ).verdicts
    assert verdict.status == status
