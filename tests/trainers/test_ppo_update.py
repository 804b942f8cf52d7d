"""The mechanics of one update: gradient steps, keys, losses, and what a rollout stores."""

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import optax
import pytest
from flax.training.train_state import TrainState as Learner
from jax import Array
from probes import (
    FAST_TO_COMPILE,
    Probe,
    endless_riches,
    learn,
    matching,
    opposite,
    quick,
    recalled,
    uneven,
)

from sjdsl.trainers import PPOConfig, TrainState, make_config, make_train
from sjdsl.trainers.algorithms.losses import Batch
from sjdsl.trainers.algorithms.optimisers import (
    learning_rate_schedule,
    make_optimiser,
    part_of_each,
)
from sjdsl.trainers.algorithms.ppo import (
    Acting,
    draw_actions,
    draw_orders,
    learn_teams,
    make_batch,
    ppo_loss,
    take_epochs,
)
from sjdsl.trainers.algorithms.preferences import draw_preferences
from sjdsl.trainers.algorithms.rollout import Rollout
from sjdsl.trainers.algorithms.training_functions import keep_if_finite
from sjdsl.trainers.networks.actor_critics import make_actor_critics
from sjdsl.trainers.networks.masks import NEVER

CENTRAL = {"algorithm": "mappo"}
READS = ("action", "reward", "trial")
VARIANTS = {
    "ippo": {},
    "mappo": CENTRAL,
    "mappo of the state": {**CENTRAL, "critic": "state"},
    "mappo, pooled": {**CENTRAL, "critic": "pooled"},
    "per agent": {"sharing": "per_agent"},
    "memory": {"memory": "gru"},
}
SELDOM = {"ippo": [], "per agent": [pytest.mark.thorough]}  # the others only with all tests
ALL_VARIANTS = pytest.mark.parametrize(
    "changes",
    [
        pytest.param(v, id=name, marks=SELDOM.get(name, [pytest.mark.slow]))
        for name, v in VARIANTS.items()
    ],
)


def trained(changes: dict[str, Any]) -> tuple[Probe, TrainState]:
    """Returns a variant and what it has learnt on a probe that suits it."""
    env = recalled() if "memory" in changes else opposite() if "sharing" in changes else matching()
    return env, learn(env, **changes)[0]


@ALL_VARIANTS
def test_every_minibatch_of_every_epoch_is_a_gradient_step(changes: dict[str, Any]) -> None:
    """Counted by the learner, and by Adam and the schedule of its learning rate."""
    _, state = trained(changes)
    assert int(state.updates) == 100
    counts = [leaf for leaf in jax.tree.leaves(state.learner.opt_state) if leaf.dtype == jnp.int32]
    # a critic with a torso has an optimiser of its own
    assert len(counts) == (4 if make_config(changes).critic_has_torso else 2)
    for count in (state.learner.step, *counts):
        np.testing.assert_array_equal(count, 2 * 2 * 100)


def test_the_learning_rate_falls_to_zero() -> None:
    config = quick()
    rate = learning_rate_schedule(config)
    assert float(rate(0)) == pytest.approx(config.learning_rate)
    assert float(rate(200)) == pytest.approx(config.learning_rate / 2)
    assert float(rate(400)) == pytest.approx(0.0)
    _, metrics = learn(matching())
    np.testing.assert_allclose(
        metrics["learning_rate"], [rate(4 * update) for update in range(100)], rtol=1e-4, atol=1e-8
    )


def test_episodes_are_counted_when_they_end() -> None:
    """Episodes of two and of five steps: returns and events add up over rollouts of 16 steps, which cut them anywhere."""
    _, metrics = learn(uneven())
    episodes, lengths = np.asarray(metrics["episodes"]), np.asarray(metrics["episode_length"])
    np.testing.assert_allclose(metrics["agent_return"][:, 0], lengths, rtol=1e-6)
    np.testing.assert_allclose(metrics["event"]["steps"], lengths, rtol=1e-6)
    played = (episodes * lengths).sum()
    assert 16 * 16 * 100 - 16 * 5 <= played <= 16 * 16 * 100
    # they pay n and 0: equality 1/2; their step is (n + 1) / 2 on average and n at the end
    np.testing.assert_allclose(metrics["equality"], 0.5, rtol=1e-6)
    np.testing.assert_allclose(metrics["mean"]["step"], (lengths + 1) / 2, rtol=1e-6)
    np.testing.assert_allclose(metrics["final"]["step"], lengths, rtol=1e-6)


# what is played, and learnt from


def test_a_rollout_keeps_bytes_and_independent_actions() -> None:
    """Networks that have learnt nothing: actions agree by chance, 1 in 2, over 2048 pairs with a standard error of 0.011."""
    state, _ = learn(endless_riches())
    program = make_train(matching(), quick(num_steps=128))
    rollout: Rollout = jax.jit(
        lambda state: program.collect(state)[1].rollout, compiler_options=FAST_TO_COMPILE
    )(state)
    assert rollout.observation.dtype == jnp.uint8
    assert rollout.observation.shape == (128, 16, 2, 1)
    alike = (rollout.action[..., 0] == rollout.action[..., 1]).mean()
    repeated = (rollout.action[1:] == rollout.action[:-1]).mean()
    across = (rollout.action[:, 1:] == rollout.action[:, :-1]).mean()
    assert all(0.45 < float(share) < 0.55 for share in (alike, repeated, across))


def less_sure(parameters: Any) -> Any:
    """Returns the parameters with a fifth of the actor's logits."""
    return jax.tree_util.tree_map_with_path(
        lambda path, leaf: leaf / 5 if "['actor']['out']" in jax.tree_util.keystr(path) else leaf,
        parameters,
    )


@pytest.mark.thorough
@pytest.mark.parametrize(
    "changes",
    [
        CENTRAL,
        {"sharing": "per_agent"},
        pytest.param({"memory": "gru"}, marks=pytest.mark.slow),
        pytest.param({}, marks=pytest.mark.slow),
        pytest.param({**CENTRAL, "critic": "state"}, marks=pytest.mark.slow),
        pytest.param({**CENTRAL, "critic": "pooled", "memory": "gru"}, marks=pytest.mark.slow),
        pytest.param({**CENTRAL, "memory": "gru", "sharing": "per_agent"}, marks=pytest.mark.slow),
        pytest.param({"memory": "gru", "memory_reads": READS}, marks=pytest.mark.slow),
        pytest.param(
            {**CENTRAL, "memory": "gru", "memory_reads": READS, "sharing": "per_agent"},
            marks=pytest.mark.slow,
        ),
        {"preference_noise": 2.0},
        pytest.param({"preference_noise": 2.0, "memory": "gru"}, marks=pytest.mark.slow),
    ],
    ids=[
        "mappo",
        "per agent",
        "memory",
        "ippo",
        "mappo of the state",
        "mappo, pooled, with memory",
        "all at once",
        "memory of rewards",
        "all at once, of rewards",
        "preferences",
        "preferences with memory",
    ],
)
def test_learning_computes_what_acting_did(changes: dict[str, Any]) -> None:
    """Before the first gradient step the ratio of probabilities is 1 and values are those kept, whatever networks remember.

    Of networks that have learnt, for those of the start give all actions the same probability; but made less sure of themselves.
    """
    env, state = trained(changes)
    learner = state.learner.replace(params=less_sure(state.learner.params))
    state = state.replace(learner=learner, updates=jnp.int32(0))
    config = quick(**changes, num_steps=5, num_epochs=1, num_minibatches=1)
    assert isinstance(config, PPOConfig)
    networks = make_actor_critics(env, config)
    program = make_train(env, config)

    def play_and_learn(state: TrainState, key: Array) -> tuple[Batch, dict[str, Array]]:
        _, played = program.collect(program.collect(state)[0])  # begins in the middle of an episode
        batch = make_batch(played.rollout, played.memory, jnp.zeros((16, 2)), config)
        return batch, learn_teams(state.learner, batch, key, networks, config)[1]

    with jax.debug_key_reuse(
        False
    ):  # the key of the trained state is used by every test that asks for it
        batch, losses = jax.jit(play_and_learn, compiler_options=FAST_TO_COMPILE)(
            state, jax.random.key(1)
        )
    assert batch.log_probability.min() < -1.0  # something else than a coin is at work
    assert float(jnp.abs(losses["kl"])) < 1e-6
    assert float(losses["clip_fraction"]) == 0.0
    assert float(losses["value_loss"]) == pytest.approx(
        0.5 * float(jnp.square(batch.advantage).mean()), rel=1e-3, abs=1e-7
    )


def test_preferences_end_in_one_environment_after_the_other() -> None:
    config = PPOConfig(preference_noise=2.0, total_timesteps=100 * 64 * 125, num_envs=64)
    config = config.model_copy(update={"num_steps": 125})
    assert config.num_updates == 100

    def deviations(updates: int) -> Array:
        """Returns the deviation in each environment, of 200 x 9 draws."""
        keys = jax.random.split(jax.random.key(updates), 200)
        drawn = jax.vmap(lambda key: draw_preferences(key, 64, 9, jnp.int32(updates), config))(keys)
        return drawn.std(axis=(0, 2))

    share = np.arange(1, 65) / 64
    # five standard errors
    np.testing.assert_allclose(deviations(0), 2 * share, rtol=0.085)
    np.testing.assert_allclose(deviations(25), 2 * np.maximum(share - 0.5, 0), rtol=0.085)
    assert deviations(50).max() == deviations(75).max() == 0.0


def test_values_follow_the_rewards_of_each_agent() -> None:
    """Steps that end an episode at once, paid 1 and -1 to two agents of the same value: targets are the rewards."""
    acting = Acting(log_probability=jnp.zeros((3, 4, 2)), value=jnp.full((3, 4, 2), 0.25))
    reward = jnp.broadcast_to(jnp.array([1.0, -1.0]), (3, 4, 2))
    ended = jnp.ones((3, 4), bool)
    rollout = Rollout(
        observation=jnp.zeros((3, 4, 2, 1, 1), jnp.uint8),
        for_critic=None,
        fresh=ended,
        action=jnp.zeros((3, 4, 2), jnp.int32),
        reward=0 * reward,
        shaped_reward=reward,
        done=ended,
        truncated=~ended,
        acting=acting,
        ending=jnp.full((3, 4, 2), 9.0),
    )
    batch = make_batch(rollout, (), jnp.full((4, 2), 9.0), PPOConfig())
    assert batch.target.shape == (1, 12, 2)
    np.testing.assert_allclose(batch.target, np.broadcast_to([1.0, -1.0], (1, 12, 2)), rtol=1e-6)


# the loss


@pytest.mark.parametrize("clip_value_loss", [True, False])
def test_the_loss_equals_its_formula(clip_value_loss: bool) -> None:
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
    squared_error = (
        np.maximum((value - target) ** 2, (clipped - target) ** 2)
        if clip_value_loss
        else (value - target) ** 2
    )
    value_loss = 0.5 * np.mean(squared_error)
    entropy = -(np.exp(log_probability) * log_probability).sum(1).mean()

    batch = Batch(
        joint=None,
        memory=(),
        fresh=None,
        observation=jnp.zeros((4, 1, 1, 1), jnp.uint8),
        action=jnp.asarray(action),
        log_probability=jnp.asarray(old_log),
        value=jnp.asarray(old_value, jnp.float32),
        advantage=jnp.asarray(advantage, jnp.float32),
        target=jnp.asarray(target, jnp.float32),
    )
    network = lambda *_: ((), jnp.asarray(logits), jnp.asarray(value))  # noqa: E731
    loss, parts = ppo_loss(None, network, batch, PPOConfig(clip_value_loss=clip_value_loss))
    assert float(parts["policy_loss"]) == pytest.approx(policy_loss, rel=1e-5)
    assert float(parts["value_loss"]) == pytest.approx(value_loss, rel=1e-5)
    assert float(parts["entropy"]) == pytest.approx(entropy, rel=1e-5)
    assert float(parts["clip_fraction"]) == pytest.approx(np.mean(np.abs(ratio - 1) > 0.2))
    assert float(parts["kl"]) == pytest.approx(np.mean(ratio - 1 - np.log(ratio)), rel=1e-4)
    assert float(loss) == pytest.approx(policy_loss + 0.5 * value_loss - 0.01 * entropy, rel=1e-5)


@pytest.mark.parametrize(("scaled", "epsilon"), [(True, 0.2 / 2), (False, 0.2)])
def test_the_clip_range_may_be_divided_by_the_number_of_agents(
    scaled: bool, epsilon: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = []
    monkeypatch.setattr(
        "sjdsl.trainers.algorithms.ppo.ppo_loss", lambda *given: seen.append(given[-1]) or 1 / 0
    )
    program = make_train(matching(), quick(scale_clip_epsilon=scaled))
    with pytest.raises(ZeroDivisionError):
        jax.eval_shape(lambda key: program.update(program.init(key)), jax.random.key(0))
    assert [config.clip_epsilon for config in seen] == [pytest.approx(epsilon)]


def test_every_epoch_sees_every_sample_once() -> None:
    """The value of each sample is a parameter of its own, which goes a tenth of its way to the target when seen.

    What says which sample it is stands in the place of memory.
    """
    config = PPOConfig(
        num_envs=4,
        num_steps=8,
        num_epochs=3,
        num_minibatches=4,
        value_coefficient=1.0,
        clip_value_loss=False,
    )
    samples, minibatch = 32, 8
    shape = (1, samples, 1)
    batch = Batch(
        observation=jnp.zeros((*shape, 1, 1), jnp.uint8),
        joint=None,
        fresh=jnp.zeros((1, samples), bool),
        memory=jnp.arange(samples),
        action=jnp.zeros(shape, jnp.int32),
        log_probability=jnp.zeros(shape),
        value=jnp.zeros(shape),
        advantage=jnp.zeros(shape),
        target=jnp.ones(shape),
    )

    def read(parameters: dict[str, Array], memory: Array, *_: Any) -> tuple[Array, Array, Array]:
        return memory, jnp.zeros((1, minibatch, 1, 2)), parameters["values"][memory][None, :, None]

    learner = Learner.create(
        apply_fn=None, params={"values": jnp.zeros(samples)}, tx=optax.sgd(0.1 * minibatch)
    )
    networks = make_actor_critics(matching(1), config)
    network = SimpleNamespace(apply=read, num_actions=2, config=config)
    networks = replace(networks, network=network)  # type: ignore[arg-type]
    orders = draw_orders(jax.random.key(0), 1, config)
    learner, _ = take_epochs(
        learner,
        orders[0],
        np.array([0]),
        batch.memory,
        batch,
        networks,
        config,
    )
    np.testing.assert_allclose(learner.params["values"], np.full(samples, 1 - 0.9**3), rtol=1e-5)


def test_every_epoch_and_team_has_an_order_of_its_own() -> None:
    orders = draw_orders(
        jax.random.key(0), 2, PPOConfig(num_envs=8, num_steps=8, num_epochs=3, num_minibatches=4)
    ).reshape(6, 64)
    np.testing.assert_array_equal(np.sort(orders, axis=1), np.broadcast_to(np.arange(64), (6, 64)))
    assert len(np.unique(orders, axis=0)) == 6


def test_a_minibatch_has_as_much_of_each_group_of_environments() -> None:
    """Steps of 8 environments, 12 in a minibatch: 3 of each of the four pairs that 8 and 12 divide into; with memory whole rollouts of 2 pairs."""
    config = PPOConfig(num_envs=8, num_steps=6, num_minibatches=4)
    orders = draw_orders(jax.random.key(0), 1, config)
    np.testing.assert_array_equal(
        np.sort(orders.reshape(config.num_epochs, 48)),
        np.broadcast_to(np.arange(48), (config.num_epochs, 48)),
    )
    pairs = np.sort(np.asarray(orders) % 8 // 2, axis=-1)
    np.testing.assert_array_equal(
        pairs, np.broadcast_to(np.repeat(np.arange(4), 3), (1, config.num_epochs, 4, 12))
    )
    remembering = draw_orders(
        jax.random.key(0), 1, PPOConfig(num_envs=8, num_steps=6, num_minibatches=2, memory="gru")
    )
    np.testing.assert_array_equal(
        np.sort(remembering // 2, axis=-1),
        np.broadcast_to(np.arange(4), (1, config.num_epochs, 2, 4)),
    )


def test_actions_are_drawn_with_their_probabilities() -> None:
    """Of 40,000 environments, within five standard deviations; what is forbidden, first, last or in between, never."""
    logits = jnp.array(
        [
            [NEVER, 0.3, NEVER, -1.0, 2.0, NEVER],
            [1.0, -0.5, 0.0, 0.2, -3.0, 0.7],
            [NEVER, NEVER, NEVER, NEVER, NEVER, 0.0],
        ]
    )
    number = 40_000
    actions = np.asarray(
        draw_actions(jax.random.key(0), jnp.broadcast_to(logits, (number, *logits.shape)))
    )
    for agent, wanted in enumerate(np.asarray(jax.nn.softmax(logits))):
        counted = np.bincount(actions[:, agent], minlength=6) / number
        assert (np.abs(counted - wanted) <= 5 * np.sqrt(wanted * (1 - wanted) / number)).all()


def _two_steps(gradients: Sequence[Any]) -> np.ndarray:
    """Returns where Adam, epsilon 1e-8 and rate 0.1, takes parameters in two steps on gradients clipped to a norm of 0.5: by hand."""
    first, second, parameters = (np.zeros(len(gradients[0])) for _ in range(3))
    for step, gradient in enumerate(map(np.asarray, gradients), start=1):
        gradient = gradient * min(1.0, 0.5 / np.linalg.norm(gradient))
        first, second = 0.9 * first + 0.1 * gradient, 0.999 * second + 0.001 * gradient**2
        parameters = parameters - 0.1 * (first / (1 - 0.9**step)) / (
            np.sqrt(second / (1 - 0.999**step)) + 1e-8
        )
    return parameters


def test_gradients_are_clipped_by_their_global_norm() -> None:
    """Gradients of norm 5 and 0.1."""
    optimiser = make_optimiser(
        PPOConfig(learning_rate=0.1, anneal_learning_rate=False, max_gradient_norm=0.5)
    )
    gradients = np.array([[3.0, 4.0], [0.06, -0.08]])
    parameters = {"a": jnp.zeros(1), "b": jnp.zeros(1)}
    memory = optimiser.init(parameters)
    for gradient in gradients:
        updates, memory = optimiser.update(
            {"a": jnp.float32(gradient[:1]), "b": jnp.float32(gradient[1:])}, memory, parameters
        )
        parameters = optax.apply_updates(parameters, updates)
    np.testing.assert_allclose(
        [parameters["a"][0], parameters["b"][0]], _two_steps(gradients), rtol=1e-5
    )


@pytest.mark.parametrize("reads", ["observations", "pooled"])
def test_a_critic_with_a_torso_has_an_optimiser_and_a_clip_of_its_own(reads: str) -> None:
    """The critic's gradients are a hundred times the actor's in the first step: clipped together, they take all of its norm."""
    config = PPOConfig(
        algorithm="mappo", critic=reads, learning_rate=0.1, anneal_learning_rate=False
    )
    optimiser = make_optimiser(config)
    actor, critic = np.array([[0.3, 0.4], [0.06, -0.08]]), np.array([[30.0, 40.0], [0.4, 0.1]])
    parameters = {"params": {"actor": jnp.zeros(2), "critic_torso": jnp.zeros(2)}}
    memory = optimiser.init(parameters)
    for step in range(2):
        gradients = {
            "params": {"actor": jnp.float32(actor[step]), "critic_torso": jnp.float32(critic[step])}
        }
        updates, memory = optimiser.update(gradients, memory, parameters)
        parameters = optax.apply_updates(parameters, updates)
    wanted = (
        _two_steps(np.concatenate([actor, critic], axis=1))
        if reads == "pooled"
        else np.concatenate([_two_steps(actor), _two_steps(critic)])
    )
    np.testing.assert_allclose(
        np.concatenate([parameters["params"]["actor"], parameters["params"]["critic_torso"]]),
        wanted,
        rtol=1e-4,
    )


def test_every_parameter_of_a_central_critic_is_the_critics() -> None:
    """And none of the actor's."""
    networks = make_actor_critics(matching(), quick(**CENTRAL, memory="gru"))
    shapes = jax.eval_shape(lambda key: networks.init(key, matching()), jax.random.key(0))["params"]
    found = {
        module: set(jax.tree.leaves(part))
        for module, part in part_of_each({"params": shapes})["params"].items()
    }
    critic = {name: {"critic"} for name in ("critic", "critic_torso", "critic_memory")}
    assert found == {"torso": {"actor"}, "memory": {"actor"}, "actor": {"actor"}, **critic}


# numbers that are not finite


@pytest.mark.parametrize(
    ("loss", "new", "diverged", "good"),
    [
        (1.0, 2.0, False, True),
        (np.nan, 2.0, False, False),
        (np.inf, 2.0, False, False),
        (1.0, np.nan, False, False),
        (1.0, -np.inf, False, False),
        (1.0, 2.0, True, False),
    ],
)
def test_what_is_not_finite_or_was_not_is_not_kept(
    loss: float, new: float, diverged: bool, good: bool
) -> None:
    old = {"weights": jnp.array([1.0, 1.0]), "step": jnp.int32(3)}
    fresh = {"weights": jnp.array([2.0, new]), "step": jnp.int32(4)}
    kept, told = keep_if_finite(jnp.float32(loss), fresh, old, jnp.bool_(diverged))
    assert kept["weights"].tolist() == ([2.0, 2.0] if good else [1.0, 1.0])
    assert int(kept["step"]) == (4 if good else 3)
    assert np.isnan(told) == (not good)


@pytest.mark.parametrize(
    "changes",
    [{}, pytest.param({"sharing": "per_agent"}, marks=pytest.mark.thorough)],
    ids=["shared", "per agent"],
)
def test_an_infinite_reward_leaves_the_parameters_as_they_were(changes: dict[str, Any]) -> None:
    """No step is counted, and the critic's weights have the length 1 that they start with."""
    ruined, metrics = learn(endless_riches(), **changes)
    assert np.isnan(metrics["loss"]).all()
    np.testing.assert_array_equal(ruined.learner.step, 0)
    kernels = ruined.learner.params["params"]["critic"]["out"]["kernel"]
    np.testing.assert_allclose(jnp.linalg.norm(kernels, axis=-2), 1.0, atol=1e-5)
