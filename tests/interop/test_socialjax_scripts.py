"""The released suite's families of scripts: their calls on our games; the scripts themselves where SOCIALJAX=CHECKOUT names a copy."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.interop import socialjax
from sjdsl.interop.socialjax_table import entries
from sjdsl.library.games_folder import games_folder
from tests.interop.socialjax_client import FAMILIES, GAMES, train

HERE = Path(__file__).parent
CHECKOUT = os.environ.get("SOCIALJAX")
TINY = {"NUM_ENVS": 2, "NUM_STEPS": 8, "SEED": 30}
STEPS = 8  # of an episode: each update sees one end
# what makes the suite's configurations tiny; `++` sets a key whether or not a configuration has it
SMALL = {
    **TINY,
    "TOTAL_TIMESTEPS": 32,
    "NUM_MINIBATCHES": 2,
    "UPDATE_EPOCHS": 1,
    "BUFFER_SIZE": 64,
    "BUFFER_BATCH_SIZE": 4,
    "LEARNING_STARTS": 0,
    "NUM_EPOCHS": 1,
    "TEST_INTERVAL": 0.5,
    "TEST_NUM_STEPS": 8,
    "TEST_NUM_ENVS": 2,
}
ALWAYS = {
    "NUM_SEEDS": 1,
    "GIF_NUM_FRAMES": 2,
    "WANDB_MODE": "offline",
    "TUNE": False,
    "HYP_TUNE": False,
    "ENV_KWARGS.num_inner_steps": STEPS,
}


def keywords(game: str, **more: Any) -> dict[str, Any]:
    """Returns the keywords of `make` in the IPPO configuration of a game."""
    asked = GAMES[game]
    given = {**asked["kwargs"], **more, "num_inner_steps": STEPS, "cnn": True, "jit": True}
    if "map" in asked:
        letters = {ours: theirs for theirs, ours in entries()[asked["id"]].letters.items()}
        rows = (games_folder() / "maps" / f"{asked['map']}.txt").read_text().splitlines()
        given["map_ASCII"] = ["".join(letters[letter] for letter in row) for row in rows]
    return given


def assert_learnt(metrics: list[dict[str, float]], names: list[str]) -> None:
    assert len(metrics) == 2
    for metric in metrics:
        assert set(names) <= set(metric)
        assert all(math.isfinite(value) for value in metric.values())


@pytest.mark.parametrize("family", FAMILIES)
def test_the_calls_of_each_family(family: str) -> None:
    kwargs = {**FAMILIES[family]["kwargs"], "num_inner_steps": STEPS, "cnn": True, "jit": True, "regrow_rate": 0.2}
    metrics = train(family, socialjax, socialjax, {"ENV_NAME": "coin_game", "ENV_KWARGS": kwargs, **TINY})
    assert_learnt(metrics, [*FAMILIES[family]["infos"], *GAMES["coins"]["figures"]])
    assert [metric["ends"] for metric in metrics] == [pytest.approx(1 / STEPS)] * 2
    scale = 1 if kwargs["shared_rewards"] else 2
    assert metrics[0]["original_rewards"] != 0 or metrics[1]["original_rewards"] != 0
    if family in ("IPPO", "MAPPO", "VDN"):  # everybody is paid the sum, VDN's target has it once for each of the two
        paid = metrics[0]["shaped_rewards"]
        assert paid == pytest.approx(2 * metrics[0]["original_rewards"], abs=1e-6)
        assert metrics[0]["reward"] == pytest.approx(2 * paid if family == "VDN" else paid, abs=1e-6)
    else:
        assert scale == 2 and metrics[0]["reward"] == pytest.approx(metrics[0]["shaped_rewards"])


@pytest.mark.parametrize("game", [game for game in GAMES if game != "coins"])
def test_the_calls_of_ippo_in_each_game(game: str) -> None:
    sharing = not GAMES[game]["kwargs"]["shared_rewards"]
    config = {"ENV_NAME": GAMES[game]["id"], "ENV_KWARGS": keywords(game), **TINY}
    metrics = train("IPPO", socialjax, socialjax, config, sharing, shown=False)
    assert_learnt(metrics, [*FAMILIES["IPPO"]["infos"], *GAMES[game]["figures"]])


def test_managers_are_the_environment_in_another_form() -> None:
    """Observations, rewards and ends by agent, each against the environment's own step under the same keys."""
    env = socialjax.make("coin_game", shared_rewards=False, regrow_rate=0.5, num_inner_steps=4)
    plain = socialjax.CTRolloutManager(env, 3, training_agents=[1], preprocess_obs=False)
    vectors = socialjax.CTRolloutManager(env, 3)
    reset, step = jax.random.key(0), jax.random.key(1)
    seen, states = plain.batch_reset(reset)
    flat, _ = vectors.batch_reset(reset)
    size = 11 * 11 * 14
    assert (vectors.obs_size, plain.obs_size, plain.max_action_space) == (size + 2, size, 7)
    actions = {"0": jnp.array([2, 3, 4]), "1": jnp.array([5, 2, 3])}
    after, _, reward, done, _ = plain.batch_step(step, states, actions)
    numbered = {0: actions["0"], 1: actions["1"]}
    np.testing.assert_array_equal(plain.batch_step(step, states, numbered)[2]["0"], reward["0"])
    for number, (first, then) in enumerate(zip(jax.random.split(reset, 3), jax.random.split(step, 3), strict=True)):
        observation, state = env.reset(first)
        np.testing.assert_array_equal(seen["1"][number], observation[1])
        np.testing.assert_array_equal(flat["1"][number], [*np.ravel(observation[1]), 0, 1])
        np.testing.assert_array_equal(seen["__all__"][number], np.ravel(observation))
        last, _, paid, over, _ = env.step(then, state, [actions["0"][number], actions["1"][number]])
        np.testing.assert_array_equal(after["0"][number], last[0])
        assert [reward["0"][number], reward["1"][number], reward["__all__"][number]] == [paid[0], paid[1], paid[1]]
        assert bool(done["__all__"][number]) == bool(over["__all__"])
    assert (np.asarray(reward["0"]) != 0).any() and (np.asarray(reward["1"]) != 0).any()
    assert plain.get_valid_actions(states)["0"].shape == (3, 7)
    sampled = np.concatenate([plain.batch_sample(key, 1) for key in jax.random.split(reset, 100)])
    assert set(sampled.tolist()) == set(range(7))


def test_world_states_and_files_of_parameters(tmp_path: Path) -> None:
    env = socialjax.make("coin_game")
    observation, state = socialjax.MAPPOWorldStateWrapper(env).reset(jax.random.key(2))
    np.testing.assert_array_equal(socialjax.MAPPOWorldStateWrapper(env).world_state(observation, state), observation)
    params = {"params": {"Dense_0": {"kernel": jnp.arange(6.0).reshape(2, 3)}}}
    socialjax.save_params(params, tmp_path / "new" / "policy.safetensors")
    read = socialjax.load_params(tmp_path / "new" / "policy.safetensors")
    np.testing.assert_array_equal(read["params"]["Dense_0"]["kernel"], params["params"]["Dense_0"]["kernel"])


def test_where_agents_are_by_the_suites_count() -> None:
    """Its `up` is a larger row; an agent that turns left and moves counts as there."""
    env = socialjax.make("coin_game")
    _, state = env.reset(jax.random.key(3))
    row, col, heading = state.agent_locs[0].tolist()
    assert state.agent_locs[:, :2].T.tolist() == [cells.tolist() for cells in env.env.cells(state.game)]
    facing = {0: (1, 0), 1: (0, 1), 2: (-1, 0), 3: (0, -1)}[heading]  # the suite's table of steps
    ours = {0: (-1, 0), 1: (0, 1), 2: (1, 0), 3: (0, -1)}[int(state.game.heading[0])]
    assert facing == ours
    for action, (down, right) in {2: (0, 1), 3: (0, -1), 4: (1, 0), 5: (-1, 0)}.items():
        _, after, *_ = env.step(jax.random.key(4), state, [action, 6])
        there = [min(max(row + down, 0), 15), min(max(col + right, 0), 10), heading]
        assert after.agent_locs[0].tolist() == there or there[:2] == state.agent_locs[1, :2].tolist()


def run_script(tree: Path, folder: Path, family: str, env: str) -> list[dict[str, float]]:
    """Runs a script of a checkout in a folder for two tiny updates; returns what it logged last of each.

    `wandb` is the recorder in `stand_ins/`; the other packages that the suite's scripts import are installed by who runs this.
    """
    asked = FAMILIES[family]
    within = f"{asked['section']}." if "section" in asked else ""
    overrides = {f"{within}{name}": value for name, value in SMALL.items() if name != "SEED"} | {"SEED": TINY["SEED"]} | ALWAYS
    script, choice = tree / "algorithms/train.py", ["--algo", family, "--env", env]
    if not script.is_file():  # older checkouts have a script for each game
        script, choice = tree / f"algorithms/{family}/{asked['prefix']}_cnn_{env}.py", []
    choice += ["hydra.run.dir=outputs"]
    log = folder / "logged.jsonl"
    (folder / "checkpoints/individual").mkdir(parents=True, exist_ok=True)
    (folder / "checkpoints/indvidual").mkdir(exist_ok=True)  # as the suite's scripts spell it
    paths = [str(HERE / "stand_ins"), str(HERE.parents[1]), os.environ.get("PYTHONPATH", "")]
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "sjdsl.interop",
            str(script.resolve()),
            *choice,
            *(f"++{name}={value}" for name, value in overrides.items()),
        ],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(paths), "WANDB_LOG": str(log), "MPLBACKEND": "agg"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-6000:]
    lines = [line for line in map(json.loads, log.read_text().splitlines()) if set(line) - {"Episode GIF"}]
    updates = {line.get("update_step", line.get("update_steps", number)): line for number, line in enumerate(lines)}  # gift's logs twice
    return list(updates.values())


SCRIPTS = [(family, "coins") for family in FAMILIES] + [("IPPO", game) for game in GAMES if game != "coins"]


@pytest.mark.skipif(CHECKOUT is None, reason="SOCIALJAX names no checkout of the suite")
@pytest.mark.parametrize(("family", "game"), SCRIPTS)
def test_the_suites_own_scripts(tmp_path: Path, family: str, game: str) -> None:
    metrics = run_script(Path(str(CHECKOUT)), tmp_path, family, game)
    assert_learnt(metrics, [*FAMILIES[family]["infos"], *GAMES[game]["figures"]])


def test_a_script_laid_out_like_the_suites(tmp_path: Path) -> None:
    """The same run of a checkout of our own writing: a script with Hydra configurations that says `import socialjax`."""
    metrics = run_script(HERE / "stand_ins/checkout", tmp_path, "VDN", "coins")
    assert_learnt(metrics, [*FAMILIES["VDN"]["infos"], *GAMES["coins"]["figures"]])
