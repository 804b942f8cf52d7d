"""Configurations: wrong ones are refused in the user's words, right ones never change."""

from pathlib import Path

import pytest
from probes import QUICK, constant
from pydantic import ValidationError

from sjdsl.trainers import Config, ConfigError, load_preset, make_train


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
        ({"reward": "shared"}, "`reward` must be 'individual' or 'common', not 'shared'"),
    ],
)
def test_wrong_values_are_explained(values: dict[str, object], message: str) -> None:
    with pytest.raises(ConfigError) as error:
        Config(**values)
    assert message in str(error.value)


def test_all_faults_are_told_at_once() -> None:
    with pytest.raises(ConfigError) as error:
        Config(gama=0.9, num_envs=-1)
    assert len(str(error.value).splitlines()) == 2


def test_numbers_may_come_as_text() -> None:
    config = Config(total_timesteps="1e6", learning_rate="3e-4", anneal_learning_rate="false")
    assert (config.total_timesteps, config.learning_rate, config.anneal_learning_rate) == (1_000_000, 3e-4, False)


def test_a_config_is_frozen() -> None:
    config = Config()
    before = config.model_dump()
    with pytest.raises(ValidationError):
        config.seed = 1  # type: ignore[misc]
    make_train(constant(1.0), config)
    assert config.model_dump() == before


def test_the_last_update_is_whole() -> None:
    assert Config(num_envs=4, num_steps=8, total_timesteps=65).num_updates == 3


def test_samples_must_divide_into_minibatches() -> None:
    with pytest.raises(ConfigError, match="16 x 16 x 1 = 256 samples cannot be split into num_minibatches = 3"):
        make_train(constant(1.0), Config(**{**QUICK, "num_minibatches": 3}))


def test_a_packaged_preset_and_changes() -> None:
    quick = load_preset("quick", {"seed": 7, "num_envs": "32"})
    assert quick.game == "coins"
    assert (quick.config.seed, quick.config.num_envs, quick.config.reward) == (7, 32, "common")
    with pytest.raises(ConfigError, match="did you mean `learning_rate`"):
        load_preset("quick", {"learning_rates": 1})


def test_a_preset_in_a_file(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('game = "harvest"\n[environment]\nnum_agents = 3\n[config]\ntotal_timesteps = 1e5\n')
    mine = load_preset(path)
    assert (mine.game, mine.environment, mine.config) == ("harvest", {"num_agents": 3}, Config(total_timesteps=100_000))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('game = "a"\n[confg]\n', r"mine\.toml: unknown key `confg`; did you mean `config`"),
        ("game = 3\n", "`game` must be text, not 3"),
        ('game = "a"\nconfig = 3\n', "`config` must be a table, not 3"),
        ("[config]\nseed = 1\n", "no game is named"),
        ("game = \n", r"mine\.toml: "),
    ],
)
def test_wrong_preset_files_are_explained(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "mine.toml").write_text(text)
    with pytest.raises(ConfigError, match=message):
        load_preset(tmp_path / "mine.toml")


@pytest.mark.parametrize(
    ("name", "message"),
    [("quik", "unknown preset `quik`; did you mean `quick`"), ("none.toml", r"none\.toml does not exist")],
)
def test_missing_presets_are_explained(name: str, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        load_preset(name)
