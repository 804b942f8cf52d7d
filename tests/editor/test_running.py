"""Phases and checks run from the text, on the interpreter."""

from collections.abc import Iterator

from lsprotocol import types

from sjdsl.editor.running import Result, run_checks, run_phase
from tests.editor.asked import ORCHARD, opened


def outcome(runs: Iterator[Result | None]) -> Result:
    *before, last = runs
    assert all(step is None for step in before)
    assert last is not None
    return last


def analysed(text: str = ORCHARD):
    session, uri = opened(text)
    analysis = session.analyses.of(uri)
    assert analysis is not None
    return analysis


def test_the_scenes_of_a_phase_show_what_it_did() -> None:
    result = outcome(run_phase(analysed(), "walk", steps=6))
    assert result.summary == "phase `walk`: something changes in 2 of 6 steps with random actions (seed 0)"
    assert "move each agent" in result.text
    assert result.text.count("\nstep ") == 2
    assert "grow" not in result.text
    assert result.marks == ()


def test_statements_that_did_not_happen_are_marked() -> None:
    result = outcome(run_phase(analysed(), "fire", steps=2))
    assert [m.message for m in result.marks if m.range.start.line == 31] == ["did not happen in 2 steps with random actions"] * 2
    assert {m.severity for m in result.marks} == {types.DiagnosticSeverity.Information}


def test_a_phase_of_a_variant_is_run_in_it() -> None:
    text = ORCHARD.replace(
        "{ set apple = 2 }", "{ phase rest { each agent { give apple to agent } }  schedule tick -> grow -> walk -> eat -> fire -> rest }"
    )
    result = outcome(run_phase(analysed(text), "rest", steps=2))
    assert result.summary.startswith("phase `rest` of variant `rich`: something changes in 2 of 2 steps")


def test_a_phase_of_a_broken_game_cannot_be_run() -> None:
    assert outcome(run_phase(analysed(ORCHARD.replace("give apple", "give appel")), "walk")).failed


def test_a_check_that_holds_passes_and_one_that_fails_shows_why() -> None:
    analysis = analysed(
        ORCHARD.replace("always count(agent) == players", "always count(agent) == players  always count(tree where tree.fruit is ripe) > 0")
    )
    start = analysis.source.text.index("always count(agent)")
    held = outcome(run_checks(analysis, start))
    assert not held.failed
    assert [m.severity for m in held.marks] == [types.DiagnosticSeverity.Information]
    wrong = outcome(run_checks(analysis, analysis.source.text.index("always count(tree")))
    assert wrong.failed
    (mark,) = wrong.marks
    assert mark.severity == types.DiagnosticSeverity.Error
    assert "count(tree where tree.fruit is ripe) > 0" in wrong.summary
    assert len(mark.message.splitlines()) > 3, "the counterexample, step by step"


def test_an_expectation_plays_whole_episodes() -> None:
    analysis = analysed()
    result = outcome(run_checks(analysis, analysis.source.text.index("expect hits")))
    assert (
        result.summary
        == "`expect hits == 0 with never(zap) over 2 episodes`: passed: 2 of 2 episodes on the interpreter; `sjdsl test` plays all of them"
    )
    other = analysed(ORCHARD.replace("expect hits == 0", "expect hits > 99"))
    assert outcome(run_checks(other, other.source.text.index("expect hits"))).failed
