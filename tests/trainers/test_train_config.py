"""Configurations: wrong ones are refused in the user's words, right ones never change."""

from typing import Any

import jax
import pytest
from probes import constant, quick
from pydantic import ValidationError

from sjdsl.trainers import ConfigError, PPOConfig, VDNConfig, load_preset, make_config, make_train


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"learning_rat": 1e-3}, "unknown key `learning_rat`; did you mean `learning_rate`?"),
        ({"NUM_ENVS": 4}, "unknown key `NUM_ENVS`"),
        ({"num_envs": 0}, "`num_envs` must be more than 0, not 0"),
        ({"num_envs": 2.5}, "`num_envs` must be a whole number, not 2.5"),
        ({"seed": "first"}, "`seed` must be a whole number, not 'first'"),
        ({"gamma": 1.5}, "`gamma` must be at most 1.0, not 1.5"),
        ({"gamma": -0.1}, "`gamma` must be at least 0.0, not -0.1"),
        ({"learning_rate": float("inf")}, "`learning_rate` must be a finite number, not inf"),
        ({"anneal_learning_rate": "perhaps"}, "`anneal_learning_rate` must be true or false, not 'perhaps'"),
        (
            {"reward": "shared"},
            "`reward` must be 'individual', 'common', 'svo', 'exchange', 'inequity', the name of a reward that was registered, or FILE.py:NAME, not",
        ),
        ({"exchange_ratio": 1.1}, "`exchange_ratio` must be at most 1.0, not 1.1"),
        ({"svo_angle": 200}, "`svo_angle` must be at most 180.0, not 200"),
        ({"svo_angle": ()}, "`svo_angle` must be one number or more"),
        ({"roles": (0, -1)}, "`roles` must be at least 0, not -1"),
        ({"memory": "lstm"}, "`memory` must be 'none' or 'gru', not 'lstm'"),
        ({"algorithm": "a2c"}, "unknown algorithm 'a2c'; known: ippo, mappo, irat, vdn"),
        ({"algorithm": "vdn", "reward": "svo"}, "`reward` must be 'common', not 'svo'"),
        ({"algorithm": "vdn", "epsilon_fraction": 0}, "`epsilon_fraction` must be more than 0.0, not 0"),
        ({"algorithm": "vdn", "num_epochs": 2}, "`num_epochs`"),
        ({"buffer_size": 2}, "`buffer_size`"),
        ({"convolution_sides": (5, 4)}, "`convolution_sides` must be odd, so that a window has a middle, not 4"),
        ({"convolution_sides": "5,x"}, "`convolution_sides` must be a whole number, not 'x'"),
        ({"convolution_sides": ()}, "`convolution_sides` must be one number or more"),
    ],
)
def test_wrong_values_are_explained(values: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError) as error:
        make_config(values)
    assert message in str(error.value)


def test_all_faults_are_told_at_once() -> None:
    with pytest.raises(ConfigError) as error:
        make_config(gama=0.9, num_envs=-1)
    assert len(str(error.value).splitlines()) == 2


def test_numbers_may_come_as_text() -> None:
    config = make_config(total_timesteps="1e6", learning_rate="3e-4", anneal_learning_rate="false")
    assert (config.total_timesteps, config.learning_rate, config.anneal_learning_rate) == (1_000_000, 3e-4, False)


def test_a_config_is_frozen() -> None:
    config = PPOConfig()
    before = config.model_dump()
    with pytest.raises(ValidationError):
        config.seed = 1  # type: ignore[misc]
    make_train(constant(1.0), config)
    assert config.model_dump() == before


def test_the_last_update_is_whole() -> None:
    assert PPOConfig(num_envs=4, num_steps=8, total_timesteps=65).num_updates == 3


def test_lists_may_come_as_text_or_as_one_number() -> None:
    config = make_config(reward="svo", svo_angle="45, 90", sharing="by_role", roles="0,0,1")
    assert isinstance(config, PPOConfig)
    assert (config.svo_angle, config.roles) == ((45.0, 90.0), (0, 0, 1))
    assert make_config(reward="svo", svo_angle=45).svo_angle == (45.0,)


def test_the_algorithm_decides_which_keys_there_are() -> None:
    kinds = {algorithm: type(make_config(algorithm=algorithm)) for algorithm in ("ippo", "mappo", "irat", "vdn")}
    assert kinds == {"ippo": PPOConfig, "mappo": PPOConfig, "irat": PPOConfig, "vdn": VDNConfig}
    assert make_config().algorithm == "ippo"


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"num_minibatches": 3}, "16 x 16 = 256 steps cannot be split into num_minibatches = 3 equal parts"),
        ({"num_minibatches": 32, "memory": "gru"}, "num_envs = 16 cannot be split into num_minibatches = 32 equal parts"),
    ],
)
def test_a_rollout_must_divide_into_minibatches(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        make_train(constant(1.0), quick(**changes))


def test_seeds_are_numbered_from_the_first() -> None:
    assert make_config(seed=3, seeds=4).seed_numbers == (3, 4, 5, 6)


@pytest.mark.parametrize(
    ("values", "said"), [({"seed": 2**32}, "not 4294967296"), ({"seed": 2**32 - 2, "seeds": 3}, "the last is 4294967296")]
)
def test_seeds_are_numbers_of_32_bits(values: dict[str, int], said: str) -> None:
    """`jax.random.key` takes the lower 32 bits without a word: 2^32 would be seed 0 again."""
    assert (jax.random.key_data(jax.random.key(2**32)) == jax.random.key_data(jax.random.key(0))).all()
    with pytest.raises(ConfigError, match=rf"`seed` must be below 2\^32 = 4294967296.*{said}"):
        make_config(values)
    assert make_config(seed=2**32 - 1).seed_numbers == (2**32 - 1,)


def test_agents_learn_from_their_own_reward_unless_asked_otherwise() -> None:
    assert [make_config(algorithm=name).reward for name in ("ippo", "mappo", "vdn")] == ["individual", "individual", "common"]
    assert [load_preset("two_cores", {"algorithm": name}).config.reward for name in ("ippo", "vdn")] == ["individual", "common"]
    assert load_preset("paper", {}, "coins").config.reward == "common", "as in the released configurations"
