"""Checks on transitions: `before(e)` is the value of e when the step began, in both engines, and nothing is proved of it that is not so."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from sjdsl.compiler import check, ir
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.interpreter.state import World
from sjdsl.properties import verify_properties
from sjdsl.properties.engines import Episode, EpisodeRunner
from sjdsl.properties.trajectory import play
from sjdsl.properties.verdict import Effort
from sjdsl.properties.verify_properties import decide_statically

from .small_games import ORCHARD, small_game

RANDOM = (ir.Policy(name="random"),)

RULE = """each agent where agent chose zap { set agent.tired = 2  tally zaps for agent }
  each tree where tree.fruit is none and nobody on tree { chance regrow { set tree.fruit = ripe } }
  each agent where agent.wealth == 3 { send agent to grass after 2 }
  each agent as a where a chose stay { first agent as b in disc(2) of a { set a.friend = b } }"""
FRIEND = "field friend : agent"

# A check, and what it reads of two states, by a program of its own.
READ = [
    ("always before(fruit) - fruit < 1", lambda a, b, _: ripe(a) - ripe(b) < 1),
    ("always before(step) + 1 == step", lambda a, b, _: a.step + 1 == b.step),
    (
        "always all(agent where agent.wealth <= before(agent.wealth) + 1)",
        lambda a, b, _: all(y <= x + 1 for x, y in pairs(a, b, "wealth")),
    ),
    (
        "always count(agent where agent.wealth > before(agent.wealth)) < 1",
        lambda a, b, _: not any(y > x for x, y in pairs(a, b, "wealth")),
    ),
    (
        "always all(agent where agent.friend is before(agent.friend))",
        lambda a, b, _: all(x == y for x, y in pairs(a, b, "friend")),
    ),
    ("always all(agent where before(agent.away) or not agent.away)", None),
    ("always all(tree where tree.fruit is before(tree.fruit))", lambda a, b, _: a.cells == b.cells),
    ("always before(any(agent on tree where tree.fruit is none)) or fruit > 0", None),
    ("always before(count(agent as x where any(agent as y in ray of x))) == 0", None),
    ("always eaten - before(eaten) < 1", lambda _, __, counts: counts[1] == counts[0]),
    ("once before(fruit) > fruit always before(eaten) <= eaten and eaten > 0", None),
]


def ripe(world: World) -> int:
    return world.cells["tree", "fruit"].count("ripe")


def pairs(a: World, b: World, field: str) -> list[tuple[Any, Any]]:
    return [
        (x, y)
        for x, y, away in zip(a.agents[field], b.agents[field], b.away, strict=True)
        if away is None
    ]


@pytest.fixture(scope="module")
def family() -> Any:
    text = ORCHARD.replace('"..T" ".T."', '"..T." ".T#." "...."').replace(
        "timer tired", f"timer tired  {FRIEND}"
    )
    return small_game("  ".join(check for check, _ in READ), RULE, text=text)


@pytest.fixture(scope="module")
def episodes(family: Any) -> tuple[list[Episode], list[Episode]]:
    runner = EpisodeRunner(family, seed=3)
    runner.checks = dict(enumerate(family.own.checks))
    return runner.play_compiled(RANDOM, 0, 4), [
        runner.play_interpreted(RANDOM, number) for number in range(4)
    ]


def test_both_engines_read_the_same(episodes: tuple[list[Episode], list[Episode]]) -> None:
    for mine, theirs in zip(*episodes, strict=True):
        for number, values in mine.values.items():
            np.testing.assert_array_equal(
                np.asarray(values, float),
                np.asarray(theirs.values[number], float),
                err_msg=READ[number][0],
            )


@pytest.mark.parametrize("number", [n for n, (_, read) in enumerate(READ) if read is not None])
def test_what_is_read_is_the_state_before_the_step(family: Any, number: int) -> None:
    """Also of fields of agents that were away then, and of totals."""
    runner, (_, wanted) = EpisodeRunner(family, seed=3), READ[number]
    seen: set[bool] = set()
    for episode in range(4):
        trajectory = play(family.own, runner.scenario(RANDOM, episode), 20)
        found = trajectory.values(family.own.checks[number])
        for t in range(1, len(found)):
            counts = [
                sum(n for (event, _), n in trajectory.totals[at].items() if event == "eaten")
                for at in (t - 1, t)
            ]
            assert found[t][0] == wanted(*trajectory.worlds[t - 1 : t + 1], counts), t
            seen.add(found[t][0])
    assert seen == {True, False} or number in (1, 2), "what is read changes"


FAILING = [
    "always before(fruit) <= fruit",
    "always all(agent where agent.wealth == before(agent.wealth))",
    "always before(fruit) == fruit",
    "once before(fruit) > fruit always fruit > 1",
    "always eaten == before(eaten)",
]
HOLDING = [
    "always before(step) < step",
    "always all(agent where agent.wealth >= before(agent.wealth))",
    "once before(fruit) > fruit always eaten > 0",
    "always before(fruit) - fruit == eaten - before(eaten)",
]


@pytest.mark.parametrize("check", [*FAILING, *HOLDING])
def test_a_verdict_on_a_transition_is_found_by_play(check: str) -> None:
    game = small_game(check, text=ORCHARD)
    assert decide_statically(game, 0) is None
    (verdict,) = verify_properties(game, Effort(examples=60, seed=1, compiled=False)).verdicts
    assert verdict.passed == (check in HOLDING), verdict


def test_ranges_hold_before_a_step_as_after_it() -> None:
    verdict = decide_statically(small_game("always before(fruit) <= count(tree)"), 0)
    assert verdict is not None
    assert verdict.how == "proved"


def refused(checks: str, rule: str = "") -> Sequence[str]:
    text = ORCHARD.format(more="", rule=rule, checks=checks)
    return [d.code for d in check(Source("game.sj", text)) if d.severity == "error"]


@pytest.mark.parametrize(
    "checks",
    [
        "conserved before(fruit)",
        "require before(2) < 3",
        "always before(before(fruit)) > 0",
        "expect before(fruit) > 0 with random over 3 episodes",
    ],
)
def test_before_is_for_checks_of_steps(checks: str) -> None:
    assert refused(checks) == ["SJ213"]


def test_before_is_no_part_of_rules() -> None:
    assert refused("", "when before(fruit) > 0 { end }") == ["SJ213"]


def test_a_place_before_the_step_is_asked_of_those_who_had_one() -> None:
    away = "each agent where agent chose zap { send agent to grass after 3 }"
    assert refused("always all(agent where before(agent.row) >= 0)", away) == ["SJ508"]
    assert refused("always all(agent where before(agent.row) >= 0)") == []
    assert refused("always before(all(agent where agent.row >= 0))", away) == []


def test_what_is_known_now_is_not_known_of_the_state_before() -> None:
    text = ORCHARD.replace("timer tired", f"timer tired  {FRIEND}")
    tests = "always all(agent where agent.friend is nobody or before(agent.friend.wealth) >= 0)"
    inside = "always all(agent where before(agent.friend is nobody or agent.friend.wealth >= 0))"
    for checks, codes in ((tests, ["SJ209"]), (inside, [])):
        found = check(Source("game.sj", text.format(more="", rule="", checks=checks)))
        assert [d.code for d in found if d.severity == "error"] == codes
