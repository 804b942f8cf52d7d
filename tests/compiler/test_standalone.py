"""A game in one file: no module of sjdsl or flax is needed, and it plays as the environment does."""

import ast
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import sjdsl
from sjdsl.cli import run
from sjdsl.library.games_folder import main_games

STEPS = 6
USUAL = ("coins",)  # the others only with all tests
HIDDEN = (
    "import sys; sys.modules.update(dict.fromkeys(('sjdsl', 'flax', 'lark', 'pydantic', 'jinja2')))"
)


def written(game: str, folder: Path) -> Path:
    path = folder / f"{game}_standalone.py"
    assert run(["compile", "--standalone", game, "-o", str(path)]) == 0
    return path


def loaded(path: Path) -> ModuleType:
    module = ModuleType(path.stem)
    sys.modules[path.stem] = module  # as dataclasses want it
    exec(compile(path.read_text(), str(path), "exec"), module.__dict__)
    return module


def trajectory(env: Any, state: Any, actions: list[list[int]]) -> list[Any]:
    seen = []
    for number, chosen in enumerate(actions):
        observation, state, reward, done, info = env.step(
            jax.random.key(number), state, jnp.asarray(chosen)
        )
        kept = {
            name: info[name]
            for name in ("truncated", "terminated", "events", "metrics", "terminal_observation")
        }
        seen.append((observation, vars(state), reward, done, kept, env.allowed_actions(state)))
    return jax.tree.map(np.asarray, seen)


@pytest.mark.parametrize(
    "game",
    [
        name if name in USUAL else pytest.param(name, marks=pytest.mark.slow)
        for name in main_games()
    ],
)
@pytest.mark.parametrize("observation", ["tokens", pytest.param("onehot", marks=pytest.mark.slow)])
def test_it_plays_as_the_environment_does(game: str, observation: str, tmp_path: Path) -> None:
    """Also across the end of an episode: it begins shortly before it."""
    env = sjdsl.make(game, observation=observation)
    alone = loaded(written(game, tmp_path)).Environment(observation)
    assert (alone.name, alone.num_agents, alone.action_names) == (
        env.name,
        env.num_agents,
        env.action_names,
    )
    assert (alone.observation_shape, alone.episode_length) == (
        env.observation_shape,
        env.episode_length,
    )
    assert alone.channel_names == env.channel_names
    key = jax.random.key(7)
    (mine, state), (theirs, other) = alone.reset(key), env.reset(key)
    np.testing.assert_array_equal(mine, theirs)
    late = env.episode_length - STEPS // 2
    state, other = state.replace(step=state.step + late), other.replace(step=other.step + late)
    actions = [
        [(5 * t + agent * (t + 1)) % env.num_actions for agent in range(env.num_agents)]
        for t in range(STEPS)
    ]
    first, second = trajectory(alone, state, actions), trajectory(env, other, actions)
    assert sum(bool(step[3]) for step in first) == 1
    for (path, a), (_, b) in zip(
        *(jax.tree_util.tree_leaves_with_path(x) for x in (first, second)), strict=True
    ):
        assert a.dtype == b.dtype, path
        np.testing.assert_allclose(a, b, rtol=1e-6, err_msg=jax.tree_util.keystr(path))


def test_it_needs_jax_and_numpy_alone(tmp_path: Path) -> None:
    path = written("clean_up", tmp_path)
    found = {
        n.module if isinstance(n, ast.ImportFrom) else n.names[0].name
        for n in ast.walk(ast.parse(path.read_text()))
        if isinstance(n, ast.Import | ast.ImportFrom)
    }
    assert {name.split(".")[0] for name in found} <= {
        "jax",
        "numpy",
        "dataclasses",
        "types",
        "typing",
        "collections",
        "functools",
        "math",
        "operator",
    }
    use = f"{HIDDEN}\nimport jax, clean_up_standalone as game\nenv = game.Environment()\n"
    use += "observation, state = jax.jit(jax.vmap(env.reset))(jax.random.split(jax.random.key(0), 3))\nprint(observation.shape)"
    done = subprocess.run(
        [sys.executable, "-c", use], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "(3, 7, 3, 11, 11)"


def test_a_wrong_observation_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="observation is `tokens` or `onehot`, not 'rgb'"):
        loaded(written("coins", tmp_path)).Environment("rgb")


def test_on_the_command_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["compile", "--standalone", "clean_up", "--variant", "socialjax"]) == 0
    assert "clean_up_socialjax_standalone.py  " in capsys.readouterr().out
    assert (tmp_path / "clean_up_socialjax_standalone.py").exists()
    assert run(["compile", "--standalone", "--check", "coins"]) == 2
    assert "leave out --standalone" in capsys.readouterr().err
