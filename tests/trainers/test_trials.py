"""Learning in episodes of several trials: figures by trial, and returns that run through their ends."""

import json
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import sjdsl
from sjdsl.runtime.env import Environment
from sjdsl.trainers import evaluate, make_config, random_policy, summarise, train
from sjdsl.trainers.algorithms.advantage import generalised_advantages, successor_values
from sjdsl.trainers.algorithms.partners import NOBODY
from sjdsl.trainers.algorithms.rollout import Actor, collect_rollout, start_worlds
from sjdsl.trainers.algorithms.shaping import make_shaping
from sjdsl.trainers.runs.curves import draw_curves
from sjdsl.trainers.runs.run_errors import RunError

GAME = """sj 1
game wages "A wage that rises from trial to trial" {
  episode 3 trials of 2 { keep wage }
  kind room "."
  map { ".." }
  field wage : 1 .. 4 = 1
  agents 2 { acts stay, forward  moves relative }
  phase start { each agent { send agent to room } }
  schedule pay -> rise
  phase pay {
    give 1 to all
    when wage >= 2 { give 1 to all }
    when wage >= 3 { give 1 to all }
    tally paid by wage
  }
  phase rise { when step == 1 { set wage = min(4, wage + 1) } }
  observe { window ahead 0, behind 0, left 0, right 0 }
  metrics { event paid  mean seen = wage  final last = wage }
}
"""


@pytest.fixture(scope="module")
def env(tmp_path_factory: pytest.TempPathFactory) -> Environment:
    path = tmp_path_factory.mktemp("trials") / "wages.sj"
    path.write_text(GAME, encoding="utf-8")
    return sjdsl.make(path)


def test_evaluation_has_figures_by_trial(env: Environment) -> None:
    evaluation = evaluate(env, random_policy(env), jax.random.key(0), num_episodes=2)
    assert evaluation.lengths.tolist() == [6, 6]
    assert evaluation.by_trial["collective_return"].tolist() == [[4, 8, 12]] * 2
    assert evaluation.by_trial["event_paid"].tolist() == [[2, 4, 6]] * 2
    assert evaluation.by_trial["mean_seen"].tolist() == [[1.5, 2.5, 3.5]] * 2
    assert evaluation.by_trial["final_last"].tolist() == [[2, 3, 4]] * 2
    assert summarise(evaluation)["collective return of trial 2"].mean == 12


def test_discounted_returns_run_through_the_ends_of_trials(env: Environment) -> None:
    """With discount 1/2 and lambda 1, the advantage of the first step, where all values are 0, is
    1 + 1/2 + 2/4 + 2/8 + 3/16 + 3/32."""
    config = make_config(num_envs=1, num_steps=6, num_minibatches=1)

    def act(_worlds: object, _key: jax.Array) -> tuple[tuple[()], jax.Array, None]:
        return (), jnp.zeros((1, 2), jnp.int32), None

    actor = Actor(act, lambda seen: seen, lambda *_: jnp.zeros((1, 2)))
    worlds = start_worlds(env, 1, (), jax.random.key(0))
    _, rollout, finished, _ = collect_rollout(
        env, actor, worlds, jax.random.key(1), 6, make_shaping(config, 2), NOBODY
    )
    assert rollout.done[:, 0].tolist() == [False] * 5 + [True]
    assert rollout.fresh[:, 0].tolist() == [True] + [False] * 5
    assert finished["by_trial"]["collective_return"].tolist() == [4, 8, 12]
    values = jnp.zeros((6, 1, 2))
    successors = successor_values(
        values, values[0], rollout.ending, rollout.done, rollout.truncated
    )
    advantage = generalised_advantages(
        rollout.reward, values, successors, rollout.done, gamma=0.5, gae_lambda=1.0
    )
    first = 1 + 1 / 2 + 2 / 4 + 2 / 8 + 3 / 16 + 3 / 32
    np.testing.assert_allclose(advantage[0, 0], [first, first])


@pytest.mark.thorough
def test_run_has_curves_by_trial(env: Environment, tmp_path: Path) -> None:
    config = make_config(
        network="mlp", num_envs=2, num_steps=12, num_minibatches=2, total_timesteps=48
    )
    train(env, config, tmp_path / "run", progress="none")
    rows = [json.loads(line) for line in (tmp_path / "run/metrics.jsonl").read_text().splitlines()]
    by_trial = [rows[-1][f"collective_return_trial_{trial}"] for trial in range(3)]
    assert by_trial == [4, 8, 12]
    assert sum(by_trial) == rows[-1]["collective_return"]
    assert rows[-1]["event_paid_trial_1"] == 4
    draw_curves([("a", tmp_path / "run")], "event_paid", tmp_path / "c.svg", by_trial=True)
    assert "a, trial 2" in (tmp_path / "c.svg").read_text()
    with pytest.raises(RunError, match="no `entropy` by trial"):
        draw_curves([("a", tmp_path / "run")], "entropy", tmp_path / "d.svg", by_trial=True)


def test_a_batch_ends_its_trials_as_single_environments_do(env: Environment) -> None:
    keys = jax.random.split(jax.random.key(3), 3)
    _, states = jax.vmap(env.reset)(keys)
    singles = [env.reset(key)[1] for key in keys]
    actions = jnp.ones((3, 2), jnp.int32)
    together = jax.jit(jax.vmap(env.step))
    for step in range(7):
        step_keys = jax.random.split(jax.random.key(step), 3)
        seen, states, reward, done, info = together(step_keys, states, actions)
        batched = (seen, states, reward, done, info["trial"], info["trial_ended"])
        for index in range(3):
            alone = env.step(step_keys[index], singles[index], actions[index])
            singles[index] = alone[1]
            single = (*alone[:4], alone[4]["trial"], alone[4]["trial_ended"])
            leaves = zip(jax.tree.leaves(batched), jax.tree.leaves(single), strict=True)
            for of_batch, leaf in leaves:
                np.testing.assert_array_equal(of_batch[index], leaf)
