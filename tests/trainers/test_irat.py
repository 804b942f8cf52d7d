"""Agents with an individual and a team policy each: the loss term by term, who acts, what is learnt."""

import json
from functools import partial
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from probes import FAST_TO_COMPILE, Probe, dilemma, judge, learn, matching, quick, stream
from run_outcomes import SHORT, assert_same_end, copy_run, read_lines

import sjdsl
from sjdsl.trainers import PPOConfig, load_preset, make_config, make_train, resume, train, trained_policy
from sjdsl.trainers.actor_critics import make_actor_critics
from sjdsl.trainers.irat import both_rewards, irat_loss
from sjdsl.trainers.losses import Batch
from sjdsl.trainers.networks import INDIVIDUAL, TEAM
from sjdsl.trainers.optimisers import gradient_norms, part_of_each
from sjdsl.trainers.recorder import Recorder
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


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        {"memory": "gru"},
        {"sharing": "per_agent", "critic": "state", "agent_id": True},
        {"sharing": "by_role", "roles": (0, 1, 1), "partners": {0: "random"}},
        {"reward": "svo", "anneal_learning_rate": False, "team_kl": 1},
    ],
    ids=["memory", "own networks", "partners", "svo"],
)
def test_it_goes_with_the_other_settings(changes: dict[str, Any]) -> None:
    env, config = matching(3), config_of(**changes)
    program = make_train(env, config)
    after, metrics = jax.jit(lambda key: program.update(program.init(key)), compiler_options=FAST_TO_COMPILE)(jax.random.key(0))
    assert np.isfinite(metrics["loss"])
    assert not after.diverged


@pytest.mark.slow
def test_forbidden_actions_are_never_drawn() -> None:
    env = sjdsl.make(Path(__file__).parent / "games" / "one_door.sj")
    program = make_train(env, config_of(num_envs=4, num_minibatches=2))
    state = program.init(jax.random.key(0))
    after, played = jax.jit(program.collect)(state)
    acting = played.rollout.acting
    allowed = jnp.unpackbits(acting.allowed, axis=-1, count=env.num_actions).astype(bool)
    assert not allowed.all()
    assert jnp.take_along_axis(allowed, played.rollout.action[..., None], axis=-1).all()
    assert np.isfinite(jax.jit(program.learn)(after, played)[1]["loss"])


# what is learnt


def _learnt(env: Probe, shown: int, **changes: Any) -> tuple[np.ndarray, np.ndarray]:
    """Returns the probabilities `[N, 2, A]` and values `[N, 2]` of the individual and the team policies."""
    state, metrics = learn(env, **IRAT, **changes)
    assert np.isfinite(metrics["loss"]).all()
    probabilities, values = judge(env, state, shown, **IRAT, **changes)
    return np.asarray(probabilities), np.asarray(values)


@pytest.mark.thorough
def test_both_policies_learn_what_pays_both() -> None:
    """An agent is paid 1 for the cue's action: with the sum, the two of them have 2."""
    for cue in (0, 1):
        probabilities, values = _learnt(matching(), cue, team_reward="sum")
        assert (probabilities[:, :, cue] > 0.95).all()
        np.testing.assert_allclose(values, [[1.0, 2.0]] * 2, atol=0.1)


@pytest.mark.slow
@pytest.mark.parametrize(("individual_kl", "action", "paid"), [((0.0, 10.0), 0, 3.0), ((0.0, 0.0), 1, 1.0)])
def test_the_weight_of_the_team_decides_the_dilemma(individual_kl: tuple[float, float], action: int, paid: float) -> None:
    """Individual policies that come ever closer to the team's cooperate, 3 each; left alone they defect, 1 each."""
    team_kl = 0.0 if action == 0 else (1.5, 0.0)  # otherwise the team policies imitate the defectors before they have learnt anything
    probabilities, values = _learnt(dilemma(), 0, individual_kl=individual_kl, team_kl=team_kl)
    assert (probabilities[:, :, action] > 0.9).all()
    np.testing.assert_allclose(values, paid, atol=0.15)


@pytest.mark.thorough
@pytest.mark.parametrize(("ends", "worth"), [("truncated", [5.0, 5.0, 5.0]), ("terminated", [2.44, 1.8, 1.0])])
def test_both_values_know_a_time_limit_from_an_ending(ends: Any, worth: list[float]) -> None:
    """Ones at gamma 0.8: for ever, or for the steps that are left."""
    for step, value in enumerate(worth):
        np.testing.assert_allclose(_learnt(stream(ends), 1 + 2 * step)[1], value, atol=0.3)


# runs


@pytest.mark.thorough
def test_a_stopped_run_goes_on_to_the_same_end(tmp_path: Path) -> None:
    """Weights that change over the run included: stopped after update 7 of 12, with a checkpoint of update 6."""
    config = make_config({**SHORT.model_dump(), **IRAT, **SPANS})
    append = Recorder.append

    def append_and_copy(self: Recorder, row: dict[str, Any]) -> None:
        append(self, row)
        if row["update"] == 7:
            copy_run(tmp_path / "whole", tmp_path / "stopped")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Recorder, "append", append_and_copy)
        train(matching(), config, tmp_path / "whole", "none")
    assert len(read_lines(tmp_path / "stopped" / "metrics.jsonl")) == 7
    resume(matching(), tmp_path / "stopped", "none")
    assert_same_end(tmp_path / "stopped", tmp_path / "whole")
    assert json.loads((tmp_path / "whole" / "manifest.json").read_text())["config"]["team_kl"] == [1.5, 0.5]


def test_presets_have_the_released_configuration() -> None:
    """`irat_base.yaml` of SocialJax 9df972d."""
    for name, width, team_reward in (("paper", 64, "mean"), ("released", 16, "sum")):
        config = load_preset(name, IRAT, "clean_up").config
        assert isinstance(config, PPOConfig)
        assert (config.reward, config.team_reward, config.network_width) == ("individual", team_reward, width)
        assert (config.num_envs, config.num_steps, config.num_epochs, config.num_minibatches) == (5, 100, 2, 4)
        assert (config.learning_rate, config.anneal_learning_rate, config.total_timesteps) == (5e-4, True, 3e8)
        assert (config.gamma, config.gae_lambda, config.clip_epsilon, config.scale_clip_epsilon) == (0.99, 0.95, 0.2, True)
        assert (config.entropy_coefficient, config.value_coefficient, config.max_gradient_norm, config.seed) == (0.01, 0.5, 0.5, 30)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"team_kl": "1,2,3"}, "`team_kl` must be one number, or two: at the start and at the end of the run, not '1,2,3'"),
        ({"similarity_clip": "-1,2"}, "`similarity_clip` must be at least 0.0"),
        ({"individual_kl": "a"}, "`individual_kl` must be a finite number, not 'a'"),
    ],
)
def test_wrong_spans_are_explained(given: dict[str, Any], message: str) -> None:
    with pytest.raises(sjdsl.trainers.ConfigError, match=message):
        make_config(given, **IRAT)
    assert make_config(algorithm="irat", team_kl=2).team_kl == (2.0, 2.0)
