"""What random courses find, how short it becomes, and that the same seed finds the same."""

from collections.abc import Callable
from pathlib import Path

import pytest

from sjdsl.properties import Effort, Ground, examine
from sjdsl.properties.counterexample import tell_course
from sjdsl.properties.monitors import find_break
from sjdsl.properties.random_starts import random_start
from sjdsl.properties.search import search
from sjdsl.properties.trajectory import play

from .small_games import ORCHARD, ground

GOLDEN = Path(__file__).parent
BROKEN = [  # promise, rule, the steps and the agents of the shortest course
    ("always zaps == 0", "each agent where agent chose zap { tally zaps for agent }", 1, 1),
    ("once fruit == 0 always fruit == 0", "each tree where nobody on tree { chance 0.001 { set tree.fruit = ripe } }", 2, 1),
    ("conserved fruit", "", 1, 1),
    ("always eaten < 2", "", 1, 2),
    ("always count(agent where agent.tired > 0) == 0", "each agent where agent chose zap { set agent.tired = 2 }", 1, 1),
    ("monotone bare rising in fruit", "", 1, 1),
]


@pytest.mark.parametrize(("promise", "rule", "steps", "agents"), BROKEN)
def test_broken_promises_become_short(promise: str, rule: str, steps: int, agents: int) -> None:
    orchard = ground(promise, rule)
    (broken,), _ = search(orchard, [0], Effort(examples=100, seed=1))
    assert len(broken.course.actions) <= steps + 1
    assert broken.course.agents <= agents
    assert len(broken.course.rows) * len(broken.course.rows[0]) <= 6
    assert not broken.course.params
    stay = orchard.own.agents.actions.index("stay")
    assert sum(action != stay for step in broken.course.actions for action in step) <= 2


def test_a_course_that_is_told_breaks_the_promise_when_played_again() -> None:
    orchard = ground("always eaten < 2")
    (broken,), _ = search(orchard, [0], Effort(examples=100))
    game = orchard.on(broken.course.rows, broken.course.agents)
    assert game is not None
    assert find_break(game.checks[0], play(game, broken.course).values(game.checks[0])) == broken.where


def test_a_trace_in_full(golden: Callable[[Path, str], None]) -> None:
    orchard = ground("once fruit == 0 always fruit == 0", "each tree where nobody on tree { chance 0.5 { set tree.fruit = ripe } }")
    (broken,), _ = search(orchard, [0], Effort(examples=100))
    golden(GOLDEN / "collapse.txt", "\n".join(tell_course(orchard, broken)) + "\n")


def test_the_same_seed_plays_the_same() -> None:
    """Seen in the courses themselves: what they break can be made so simple that all seeds come to the same."""
    tried = [search(ground("always eaten < 99"), [0], Effort(examples=20, seed=seed))[1] for seed in (3, 3, 4)]
    courses = [[kept.course for kept in one.corpus.kept] for one in tried]
    assert courses[0] == courses[1]
    assert tried[0].ran == tried[1].ran
    assert courses[0] != courses[2]
    reports = [examine(ground("always eaten < 2"), Effort(examples=20, episodes=0, seed=seed)) for seed in (3, 3)]
    assert reports[0] == reports[1]


def test_numbers_of_a_course_stay_inside_their_limits_and_keep_requirements() -> None:
    from random import Random

    from sjdsl.compiler.ir.evaluate_constant import holds

    more = "param lo : steps = 2 in 1 .. 9  param hi : steps = 5 in 0 .. 9"
    orchard = ground("require lo <= hi  always lo <= hi", "each agent { set agent.tired = max(hi - lo, 0) }", more)
    seen = set()
    for seed in range(200):
        course = random_start(orchard, Random(seed))
        assert course is not None
        given = {p.name: p.value for p in orchard.own.params} | dict(course.params)
        assert 1 <= given["lo"] <= 9
        assert 0 <= given["hi"] <= 9
        assert 0 <= given["regrow"] <= 1
        assert holds(orchard.own.checks[0].values[0], given)
        seen.add((given["lo"], given["hi"]))
    assert len(seen) >= 5


def test_what_only_a_long_episode_shows_is_found_there() -> None:
    orchard = ground("always step < 79", text=ORCHARD.replace("episode 20", "episode 80"))  # courses are not that long
    (verdict,) = examine(orchard, Effort(examples=5, episodes=2)).verdicts
    assert verdict.kept is False
    assert verdict.how == "episodes"
    assert verdict.said == "broken after step 78 of an episode of random play"


def test_a_trigger_that_never_came_is_said() -> None:
    (verdict,) = examine(ground("once step > 900 always fruit == 0"), Effort(examples=10, episodes=1)).verdicts
    assert verdict.kept
    assert "never held" in verdict.said


def test_a_game_that_takes_no_other_map_or_number_is_played_as_it_is() -> None:
    one = Ground(ground("always eaten <= 9").source)
    assert one.few_agents == (1, 2)
    assert set(one.glyphs) == {".", "#", "T"}


FEW_MOVES = ("turn_left, turn_right, step_left, step_right, forward, backward, stay", "turn_left, turn_right, forward, stay")
SELDOM = [  # a rule by which a collapse does not last, the steps of an episode, how many of 12 seeds must find that
    ("each tree where nobody on tree { chance 0.001 { set tree.fruit = ripe } }", 20, 11),
    ("each tree where tree.fruit is none { chance 0.5 { set tree.fruit = ripe } }", 20, 10),
    ("each tree where tree.fruit is none { chance 0.5 { set tree.fruit = ripe } }", 6, 4),
]


@pytest.mark.slow
@pytest.mark.parametrize(("rule", "steps", "least"), SELDOM)
def test_what_is_seldom_is_found_with_most_seeds(rule: str, steps: int, least: int) -> None:
    text = ORCHARD.replace("episode 20", f"episode {steps}")
    text = text.replace(*FEW_MOVES) if steps < 20 else text  # short episodes of agents that must turn
    orchard = ground("once fruit == 0 always fruit == 0", rule, text=text)
    found = sum(bool(search(orchard, [0], Effort(examples=200, seed=seed, tries=0))[0]) for seed in range(12))
    print(f"{found} of 12 seeds")
    assert found >= least
