"""Configurations: wrong ones are refused in the user's words, right ones never change."""

import pytest
from probes import constant
from pydantic import ValidationError

from sjdsl.trainers import PPOConfig, VDNConfig, load_preset, make_config, make_train


def test_numbers_may_come_as_text() -> None:
    config = make_config(total_timesteps="1e6", learning_rate="3e-4", anneal_learning_rate="false")
    assert (config.total_timesteps, config.learning_rate, config.anneal_learning_rate) == (
        1_000_000,
        3e-4,
        False,
    )


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
    assert make_config(reward="svo", svo_angle="45, 90").svo_angle == (45.0, 90.0)
    assert make_config(reward="svo", svo_angle=45).svo_angle == (45.0,)


def test_the_algorithm_decides_which_keys_there_are() -> None:
    kinds = {
        algorithm: type(make_config(algorithm=algorithm)) for algorithm in ("ippo", "mappo", "vdn")
    }
    assert kinds == {"ippo": PPOConfig, "mappo": PPOConfig, "vdn": VDNConfig}
    assert make_config().algorithm == "ippo"


def test_seeds_are_numbered_from_the_first() -> None:
    assert make_config(seed=3, seeds=4).seed_numbers == (3, 4, 5, 6)


def test_agents_learn_from_their_own_reward_unless_asked_otherwise() -> None:
    assert [make_config(algorithm=name).reward for name in ("ippo", "mappo", "vdn")] == [
        "individual",
        "individual",
        "common",
    ]
    assert [
        load_preset("two_cores", {"algorithm": name}).config.reward for name in ("ippo", "vdn")
    ] == ["individual", "common"]
    assert load_preset("paper", {}, "coins").config.reward == "common", (
        "as in the released configurations"
    )
