"""Presets: layered tables, and what those of the package say."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jax
import pytest

from sjdsl.trainers import ConfigError, PPOConfig, VDNConfig, load_preset
from sjdsl.trainers.algorithms.minibatches import check_minibatches
from sjdsl.trainers.policies.loading import parameter_shapes
from tests.games.environments import NINE, environment

PPO = tuple(
    (algorithm, reward)
    for algorithm in ("ippo", "mappo")
    for reward in ("individual", "common", "svo", "exchange", "inequity")
)
RUNS = (*PPO, ("vdn", "common"))


def test_a_preset_may_name_a_game(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(
        'extends = "two_cores"\ngame = "coins"\n[environment]\nnum_agents = 3\n'
    )
    preset = load_preset(tmp_path / "mine.toml")
    assert (preset.game, preset.environment, preset.config.total_timesteps) == (
        "coins",
        {"num_agents": 3},
        4_000_000,
    )
    other = load_preset(tmp_path / "mine.toml", game="harvest_open")
    assert (other.game, other.environment, other.config.total_timesteps) == (
        "harvest_open",
        {},
        4_000_000,
    )


def test_a_preset_may_choose_tasks(tmp_path: Path) -> None:
    side = '[environment]\ntasks = "held_out"\nsplit = "late"\nproblem = 3\n'
    (tmp_path / "side.toml").write_text(side)
    chosen = load_preset(tmp_path / "side.toml", game="a")
    assert chosen.environment == {"tasks": "held_out", "split": "late", "problem": 3}
    fields = 'extends = "side.toml"\n[environment]\ntasks = { hue = "red" }\n'
    (tmp_path / "fields.toml").write_text(fields)
    merged = load_preset(tmp_path / "fields.toml", game="a")
    assert merged.environment["tasks"] == {"hue": "red"}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('game = "a"\n[confg]\n', r"mine\.toml: unknown key `confg`; did you mean `config`"),
        ("game = 3\n", "`game` must be text, not 3"),
        ('game = "a"\nconfig = 3\n', "`config` must be a table, not 3"),
        ('only_listed = "yes"\n', "`only_listed` must be true or false, not 'yes'"),
        (
            "[environment]\nagents = 3\n",
            r"mine\.toml: environment: unknown key `agents`; did you mean `num_agents`|the keys are",
        ),
        (
            '[games.coins.environment]\nnum_agents = "3"\n',
            r"mine\.toml: games\.coins\.environment: `num_agents` must be a whole number, not '3'",
        ),
        ("[environment]\ntasks = 3\n", r"environment: `tasks` must be text or a table, not 3"),
        ("[algorithm]\nippo = 3\n", r"mine\.toml: algorithm: `ippo` must be a table, not 3"),
        (
            "[algorithm.ipo]\nseed = 3\n",
            r"mine\.toml: algorithm: unknown key `ipo`; did you mean `ippo`",
        ),
        (
            "[reward.svoo]\nseed = 3\n",
            r"mine\.toml: reward: unknown key `svoo`; did you mean `svo`",
        ),
        (
            "[games.coins.reward.svoo]\nseed = 3\n",
            r"mine\.toml: games\.coins\.reward: unknown key `svoo`",
        ),
        (
            "[algorithm.ippo.reward.comon]\nseed = 3\n",
            r"mine\.toml: algorithm\.ippo\.reward: unknown key `comon`; did you mean `common`",
        ),
        (
            "[algorithm.ippo.reward]\nsvo = 3\n",
            r"mine\.toml: algorithm\.ippo\.reward: `svo` must be a table, not 3",
        ),
        ("[algorithm.ippo.gamma]\nsvo = 3\n", "`gamma`"),
        ("[games]\ncoins = 3\n", r"mine\.toml: games: `coins` must be a table, not 3"),
        (
            "[games.coins]\nconfg = 3\n",
            r"mine\.toml: games\.coins: unknown key `confg`; did you mean `config`",
        ),
        ("[config]\nnum_env = 3\n", "unknown key `num_env`; did you mean `num_envs`"),
        ("game = \n", r"mine\.toml: "),
        ('[config]\nalgorithm = ["ippo"]\n', r"unknown algorithm \['ippo'\]"),
        ('[config]\nreward = ["svo"]\n', r"`reward` must be .*, not \['svo'\]"),
        ("[config]\nnetwork = [[]]\n", r"`network` must be .*, not \[\[\]\]"),
        ("[config]\npartners = [1]\n", "`partners` must be of the form AGENT=POLICY"),
        ("[config]\npartners = 7\n", "`partners` must be of the form AGENT=POLICY"),
        ('[config]\npartners = ["x=random"]\n', "`partners` must be of the form AGENT=POLICY"),
        ('[config]\npartners = [[0.5, "random"]]\n', "`partners` must be of the form AGENT=POLICY"),
        ("[config]\nseed = " + "9" * 5000 + "\n", r"mine\.toml: "),
        ("[config]\nown = " + "[" * 100_000 + "\n", r"mine\.toml: it is nested too deep"),
        ('game = "\xff"\n', r"mine\.toml: .*utf-8"),
        ("#" * 2**21, r"mine\.toml can't be read: it has more than 1,048,576 bytes"),
        ('extends = "../FOLDER/mine.toml"\n', "presets extend each other in a circle"),
        ('extends = "./mine.toml"\n', "presets extend each other in a circle"),
        (
            'extends = "mine.toml"\n',
            r"mine\.toml: presets extend each other in a circle: .*mine\.toml -> .*mine\.toml",
        ),
    ],
)
def test_wrong_preset_files_are_explained(tmp_path: Path, text: str, message: str) -> None:
    text = text.replace("FOLDER", tmp_path.name)
    (tmp_path / "mine.toml").write_bytes(text.encode("latin-1"))
    with pytest.raises(ConfigError, match=message):
        load_preset(tmp_path / "mine.toml")


LAYERS = """
[config]
num_envs = 2
num_steps = 2
num_epochs = 2
gamma = 0.2
gae_lambda = 0.2
clip_epsilon = 0.2
entropy_coefficient = 0.2
[algorithm.mappo]
num_steps = 3
gamma = 0.3
gae_lambda = 0.3
clip_epsilon = 0.3
entropy_coefficient = 0.3
[reward.svo]
gamma = 0.4
gae_lambda = 0.4
clip_epsilon = 0.4
entropy_coefficient = 0.4
[games.coins.config]
num_epochs = 5
gae_lambda = 0.5
clip_epsilon = 0.5
entropy_coefficient = 0.5
[games.coins.algorithm.mappo]
clip_epsilon = 0.6
entropy_coefficient = 0.6
[games.coins.reward.svo]
entropy_coefficient = 0.7
[games.coins.environment]
num_agents = 3
"""


@pytest.mark.parametrize(
    ("game", "changes", "expected"),
    [
        ("coins", {"algorithm": "mappo", "reward": "svo"}, (2, 3, 5, 0.4, 0.5, 0.6, 0.7)),
        (
            "coins",
            {"algorithm": "mappo", "reward": "svo", "gae_lambda": 0.9, "entropy_coefficient": 0.9},
            (2, 3, 5, 0.4, 0.9, 0.6, 0.9),
        ),
        ("coins", {"algorithm": "mappo"}, (2, 3, 5, 0.3, 0.5, 0.6, 0.6)),
        ("coins", {}, (2, 2, 5, 0.2, 0.5, 0.5, 0.5)),
        ("other", {"algorithm": "mappo", "reward": "svo"}, (2, 3, 2, 0.4, 0.4, 0.4, 0.4)),
        ("games/coins.sj", {"reward": "svo"}, (2, 2, 5, 0.4, 0.5, 0.5, 0.7)),
        (None, {}, (2, 2, 2, 0.2, 0.2, 0.2, 0.2)),
    ],
)
def test_later_tables_win(
    tmp_path: Path, game: str | None, changes: dict[str, Any], expected: tuple[float, ...]
) -> None:
    (tmp_path / "mine.toml").write_text(LAYERS)
    preset = load_preset(tmp_path / "mine.toml", changes, game)
    found = preset.config
    assert isinstance(found, PPOConfig)
    figures = (
        found.num_envs,
        found.num_steps,
        found.num_epochs,
        found.gamma,
        found.gae_lambda,
        found.clip_epsilon,
        found.entropy_coefficient,
    )
    assert figures == expected
    assert preset.environment == ({"num_agents": 3} if game and "coins" in game else {})


def test_a_table_of_an_algorithm_with_a_reward_wins_over_both(tmp_path: Path) -> None:
    """Among tables of one game, and of all games; the game's own win over it. The algorithm's table may also choose the reward."""
    (tmp_path / "mine.toml").write_text(
        "[algorithm.ippo]\ngamma = 0.1\n[algorithm.ippo.reward.svo]\ngamma = 0.2\n[reward.svo]\ngamma = 0.3\n"
        "[games.coins.reward.common]\ngamma = 0.4\n[games.coins.algorithm.ippo.reward.svo]\ngamma = 0.5\n"
        '[algorithm.mappo]\nreward = "svo"\n'
    )

    def gamma(game: str, **changes: str) -> float:
        return load_preset(tmp_path / "mine.toml", changes, game).config.gamma

    assert gamma("chicken") == 0.1
    assert gamma("chicken", reward="svo") == 0.2
    assert gamma("chicken", reward="svo", algorithm="mappo") == 0.3
    assert gamma("coins", reward="common") == 0.4
    assert gamma("coins", reward="svo") == 0.5
    assert load_preset(tmp_path / "mine.toml", {"algorithm": "mappo"}).config.reward == "svo"


def test_a_preset_may_extend_another(tmp_path: Path) -> None:
    """Value by value: of the tables that both have, too; the layers are those of the whole."""
    (tmp_path / "under.toml").write_text(LAYERS)
    above = 'extends = "under.toml"\n[config]\nnum_envs = 9\n[games.coins.algorithm.mappo]\nclip_epsilon = 0.9\n[algorithm.mappo]\nentropy_coefficient = 0.9\n'
    (tmp_path / "mine.toml").write_text(above + "[games.coins.environment]\nmap = 'x.txt'\n")
    changes = {"algorithm": "mappo"}
    under, mine = (
        load_preset(tmp_path / name, changes, "coins") for name in ("under.toml", "mine.toml")
    )
    assert mine.config == under.config.model_copy(update={"num_envs": 9, "clip_epsilon": 0.9})
    assert mine.environment == {"num_agents": 3, "map": "x.txt"}


@pytest.mark.parametrize(
    ("line", "game", "kept"),
    [
        ("", "pd_arena", True),
        ("", None, True),
        ('game = "coins"', None, True),
        ('game = "coins"', "pd_arena", False),
    ],
)
def test_the_environment_is_that_of_the_game_named_or_of_any(
    tmp_path: Path, line: str, game: str | None, kept: bool
) -> None:
    (tmp_path / "mine.toml").write_text(f'{line}\n[environment]\nvariant = "socialjax"\n')
    assert load_preset(tmp_path / "mine.toml", game=game).environment == (
        {"variant": "socialjax"} if kept else {}
    )


def test_a_preset_may_choose_the_algorithm_whose_table_is_read(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(
        '[config]\nalgorithm = "vdn"\n[algorithm.vdn]\nbatch_size = 7\n[algorithm.ippo]\nnum_epochs = 9\n'
    )
    chosen, other = (
        load_preset(tmp_path / "mine.toml", changes).config
        for changes in ({}, {"algorithm": "ippo"})
    )
    assert isinstance(chosen, VDNConfig)
    assert isinstance(other, PPOConfig)
    assert (chosen.batch_size, other.num_epochs) == (7, 9)


def test_a_preset_made_for_some_games_refuses_others() -> None:
    with pytest.raises(
        ConfigError,
        match="the preset `paper` has no table for `chicken`; it has coins, harvest_open",
    ):
        load_preset("paper", game="chicken")


@pytest.mark.parametrize("name", ["paper", "released", "two_cores", "overnight", "rl2"])
@pytest.mark.parametrize("game", NINE)
def test_every_algorithm_and_reward_has_a_valid_configuration(name: str, game: str) -> None:
    for algorithm, reward in PPO:
        config = load_preset(name, {"algorithm": algorithm, "reward": reward}, game).config
        assert isinstance(config, PPOConfig)
        assert (config.algorithm, config.reward) == (algorithm, reward)
        check_minibatches(config)
    values = load_preset(name, {"algorithm": "vdn"}, game).config
    assert isinstance(values, VDNConfig)
    if values.replay == "none":
        check_minibatches(values)
        return
    assert values.buffer_size % values.steps_per_update == 0
    assert values.learning_starts <= values.buffer_size


def test_what_presets_resolve_to(golden: Callable[[Path, str], None]) -> None:
    """All settings, so that a changed default shows: what all runs of an algorithm share, then what those of a reward share, then each game's own.

    `paper` and `released` were compared with the configurations of SocialJax 9df972d, of which `paper` has the totals of the paper's table, and
    `released` those of the released code.
    """
    lines = []
    for name in ("paper", "released", "two_cores", "overnight", "rl2"):
        for algorithm in ("ippo", "mappo", "vdn"):
            of_reward = {}
            for reward in (reward for chosen, reward in RUNS if chosen == algorithm):
                changes = {"algorithm": algorithm, "reward": reward}
                configs = {
                    game: load_preset(name, changes, game).config.model_dump() for game in NINE
                }
                of_reward[reward] = {
                    game: {f"{key}={value}" for key, value in config.items()}
                    for game, config in configs.items()
                }
            shared_by_all = set.intersection(
                *(settings for games in of_reward.values() for settings in games.values())
            )
            lines += ["", f"{name}, {algorithm}: {' '.join(sorted(shared_by_all))}"]
            for reward, games in of_reward.items():
                shared = set.intersection(*games.values())
                lines += [f"  {reward}: {' '.join(sorted(shared - shared_by_all))}"]
                lines += [
                    f"    {game}: {' '.join(sorted(own - shared))}"
                    for game, own in games.items()
                    if own - shared
                ]
    golden(Path(__file__).with_name("presets.txt"), "\n".join(lines[1:]) + "\n")


# the released code's


@pytest.mark.parametrize(
    ("algorithm", "game", "channels", "released"),
    [
        ("ippo", "coins", 14, 286_440),
        ("ippo", "clean_up", 19, 290_570),
        ("vdn", "coins", 14, 282_215),
        ("vdn", "clean_up", 19, 286_345),
        ("mappo", "coins", 14, 33_415 + 35_329),
        ("mappo", "clean_up", 19, 34_169 + 50_449),
    ],
)
def test_networks_have_the_released_sizes(
    algorithm: str, game: str, channels: int, released: int
) -> None:
    """Parameters of the released networks, counted by running its code; ours may see another number of channels, and a central critic
    says a value for each agent instead of one."""
    config = load_preset("released", {"algorithm": algorithm}, game).config
    env = environment(game, "socialjax")
    shapes = parameter_shapes(env, config)
    found = sum(math.prod(leaf.shape) for leaf in jax.tree.leaves(shapes))
    more = len(env.channel_names) - channels
    if algorithm == "mappo":
        assert found == released + 9 * 16 * more * (1 + env.num_agents) + 17 * (env.num_agents - 1)
    else:
        assert found == released + 25 * 32 * more
