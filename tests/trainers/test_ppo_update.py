"""The mechanics of one update: gradient steps, keys, losses, and what a rollout stores."""

import jax
import jax.numpy as jnp
import numpy as np
import optax
import pytest
from flax.training.train_state import TrainState as Learner
from probes import QUICK, constant, dilemma, learn, matching, run_of, uneven

from sjdsl.trainers import Config
from sjdsl.trainers.networks import ActorCritic
from sjdsl.trainers.ppo import Batch, explained_variance, learning_rate_schedule, make_optimiser, ppo_loss, take_epochs
from sjdsl.trainers.rollout import Rollout, collect_rollout, start_worlds

SHORT = {"num_epochs": 3, "num_minibatches": 4, "total_timesteps": 16 * 16 * 5}


def test_every_minibatch_of_every_epoch_is_a_gradient_step() -> None:
    state, _ = learn(matching(), **SHORT)
    assert int(state.updates) == 5
    assert int(state.learner.step) == 3 * 4 * 5


def test_the_learning_rate_falls_to_zero() -> None:
    config = Config(**{**QUICK, **SHORT})
    rate = learning_rate_schedule(config)
    assert float(rate(0)) == pytest.approx(config.learning_rate)
    assert float(rate(30)) == pytest.approx(config.learning_rate / 2)
    assert float(rate(60)) == pytest.approx(0.0)
    _, metrics = learn(matching(), **SHORT)
    np.testing.assert_allclose(metrics["learning_rate"], [rate(12 * update) for update in range(5)], rtol=1e-5)


def test_the_same_seed_gives_the_same_run() -> None:
    first, again, other = (jax.tree.leaves(learn(matching(), seed, **SHORT)[1]) for seed in (3, 3, 4))
    assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(first, again, strict=True))
    assert not all(np.array_equal(a, b, equal_nan=True) for a, b in zip(first, other, strict=True))


def test_seeds_can_be_vmapped() -> None:
    """Each seed of a batch of runs is the run it would have been alone."""
    run = run_of(matching(), Config(**{**QUICK, **SHORT}))
    with jax.debug_key_reuse(False):  # JAX takes the keys of any vmapped scan for used
        _, together = jax.vmap(run)(jax.vmap(jax.random.key)(jnp.arange(3)))
    for seed in range(3):
        _, alone = learn(matching(), seed, **SHORT)
        np.testing.assert_allclose(together["entropy"][seed], alone["entropy"], rtol=1e-4)
    assert len(np.unique(together["entropy"][:, -1])) == 3


def test_common_reward_of_one_agent_is_individual_reward() -> None:
    common, individual = (learn(constant(0.7), reward=reward)[1] for reward in ("common", "individual"))
    jax.tree.map(np.testing.assert_array_equal, common, individual)


def test_raw_shaped_and_collective_returns_are_told_apart() -> None:
    _, metrics = learn(dilemma(), reward="common")
    raw, shaped = metrics["agent_return"][0], metrics["shaped_agent_return"][0]
    assert metrics["episodes"][0] == 16 * 16
    assert metrics["collective_return"][0] == pytest.approx(float(raw.sum()), rel=1e-5)
    np.testing.assert_allclose(shaped, [raw.sum(), raw.sum()], rtol=1e-5)
    assert metrics["reward_per_step"][0] == pytest.approx(float(raw.sum()), rel=1e-5)


def test_episodes_are_counted_when_they_end() -> None:
    """Episodes of two and of five steps: returns and events add up over rollouts that cut them anywhere."""
    _, metrics = learn(uneven(), num_steps=3, total_timesteps=16 * 3 * 50)
    episodes, lengths = np.asarray(metrics["episodes"]), np.asarray(metrics["episode_length"])
    finished = episodes > 0
    assert np.isnan(lengths[~finished]).all()
    np.testing.assert_allclose(metrics["agent_return"][finished, 0], lengths[finished], rtol=1e-6)
    np.testing.assert_allclose(metrics["event"]["steps"][finished], lengths[finished], rtol=1e-6)
    played = (episodes[finished] * lengths[finished]).sum()
    assert 16 * 3 * 50 - 16 * 5 <= played <= 16 * 3 * 50
    assert set(np.unique(lengths[finished & (episodes == 1)])) <= {2.0, 5.0}
    # they pay n and 0: equality 1/2; their step is (n + 1) / 2 on average and n at the end
    np.testing.assert_allclose(metrics["equality"][finished], 0.5, rtol=1e-6)
    np.testing.assert_allclose(metrics["mean"]["step"][finished], (lengths[finished] + 1) / 2, rtol=1e-6)
    np.testing.assert_allclose(metrics["final"]["step"][finished], lengths[finished], rtol=1e-6)


def test_a_rollout_keeps_bytes_and_independent_actions() -> None:
    env = matching()
    network = ActorCritic(env.num_actions, env.token_planes, "mlp", 8)

    def play(parameters_key: jax.Array, worlds_key: jax.Array, rollout_key: jax.Array) -> Rollout:
        worlds = start_worlds(env, 32, worlds_key)
        parameters = network.init(parameters_key, worlds.observation)

        def act_and_value(seen: jax.Array) -> tuple[jax.Array, jax.Array]:
            return network.apply(parameters, seen)

        return collect_rollout(env, act_and_value, worlds, rollout_key, 64, "individual")[1]

    rollout = jax.jit(play)(*jax.random.split(jax.random.key(0), 3))
    assert rollout.observation.dtype == jnp.uint8
    assert rollout.observation.shape == (64, 32, 2, 1, 1, 1)
    alike = (rollout.action[..., 0] == rollout.action[..., 1]).mean()
    repeated = (rollout.action[1:] == rollout.action[:-1]).mean()
    across = (rollout.action[:, 1:] == rollout.action[:, :-1]).mean()
    assert all(0.45 < float(share) < 0.55 for share in (alike, repeated, across))


def test_the_loss_equals_its_formula() -> None:
    """Four samples, two actions; logits and values stand for a network."""
    logits = np.array([[0.0, 0.0], [1.0, -1.0], [0.5, 0.0], [-2.0, 1.0]], np.float32)
    value = np.array([1.0, 2.0, -1.0, 0.5], np.float32)
    action, old_log = np.array([0, 1, 0, 1]), np.array([-0.9, -1.0, -0.2, -0.6], np.float32)
    old_value, advantage = np.array([0.5, 2.1, -1.0, 0.0]), np.array([1.0, -1.0, 2.0, 0.5])
    target = np.array([2.0, 0.0, -1.5, 0.4])

    log_probability = logits - np.log(np.exp(logits).sum(1, keepdims=True))
    ratio = np.exp(log_probability[np.arange(4), action] - old_log)
    normal = (advantage - advantage.mean()) / advantage.std()
    policy_loss = -np.mean(np.minimum(ratio * normal, np.clip(ratio, 0.8, 1.2) * normal))
    clipped = old_value + np.clip(value - old_value, -0.2, 0.2)
    value_loss = 0.5 * np.mean(np.maximum((value - target) ** 2, (clipped - target) ** 2))
    entropy = -(np.exp(log_probability) * log_probability).sum(1).mean()

    batch = Batch(
        observation=jnp.zeros((4, 1, 1, 1), jnp.uint8),
        action=jnp.asarray(action),
        log_probability=jnp.asarray(old_log),
        value=jnp.asarray(old_value, jnp.float32),
        advantage=jnp.asarray(advantage, jnp.float32),
        target=jnp.asarray(target, jnp.float32),
    )
    loss, parts = ppo_loss(None, lambda _, __: (jnp.asarray(logits), jnp.asarray(value)), batch, Config())
    assert float(parts["policy_loss"]) == pytest.approx(policy_loss, rel=1e-5)
    assert float(parts["value_loss"]) == pytest.approx(value_loss, rel=1e-5)
    assert float(parts["entropy"]) == pytest.approx(entropy, rel=1e-5)
    assert float(parts["clip_fraction"]) == pytest.approx(np.mean(np.abs(ratio - 1) > 0.2))
    assert float(parts["kl"]) == pytest.approx(np.mean(ratio - 1 - np.log(ratio)), rel=1e-4)
    assert float(loss) == pytest.approx(policy_loss + 0.5 * value_loss - 0.01 * entropy, rel=1e-5)


def test_every_epoch_sees_every_sample_once() -> None:
    """The value of each sample is a parameter of its own, which goes a tenth of its way to the target when seen."""
    config = Config(num_epochs=3, num_minibatches=4, value_coefficient=1.0, clip_value_loss=False)
    samples, minibatch = 32, 8
    batch = Batch(
        observation=jnp.arange(samples, dtype=jnp.uint8).reshape(-1, 1, 1, 1),
        action=jnp.zeros(samples, jnp.int32),
        log_probability=jnp.zeros(samples),
        value=jnp.zeros(samples),
        advantage=jnp.zeros(samples),
        target=jnp.ones(samples),
    )

    def read(parameters: dict[str, jax.Array], observation: jax.Array) -> tuple[jax.Array, jax.Array]:
        return jnp.zeros((minibatch, 2)), parameters["values"][observation[:, 0, 0, 0]]

    learner = Learner.create(apply_fn=read, params={"values": jnp.zeros(samples)}, tx=optax.sgd(0.1 * minibatch))
    learner, _ = take_epochs(learner, batch, jax.random.key(0), config)
    np.testing.assert_allclose(learner.params["values"], np.full(samples, 1 - 0.9**3), rtol=1e-5)


def test_explained_variance() -> None:
    target = jnp.array([1.0, 2.0, 3.0, 4.0])
    assert float(explained_variance(target, target)) == pytest.approx(1.0)
    assert float(explained_variance(jnp.full(4, 2.5), target)) == pytest.approx(0.0)
    assert float(explained_variance(target, jnp.full(4, 1.0))) == 0.0


def test_gradients_are_clipped_by_their_global_norm() -> None:
    """Two steps of Adam, epsilon 1e-5, on gradients of norm 5 and 0.1 clipped to 0.5: by hand."""
    config = Config(learning_rate=0.1, anneal_learning_rate=False, max_gradient_norm=0.5)
    optimiser = make_optimiser(config)
    parameters = {"a": jnp.zeros(1), "b": jnp.zeros(1)}
    memory = optimiser.init(parameters)
    first, second, expected = np.zeros(2), np.zeros(2), np.zeros(2)
    for step, gradient in enumerate([np.array([3.0, 4.0]), np.array([0.06, -0.08])], start=1):
        updates, memory = optimiser.update({"a": jnp.float32(gradient[:1]), "b": jnp.float32(gradient[1:])}, memory, parameters)
        parameters = optax.apply_updates(parameters, updates)
        gradient = gradient * min(1.0, 0.5 / np.linalg.norm(gradient))
        first = 0.9 * first + 0.1 * gradient
        second = 0.999 * second + 0.001 * gradient**2
        expected -= 0.1 * (first / (1 - 0.9**step)) / (np.sqrt(second / (1 - 0.999**step)) + 1e-5)
    np.testing.assert_allclose([parameters["a"][0], parameters["b"][0]], expected, rtol=1e-5)
