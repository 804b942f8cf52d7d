"""What the search finds, how its counterexamples are simplified, and that the same seed finds the same."""

from collections.abc import Callable
from dataclasses import replace
from itertools import product
from pathlib import Path
from random import Random
from typing import Any

import pytest

from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.ir.values import holds
from sjdsl.properties import Effort, GameFamily, search, verify_properties
from sjdsl.properties.counterexample import describe_counterexample
from sjdsl.properties.monitors import Violation, find_violation
from sjdsl.properties.random_play import random_scenario
from sjdsl.properties.search import Counterexample
from sjdsl.properties.trajectory import Scenario, Trajectory, play

from .small_games import ORCHARD, searched, small_game

GOLDEN = Path(__file__).parent
FAILING = [  # check, rule
    ("always zaps == 0", "each agent where agent chose zap { tally zaps for agent }"),
    (
        "once fruit == 0 always fruit == 0",
        "each tree where nobody on tree { chance 0.001 { set tree.fruit = ripe } }",
    ),
    ("conserved fruit", ""),
    ("always eaten < 2", ""),
    (
        "always count(agent where agent.tired > 0) == 0",
        "each agent where agent chose zap { set agent.tired = 2 }",
    ),
    ("monotone bare rising in fruit", ""),
]


@pytest.mark.parametrize(("check", "rule"), FAILING)
@pytest.mark.parametrize("compiled", [False, pytest.param(True, marks=pytest.mark.thorough)])
def test_a_counterexample_ends_at_the_violation_and_has_no_action_too_many(
    check: str, rule: str, compiled: bool
) -> None:
    """Played again it violates the check in its last state, and with `stay` in place of any one action it does not."""
    orchard = small_game(check, rule)
    game, stay = orchard.own, orchard.own.agents.actions.index("stay")
    found = searched(
        orchard, Effort(examples=200 if not compiled else 0, seed=1, compiled=compiled)
    ).found[0]
    assert len(found.scenario.actions) == found.where.at
    assert (
        find_violation(game.checks[0], play(game, found.scenario).values(game.checks[0]))
        == found.where
    )
    for t, agent in product(range(found.where.at), range(2)):
        steps = [list(step) for step in found.scenario.actions]
        steps[t][agent] = stay
        still = replace(found.scenario, actions=tuple(map(tuple, steps)))
        assert (
            still == found.scenario
            or find_violation(game.checks[0], play(game, still).values(game.checks[0])) is None
        )


def test_a_trace_in_full(golden: Callable[[Path, str], None]) -> None:
    orchard = small_game(
        "once fruit == 0 always fruit == 0",
        "each tree where nobody on tree { chance 0.5 { set tree.fruit = ripe } }",
    )
    found = searched(orchard, Effort(examples=100, seed=5, compiled=False)).found[0]
    golden(GOLDEN / "collapse.txt", "\n".join(describe_counterexample(orchard, found)) + "\n")


WIDE = """sj 1
game wide {
  episode 20
  kind grass "."
  kind tree "T" { field fruit : { none, ripe } = ripe  field owed : reward = 0  field taker : agent }
  map { "..MAP" }
  agents 2 {
    acts forward, stay
    moves relative
    field purse by 0 .. 63 : 0 .. 99 = 0
  }
  field total : reward = 0
  phase start { each agent { send agent to grass } }
  schedule rule
  phase rule { RULE }
  checks { always step == 0 }
}
"""
PLENTY = [
    "each tree { set tree.fruit = none }",  # alike changes
    "each tree { set tree.owed = case tree.col % 2 == 0 { yes: 0.5, no: 1.5 } }",  # changes of numbers
    "each tree { chance 1 { add 1 to total } }",  # reasons of one change
    "each agent { each tree { set tree.taker = agent by lot } }",  # lots
    "each agent { set agent.purse = 7 }",  # entries of a row
]


@pytest.mark.parametrize("rule", PLENTY)
def test_a_counterexample_is_readable_however_much_happens(rule: str) -> None:
    wide = GameFamily(Source("wide.sj", WIDE.replace("MAP", "T" * 120).replace("RULE", rule), None))
    found = searched(wide, Effort(examples=5, compiled=False)).found[0]
    lines, full = (describe_counterexample(wide, found, full) for full in (False, True))
    assert len(lines) < 40 < 100 < len(full)
    assert "every change of this step: `sjdsl test --full`" in lines
    assert set(full) >= {line for line in lines if not line.lstrip().startswith(("and ", "every "))}


def test_a_search_for_actions_too_many_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    orchard, played = small_game("always step < 19"), list[int]()

    def counted(*given: Any, **named: Any) -> Trajectory:
        trajectory = play(*given, **named)
        played.append(len(trajectory.outcomes) - named.get("since", 0))
        return trajectory

    scenario = Scenario(0, actions=((7, 7),) * 19)
    found = Counterexample(0, scenario, play(orchard.own, scenario), Violation(19))
    monkeypatch.setattr(search, "AGAIN", 60)
    monkeypatch.setattr(search, "play", counted)
    search.simplified(found)
    assert 0 < sum(played) <= 60


def test_the_same_seed_plays_the_same() -> None:
    def scenarios(seed: int) -> list[Scenario]:
        random = Random(seed)
        return [random_scenario(small_game("").own, 20, random) for _ in range(5)]

    assert scenarios(3) == scenarios(3) != scenarios(4)
    reports = [
        verify_properties(
            small_game("always eaten < 2"), Effort(examples=20, seed=seed, compiled=False)
        )
        for seed in (3, 3)
    ]
    assert reports[0] == reports[1]


def test_numbers_of_a_scenario_stay_inside_their_limits_and_keep_requirements() -> None:
    more = "param lo : steps = 2 in 1 .. 9  param hi : steps = 5 in 0 .. 9"
    orchard = small_game(
        "require lo <= hi  always lo <= hi",
        "each agent { set agent.tired = max(hi - lo, 0) }",
        more,
    )
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
    orchard = small_game(
        "always step < 79", text=ORCHARD.replace("episode 20", "episode 80")
    )  # trajectories are not that long
    (verdict,) = verify_properties(orchard, Effort(examples=5)).verdicts
    assert verdict.passed is False
    assert verdict.reason == "fails after step 78"
