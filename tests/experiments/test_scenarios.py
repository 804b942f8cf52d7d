"""Scenarios: who is focal, what focal and background agents earn in games whose payoffs are known, the score, and what is refused."""

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_games import GAMES, matrix_game
from stored_policies import store, store_pool

import sjdsl
from sjdsl.compiler import ir
from sjdsl.experiments import ExperimentError, play_scenarios
from sjdsl.experiments.lineups import orders_of, play_key
from sjdsl.experiments.scenario_scores import ScenarioScore, ScenarioScores
from sjdsl.experiments.scenarios import plan_scenarios
from sjdsl.trainers import PolicyError, evaluate, find_policy
from tests.trainers.probes import constant

VISITORS = GAMES / "visitors.sj"
FITTING = ("visitor", "intruded", "alone")  # with four agents
EPISODES, SEED = 5, 3


@cache
def visitors(players: int = 4, ranked: float = 1.0) -> Any:
    """Two steps; who `stay`s gives 1, and has a half of all that is given, as everybody has, and its number."""
    return sjdsl.make(VISITORS, params={"players": players, "ranked": ranked})


@pytest.fixture(scope="module")
def played(tmp_path_factory: pytest.TempPathFactory) -> tuple[ScenarioScores, Path]:
    """Those who give, in a scenario; then, in the same folder, in all that four agents fill."""
    folder = tmp_path_factory.mktemp("scenarios")
    said: list[str] = []
    first = play_scenarios(visitors(), "giver", "visitor", EPISODES, SEED, folder, tell=said.append)
    assert said == [
        f"playing {EPISODES} episodes of line-up {number} of 4" for number in (1, 2, 3, 4)
    ], "giver, random, keeper, stay"
    assert list(first) == list(first.scenarios) == ["visitor"]
    assert list(json.loads((folder / "scenarios.json").read_text())["scenarios"]) == ["visitor"]
    return play_scenarios(visitors(), "giver", FITTING, EPISODES, SEED, folder), folder


def per_capita(deeds: str, members: slice) -> list[float]:
    """Returns what members of a line-up earn on average in each episode: `g` gives, `k` keeps, as the slots of the episode are drawn."""
    share = 2 * deeds.count("g") / len(deeds)
    earned = [
        [2 * (share + slot - (deed == "g")) for deed, slot in zip(deeds, order, strict=True)]
        for order in orders_of(SEED, 0, EPISODES, len(deeds)).tolist()
    ]
    return [float(np.mean(row[members])) for row in earned]


def test_focal_and_background_returns_exactly(played: tuple[ScenarioScores, Path]) -> None:
    """Each episode seats them anew, and who sits where shows in what it is paid."""
    found, _ = played
    first, second = slice(0, 1), slice(1, 4)
    assert found["visitor"].focal_returns.tolist() == [per_capita("gkkk", first)]
    assert found["visitor"].background_returns is not None
    assert found["visitor"].background_returns.tolist() == [per_capita("gkkk", second)]
    assert len(set(found["visitor"].focal_returns[0])) > 1, "slots are drawn"
    assert found["intruded"].focal_returns.tolist() == [per_capita("kggg", second)]
    assert found["intruded"].background_returns is not None
    assert found["intruded"].background_returns.tolist() == [per_capita("kggg", first)]
    assert found["alone"].focal_returns.tolist() == [[2 * (2 - 1 + 1.5)] * EPISODES]
    assert found["alone"].background is None
    visitor = found["visitor"].baselines
    assert visitor["keeper"].tolist() == [per_capita("kkkk", first)]
    assert (
        visitor["giver"].tolist()
        == visitor["stay"].tolist()
        == found["visitor"].focal_returns.tolist()
    )
    random, giver, keeper = (visitor[name][0] for name in ("random", "giver", "keeper"))
    assert ((giver <= random) & (random <= keeper)).all(), (
        "who gives now and then loses a half of what it gives"
    )
    assert ((giver < random) & (random < keeper)).any()


def test_the_files_and_a_second_time(played: tuple[ScenarioScores, Path]) -> None:
    """A scenario that was played before, and one that is asked for now, are in one file; another experiment is refused there."""
    found, folder = played
    stored = json.loads((folder / "scenarios.json").read_text())
    assert (stored["format"], stored["game"]["hash"], stored["focal_policy"]) == (
        1,
        visitors().hash,
        "giver",
    )
    assert (stored["unit"], stored["units"], stored["training_seeds"]) == ("episode", EPISODES, [])
    assert tuple(stored["scenarios"]) == FITTING
    visitor = stored["scenarios"]["visitor"]
    assert visitor["slots"] == [[1, None], [3, "keeper"]]
    assert (visitor["best"], visitor["score"]) == ("keeper", found["visitor"].score)
    assert visitor["returns"]["focal"] == found["visitor"].focal_returns.tolist()
    assert visitor["focal"]["mean"] == found["visitor"].focal.mean
    assert visitor["baselines"]["keeper"]["mean"] == found["visitor"].baseline("keeper").mean
    assert stored["scenarios"]["alone"]["background"] is None

    before = (folder / "scenarios.json").read_bytes()
    again = play_scenarios(visitors(), "giver", "alone", EPISODES, SEED, folder)
    assert list(again.scenarios) == ["alone"]
    assert (folder / "scenarios.json").read_bytes() == before
    for message, env, policy in (
        ("its policies differ", visitors(), "keeper"),
        ("ranked 1.0 there, 0.0 here", visitors(4, 0.0), "giver"),
    ):
        with pytest.raises(ExperimentError, match=message):
            play_scenarios(env, policy, FITTING, EPISODES, SEED, folder)


def scored(focal: Any, **baselines: list[float]) -> ScenarioScore:
    """Returns a scenario with given returns."""
    slots = (ir.Slots(number=1), ir.Slots(number=1, policy="stay"))
    arrays = {name: np.array([returns]) for name, returns in baselines.items()}
    return ScenarioScore(
        ir.Scenario(name="made", slots=slots), np.array(focal, float), None, arrays
    )


def test_the_score_by_hand() -> None:
    """(4 - 1) / (9 - 1); the best scripted policy counts wherever it stands."""
    score = scored(
        [[3.0, 5.0]], random=[0.5, 1.5], cooperator=[3, 3], defector=[8, 10], stay=[0, 0]
    )
    assert (score.best, score.score, score.caution) == ("defector", 3 / 8, "")
    assert scored([[9.0, 9.0]], random=[1, 1], cooperator=[9, 9], stay=[9, 9]).best == "cooperator"
    below = scored([[-7.0, -7.0]], random=[1, 1], stay=[9, 9])
    assert (below.best, below.score) == ("stay", -1.0)


@pytest.mark.parametrize("best", [[1.0, 1.0], [0.0, 1.0]])
def test_a_score_that_is_not_defined(best: list[float]) -> None:
    score = scored([[3.0, 5.0]], random=[1, 1], cooperator=best, stay=[0, 0])
    assert score.score is None
    assert (
        "the score is undefined: the best scripted focal policy, cooperator, earns" in score.caution
    )


def test_a_score_that_may_be_a_share_of_nothing() -> None:
    score = scored([[3.0, 5.0]], random=[1, 1], stay=[0, 4])
    assert score.score == 3.0
    assert (
        "the score is uncertain: stay minus random is 1, with the interval [-24.41, 26.41]"
        in score.caution
    )
    assert "of unknown width" in scored([[3.0]], random=[1], stay=[2]).caution


def test_intervals_are_over_training_seeds_where_there_are_two() -> None:
    seeds = scored([[1.0, 3.0], [5.0, 5.0], [8.0, 8.0]], random=[1, 1], stay=[9, 9])
    assert seeds.focal.mean == 5.0
    assert seeds.focal.high - seeds.focal.mean == pytest.approx(
        4.302653 * 3 / np.sqrt(3)
    )  # t(0.975, 2), standard deviation 3


@pytest.mark.thorough
def test_networks_with_memory_of_their_own_and_several_seeds(tmp_path: Path) -> None:
    """Who visits those who keep has, of each 1 that it gives, a half: what it gives in slot i is known from its evaluation."""
    env = visitors(4, 0.0)
    pool = store_pool(tmp_path / "run", env, (5, 6), sharing="per_agent", memory="gru")
    found = play_scenarios(env, pool, "visitor", EPISODES, SEED, folder=pool)
    assert (found.unit, found.population, [*found.scenarios]) == (
        "training seed",
        "2 training seeds",
        ["visitor"],
    )
    for replicate, seed in enumerate((5, 6)):
        alone = evaluate(
            env, find_policy(f"{pool}/seed_{seed}", env), play_key(SEED, 0), EPISODES
        ).events["given"]
        assert (alone == alone[0]).all(), "actions are certain"
        orders = orders_of(SEED, replicate, EPISODES, 4)
        assert found["visitor"].focal_returns[replicate].tolist() == [
            -alone[0][order[0]] / 2 for order in orders
        ]
    assert len(set(found["visitor"].focal_returns.ravel())) > 1
    stored = json.loads((pool / "scenarios.json").read_text())
    assert (stored["unit"], stored["units"], stored["training_seeds"]) == (
        "training seed",
        2,
        [5, 6],
    )
    assert np.shape(stored["scenarios"]["visitor"]["returns"]["focal"]) == (2, EPISODES)


def test_what_is_refused() -> None:
    env = visitors()
    for names, said in (
        ("visitr", r"there is no scenario `visitr`; did you mean `visitor`\?"),
        (
            "nobody",
            "there is no scenario `nobody`; those of visitors are visitor, intruded, three, alone",
        ),
        ((), "name at least one scenario"),
        (
            "three",
            "the scenario `three` doesn't fit 4 agents: it has 3 slots; name another, such as visitor",
        ),
        ("all", "the scenario `three` doesn't fit 4 agents"),
    ):
        with pytest.raises(ExperimentError, match=said):
            plan_scenarios(env, "giver", names, 2, 0)
    with pytest.raises(ExperimentError, match="`three` doesn't fit 2 agents: it has 3 slots"):
        plan_scenarios(visitors(2), "giver", "all", 2, 0)
    with pytest.raises(
        ExperimentError,
        match="a scenario needs at least two agents, and visitors has one here; ask for more with --agents",
    ):
        plan_scenarios(visitors(1), "giver", "all", 2, 0)
    with pytest.raises(ExperimentError, match="at least one episode must be played, not 0"):
        plan_scenarios(env, "giver", "visitor", 0, 0)
    with pytest.raises(PolicyError, match=r"there is no policy `givr`; did you mean `giver`\?"):
        plan_scenarios(env, "givr", "visitor", 2, 0)
    for without in (matrix_game(), constant(1.0)):
        with pytest.raises(
            ExperimentError,
            match=r"has no scenarios; write one into the game's file, such as `scenario visitors .* slots 1 focal",
        ):
            plan_scenarios(without, "random", "all", 2, 0)


def test_a_scenario_of_fewer_agents_than_its_slots(tmp_path: Path) -> None:
    """A number of slots that is counted from that of agents can be below none, or none for the focal agents."""
    text = VISITORS.read_text().replace(
        "slots 1 focal  slots players - 1 policy", "slots players - 3 focal  slots 3 policy"
    )
    (tmp_path / "few.sj").write_text(
        text.replace("count  = 3", "count  = 4").replace(
            "slots 1 policy giver", "slots 2 policy giver"
        )
    )
    with pytest.raises(
        ExperimentError, match="`visitor` doesn't fit 3 agents: it has no focal slot"
    ):
        plan_scenarios(sjdsl.make(tmp_path / "few.sj", num_agents=3), "giver", "visitor", 2, 0)
    with pytest.raises(
        ExperimentError,
        match="`visitor` doesn't fit 2 agents: it would have -1 slots of focal agents",
    ):
        plan_scenarios(sjdsl.make(tmp_path / "few.sj", num_agents=2), "giver", "visitor", 2, 0)


def test_runs_of_another_game_and_of_another_form(tmp_path: Path) -> None:
    env = visitors()
    file = store(tmp_path / "other", env, 0, game={"name": "coins"})
    with pytest.raises(
        ExperimentError, match="was trained on another game: coins there, visitors here"
    ):
        plan_scenarios(env, str(file), "visitor", 2, 0)
    file = store(tmp_path / "form", env, 0, game={"hash": "0123456789abcdef"})
    with pytest.warns(UserWarning, match="another form of the game: visitors 0123456789abcdef"):
        planned = plan_scenarios(env, str(file), "visitor", 2, 0)
    assert "another form of the game" in planned.describe()["notes"][0], "it is in the files, too"
    planned_again = plan_scenarios(
        env, str(store(tmp_path / "a", env, 0)), "visitor", 2, 0
    ).describe()
    moved = plan_scenarios(env, str(store(tmp_path / "b", env, 0)), "visitor", 2, 0).describe()
    assert planned_again == moved, "a policy is known by what it is, not by where it lies"
