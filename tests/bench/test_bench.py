"""Benchmarks: what is measured and reported; how fast it is, is not tested."""

import json
import shutil
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import pytest
from jax import Array
from jax.experimental.compilation_cache import compilation_cache

from sjdsl.bench import Report, Task, game_task, measure
from sjdsl.bench.loop import make_loop
from sjdsl.cli import run
from sjdsl.runtime.env import Environment


def _count(state: Array, actions: Array, key: Array) -> tuple[Array, Array, Array]:
    del key
    return state + actions, state.astype(jnp.float32), state


@pytest.fixture(scope="module", autouse=True)
def _small_yardstick() -> Iterator[None]:
    """The true one takes seconds to compile."""
    small = Task("yardstick", 2, 3, lambda: jnp.zeros(2, jnp.int32), _count)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sjdsl.bench.timing.yardstick_task", lambda: small)
        yield


@pytest.fixture
def folder(meadow: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An own folder to be in, with the game."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(meadow, "meadow.sj")


@pytest.fixture(scope="module")
def report(meadow_env: Environment) -> Report:
    return measure([game_task(meadow_env)], (1, 3), repeats=3, steps=lambda _: 2)


def test_each_task_is_measured_at_each_number_of_environments(report: Report) -> None:
    measured = [(speed.name, speed.num_envs) for speed in report.speeds]
    assert measured == [("yardstick", 1), ("meadow", 1), ("yardstick", 3), ("meadow", 3)]


def test_figures_agree_with_one_another(report: Report) -> None:
    for speed in report.speeds:
        assert 0 < speed.slowest <= speed.env_steps_per_s <= speed.fastest
        assert speed.ratio > 0
        assert speed.loop_compile_s > 0
        assert speed.env_steps_per_processor_s is not None
        assert speed.env_steps_per_processor_s > 0
        assert speed.memory_bytes > 0
        if speed.name == "yardstick":
            assert speed.ratio == 1


def test_the_report_can_be_stored(report: Report) -> None:
    stored = json.loads(json.dumps(asdict(report)))
    assert stored["machine"]["jax"] == jax.__version__
    assert len(stored["speeds"]) == 4
    assert stored["compilations"][0]["name"] == "meadow"
    assert stored["compilations"][0]["stablehlo_lines"] > 100
    assert stored["compilations"][0]["operations"]["sort"] == 0
    assert {speed["observation"] for speed in stored["speeds"]} == {"tokens"}


def test_the_loop_adds_all_rewards_and_the_last_observations() -> None:
    """One environment counts its steps and shows the count: of four, with two agents, after n steps."""

    def step(
        count: jax.Array, actions: jax.Array, key: jax.Array
    ) -> tuple[jax.Array, jax.Array, jax.Array]:
        del actions, key
        return count + 1, jnp.full(2, 0.5), jnp.full((2, 1, 3), count + 1, jnp.uint8)

    task = Task("count", 2, 5, lambda: jnp.int32(0), step)
    for steps in (1, 9):
        assert float(make_loop(task, 4, steps)(jax.random.key(0))) == 4 * 2 * (
            0.5 * steps + 3 * steps
        )


def test_episodes_begin_anew_in_the_loop(meadow_env: Environment) -> None:
    """Three cells can be eaten once each in an episode of three steps."""

    def rewards(num_steps: int) -> float:
        return float(make_loop(blind, 4, num_steps)(jax.random.key(0)))

    def unseeing(state: Any, actions: jax.Array, key: jax.Array) -> Any:
        state, reward, _ = game_task(meadow_env).step(state, actions, key)
        return state, reward, jnp.zeros((), jnp.uint8)

    blind = Task(
        "blind",
        meadow_env.num_agents,
        meadow_env.num_actions,
        game_task(meadow_env).reset,
        unseeing,
    )
    assert 0 < rewards(3) < rewards(9) < rewards(18)


@pytest.fixture
def keeping(tmp_path: Path) -> Iterator[Path]:
    """A folder in which JAX keeps every program, and has begun to."""
    names = (
        "jax_compilation_cache_dir",
        "jax_persistent_cache_min_compile_time_secs",
        "jax_enable_compilation_cache",
    )
    before = {name: getattr(jax.config, name) for name in names}
    for name, value in zip(names, (str(tmp_path / "kept"), 0, True), strict=True):
        jax.config.update(name, value)
    compilation_cache.reset_cache()
    jax.jit(lambda x: x + 1)(1.0)
    yield tmp_path / "kept"
    for name, value in before.items():
        jax.config.update(name, value)
    compilation_cache.reset_cache()


@pytest.mark.thorough
@pytest.mark.usefixtures("folder")
def test_the_command_prints_and_stores_a_table_and_keeps_no_program(
    keeping: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What it compiles is neither kept nor found: it measures how long that takes."""
    kept = sorted(keeping.iterdir())
    assert kept
    assert (
        run(
            [
                "bench",
                "meadow.sj",
                "--variant",
                "dry",
                "--envs",
                "2",
                "--steps",
                "2",
                "--repeats",
                "1",
                "--json",
                "out.json",
            ]
        )
        == 0
    )
    shown = capsys.readouterr().out
    for part in ("yardstick", "meadow+dry", "2 envs", "x1.00"):
        assert part in shown
    assert json.loads(Path("out.json").read_text())["repeats"] == 1
    assert sorted(keeping.iterdir()) == kept
