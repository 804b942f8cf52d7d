"""The counterexample to a failed check comes to the board: its map, its draws and actions, step by step, until the game is begun again."""

import json
from pathlib import Path
from typing import Any

import pytest

from sjdsl.compiler.diagnostics.source import Source
from sjdsl.properties import Effort, GameFamily, verify_properties
from sjdsl.properties.trajectory import Scenario, play
from sjdsl.studio.bench import Bench
from sjdsl.studio.requests import READ

GAME = """sj 1
game yard "Yard" {
  param luck : probability = 0.5 in 0 .. 1
  episode 30
  kind floor "."
  kind soil "A" { field fruit : { none, ripe } = none }
  map { "..A....."
        "........"
        "........"
        "........"
        "........"
        "........"
        "........"
        "........"
        "........" }
  agents 2 {
    acts turn_left, forward, stay
    moves relative
    field bag : 0 .. 3 capped = 0
  }
  phase start { each agent { send agent to floor facing north } }
  schedule grow -> walk -> eat
  phase grow { each soil where soil.fruit is none { chance luck { set soil.fruit = ripe } } }
  phase walk { move each agent }
  phase eat { each agent on soil where soil.fruit is ripe { add 1 to agent.bag  give 1 to agent  set soil.fruit = none } }
  observe { window ahead 1, behind 1, left 1, right 1 }
  checks { always count(agent where agent.bag > 0) == 0 }
}
"""


def ask(bench: Bench, **request: Any) -> dict[str, Any]:
    return json.loads(
        json.dumps(bench.answer(READ.validate_json(json.dumps({"id": 7, **request}))))
    )


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    made = Bench(tmp_path)
    assert ask(made, do="text", version=1, path="yard.sj", text=GAME)["compiles"]
    return made


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Returns the counterexample that the panel of checks gives, as the page gets it."""
    made = Bench(tmp_path_factory.mktemp("folder"))
    ask(made, do="text", version=1, path="yard.sj", text=GAME)
    (verdict,) = ask(made, do="panel", panel="checks")["verdicts"]
    assert verdict["status"] == "failed"
    assert verdict["scenario"]["actions"]
    return dict(verdict["scenario"])


def test_a_failed_check_has_what_leads_to_it() -> None:
    """Played again by the interpreter, the scenario of a verdict violates the check in its last state, and in none before."""
    family = GameFamily(Source("yard.sj", GAME, Path()))
    (verdict,) = verify_properties(family, Effort(examples=200, compiled=False)).verdicts
    assert isinstance(verdict.scenario, Scenario)
    bags = [world.agents["bag"] for world in play(family.own, verdict.scenario).worlds]
    assert len(bags) == len(verdict.scenario.actions) + 1
    assert max(bags[-1]) > 0
    assert not any(max(bag) for bag in bags[:-1])


def test_an_episode_that_misses_an_expectation_is_written_out() -> None:
    """It is the whole episode on the game's own map, with the draws and actions that the verdict is about."""
    text = GAME.replace(
        "always count(agent where agent.bag > 0) == 0",
        "expect eaten > 1000 with random over 2 episodes",
    )
    text = text.replace(
        "set soil.fruit = none }", "set soil.fruit = none  tally eaten for agent }"
    ).replace("  checks", "  metrics { event eaten }\n  checks")
    family = GameFamily(Source("yard.sj", text, Path()))
    (verdict,) = verify_properties(family, Effort(examples=1)).verdicts
    assert verdict.scenario is not None
    assert len(verdict.scenario.actions) == 30
    trajectory = play(family.own, verdict.scenario)
    assert trajectory.is_over
    said = next(line for line in verdict.trace if line.startswith("at its end"))
    assert f"eaten {sum(sum(outcome.events['eaten']) for outcome in trajectory.outcomes)}" in said


def test_it_is_shown_step_by_step(bench: Bench, scenario: dict[str, Any]) -> None:
    shown = ask(bench, do="replay", **scenario)
    assert (shown["at"], shown["moments"]) == (0, len(scenario["actions"]) + 1)
    assert (shown["game"]["height"], shown["game"]["width"]) == (
        len(scenario["rows"]),
        len(scenario["rows"][0]),
    )
    assert shown["game"]["counterexample"]
    last = ask(bench, do="go", to=99)
    assert max(last["scene"]["rewards"]) == 1
    assert last["scene"]["actions"] == scenario["actions"][-1]
    agents = ask(bench, do="panel", panel="state")["agents"]
    assert any(dict(agent)["bag"] == "1" for agent in agents)


def test_why_is_told_with_its_own_draws(bench: Bench, scenario: dict[str, Any]) -> None:
    """What every step is said to change is what changed: the account takes the draws of the counterexample, not those of the seed."""
    ask(bench, do="replay", **scenario)
    grew = ate = 0
    for at in range(len(scenario["actions"]) + 1):
        ask(bench, do="go", to=at)
        ripe_now = [
            dict(ask(bench, do="panel", panel="state", row=r, col=c)["cell"]["values"])
            for r, c in soils(scenario)
        ]
        turns = ask(bench, do="panel", panel="trace")["turns"]
        said = [
            effect["said"] for turn in turns for rule in turn["rules"] for effect in rule["effects"]
        ]
        grew += sum("none -> ripe" in text for text in said)
        ate += sum("ripe -> none" in text for text in said)
        assert sum(values["fruit"] == "ripe" for values in ripe_now) == grew - ate
    assert ate == 1


def soils(scenario: dict[str, Any]) -> list[tuple[int, int]]:
    return [
        (r, c)
        for r, row in enumerate(scenario["rows"])
        for c, glyph in enumerate(row)
        if glyph == "A"
    ]


def test_the_game_itself_comes_back(bench: Bench, scenario: dict[str, Any]) -> None:
    ask(bench, do="replay", **scenario)
    assert "counterexample" in ask(bench, do="paint", row=0, col=0, glyph="A")["refused"]
    ask(bench, do="go", to=99)
    assert ask(bench, do="step")["at"] == len(scenario["actions"]) + 1, "one can play on from there"
    back = ask(bench, do="begin", seed=4)
    assert (back["game"]["height"], back["game"]["counterexample"], back["at"]) == (9, False, 0)
    ask(bench, do="replay", **scenario)
    edited = ask(bench, do="text", version=2, path="yard.sj", text=GAME.replace("give 1", "give 2"))
    assert (edited["game"]["height"], edited["kept"]) == (9, False)


@pytest.mark.parametrize(
    "wrong",
    [
        {"rows": ["..?"]},
        {"rows": ["..", "..."]},
        {"actions": [[0]]},
        {"actions": [[9, 0]]},
        {"params": [["gone", 1]]},
    ],
    ids=str,
)
def test_one_of_other_rules_is_refused_in_words(
    bench: Bench, scenario: dict[str, Any], wrong: dict[str, Any]
) -> None:
    assert "have changed since" in ask(bench, do="replay", **{**scenario, **wrong})["refused"]
    assert ask(bench, do="step")["at"] == 1, "and the board is as it was"
