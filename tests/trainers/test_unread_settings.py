"""A setting that was asked for and that nothing reads is refused, with the setting that would have it read."""

import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any, get_args

import jax
import numpy as np
import pytest
from probes import constant, quick

from sjdsl.trainers import (
    Config,
    ConfigError,
    PPOConfig,
    RunError,
    load_preset,
    make_config,
    make_train,
    register,
    resume,
)
from sjdsl.trainers.algorithms.shaping import make_shaping
from sjdsl.trainers.json_files import write_json
from sjdsl.trainers.runs.manifest import MANIFEST
from sjdsl.trainers.runs.run_folder import describe_run
from sjdsl.trainers.settings.config import dependent_settings
from sjdsl.trainers.settings.extensions import RewardMode


def test_what_nothing_reads_is_refused_however_it_is_set() -> None:
    """Also at its default, as it was asked for; more of what is refused is in `tests/cli/refused.txt`."""
    for make in (
        make_config,
        lambda values: PPOConfig(**values),
        lambda values: load_preset("two_cores", values),
    ):
        with pytest.raises(
            ConfigError, match="`exchange_ratio` has no effect while `reward` is individual"
        ):
            make({"exchange_ratio": 0.5})


def test_rewards_of_ones_own_read_the_smoothing_and_no_angle() -> None:
    register("reward", "kind", lambda step: step.trace)
    assert make_config(reward="kind", reward_smoothing=0.5)
    with pytest.raises(ConfigError, match="`svo_angle` has no effect while `reward` is kind"):
        make_config(reward="kind", svo_angle=45)
    with pytest.raises(ConfigError, match="`match_socialjax` has no effect while `reward` is kind"):
        make_config(reward="kind", match_socialjax=True)


def test_a_run_is_not_gone_on_with_by_what_nothing_reads(tmp_path: Path) -> None:
    env = constant(1.0)
    manifest = describe_run(env, quick(), {})
    manifest["config"]["exchange_ratio"] = 0.9
    write_json(tmp_path / MANIFEST, manifest)
    with pytest.raises(
        RunError,
        match="`exchange_ratio` has no effect while `reward` is individual: set `reward` to exchange",
    ):
        resume(env, tmp_path)


# The declaration is what the program does: what is said not to be read leaves the program of a run as it is, letter by letter, and what
# is said to be read changes it.

OTHERS: dict[str, Any] = {
    "loss": "none",
    "svo_angle": (20.0,),
    "common_reward": "mean",
    "svo_at_rest": "content",
    "convolution_sides": (3,),
    "critic": "state",
    "reward_horizons": (5.0,),
}


def other(config: Config, name: str) -> Any:
    """Returns another value of a setting than its default."""
    if name in OTHERS:
        return OTHERS[name]
    value = type(config).model_fields[name].default
    return (
        not value
        if isinstance(value, bool)
        else value // 2
        if isinstance(value, int)
        else value / 2 + 0.125
    )


def text_of(traced: Any) -> str:
    """Returns a traced program with its constants."""
    return re.sub(
        "0x[0-9a-f]+", "", f"{traced} {[np.asarray(constant) for constant in traced.consts]}"
    )


@pytest.mark.parametrize("algorithm", ["ippo", "vdn"])
@pytest.mark.parametrize("reward", get_args(RewardMode))
def test_rewards_read_what_they_are_said_to(algorithm: str, reward: str) -> None:
    if algorithm == "vdn" and reward != "common":
        return

    def program(config: Config) -> str:
        shaping = make_shaping(config, 2)
        traced = jax.make_jaxpr(
            lambda reward, trace: shaping.shape(SimpleNamespace(reward=reward, trace=trace))
        )(np.ones(2), np.ones(2))
        return text_of(traced) + (str(shaping.smoothing) if reward in ("svo", "inequity") else "")

    config = make_config(algorithm=algorithm, reward=reward)
    for name, mark in dependent_settings(type(config)).items():
        if mark.setting == "reward":
            changed = program(config.model_copy(update={name: other(config, name)})) != program(
                config
            )
            assert changed == (name not in config.unread), name
    scaled = program(config.model_copy(update={"match_socialjax": True})) != program(config)
    assert scaled == ("match_socialjax" not in config.unread)


@pytest.mark.thorough
@pytest.mark.parametrize(("algorithm", "network"), [("ippo", "cnn"), ("mappo", "mlp")])
def test_programs_read_what_they_are_said_to(algorithm: str, network: str) -> None:
    def program(config: Config) -> str:
        run = make_train(constant(1.0), config)
        return text_of(jax.make_jaxpr(run.update)(jax.eval_shape(run.init, jax.random.key(0))))

    register(
        "loss",
        "none",
        lambda parameters, *_: (sum(leaf.sum() for leaf in jax.tree.leaves(parameters)), {}),
    )
    config = quick(algorithm=algorithm, network=network)
    before = program(config)
    for name, mark in dependent_settings(type(config)).items():
        if mark.setting in ("algorithm", "critic", "network"):
            changed = program(config.model_copy(update={name: other(config, name)})) != before
            assert changed == (name not in config.unread), name
