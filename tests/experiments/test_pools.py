"""Pools: the seeds of a run, single policies and functions by their names; what does not fit is refused."""

from pathlib import Path

import pytest
from small_games import matrix_game
from stored_policies import store, store_manifest, store_pool

from sjdsl.experiments import ExperimentError, find_pool
from sjdsl.experiments.players import LEARNING, player_of
from sjdsl.experiments.playing import find_pools
from sjdsl.experiments.schelling import plan_diagram
from sjdsl.trainers import PolicyError, PPOConfig, VDNConfig

ACTING = {
    *(
        "algorithm",
        "partners",
        "agent_id",
        "mask_actions",
        "network",
        "network_width",
        "convolution_sides",
        "convolution_channels",
    ),
    *(
        "precision",
        "critic",
        "reward_horizons",
        "sharing",
        "memory",
        "memory_reads",
        "epsilon_end",
        "own",
        "normalise_values",
        "layer_norm",
        "share_hidden",
    ),
}


def test_each_key_of_a_configuration_is_of_learning_or_of_acting() -> None:
    """A key that is forgotten would have different networks computed as one."""
    assert PPOConfig.model_fields.keys() | VDNConfig.model_fields.keys() == LEARNING | ACTING
    assert LEARNING.isdisjoint(ACTING)


def test_a_run_of_several_seeds_is_a_pool(tmp_path: Path) -> None:
    env = matrix_game()
    folder = store_pool(tmp_path / "run", env, (10, 9, 2))
    pool = find_pool(folder, env)
    assert (pool.name, [player.seed for player in pool.players], pool.is_trained) == (
        str(folder),
        [2, 9, 10],
        True,
    )
    assert len({player.digest for player in pool.players}) == 3
    assert len({player.kind for player in pool.players}) == 1
    alone = find_pool(f"{folder}/seed_9", env)
    assert [(player.seed, player.digest) for player in alone.players] == [
        (9, pool.players[1].digest)
    ]
    file = find_pool(str(folder / "seed_9/policies/last.safetensors"), env)
    assert file.players[0].digest == pool.players[1].digest


def test_seeds_that_diverged_are_left_out_and_named(tmp_path: Path) -> None:
    env = matrix_game()
    folder = store_pool(tmp_path / "run", env, (0, 1, 2), diverged=(1,))
    with pytest.warns(
        UserWarning, match=r"left out of .*: seed 1, which diverged \(non-finite loss\) in update 3"
    ):
        pool = find_pool(folder, env)
    assert [player.seed for player in pool.players] == [0, 2]
    assert len(pool.notes) == 1
    none_left = store_pool(tmp_path / "none", env, (0,), diverged=(0,))
    with pytest.raises(ExperimentError, match=r"every seed of .* diverged"):
        find_pool(none_left, env)


def test_what_is_no_policy_is_refused(tmp_path: Path) -> None:
    env = matrix_game()
    with pytest.raises(
        PolicyError,
        match=r"there is no policy `randm`; did you mean `random`\? A policy is random, stay",
    ):
        find_pool("randm", env)
    with pytest.raises(PolicyError, match="is not the folder of a training run"):
        find_pool(tmp_path, env)
    (tmp_path / "mine.py").write_text("def alone(observation):\n    return observation\n")
    with pytest.raises(
        PolicyError,
        match=r"mine.py:alone` is called with a key and an observation, but takes \(observation\)",
    ):
        find_pool(f"{tmp_path}/mine.py:alone", env)
    (tmp_path / "number.py").write_text("seven = 7\n")
    with pytest.raises(PolicyError, match=r"number.py:seven` must be a function, not 7"):
        find_pool(f"{tmp_path}/number.py:seven", env)
    (tmp_path / "begun/seed_0").mkdir(parents=True)
    store_manifest(tmp_path / "begun")
    (tmp_path / "begun/seed_0/policies").mkdir()
    with pytest.raises(PolicyError, match="holds no policy yet"):
        find_pool(tmp_path / "begun", env)
    store(tmp_path / "one", env, 0)
    with pytest.raises(PolicyError, match="has no policy called best, but of last"):
        find_pool(f"{tmp_path}/one@best", env)


@pytest.mark.filterwarnings("ignore:.*another form of the game")
def test_policies_of_another_game_are_refused(tmp_path: Path) -> None:
    env = matrix_game()
    for key, value, said in (
        ("name", "coins", "another game: coins there, matrix_game here"),
        ("action_names", ["stay", "help"], "other actions: stay, help there, stay, betray here"),
        (
            "observation_shape",
            [2, 2, 3, 3],
            "other observations: 2, 2, 3, 3 there, 2, 2, 1, 1 here",
        ),
    ):
        file = store(tmp_path / key, env, 0, game={key: value})
        with pytest.raises(ExperimentError, match=f"was trained on {said}"):
            find_pool(str(file), env)


def played_together(first: Path, second: Path) -> tuple[list[tuple[int | None, ...]], list[str]]:
    """Returns the seeds of the pairs that two pools make, and what a diagram says of them; of folders by their last name."""
    experiment = plan_diagram(matrix_game(), str(first), str(second), 2, 0)
    pairs = [
        tuple(player_of(pool, replicate).seed for pool in experiment.pools)
        for replicate in range(experiment.replicates)
    ]
    return pairs, [note.replace(f"{first.parent}/", "") for note in experiment.notes]


def test_seeds_of_one_number_play_together(tmp_path: Path) -> None:
    """A seed that diverged in one pool is left out of the other: it does not shift those that follow."""
    env = matrix_game()
    one, two = (
        store_pool(tmp_path / "one", env, range(5), diverged=(1,)),
        store_pool(tmp_path / "two", env, range(5), diverged=(3,)),
    )
    with pytest.warns(UserWarning, match="which another pool lacks"):
        pairs, notes = played_together(one, two)
    assert pairs == [(0, 0), (2, 2), (4, 4)]
    assert notes == [
        "left out of one: seed 1, which diverged (non-finite loss) in update 3",
        "left out of one: seed 3, which another pool lacks",
        "left out of two: seed 3, which diverged (non-finite loss) in update 3",
        "left out of two: seed 1, which another pool lacks",
    ]
    shifted = store_pool(tmp_path / "shifted", env, range(2, 7))
    with (
        pytest.warns(UserWarning, match="diverged"),
        pytest.raises(
            ExperimentError,
            match=r"one has 0, 1, 2, 3, 4; .*shifted has 2, 3, 4, 5, 6; name single seeds",
        ),
    ):
        played_together(one, shifted)


def test_single_policies_play_together_whatever_their_seeds(tmp_path: Path) -> None:
    one = store_pool(tmp_path / "one", matrix_game(), range(3))
    alone = find_pools(
        [f"{one}/seed_0", f"{one}/seed_2", f"{one}/seed_0/policies/last.safetensors"], matrix_game()
    )
    assert [pool.seeds for pool in alone] == [(0,), (2,), (0,)]


@pytest.mark.filterwarnings("ignore:left out")
def test_too_few_seeds_of_one_number_are_refused(tmp_path: Path) -> None:
    env = matrix_game()
    seeds = range(3)
    one, two = (
        store_pool(tmp_path / "one", env, seeds, diverged=(0,)),
        store_pool(tmp_path / "two", env, seeds, diverged=(1,)),
    )
    with pytest.raises(
        ExperimentError,
        match=r"only one is left in all pools: .*one has 1, 2; .*two has 0, 2; name single seeds, such as",
    ):
        played_together(one, two)
    store_pool(one, env, seeds, diverged=(0, 2))
    assert played_together(one, store_pool(two, env, seeds))[0] == [(1, 1)], (
        "one of the pools has no more"
    )
    store_pool(two, env, seeds, diverged=(1,))
    with pytest.raises(ExperimentError, match="none is left in all pools"):
        played_together(one, two)
