"""Agents with an individual and a team policy each: the loss term by term, who acts, what is learnt."""

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from probes import matching, quick

from sjdsl.trainers import PPOConfig, make_train, trained_policy
from sjdsl.trainers.actor_critics import make_actor_critics
from sjdsl.trainers.irat import both_rewards, irat_loss
from sjdsl.trainers.losses import Batch
from sjdsl.trainers.networks import INDIVIDUAL, TEAM
from sjdsl.trainers.optimisers import gradient_norms, part_of_each
from sjdsl.trainers.rollout import Rollout

IRAT = {"algorithm": "irat"}
SPANS = {"similarity_clip": (0.5, 0.1), "individual_kl": (0.2, 2.2), "team_kl": (1.5, 0.5)}


def config_of(**changes: Any) -> PPOConfig:
    config = quick(**IRAT, **changes)
    assert isinstance(config, PPOConfig)
    return config


# the loss


def _log_softmax(logits: np.ndarray) -> np.ndarray:
    return logits - np.log(np.exp(logits).sum(axis=-1, keepdims=True))


def _samples(number: int = 24) -> tuple[np.ndarray, np.ndarray, Batch]:
    """Returns what the policies' logits `[1, m, 1, 2, 3]` and the values `[1, m, 1, 2]` are now, and a batch of one agent: as drawn."""
    draw = np.random.default_rng(3)
    now, then = draw.normal(size=(2, 1, number, 1, 2, 3))
    value, before, advantage, target = draw.normal(size=(4, 1, number, 1, 2))
    batch = Batch(
        observation=jnp.zeros((1, number, 1, 1, 1, 1), jnp.uint8),
        joint=None,
        fresh=jnp.zeros((1, number), bool),
        memory=(),
        action=jnp.asarray(draw.integers(0, 3, (1, number, 1))),
        log_probability=jnp.asarray(_log_softmax(then), jnp.float32),
        value=jnp.asarray(before, jnp.float32),
        advantage=jnp.asarray(advantage, jnp.float32),
        target=jnp.asarray(target, jnp.float32),
        progress=jnp.float32(0.25),
    )
    return now, value, batch


def _loss(logits: Any, value: Any, batch: Batch, config: PPOConfig) -> tuple[jax.Array, dict[str, Any]]:
    return irat_loss(None, lambda *_: ((), jnp.asarray(logits, jnp.float32), jnp.asarray(value, jnp.float32)), batch, config)


def test_every_term_of_the_loss_equals_its_formula() -> None:
    """A quarter into the run, xi is 0.4, alpha 0.7 and beta 1.25; samples are taken one by one."""
    now, value, batch = _samples()
    own, team, own_kl, team_kl, own_entropy, team_entropy = (np.zeros(24) for _ in range(6))
    errors = np.zeros((24, 2))
    advantage = np.asarray(batch.advantage)[0, :, 0].astype(np.float64)
    normal = (advantage - advantage.mean(axis=0)) / advantage.std(axis=0)
    for m in range(24):
        action = int(batch.action[0, m, 0])
        p, q = np.exp(_log_softmax(now[0, m, 0]))
        p_then, q_then = np.exp(np.asarray(batch.log_probability)[0, m, 0].astype(np.float64))
        ratio, similar, off = p[action] / p_then[action], p[action] / q_then[action], q[action] / p_then[action]
        a, b = normal[m]
        own[m] = min(ratio * a, np.clip(ratio, 0.8, 1.2) * a, np.clip(similar, 0.6, 1.4) * a)
        team[m] = min(off * b, np.clip(off, 0.8, 1.2) * b)
        own_kl[m], team_kl[m] = (q_then * np.log(q_then / p)).sum(), (p_then * np.log(p_then / q)).sum()
        own_entropy[m], team_entropy[m] = -(p * np.log(p)).sum(), -(q * np.log(q)).sum()
        for one in (0, 1):
            before, new, target = float(batch.value[0, m, 0, one]), value[0, m, 0, one], float(batch.target[0, m, 0, one])
            errors[m, one] = 0.5 * max((new - target) ** 2, (before + np.clip(new - before, -0.2, 0.2) - target) ** 2)
    loss, parts = _loss(now, value, batch, config_of(**SPANS, clip_value_loss=True))
    wanted = {
        "individual_policy_loss": -own.mean(),
        "team_policy_loss": -team.mean(),
        "individual_kl": own_kl.mean(),
        "team_kl": team_kl.mean(),
        "entropy": own_entropy.mean(),
        "team_entropy": team_entropy.mean(),
        "individual_value_loss": errors[:, 0].mean(),
        "team_value_loss": errors[:, 1].mean(),
    }
    for name, term in wanted.items():
        assert float(parts[name]) == pytest.approx(term, rel=1e-4), name
    whole = -own.mean() - team.mean() + 0.7 * own_kl.mean() + 1.25 * team_kl.mean() + 0.5 * errors.mean(axis=0).sum()
    assert float(loss) == pytest.approx(whole - 0.01 * (own_entropy.mean() + team_entropy.mean()), rel=1e-4)


def test_no_gradient_passes_from_one_policy_to_the_other() -> None:
    """What the team's logits are now changes nothing in the gradient of the individual ones, and the other way round."""
    now, value, batch = _samples()
    gradient = jax.grad(lambda logits: _loss(logits, value, batch, config_of(**SPANS))[0])
    for one, other in ((INDIVIDUAL, TEAM), (TEAM, INDIVIDUAL)):
        changed = now.copy()
        changed[..., other, :] = 0.3
        np.testing.assert_array_equal(gradient(jnp.asarray(now))[..., one, :], gradient(jnp.asarray(changed))[..., one, :])


def test_gradients_are_finite_where_the_team_policy_would_never_have_done_it() -> None:
    now, value, batch = _samples()
    never = jnp.where(jnp.arange(3) == batch.action[..., None], -1e6, 0.0)
    log_probability = batch.log_probability.at[..., TEAM, :].set(jax.nn.log_softmax(never))
    gradient = jax.grad(lambda logits: _loss(logits, value, batch.replace(log_probability=log_probability), config_of(**SPANS))[0])
    assert np.isfinite(gradient(jnp.asarray(now))).all()


def test_what_is_forbidden_is_in_no_term() -> None:
    now, value, batch = _samples()
    allowed = (jnp.arange(3) != 2) | (batch.action[..., None] == 2)
    masks = partial(jnp.where, allowed[..., None, :])
    drawn = batch.replace(allowed=allowed, log_probability=jax.nn.log_softmax(masks(batch.log_probability, -1e9)))
    gradient = jax.grad(lambda logits: _loss(logits, value, drawn, config_of(**SPANS))[0])(jnp.asarray(now))
    assert np.isfinite(gradient).all()
    assert (masks(0.0, gradient) == 0.0).all()


@pytest.mark.parametrize(("team_reward", "team"), [("sum", 5.0), ("mean", 2.5)])
def test_teams_learn_from_all_raw_rewards(team_reward: str, team: float) -> None:
    nothing: dict[str, Any] = dict.fromkeys(Rollout.__dataclass_fields__)
    rollout = Rollout(**{**nothing, "reward": jnp.array([[[1.0, 4.0]]]), "shaped_reward": jnp.array([[[7.0, 9.0]]])})
    np.testing.assert_allclose(both_rewards(rollout, config_of(team_reward=team_reward)), [[[[7.0, team], [9.0, team]]]])


# networks and who acts


@pytest.mark.parametrize("memory", ["none", "gru"])
def test_every_parameter_is_of_one_part(memory: str) -> None:
    """The individual network has one optimiser, the team's actor and its critic one each."""
    networks = make_actor_critics(matching(), config_of(memory=memory))
    shapes = jax.eval_shape(lambda key: networks.init(key, matching()), jax.random.key(0))[0]
    found = part_of_each(shapes)["params"]
    assert set(jax.tree.leaves(found["individual"])) == {"individual"}
    of_team = {module: set(jax.tree.leaves(part)) for module, part in found["team"].items()}
    assert all(part == ({"critic"} if "critic" in module else {"actor"}) for module, part in of_team.items())
    ones = jax.tree.map(lambda leaf: jnp.ones(leaf.shape), shapes)
    norms = {name: float(norm) ** 2 for name, norm in gradient_norms(ones, config_of(memory=memory)).items()}
    parts = [norms[f"{part}_gradient_norm"] for part in ("individual", "actor", "critic")]
    assert min(parts) > 0
    assert sum(parts) == pytest.approx(norms["gradient_norm"], rel=1e-5)


@pytest.mark.thorough
def test_individual_policies_act_while_learning_and_team_policies_are_what_is_kept() -> None:
    """Of networks whose individual policies always take action 0 and whose team policies always take 1."""
    env, config = matching(), config_of()
    program = make_train(env, config)
    state = program.init(jax.random.key(0))
    bias = {INDIVIDUAL: jnp.array([50.0, -50.0]), TEAM: jnp.array([-50.0, 50.0])}
    (parameters,) = program.parameters(state)
    for name, one in (("individual", INDIVIDUAL), ("team", TEAM)):
        parameters["params"][name]["actor"]["out"]["bias"] = bias[one][None]
    assert program.adopt is not None
    state = program.adopt(state, (parameters,))
    rollout = program.collect(state)[1].rollout
    assert (rollout.action == 0).all()
    assert rollout.acting.log_probability.shape == (16, 16, 2, 2, 2)
    for greedy in (False, True):
        policy = trained_policy(env, config, (parameters,), greedy)
        assert callable(policy)
        observation, _ = env.reset(jax.random.key(1))
        assert policy(jax.random.key(2), observation).tolist() == [1, 1]


# what is learnt


# runs
