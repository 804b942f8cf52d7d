"""Static verdicts: each proof on a check that holds, and none on similar checks that do not hold or that it cannot prove."""

import pytest

from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.properties.search import Search
from sjdsl.properties.verdict import Effort
from sjdsl.properties.verify_properties import decide_statically

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


OF_STATES = ("always", "once", "conserved", "monotone")


def test_what_is_proved_holds_when_played() -> None:
    """The proofs against play: every proved check once more, on trajectories, with the proofs switched off."""
    everything = small_game("  ".join(p for p in PROVED if p.split()[0] in OF_STATES))
    search = Search(
        everything, range(len(everything.own.checks)), Effort(examples=20, compiled=False)
    )
    search.run()
    assert search.steps
    assert not search.found


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
        verdict = decide_statically(
            small_game(f"monotone value {direction} in argument", more=declared), 0
        )
        found += [direction] if verdict is not None else []
    assert (
        found
        == {"rising": ["rising"], "falling": ["falling"], "level": ["rising", "falling"], None: []}[
            SLOPES[value, argument]
        ]
    )


UNEVEN = {  # rule -> which line tells agents apart, and how
    "each agent where agent.index == 0 { give 1 to agent }": "line 29 reads `agent.index`",
    "each agent as a { each agent as b where a.index < b.index { give 1 to a } }": "line 29 reads `agent.index`",
    "each agent as a where a chose vote(0) { give 1 to a }": "line 29 names agent 0 by its number",
    "each agent as a where a chose vote(0) or a chose vote(1) { give 1 to a }": "line 29 names agent 0 by its number",
}
VOTE = ORCHARD.replace("stay, zap", "stay, zap, vote(agent)")


@pytest.mark.parametrize("rule", UNEVEN)
def test_uneven_rules_fail_with_their_line(rule: str) -> None:
    verdict = decide_statically(small_game("symmetric agents", rule, text=VOTE), 0)
    assert verdict is not None
    assert (verdict.status, verdict.how, verdict.reason) == ("failed", "decided", UNEVEN[rule])


@pytest.mark.parametrize(
    ("forbidden", "passes"),
    [
        ("vote", True),
        ("vote(0)", False),
        ("vote(0), vote(1)", False),
        ("vote(0), vote(1), vote(2), vote(3)", True),
    ],
)
def test_actions_forbidden_on_some_agents_tell_them_apart(forbidden: str, passes: bool) -> None:
    """The file has two agents and allows four: two that are named are not all."""
    text = VOTE.replace(
        "    timer tired\n", "    timer tired\n    forbid " + forbidden + " when agent.tired > 0\n"
    )
    text = (
        text.replace("players : count = 2 in", "players : count = 4 in")
        if "3" in forbidden
        else text
    )
    text = text.replace('"..T" ".T."', '"..T." ".T.."')
    verdict = decide_statically(small_game("symmetric agents", text=text), 0)
    assert verdict is not None
    assert verdict.passed is passes


def test_distances_are_the_same_for_all() -> None:
    verdict = decide_statically(
        small_game(
            "symmetric agents",
            "each agent where min(distance(agent, tree) over tree) > 1 { give 1 to agent }",
        ),
        0,
    )
    assert verdict is not None
    assert verdict.passed


def test_a_mirrored_map_is_no_symmetry_that_can_be_asked_for() -> None:
    with pytest.raises(CompileError, match="mirror"):
        small_game("symmetric mirror")
