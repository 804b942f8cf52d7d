"""Cross-play: each slot acts by its own policy, whatever network, memory and sharing it has, in one compilation."""

import csv
import json
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest
from small_games import matrix_game, public_goods
from stored_policies import store, store_pool

from sjdsl.experiments import ExperimentError, cross_play, schelling_diagram
from sjdsl.experiments.lineups import play_key
from sjdsl.experiments.summaries import crossplay_text
from sjdsl.trainers import evaluate, find_policy
from tests.trainers.probes import constant, hidden, recalled

# By the seed of their parameters: those of one network earn differently.
KINDS: dict[int, dict[str, Any]] = {
    0: {},
    2: {"reward": "common", "learning_rate": 1e-3},
    10: {"memory": "gru", "gamma": 0.5},
    1: {"memory": "gru"},
    5: {"memory": "gru", "memory_reads": ("action", "reward")},
    6: {"memory": "gru", "memory_reads": ("action", "reward")},
    3: {"sharing": "per_agent"},
    4: {"sharing": "per_agent", "memory": "gru", "algorithm": "mappo"},
}


@pytest.mark.parametrize(
    "seeds", [(0, 4), pytest.param(tuple(KINDS), marks=pytest.mark.thorough)], ids=["two", "all"]
)
def test_each_slot_acts_by_its_own_policy(seeds: tuple[int, ...], tmp_path: Path) -> None:
    """What an agent sees and earns does not depend on the others here: in any company it earns what it does among its like.

    All are certain of their actions, so that draws do not matter.
    """
    env, episodes = recalled(), 16
    names = [str(store(tmp_path / str(seed), env, seed % 10, **KINDS[seed])) for seed in seeds]
    alone = [
        evaluate(env, find_policy(name, env), play_key(2, 0), episodes).returns for name in names
    ]
    assert (alone[0] != alone[1]).any()
    assert (alone[-2] != alone[-1]).any()
    found = cross_play(env, policies=names, episodes=episodes, seed=2)
    assert len(found.parts) == len(seeds) * (len(seeds) + 1) // 2
    for part in found.parts:
        for episode, order in enumerate(part.order):
            expected = [
                alone[number][episode, slot]
                for number, slot in zip(part.lineup, order, strict=True)
            ]
            assert part.returns[episode].tolist() == expected


def test_all_line_ups_are_one_compilation(tmp_path: Path) -> None:
    """A function is traced for its digest and for the first line-up, and never again."""
    env = hidden()
    traced: list[int] = []

    def counting(_: jax.Array, observation: jax.Array) -> jax.Array:
        traced.append(1)
        return observation[:, 0, 0, 0] % 2

    traces: list[int] = []
    names = [str(store(tmp_path / str(seed), env, seed)) for seed in range(2)]
    cross_play(
        env, policies=[*names, counting], episodes=2, tell=lambda _: traces.append(len(traced))
    )
    assert len(traces) == 6
    assert (traces[0], set(traces[1:])) == (1, {len(traced)})


@pytest.mark.thorough
def test_of_a_mixture_without_a_trained_policy_episodes_are_the_samples(tmp_path: Path) -> None:
    env = matrix_game()
    pool = str(store_pool(tmp_path / "run", env, (4, 5, 6)))
    found = cross_play(env, policies=[pool, "random"], mix="pairs", episodes=8)
    assert {
        found.mixture(lineup): found.unit_of(lineup) for lineup in found.experiment.lineups
    } == {
        f"2 x {pool}": "training seed",
        f"1 x {pool}, 1 x random": "training seed",
        "2 x random": "episode",
    }
    played = np.concatenate(
        [part.returns.mean(axis=1) for part in found.parts if part.lineup == (1, 1)]
    )
    assert len(played) == 24
    (figure,) = found.estimates((1, 1)).values()
    # Student's t at 97.5 % with 23 degrees of freedom, from a printed table: 2.069.
    assert figure.high - figure.mean == pytest.approx(
        2.069 * played.std(ddof=1) / 24**0.5, rel=1e-3
    )
    assert (
        "over 3 training seeds; of mixtures without a trained policy over 24 episodes"
        in crossplay_text(found)
    )


def test_files_have_every_episode_and_slot(tmp_path: Path) -> None:
    env = public_goods(3, ranked=1.0)
    pool = store_pool(tmp_path / "run", env, (4, 5))
    found = cross_play(env, policies=["stay", str(pool)], episodes=2, folder=tmp_path / "out")
    with (tmp_path / "out/crossplay.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == [
        "mixture",
        "replicate",
        "episode",
        "slot",
        "policy",
        "seed",
        "return",
        "event_given",
    ]
    assert len(rows) == 4 * 2 * 2 * 3  # mixtures, replicates, episodes, slots
    for row in rows:
        assert row["seed"] == {"stay": "", str(pool): str(4 + int(row["replicate"]))}[row["policy"]]
        assert row["policy"] != "stay" or row["event_given"] == "2"
    part = next(part for part in found.parts if part.lineup == (0, 0, 1) and part.replicate == 1)
    mixture = [
        row for row in rows if row["mixture"] == f"2 x stay, 1 x {pool}" and row["replicate"] == "1"
    ]
    assert [float(row["return"]) for row in mixture] == part.played.returns.ravel().tolist()
    assert [
        sum(row["policy"] == "stay" for row in mixture if row["episode"] == str(episode))
        for episode in range(2)
    ] == [2, 2]

    stored = json.loads((tmp_path / "out/crossplay.json").read_text())
    assert (stored["format"], stored["mix"], stored["unit"], stored["episodes"]) == (
        1,
        "all",
        "training seed",
        2,
    )
    assert [player["seed"] for player in stored["policies"][1]["players"]] == [4, 5]
    entry = next(
        entry for entry in stored["mixtures"] if entry["mixture"] == f"2 x stay, 1 x {pool}"
    )
    own = [
        float(row["return"])
        for row in rows
        if row["mixture"] == entry["mixture"] and row["policy"] == "stay"
    ]
    assert entry["policies"]["stay"]["mean"] == pytest.approx(np.mean(own))
    assert entry["episodes"] == 4


@pytest.mark.thorough
def test_pools_play_seed_by_seed(tmp_path: Path) -> None:
    """A diagram of two pools: each replicate is what its two policies make alone."""
    env = hidden()
    ours, theirs = (
        store_pool(tmp_path / name, env, seeds)
        for name, seeds in (("ours", (0, 1)), ("theirs", (0, 1)))
    )
    found = schelling_diagram(env, str(ours), str(theirs), episodes=8)
    assert found.returns.cooperators.shape == (3, 2, 8)
    assert (found.returns.unit, found.units, found.population) == (
        "training seed",
        2,
        "2 training seeds",
    )
    for replicate in range(2):
        mixed = evaluate(
            env, find_policy(str(theirs / f"seed_{replicate}"), env), play_key(0, replicate), 8
        )
        np.testing.assert_array_equal(
            found.returns.defectors[0, replicate], mixed.returns.mean(axis=1, dtype=np.float64)
        )


def test_what_is_asked_wrongly_is_refused(tmp_path: Path) -> None:
    env = matrix_game()
    with pytest.raises(ExperimentError, match="matrix_game has 2 slots, but 3 policies are given"):
        cross_play(env, slots=["stay"] * 3)
    with pytest.raises(ExperimentError, match="give either slots"):
        cross_play(env)
    with pytest.raises(ExperimentError, match="give either slots"):
        cross_play(env, slots=["stay", "stay"], policies=["stay"])
    with pytest.raises(
        ExperimentError,
        match=r"needs at least two agents, and constant has one here.*`sjdsl evaluate`",
    ):
        cross_play(constant(1.0, num_agents=1), policies=["stay", "random"])
    with pytest.raises(ExperimentError, match="`stay` is named twice"):
        cross_play(env, policies=["stay", "random", "stay"])
    with pytest.raises(ExperimentError, match="name at least one policy"):
        cross_play(env, policies=[])
    two, three = (store_pool(tmp_path / str(n), env, range(n)) for n in (2, 3))
    with pytest.raises(ExperimentError, match="pools must have the same seeds"):
        cross_play(env, slots=[str(two), str(three)])
