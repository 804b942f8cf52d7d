"""Configurations: wrong ones are refused in the user's words, right ones never change."""

import pytest
from probes import constant
from pydantic import ValidationError

from sjdsl.trainers import ConfigError, PPOConfig, VDNConfig, load_preset, make_config, make_train
from sjdsl.trainers.settings.config import KEYS_OF
from sjdsl.trainers.settings.config_errors import SYNONYMS


def test_numbers_may_come_as_text() -> None:
    config = make_config(total_timesteps="1e6", learning_rate="3e-4", anneal_learning_rate="false")
    assert (config.total_timesteps, config.learning_rate, config.anneal_learning_rate) == (
        1_000_000,
        3e-4,
        False,
    )


@pytest.mark.parametrize(
    ("key", "algorithm", "meant"),
    [
        ("lr", "ippo", "learning_rate"),
        ("ent_coef", "mappo", "entropy_coefficient"),
        ("n_envs", "ippo", "num_envs"),
        ("n_steps", "ippo", "num_steps"),
        ("rollout_length", "vdn", "num_steps"),
        ("update_epochs", "ippo", "num_epochs"),
        ("max_grad_norm", "ippo", "max_gradient_norm"),
        ("vf_coef", "ippo", "value_coefficient"),
        ("gae", "ippo", "gae_lambda"),
        ("tau", "vdn", "target_rate"),
    ],
)
def test_names_of_other_libraries_are_understood(key: str, algorithm: str, meant: str) -> None:
    with pytest.raises(ConfigError) as error:
        make_config({key: 1}, algorithm=algorithm)
    assert str(error.value) == f"unknown key `{key}`; did you mean `{meant}`?"


def test_a_key_of_another_algorithm_leads_to_that_of_this_one() -> None:
    with pytest.raises(ConfigError, match="it is one of vdn; did you mean `num_minibatches`"):
        make_config(batch_size=64)
    assert make_config(algorithm="vdn", batch_size=64).batch_size == 64


def test_a_key_like_no_other_leads_to_the_list() -> None:
    with pytest.raises(ConfigError, match=r"^unknown key `zzz`; `sjdsl train --keys` lists"):
        make_config(zzz=1)


def test_the_names_of_other_libraries_are_for_settings() -> None:
    assert SYNONYMS.keys() <= {key for keys in KEYS_OF.values() for key in keys}


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
