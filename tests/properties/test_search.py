"""What the search finds, how short the counterexample becomes, and that the same seed finds the same."""

from collections.abc import Callable
from pathlib import Path

import pytest

from sjdsl.properties import Effort, GameFamily, verify_properties
from sjdsl.properties.counterexample import describe_counterexample
from sjdsl.properties.monitors import find_violation
from sjdsl.properties.random_starts import random_start
from sjdsl.properties.trajectory import play

from .small_games import ORCHARD, searched, small_game

GOLDEN = Path(__file__).parent
FAILING = [  # check, rule, the steps and the agents of the shortest counterexample
    ("always zaps == 0", "each agent where agent chose zap { tally zaps for agent }", 1, 1),
    ("once fruit == 0 always fruit == 0", "each tree where nobody on tree { chance 0.001 { set tree.fruit = ripe } }", 2, 1),
    ("conserved fruit", "", 1, 1),
    ("always eaten < 2", "", 1, 2),
    ("always count(agent where agent.tired > 0) == 0", "each agent where agent chose zap { set agent.tired = 2 }", 1, 1),
    ("monotone bare rising in fruit", "", 1, 1),
]


@pytest.mark.parametrize(("check", "rule", "steps", "agents"), FAILING)
def test_counterexamples_become_short(check: str, rule: str, steps: int, agents: int) -> None:
    orchard = small_game(check, rule)
    (found,) = searched(orchard, Effort(examples=100, seed=1)).found
    assert len(found.scenario.actions) <= steps + 1
    assert found.scenario.agents <= agents
    assert len(found.scenario.rows) * len(found.scenario.rows[0]) <= 6
    assert not found.scenario.params
    stay = orchard.own.agents.actions.index("stay")
    assert sum(action != stay for step in found.scenario.actions for action in step) <= 2


def test_a_counterexample_that_is_printed_violates_the_check_when_played_again() -> None:
    orchard = small_game("always eaten < 2")
    (found,) = searched(orchard, Effort(examples=100)).found
    game = orchard.on(found.scenario.rows, found.scenario.agents)
    assert game is not None
    assert find_violation(game.checks[0], play(game, found.scenario).values(game.checks[0])) == found.where


def test_a_trace_in_full(golden: Callable[[Path, str], None]) -> None:
    orchard = small_game("once fruit == 0 always fruit == 0", "each tree where nobody on tree { chance 0.5 { set tree.fruit = ripe } }")
    (found,) = searched(orchard, Effort(examples=100, seed=5)).found
    golden(GOLDEN / "collapse.txt", "\n".join(describe_counterexample(orchard, found)) + "\n")


def test_the_same_seed_plays_the_same() -> None:
    """Seen in the trajectories themselves: counterexamples can be made so simple that all seeds come to the same."""
    records = [searched(small_game("always eaten < 99"), Effort(examples=20, seed=seed)).record for seed in (3, 3, 4)]
    trajectories = [[entry.scenario for entry in one.corpus] for one in records]
    assert trajectories[0] == trajectories[1]
    assert records[0].ran == records[1].ran
    assert trajectories[0] != trajectories[2]
    reports = [verify_properties(small_game("always eaten < 2"), Effort(examples=20, episodes=0, seed=seed)) for seed in (3, 3)]
    assert reports[0] == reports[1]


def test_numbers_of_a_scenario_stay_inside_their_limits_and_keep_requirements() -> None:
    from random import Random

    from sjdsl.compiler.ir.evaluate_constant import holds

    more = "param lo : steps = 2 in 1 .. 9  param hi : steps = 5 in 0 .. 9"
    orchard = small_game("require lo <= hi  always lo <= hi", "each agent { set agent.tired = max(hi - lo, 0) }", more)
    seen = set()
    for seed in range(200):
        scenario = random_start(orchard, Random(seed))
        assert scenario is not None
        given = {p.name: p.value for p in orchard.own.params} | dict(scenario.params)
        assert 1 <= given["lo"] <= 9
        assert 0 <= given["hi"] <= 9
        assert 0 <= given["regrow"] <= 1
        assert holds(orchard.own.checks[0].values[0], given)
        seen.add((given["lo"], given["hi"]))
    assert len(seen) >= 5


def test_what_only_a_long_episode_shows_is_found_there() -> None:
    orchard = small_game("always step < 79", text=ORCHARD.replace("episode 20", "episode 80"))  # trajectories are not that long
    (verdict,) = verify_properties(orchard, Effort(examples=5, episodes=2, tries=20)).verdicts
    assert verdict.passed is False
    assert verdict.reason == "fails after step 78"


def test_a_trigger_that_never_came_is_said() -> None:
    (verdict,) = verify_properties(small_game("once step > 900 always fruit == 0"), Effort(examples=10, episodes=1)).verdicts
    assert verdict.passed
    assert "never held" in verdict.reason


def test_a_game_that_takes_no_other_map_or_number_is_played_as_it_is() -> None:
    (source,) = small_game("always eaten <= 9").composition.sources.values()
    one = GameFamily(source)
    assert one.few_agents == (1, 2, 3, 4)
    assert one.most_agents == 4
    assert set(one.glyphs) == {".", "#", "T"}


def test_agents_named_by_number_in_an_action_are_renumbered() -> None:
    """`vote(0)` names another agent once two have swapped numbers; all three are treated alike here, and only agent 2 is not."""
    text = ORCHARD.replace("count = 2 in 1 .. 4", "count = 3 in 1 .. 3").replace("stay, zap", "stay, zap, vote(agent)")
    alike = "each agent as a where a chose vote(0) or a chose vote(1) or a chose vote(2) { give apple to a }"
    for rule, passes in ((alike, True), (alike.replace(" or a chose vote(2)", ""), False)):
        (verdict,) = verify_properties(small_game("symmetric agents", rule, text=text), Effort(examples=20, episodes=0, tries=20)).verdicts
        assert verdict.passed is passes
