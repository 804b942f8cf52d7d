"""What all adapters do alike: seeds of any size, actions that are whole numbers, events that keep their counts under any name, masks."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxmarl.wrappers.baselines import LogWrapper
from stable_baselines3.common.vec_env import VecMonitor

from sjdsl.interop import socialjax
from sjdsl.interop.calls import TAKEN, seeded_key
from sjdsl.interop.dm_env import Substrate
from sjdsl.interop.gymnasium import AgentGame, VectorGame
from sjdsl.interop.jaxmarl import JaxMARLGame
from sjdsl.interop.pettingzoo import parallel_env
from sjdsl.interop.stable_baselines3 import VecGame

SHORT = {"params": {"length": 12}}


def played(env: VecGame, seed: int) -> np.ndarray:
    env.seed(seed)
    return env.reset()


# each begins an episode of Coins with a seed and returns what the first step shows
SEEDED: dict[str, Callable[[Any], Any]] = {
    "pettingzoo": lambda seed: parallel_env("coins").reset(seed=seed)[0]["agent_0"],
    "gymnasium": lambda seed: VectorGame("coins", 1).reset(seed=seed)[0],
    "gymnasium, one agent": lambda seed: AgentGame("coins").reset(seed=seed)[0],
    "stable_baselines3": lambda seed: played(VecGame("coins", 1), seed),
    "dm_env": lambda seed: Substrate("coins", seed=seed).reset().observation[0]["WORLD.RGB"],
}
BIG = (5, 5 + 2**32, 5 + 2**64, 2**63, 2**63 + 2**70, 2**200)


def test_every_bit_of_a_seed_counts() -> None:
    words = [
        tuple(jax.random.key_data(seeded_key(seed)).tolist())
        for seed in (*BIG, 0, 2**32, 2**64, 2**32 - 1)
    ]
    assert len(set(words)) == len(words)
    assert words[0] == tuple(jax.random.key_data(jax.random.key(5)).tolist())  # as before
    assert words[-1] == tuple(jax.random.key_data(jax.random.key(2**32 - 1)).tolist())
    assert (seeded_key(np.int64(5)) == jax.random.key(5)) and seeded_key(None) != seeded_key(None)


@pytest.mark.parametrize("adapter", SEEDED)
def test_large_seeds_begin_differently(adapter: str) -> None:
    begin = SEEDED[adapter]
    assert np.array_equal(begin(BIG[1]), begin(BIG[1]))
    assert (
        len({np.asarray(begin(seed)).tobytes() for seed in BIG}) > 3
    )  # agents that meet nobody may see the same


@pytest.mark.parametrize("seed", [-1, 2.5, "5", True, np.float64(3)])
@pytest.mark.parametrize("adapter", SEEDED)
def test_what_is_no_seed_is_refused(adapter: str, seed: Any) -> None:
    with pytest.raises(
        (TypeError, ValueError),
        match=f"the seed must be a whole number of 0 or more, not {seed!r}".replace(
            "(", r"\("
        ).replace(")", r"\)"),
    ):
        SEEDED[adapter](seed)


def test_actions_are_whole_numbers() -> None:
    """Neither a fraction nor a whole number that is stored as one, nor a truth value, in any adapter."""
    agents, vector, slots = (
        AgentGame("coins", **SHORT),
        VectorGame("coins", 1, **SHORT),
        VecGame("coins", 1, **SHORT),
    )
    pairs, players = parallel_env("coins", **SHORT), Substrate("coins", **SHORT)
    theirs, suite = JaxMARLGame("coins", **SHORT), socialjax.make("coin_game")
    key = jax.random.key(0)
    states = [env.reset(key) for env in (theirs, suite)]
    for env in (agents, vector, pairs):
        env.reset(seed=0)
    slots.reset(), players.reset()
    for wrong in (0.7, 2.0, True):
        two = np.array([wrong, wrong])
        calls: list[Callable[[], Any]] = [
            lambda wrong=wrong: agents.step(wrong),
            lambda two=two: vector.step(two),
            lambda two=two: slots.step(two),
            lambda wrong=wrong: pairs.step({"agent_0": 1, "agent_1": wrong}),
            lambda wrong=wrong: players.step([1, wrong]),
            lambda two=two: theirs.step(key, states[0][1], {"agent_0": two[0], "agent_1": two[1]}),
            lambda two=two: suite.step(key, states[1][1], list(two)),
        ]
        for call in calls:
            with pytest.raises(TypeError, match="whole number"):
                call()
    assert agents.step(np.int64(3))[0].shape == agents.step(jnp.uint8(3))[0].shape


NAMED = (
    "truncated",
    "terminated",
    "rewards",
    "is_success",
    "action_mask",
    "final_obs",
    "terminal_observation",
    "returned_episode",
    "entropy",
)


@pytest.fixture(scope="module")
def named(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Returns a game of two agents in which every step counts each event once for each of them."""
    names = (*NAMED, "own")
    text = f"""sj 1
game named "Events with names that libraries use" {{
  episode 4
  kind floor "."
  map {{ "....." }}
  agents 2 {{ acts forward, stay  moves relative }}
  phase start {{ each agent {{ send agent to floor }} }}
  schedule walk -> tallies
  phase walk {{ move each agent }}
  phase tallies {{ each agent {{ {" ".join(f"tally {name} for agent" for name in names)} }} }}
  observe {{ window ahead 1, behind 0, left 1, right 1 }}
  metrics {{ {" ".join(f"event {name}" for name in names)}  mean ratio = 3 }}
}}
"""
    path = tmp_path_factory.mktemp("game") / "named.sj"
    path.write_text(text)
    return str(path)


def assert_counted(infos: dict[str, Any]) -> None:
    for name in NAMED:
        assert name in TAKEN
        assert np.all(np.asarray(infos[f"events.{name}"]) == 1), name
    assert np.all(np.asarray(infos["own"]) == 1)


def test_no_event_is_swallowed(named: str) -> None:
    """Whatever its name, under the library's own wrappers too; what the name means there stays."""
    key = jax.random.key(0)
    env = LogWrapper(JaxMARLGame(named, shaped_reward=True, terminal_observation=True))
    *_, info = env.step(key, env.reset(key)[1], {"agent_0": jnp.int32(0), "agent_1": jnp.int32(1)})
    assert_counted(info)
    assert not info["truncated"].any() and not info["returned_episode"].any()
    assert info["metrics.ratio"].tolist() == [3, 3]

    agent = AgentGame(named)
    agent.reset(seed=0)
    info = agent.step(0)[-1]
    assert_counted(info)
    assert info["rewards"].shape == (2,) and info["action_mask"].tolist() == [1, 1]

    pair = parallel_env(named)
    pair.reset(seed=0)
    for info in pair.step({"agent_0": 0, "agent_1": 1})[-1].values():
        assert_counted(info)
        assert info["action_mask"].tolist() == [1, 1]

    vector = VectorGame(named, 2)
    vector.reset(seed=0)
    slots = VecMonitor(VecGame(named, 2))
    slots.reset()
    for step in range(4):
        infos = vector.step(np.zeros(4, int))[-1]
        assert_counted(infos)
        rows = slots.step(np.zeros(4, int))[-1]
        for row in rows:
            assert_counted(row)
            assert ("episode" in row) == ("terminal_observation" in row) == (step == 3)
    assert (
        infos["_final_obs"].all()
        and infos["final_obs"][0].shape == vector.single_observation_space.shape
    )
    assert_counted(infos["final_info"])


def test_masks_are_the_games(tmp_path: Path) -> None:
    """In a game that forbids, each adapter shows for each agent what the game allows it."""
    text = (Path(__file__).parents[1] / "runtime/yard.sj").read_text()
    path = tmp_path / "yard.sj"
    path.write_text(text)
    rest = 4
    pair, vector, slots, agent = (
        parallel_env(str(path)),
        VectorGame(str(path), 2),
        VecGame(str(path), 2),
        AgentGame(str(path), agent=1),
    )
    with pytest.raises(RuntimeError, match="call reset before action_masks"):
        slots.action_masks()
    _, infos = pair.reset(seed=0)
    assert all(
        info["action_mask"].all() and info["action_mask"].dtype == np.int8
        for info in infos.values()
    )
    infos = pair.step({"agent_0": 3, "agent_1": rest, "agent_2": 3})[-1]
    assert [info["action_mask"].tolist() for info in infos.values()] == [
        [1] * 5,
        [1, 1, 0, 1, 0],
        [1] * 5,
    ]
    assert pair.action_space("agent_1").sample(infos["agent_1"]["action_mask"]) in (0, 1, 3)
    wanted = np.ones((6, 5), bool)
    wanted[4, [2, 4]] = False
    vector.reset(seed=0), slots.reset(), agent.reset(seed=0)
    vector.step(np.array([3, 3, 3, 3, rest, 3])), slots.step(np.array([3, 3, 3, 3, rest, 3]))
    np.testing.assert_array_equal(vector.action_masks(), wanted)
    np.testing.assert_array_equal(slots.env_method("action_masks"), wanted)
    np.testing.assert_array_equal(slots.env_method("action_masks", indices=[4, 0]), wanted[[4, 0]])
    assert (
        agent.step(rest)[-1]["action_mask"].tolist()
        == agent.action_masks().astype(int).tolist()
        == [1, 1, 0, 1, 0]
    )
