"""Value decomposition: values that can be worked out by hand, and the parts of an update."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from probes import (
    FAST_TO_COMPILE,
    delayed,
    endless_riches,
    judge_actions,
    learn,
    matching,
    quick,
    stream,
)

from sjdsl.trainers import TrainState, VDNConfig, make_config, make_train
from sjdsl.trainers.algorithms.optimisers import learning_rate_schedule
from sjdsl.trainers.algorithms.rollout import Rollout
from sjdsl.trainers.algorithms.vdn import ValueLearner, follow_target
from sjdsl.trainers.algorithms.vdn_targets import (
    Steps,
    Team,
    Transition,
    bootstrapped,
    team_loss,
    with_lambda_returns,
)
from sjdsl.trainers.networks.action_values import exploration

VDN = {"algorithm": "vdn"}
ON_POLICY = {"replay": "none"}
BOTH = pytest.mark.parametrize(
    "changes",
    [{}, pytest.param(ON_POLICY, marks=pytest.mark.thorough)],
    ids=["replayed", "on policy"],
)
TOLERANCE = 0.15


def values(env: Any, shown: int, **changes: Any) -> np.ndarray:
    """Returns the action values `[N, A]` learnt."""
    state, _ = learn(env, **VDN, **changes)
    return np.asarray(judge_actions(env, state, shown, **changes))


@BOTH
def test_value_is_discounted_once_a_step(changes: dict[str, Any]) -> None:
    np.testing.assert_allclose(values(delayed(), 0, **changes).sum(axis=0), 0.8 * 2, atol=TOLERANCE)
    np.testing.assert_allclose(values(delayed(), 1, **changes).sum(axis=0), 2, atol=TOLERANCE)


@pytest.mark.parametrize(
    "changes",
    [{}, ON_POLICY, pytest.param({"double_q": True}, marks=pytest.mark.slow)],
    ids=["replayed", "on policy", "double"],
)
def test_each_joint_action_has_its_value(changes: dict[str, Any]) -> None:
    """The team has 1 for each agent that does what is cued: a sum, so that values can say it exactly."""
    for cue in (0, 1):
        found = values(matching(), cue, **changes)
        paid = np.arange(2) == cue
        np.testing.assert_allclose(
            found[0][:, None] + found[1][None], paid[:, None] + 1.0 * paid[None], atol=TOLERANCE
        )
    _, metrics = learn(matching(), **VDN, **changes)
    assert (
        float(metrics["collective_return"][-10:].mean()) > 1.85
    )  # all but 0.05 / 2 of the actions of each


@BOTH
def test_a_time_limit_is_no_ending(changes: dict[str, Any]) -> None:
    """An endless reward of 1 to both is worth 2 / (1 - 0.8), wherever it is cut."""
    found = [
        values(stream("truncated"), 1 + 2 * step, **changes).max(axis=1).sum() for step in range(3)
    ]
    np.testing.assert_allclose(found, 10.0, atol=0.7)


@BOTH
def test_a_true_ending_is_worth_nothing(changes: dict[str, Any]) -> None:
    found = [
        values(stream("terminated"), 1 + 2 * step, **changes).max(axis=1).sum() for step in range(3)
    ]
    np.testing.assert_allclose(found, [2 * 2.44, 2 * 1.8, 2 * 1.0], atol=0.3)


def test_what_is_measured() -> None:
    state, metrics = learn(matching(), **VDN)
    config = quick(**VDN)
    assert isinstance(config, VDNConfig)
    updates = np.arange(200)
    assert int(state.learner.online.step) == 4 * 200
    np.testing.assert_array_equal(metrics["replayed"], np.minimum(64 * (updates + 1), 640))
    np.testing.assert_allclose(
        metrics["epsilon"], np.maximum(1 - 0.95 * updates / 100, 0.05), atol=1e-5
    )
    np.testing.assert_allclose(
        metrics["learning_rate"], 1e-2 * (1 - (updates + 1) / 200), atol=1e-6
    )
    assert np.isfinite(metrics["loss"]).all()


@BOTH
def test_an_infinite_reward_leaves_the_parameters_as_they_were(changes: dict[str, Any]) -> None:
    ruined, metrics = learn(endless_riches(), **VDN, **changes)
    assert np.isnan(metrics["loss"]).all()
    learner = ruined.learner.online
    assert int(learner.step) == 0
    kernel = learner.params["params"]["values"]["out"]["kernel"]
    np.testing.assert_allclose(kernel.T @ kernel, np.eye(2), atol=1e-5)


# parts


@pytest.mark.parametrize(
    ("updates", "epsilon"),
    [(0, 0.9), (10, 0.7), (20, 0.5), (30, 0.3), (40, 0.1), (41, 0.1), (100, 0.1)],
)
def test_exploring_falls_in_a_line_and_stays(updates: int, epsilon: float) -> None:
    """From 0.9 to 0.1 over 0.4 of 100 updates."""
    config = make_config(
        VDN,
        num_envs=1,
        num_steps=1,
        total_timesteps=100,
        epsilon_start=0.9,
        epsilon_end=0.1,
        epsilon_fraction=0.4,
        buffer_size=1,
    )
    assert isinstance(config, VDNConfig)
    assert float(exploration(config, jnp.int32(updates))) == pytest.approx(epsilon, rel=1e-5)


def test_the_target_follows_every_so_many_updates() -> None:
    target, online = {"a": jnp.array([0.0, 4.0])}, {"a": jnp.array([1.0, 8.0])}
    config = VDNConfig(target_update_every=3, target_rate=0.25)
    moved = [
        follow_target(target, online, jnp.int32(updates), config)["a"].tolist()
        for updates in range(1, 7)
    ]
    stays, goes = [0.0, 4.0], [0.25, 5.0]
    assert moved == [stays, stays, goes, stays, stays, goes]
    np.testing.assert_array_equal(
        follow_target(target, online, jnp.int32(3), VDNConfig(target_update_every=3))["a"],
        online["a"],
    )


@pytest.mark.parametrize("double_q", [False, True])
def test_the_loss_equals_its_formula(double_q: bool) -> None:
    """Three transitions of two agents; parameters are the tables of values of a network that reads the first token."""
    draw = np.random.default_rng(0)
    online, target = draw.normal(size=(2, 4, 3)).astype(np.float32)
    seen, led = draw.integers(0, 4, (2, 3, 2))
    action, reward, ended = (
        draw.integers(0, 3, (3, 2)),
        draw.normal(size=3).astype(np.float32),
        np.array([False, True, False]),
    )

    squares, taken = [], []
    for index in range(3):
        value = sum(online[seen[index, agent], action[index, agent]] for agent in range(2))
        wanted = reward[index]
        if not ended[index]:
            for agent in range(2):
                chosen = online if double_q else target
                wanted += 0.9 * target[led[index, agent], chosen[led[index, agent]].argmax()]
        squares.append((wanted - value) ** 2)
        taken.append(value)

    class Network:
        @staticmethod
        def apply(parameters: jax.Array, observation: jax.Array) -> jax.Array:
            return parameters[observation[..., 0, 0, 0]]

    batch = Transition(
        observation=jnp.asarray(seen)[..., None, None, None],
        action=jnp.asarray(action),
        reward=jnp.asarray(reward),
        following=jnp.asarray(led)[..., None, None, None],
        ended=jnp.asarray(ended),
    )
    config = VDNConfig(gamma=0.9, double_q=double_q)
    team = Team(Network, jnp.arange(2))  # type: ignore[arg-type]
    steps = bootstrapped(jnp.asarray(online), jnp.asarray(target), batch, team, config)
    loss, parts = team_loss(jnp.asarray(online), team, steps, weight=1.0)
    assert float(loss) == pytest.approx(np.mean(squares), rel=1e-5)
    assert float(parts["team_value"]) == pytest.approx(np.mean(taken), rel=1e-5)


def test_targets_of_rollouts_equal_their_recursion() -> None:
    """G_t = r_t + gamma * ((1 - lambda) * V_{t+1} + lambda * G_{t+1}); nothing follows a termination, V of the terminal state a truncation."""
    draw = np.random.default_rng(0)
    steps, envs = 7, 3
    values, terminal, reward = draw.normal(size=(3, steps, envs)).astype(np.float32)
    last = draw.normal(size=envs).astype(np.float32)
    done = draw.random((steps, envs)) < 0.4
    truncated = done & (draw.random((steps, envs)) < 0.5)
    config = VDNConfig(replay="none", gamma=0.9, q_lambda=0.7)

    wanted = np.zeros((steps, envs))
    for env in range(envs):
        following, value = last[env], last[env]  # the return and the value of the next state
        for step in reversed(range(steps)):
            if done[step, env]:
                following = value = terminal[step, env] if truncated[step, env] else 0.0
            wanted[step, env] = reward[step, env] + 0.9 * (0.3 * value + 0.7 * following)
            following, value = wanted[step, env], values[step, env]

    rollout = Rollout(
        observation=jnp.zeros((steps, envs, 1, 1), jnp.uint8),
        for_critic=None,
        fresh=jnp.zeros((steps, envs), bool),
        action=jnp.zeros((steps, envs, 1), jnp.int32),
        reward=jnp.zeros((steps, envs, 1)),
        shaped_reward=jnp.asarray(reward)[..., None],
        done=jnp.asarray(done),
        truncated=jnp.asarray(truncated),
        acting=jnp.asarray(values),
        ending=jnp.asarray(terminal),
    )
    np.testing.assert_allclose(
        with_lambda_returns(rollout, jnp.asarray(last), config).target,
        wanted.ravel(),
        rtol=1e-5,
        atol=1e-6,
    )


def test_the_value_of_the_team_is_the_sum_over_learners() -> None:
    """Half the mean squared error; agent 1 of three doesn't learn."""
    network = type(
        "Network",
        (),
        {"apply": staticmethod(lambda parameters, observation: parameters[observation[..., 0]])},
    )
    table = jnp.array([[1.0, 2.0], [3.0, 5.0]])
    steps = Steps(jnp.array([[[0], [1], [1]]]), jnp.array([[1, 0, 1]]), jnp.array([10.0]))
    team = Team(network, jnp.array([0, 2]))  # type: ignore[arg-type]
    loss, parts = team_loss(table, team, steps, weight=0.5)
    assert (float(loss), float(parts["team_value"])) == (0.5 * (2 + 5 - 10) ** 2, 7.0)


def test_only_a_double_target_reads_the_online_network() -> None:
    """The target is y = r + gamma * max Q'(s', a): 1 + 0.5 * 3, whatever the online network says."""
    network = type(
        "Network",
        (),
        {
            "apply": staticmethod(
                lambda parameters, observation: parameters[observation[..., 0, 0, 0]]
            )
        },
    )
    zero = jnp.zeros((1, 1, 1, 1, 1), jnp.int32)
    batch = Transition(
        zero, jnp.zeros((1, 1), jnp.int32), jnp.array([1.0]), zero, jnp.array([False])
    )
    target, online = jnp.array([[3.0, 0.0]]), jnp.array([[-1.0, 8.0]])
    team = Team(network, jnp.arange(1))  # type: ignore[arg-type]
    for double_q, wanted in ((False, 1 + 0.5 * 3), (True, 1 + 0.5 * 0)):
        config = VDNConfig(gamma=0.5, double_q=double_q)
        steps = bootstrapped(online, target, batch, team, config)
        np.testing.assert_allclose(steps.target, [wanted])


def test_the_learning_rate_falls_to_zero() -> None:
    config = quick(**VDN)
    assert isinstance(config, VDNConfig)
    rate = learning_rate_schedule(config)
    assert [float(rate(step)) for step in (0, 400, 800)] == pytest.approx([1e-2, 5e-3, 0.0])


# one update


def _learners(number: int, **changes: Any) -> list[ValueLearner]:
    """Returns the learners before and after each of some updates."""
    program = make_train(matching(), quick(**VDN, **changes))

    def play(key: jax.Array) -> ValueLearner:
        start = program.init(key)

        def update(state: TrainState, _: None) -> tuple[TrainState, ValueLearner]:
            return program.update(state)[0], state.learner

        return jax.lax.scan(update, start, length=number + 1)[1]

    stacked = jax.device_get(jax.jit(play, compiler_options=FAST_TO_COMPILE)(jax.random.key(0)))
    return [jax.tree.map(lambda leaf: leaf[index], stacked) for index in range(number + 1)]  # noqa: B023


def _same(one: Any, other: Any) -> bool:
    return all(
        np.array_equal(a, b)
        for a, b in zip(jax.tree.leaves(one), jax.tree.leaves(other), strict=True)
    )


@pytest.mark.thorough
def test_learning_starts_late_and_the_target_stays_behind() -> None:
    """64 steps an update: learning starts with the third, and the target follows at every second."""
    learners = _learners(6, learning_starts=150)
    online, target = (
        [getattr(learner, name) for learner in learners] for name in ("online", "target")
    )
    assert [int(learner.step) for learner in online] == [0, 0, 0, 4, 8, 12, 16]
    assert _same(online[0].params, online[2].params)
    assert not _same(online[2].params, online[3].params)
    for update in range(1, 7):
        follows = update % 2 == 0
        assert _same(target[update], online[update].params if follows else target[update - 1])
    assert not _same(target[3], online[3].params)
    assert learners[-1].replay.entries.observation.dtype == jnp.uint8
