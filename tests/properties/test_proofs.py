"""Static verdicts: each proof on a check that holds, and none on similar checks that do not hold or that it cannot prove."""

import pytest

from sjdsl.properties import verify_properties
from sjdsl.properties.monitors import STATES
from sjdsl.properties.symmetry import transformed_games
from sjdsl.properties.verdict import Effort
from sjdsl.properties.verify_properties import PlayedVerdicts, decide_statically

from .small_games import ORCHARD, small_game

PROVED = [
    "always fruit >= 0",
    "always fruit <= count(tree)",
    "always not (fruit > count(tree))",
    "always fruit >= 0 and (bare <= count(tree) or bare > 7)",
    "always sum(agent.wealth over agent) in 0 .. 400",  # as many agents as the file allows
    "once fruit == 0 always bare <= count(tree)",
    "conserved count(agent)",
    "conserved count(tree)",
    "conserved apple",
    "conserved count(tree where tree.col > 1)",
    "conserved sum(max(distance(tree, other) over tree as other) over tree)",
    "monotone bare falling in fruit",
    "monotone fruit falling in bare",
    "monotone fruit rising in fruit",
    "symmetric agents",
    "symmetric mirror",
]
NOT_PROVED = [
    "always fruit <= 1",
    "always fruit <= 2",  # as many as the map has trees: another map has more
    "always sum(agent.wealth over agent) in 0 .. 200",
    "always bare == 2 - fruit",
    "once fruit == 0 always fruit == 0",
    "conserved fruit",
    "conserved eaten",
    "conserved count(agent on tree)",
    "conserved sum(min(distance(agent, tree) over tree) over agent)",
    "conserved count(agent where agent.tired > 0)",
    "conserved step",
    "monotone bare rising in fruit",
    "monotone fruit falling in fruit",
]


@pytest.mark.parametrize("check", PROVED)
def test_what_is_proved(check: str) -> None:
    verdict = decide_statically(small_game(check), 0)
    assert verdict is not None
    assert verdict.passed
    assert verdict.how == "proved"


@pytest.mark.parametrize("check", NOT_PROVED)
def test_what_is_left_to_playing(check: str) -> None:
    assert decide_statically(small_game(check), 0) is None


def test_what_is_proved_holds_when_played() -> None:
    """The proofs against play: every proved check once more, on trajectories, with the proofs switched off."""
    everything = small_game("  ".join(p for p in PROVED if p.split()[0] in STATES))
    verdicts = PlayedVerdicts(everything, Effort(examples=40), list(range(len(everything.own.checks))))
    assert not verdicts.failed()


SLOPES = {  # define value, define argument -> the way the one goes with the other, as far as the ranges tell
    ("2 * fruit + 1", "fruit"): "rising",
    ("3 - 2 * fruit", "fruit"): "falling",
    ("fruit * regrow", "fruit"): "rising",
    ("fruit * (0 - 1)", "fruit"): "falling",
    ("fruit * pay", "fruit"): None,
    ("fruit - bare", "fruit"): "rising",
    ("max(fruit, 1)", "fruit"): "rising",
    ("min(fruit, bare)", "fruit"): None,
    ("ramp(fruit, 0, 2)", "fruit"): "rising",
    ("ramp(fruit, 2, 0)", "fruit"): "falling",
    ("1 / (fruit + 1)", "fruit"): "falling",
    ("fruit * bare", "fruit"): None,
    ("step", "fruit"): None,
    ("7", "fruit"): "level",
}


@pytest.mark.parametrize(("value", "argument"), SLOPES)
def test_slopes(value: str, argument: str) -> None:
    found = []
    for direction in ("rising", "falling"):
        declared = f"param pay : reward = 1  define value = {value}  define argument = {argument}"
        verdict = decide_statically(small_game(f"monotone value {direction} in argument", more=declared), 0)
        found += [direction] if verdict is not None else []
    assert found == {"rising": ["rising"], "falling": ["falling"], "level": ["rising", "falling"], None: []}[SLOPES[value, argument]]


UNEVEN = {
    "agents": [
        "each agent where agent.index == 0 { give 1 to agent }",
        "each agent as a { each agent as b where a.index < b.index { give 1 to a } }",
    ],
    "mirror": [
        "each agent where agent.col == 0 { give 1 to agent }",
        "each agent where agent.heading is east { give 1 to agent }",
        "each agent where agent chose turn_left { give 1 to agent }",
        "each agent where agent chose zap { send agent to grass facing west otherwise stay }",
    ],
}


@pytest.mark.parametrize(("what", "rule"), [(what, rule) for what, rules in UNEVEN.items() for rule in rules])
def test_uneven_rules_are_found_and_shown(what: str, rule: str) -> None:
    report = verify_properties(small_game(f"symmetric {what}", rule), Effort(examples=60))
    (verdict,) = report.verdicts
    assert verdict.passed is False
    assert "would give something else" in "\n".join(verdict.trace)
    other = {"agents": "mirror", "mirror": "agents"}[what]
    even = decide_statically(small_game(f"symmetric {other}", rule), 0)
    assert even is not None
    assert even.passed


def test_distances_are_the_same_for_all_and_in_a_mirror() -> None:
    rule = "each agent where min(distance(agent, tree) over tree) > 1 { give 1 to agent }"
    for what in UNEVEN:
        verdict = decide_statically(small_game(f"symmetric {what}", rule), 0)
        assert verdict is not None
        assert verdict.passed


EVEN = [
    "each agent where agent.index >= 0 { give 1 to agent }",
    "each agent where agent chose turn_left or agent chose turn_right { give 1 to agent }",
    "each agent where agent.index == 0 { chance 0.5 { give 1 to agent } }  each agent where agent.index > 0 { chance 0.5 { give 1 to agent } }",
]


@pytest.mark.parametrize("rule", EVEN)
def test_rules_that_read_numbers_evenly_pass(rule: str) -> None:
    what = "mirror" if "turn" in rule else "agents"
    symmetric = small_game(f"symmetric {what}", rule)
    assert transformed_games(symmetric.own.checks[0], symmetric.own)
    (verdict,) = verify_properties(symmetric, Effort(examples=40)).verdicts
    assert verdict.passed
    assert verdict.how == "examples"


def test_an_uneven_shape_is_no_mirror_image() -> None:
    def shaped(shape: str) -> str:
        return ORCHARD.replace("shape ray = line(2)", shape)

    rule = "each agent as a where a chose zap { each agent as b in ray of a { give 1 to b } }"
    uneven = verify_properties(small_game("symmetric mirror", rule, text=shaped('shape ray {{ "x." ".^" }}')), Effort(60))
    assert uneven.verdicts[0].passed is False
    even = decide_statically(small_game("symmetric mirror", rule, text=shaped("shape ray = fan(2, 1)")), 0)
    assert even is not None
    assert even.passed


def test_one_sided_agents_have_no_mirror_image() -> None:
    one_sided = small_game("symmetric mirror", text=ORCHARD.replace("step_right, ", ""))
    verdict = decide_statically(one_sided, 0)
    assert verdict is not None
    assert verdict.passed is False
    assert verdict.reason == "the agents can step_left, but not step_right"
