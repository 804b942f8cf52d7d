"""What the search finds, how its counterexamples are simplified, and that the same seed finds the same."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from random import Random

import pytest

from sjdsl.compiler.ir.evaluate_constant import holds
from sjdsl.properties import Effort, verify_properties
from sjdsl.properties.counterexample import describe_counterexample
from sjdsl.properties.monitors import find_violation
from sjdsl.properties.random_play import random_scenario
from sjdsl.properties.trajectory import Scenario, play

from .small_games import ORCHARD, searched, small_game

GOLDEN = Path(__file__).parent
FAILING = [  # check, rule
    ("always zaps == 0", "each agent where agent chose zap { tally zaps for agent }"),
    ("once fruit == 0 always fruit == 0", "each tree where nobody on tree { chance 0.001 { set tree.fruit = ripe } }"),
    ("conserved fruit", ""),
    ("always eaten < 2", ""),
    ("always count(agent where agent.tired > 0) == 0", "each agent where agent chose zap { set agent.tired = 2 }"),
    ("monotone bare rising in fruit", ""),
]


@pytest.mark.parametrize(("check", "rule"), FAILING)
@pytest.mark.parametrize("compiled", [False, pytest.param(True, marks=pytest.mark.thorough)])
def test_a_counterexample_ends_at_the_violation_and_shows_who_must_act(check: str, rule: str, compiled: bool) -> None:
    """Played again it violates the check in its last state, and without the actions of any one agent it does not, or only with other draws."""
    orchard = small_game(check, rule)
    game, stay = orchard.own, orchard.own.agents.actions.index("stay")
    found = searched(orchard, Effort(examples=200 if not compiled else 0, seed=1, compiled=compiled)).found[0]
    assert len(found.scenario.actions) == found.where.at
    assert find_violation(game.checks[0], play(game, found.scenario).values(game.checks[0])) == found.where
    for agent in range(2):
        steps = [(*step[:agent], stay, *step[agent + 1 :]) for step in found.scenario.actions]
        still = replace(found.scenario, actions=tuple(steps))
        assert still == found.scenario or find_violation(game.checks[0], play(game, still).values(game.checks[0])) is None


def test_a_trace_in_full(golden: Callable[[Path, str], None]) -> None:
    orchard = small_game("once fruit == 0 always fruit == 0", "each tree where nobody on tree { chance 0.5 { set tree.fruit = ripe } }")
    found = searched(orchard, Effort(examples=100, seed=5, compiled=False)).found[0]
    golden(GOLDEN / "collapse.txt", "\n".join(describe_counterexample(orchard, found)) + "\n")


def test_the_same_seed_plays_the_same() -> None:
    def scenarios(seed: int) -> list[Scenario]:
        random = Random(seed)
        return [random_scenario(small_game("").own, 20, random) for _ in range(5)]

    assert scenarios(3) == scenarios(3) != scenarios(4)
    reports = [verify_properties(small_game("always eaten < 2"), Effort(examples=20, seed=seed, compiled=False)) for seed in (3, 3)]
    assert reports[0] == reports[1]


def test_numbers_of_a_scenario_stay_inside_their_limits_and_keep_requirements() -> None:
    more = "param lo : steps = 2 in 1 .. 9  param hi : steps = 5 in 0 .. 9"
    orchard = small_game("require lo <= hi  always lo <= hi", "each agent { set agent.tired = max(hi - lo, 0) }", more)
    seen = set()
    for seed in range(400):
        scenario = random_scenario(orchard.own, 1, Random(seed))
        given = {p.name: p.value for p in orchard.own.params} | dict(scenario.params)
        assert 1 <= given["lo"] <= 9
        assert 0 <= given["hi"] <= 9
        assert 0 <= given["regrow"] <= 1
        assert holds(orchard.own.checks[0].values[0], given)
        seen.add((given["lo"], given["hi"]))
    assert len(seen) >= 5


def test_what_only_a_long_episode_shows_is_found_there() -> None:
    orchard = small_game("always step < 79", text=ORCHARD.replace("episode 20", "episode 80"))  # trajectories are not that long
    (verdict,) = verify_properties(orchard, Effort(examples=5)).verdicts
    assert verdict.passed is False
    assert verdict.reason == "fails after step 78"
