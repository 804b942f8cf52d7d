"""Files of many episodes: each as one step at a time gives it, and as `play --watch` plays it."""

import hashlib
import json
from itertools import repeat
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest

import sjdsl
from sjdsl.cli import run
from sjdsl.cli.play import play_compiled
from sjdsl.cli.policies import choose_policy
from sjdsl.render import play_moments, random_policy
from sjdsl.replay import (
    Dataset,
    DatasetWriter,
    Episode,
    EpisodePlayer,
    Header,
    load_recording,
    play_episodes,
)
from sjdsl.replay import episodes as playing
from sjdsl.runtime.policy import MemoryPolicy, mixed_policy
from sjdsl.trainers import PPOConfig, load_policy
from sjdsl.trainers.policies.loading import parameter_shapes
from sjdsl.trainers.policies.policy_file import write_policy
from sjdsl.trainers.runs.run_folder import describe_game

BUSY = {"length": 30, "spawn": 0.3}


def record(path: Path, episodes: int, seed: int) -> list[str]:
    """Returns the call that records so many episodes of Coins in a file."""
    call = f"record coins --policy random -o {path} --episodes {episodes} --seed {seed}"
    return f"{call} --param length=30 --param spawn=0.3".split()


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns a file of five episodes of Coins."""
    path = tmp_path_factory.mktemp("recorded") / "coins.npz"
    assert run(record(path, 5, 3)) == 0
    return path


def same(first: Episode, second: Episode) -> bool:
    """Whether two episodes are alike in everything."""
    return jax.tree.all(
        jax.tree.map(
            np.array_equal,
            vars(first) | {"events": dict(first.events)},
            vars(second) | {"events": dict(second.events)},
        )
    )


def test_each_episode_is_what_single_steps_give(recorded: Path) -> None:
    """Observations, rewards, events and the end, one step at a time from the recorded actions alone."""
    env, dataset = sjdsl.make("coins", params=BUSY), Dataset(recorded)
    assert len(dataset) == 5
    paid = 0
    for number, episode in enumerate(dataset):
        assert episode.seed == 3 + number
        assert episode.observations is not None and episode.observations.shape == (
            31,
            *env.observation_shape,
        )
        player = EpisodePlayer(env, episode.seed)
        np.testing.assert_array_equal(episode.observations[0], player.observation)
        for step, actions in enumerate(episode.actions):
            moment = player.step(actions)
            np.testing.assert_array_equal(episode.observations[step + 1], player.observation)
            np.testing.assert_array_equal(episode.rewards[step], moment.reward)
            for name, counts in episode.events.items():
                np.testing.assert_array_equal(counts[step], moment.events.get(name, np.zeros(2)))
        assert player.done and episode.truncated and not episode.terminated
        np.testing.assert_allclose(dataset.returns[number], player.returns)
        paid += int(np.abs(episode.rewards).sum())
    assert paid > 0
    assert not np.array_equal(dataset[0].actions, dataset[1].actions)


@pytest.mark.thorough
def test_by_default_the_policies_of_the_file_play_in_turn(tmp_path: Path) -> None:
    """Each agent does what it does where all follow its policy; a game without policies is played at random."""
    path = tmp_path / "coins.npz"
    assert (
        run(f"record coins -o {path} --episodes 1 --param length=12 --param spawn=0.5".split()) == 0
    )
    dataset, env = Dataset(path), sjdsl.make("coins", params={"length": 12, "spawn": 0.5})
    assert dataset.header.policy == "file"
    assert [policy.name for policy in env.game.policies] == ["cooperator", "defector"]
    parts = [([0], choose_policy("cooperator", env)), ([1], choose_policy("defector", env))]
    (expected,) = play_episodes(env, mixed_policy(2, parts), 0, 1)
    assert np.array_equal(dataset[0].actions, expected.actions)
    bare = sjdsl.make("territory")
    assert not bare.game.policies
    key = jax.random.key(0)
    assert np.array_equal(choose_policy("file", bare)(key, None), random_policy(bare)(key, None))


def test_it_is_the_episode_that_play_shows(recorded: Path, tmp_path: Path) -> None:
    """The same seed comes to the same actions there, where the interpreter draws them; with a policy that remembers, too."""
    file = tmp_path / "played.json"
    watch = f"play coins --param length=30 --param spawn=0.3 --watch --seed 4 --record {file}"
    assert run(watch.split()) == 0
    assert load_recording(file) == load_recording(recorded, 1)
    env = sjdsl.make("coins", params={"length": 9})
    turns = MemoryPolicy(
        np.int32(0),
        lambda seen, key, _: (seen + 1, (seen + jax.random.randint(key, (2,), 0, 3)) % 7),
    )
    (episode,) = play_episodes(env, turns, 11, 1)
    _, *steps = play_compiled(env, turns, 11, repeat({}))
    assert [list(moment.actions) for moment in steps] == episode.actions.tolist()


def test_a_film_shows_the_recorded_episodes() -> None:
    """Those of its seed and of the next ones, each with the policy's memory from the start."""
    env = sjdsl.make("coins", params={"length": 9})
    turns = MemoryPolicy(
        np.int32(0),
        lambda seen, key, _: (seen + 1, (seen + jax.random.randint(key, (2,), 0, 3)) % 7),
    )
    recorded = np.concatenate([episode.actions for episode in play_episodes(env, turns, 11, 2)])
    moments = list(play_moments(env, turns, 15, 11))
    assert [list(moment.actions) for moment in moments if moment.actions] == recorded[:15].tolist()
    starts = [number for number, moment in enumerate(moments) if not moment.actions]
    assert starts == [0, 10]
    for start, seed in zip(starts, (11, 12), strict=True):
        assert jax.tree.all(
            jax.tree.map(
                np.array_equal,
                vars(moments[start].snapshot),
                vars(EpisodePlayer(env, seed).now().snapshot),
            )
        )


def test_episodes_end_when_the_rules_say(tmp_path: Path) -> None:
    """Different lengths side by side; what comes after an end is not kept."""
    text = (
        Path(__file__).parents[1] / "cases/endings.sj"
    ).read_text()  # made to end when both trees are eaten, or after 20 steps
    path = tmp_path / "endings.sj"
    path.write_text(
        text.replace("acts forward", "acts step_left, step_right, forward").replace(
            " or step % 7 == 6", ""
        )
    )
    env = sjdsl.make(path)
    lengths = set()
    for episode in play_episodes(env, random_policy(env), 0, 6, "none"):
        assert episode.observations is None
        player = EpisodePlayer(env, episode.seed)
        for actions in episode.actions:
            player.step(actions)
        assert player.done and (episode.terminated, episode.truncated) == (
            len(episode.actions) < 20,
            len(episode.actions) == 20,
        )
        lengths.add(len(episode.actions))
    assert len(lengths) > 1


@pytest.mark.thorough
def test_how_many_are_played_at_once_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Memory is bounded: as many as fit, one at least; the last few fill up a batch."""
    env = sjdsl.make("coins", params=BUSY)
    size = 31 * int(np.prod(env.observation_shape))
    together = list(play_episodes(env, random_policy(env), 0, 5))
    monkeypatch.setattr(playing, "MAX_BYTES", 2 * size)
    assert playing.episodes_at_once(env) == 2
    assert all(map(same, together, play_episodes(env, random_policy(env), 0, 5)))
    monkeypatch.setattr(playing, "MAX_BYTES", 1)
    assert playing.episodes_at_once(env) == 1
    long = sjdsl.make("coins", params={"length": 1_000_000})
    assert playing.episodes_at_once(long, "onehot") == 1


def test_a_file_says_how_it_was_made_and_is_the_same_each_time(
    recorded: Path, tmp_path: Path
) -> None:
    env = sjdsl.make("coins")
    header = Dataset(recorded).header
    assert (header.game, header.hash, header.policy, header.seed, header.episodes) == (
        "coins",
        env.hash,
        "random",
        3,
        5,
    )
    assert header.environment == {
        "game": "coins",
        "variant": None,
        "map": None,
        "num_agents": None,
        "params": {"length": 30, "spawn": 0.3},
    }
    assert set(header.versions) == {"sjdsl", "jax", "numpy"} and header.policy_digest is None
    assert header.planes == [plane.name for plane in env.token_planes]
    again = tmp_path / "again.npz"
    assert run(record(again, 5, 3)) == 0
    assert again.read_bytes() == recorded.read_bytes()
    few = tmp_path / "few.npz"
    assert run(record(few, 2, 4)) == 0
    assert same(Dataset(few)[1], Dataset(recorded)[2])
    with np.load(recorded) as arrays:  # without us
        assert json.loads(str(arrays["header"]))["seed"] == 3
        np.testing.assert_array_equal(
            arrays["episode_00004/rewards"].sum(axis=0), arrays["returns"][4]
        )


@pytest.mark.thorough
def test_a_stored_policy_plays_and_is_named(tmp_path: Path) -> None:
    """By the policy's own function, the same actions; the file says which policy it was."""
    env, config = (
        sjdsl.make("coins", params={"length": 4}),
        PPOConfig(network="mlp", network_width=8),
    )
    shapes = parameter_shapes(env, config)
    drawn = jax.tree.map(
        lambda leaf: np.random.default_rng(leaf.size).normal(0, 0.1, leaf.shape).astype(leaf.dtype),
        shapes,
    )
    stored, path = tmp_path / "policy.safetensors", tmp_path / "coins.npz"
    write_policy(
        stored,
        drawn,
        {
            "game": describe_game(env),
            "config": config.model_dump(mode="json"),
            "update": 0,
            "env_steps": 0,
            "seed": 0,
        },
    )
    assert (
        run(f"record coins --policy {stored} --episodes 1 --param length=4 -o {path}".split()) == 0
    )
    dataset, player, act = Dataset(path), EpisodePlayer(env, 0), load_policy(stored, env)
    key = jax.random.fold_in(jax.random.key(0), 2**32 - 1)
    for number, actions in enumerate(dataset[0].actions):
        assert act(jax.random.fold_in(key, number), player.observation).tolist() == actions.tolist()
        player.step(actions)
    assert dataset.header.policy == str(stored)
    assert dataset.header.policy_digest == hashlib.sha256(stored.read_bytes()).hexdigest()


def writer(path: Path) -> tuple[DatasetWriter, Episode]:
    header = Header(
        game="coins", environment={"game": "coins"}, hash="x", policy="stay", policy_digest=None, seed=0, episodes=9, observation="none",
        planes=[], action_names=[], versions={},
    )  # fmt: skip
    nothing: Any = np.zeros((1, 2), np.int32)
    return DatasetWriter(path, header), Episode(
        0, None, nothing, nothing.astype(np.float32), {}, False, True
    )


def test_what_was_played_before_an_interruption_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "some.npz"

    def add_and_fail(error: BaseException) -> None:
        made, episode = writer(path)
        with made:
            made.add(episode)
            raise error

    with pytest.raises(KeyboardInterrupt):
        add_and_fail(KeyboardInterrupt())
    assert Dataset(path).header.episodes == 1
    path.unlink()
    with pytest.raises(OSError, match="full"):
        add_and_fail(OSError("full"))
    assert list(tmp_path.iterdir()) == []
