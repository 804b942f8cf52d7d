"""Environments split over devices: each device draws its own actions, and what cannot be split is refused."""

import os
import re
import subprocess
import sys
from pathlib import Path

import jax
import pytest

from sjdsl.bench.loop import make_loop, yardstick_task

SUMS = """
import jax, jax.numpy as jnp
jax.config.update("jax_num_cpu_devices", 2)
from sjdsl.bench import Task
from sjdsl.bench.devices import on_devices
from sjdsl.bench.loop import make_loop

def count(state, actions, key):
    return state + 1, state.astype(jnp.float32), state

loop = make_loop(Task("count", 2, 3, lambda: jnp.zeros(2, jnp.int32), count), num_envs=6, num_steps=4, devices=2)
compiled = jax.jit(loop).lower(jax.random.key(0)).compile()
drawn = on_devices(lambda key: jax.random.uniform(key, ()), 2)
key = jax.random.key(5)
own = [float(jax.random.uniform(jax.random.fold_in(key, device), ())) for device in (0, 1)]
print(float(compiled(jax.random.key(1))), float(drawn(key)), sum(own), own[0] != own[1])
"""


def run_alone(arguments: list[str], folder: Path, **more: str) -> subprocess.CompletedProcess[str]:
    """Runs Python anew: JAX divides the CPU before its first computation alone."""
    alone = {
        name: value
        for name, value in os.environ.items()
        if name not in ("XLA_FLAGS", "JAX_NUM_CPU_DEVICES")
    }
    alone |= {"PYTHONPATH": str(Path(__file__).parents[2]), **more}
    return subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        env=alone,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.thorough
def test_each_device_plays_its_share_with_a_key_of_its_own(tmp_path: Path) -> None:
    """Six environments of two agents: rewards 0 + 1 + 2 + 3 each, and 3 as the last observation, once for all steps."""
    ended = run_alone(["-c", SUMS], tmp_path)
    assert ended.returncode == 0, ended.stderr
    played, drawn, expected, differ = ended.stdout.split()
    assert float(played) == 6 * 2 * (0 + 1 + 2 + 3) + 6 * 2 * 3
    assert float(drawn) == pytest.approx(float(expected), abs=1e-6)
    assert differ == "True"


@pytest.mark.thorough
def test_the_example_of_the_page_of_speeds_runs(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "performance.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    shown = "print(rewards.shape, len(rewards.sharding.device_set), bool((rewards.sum((1, 2)) > 0).any()))"
    ended = run_alone(["-c", f"{example}\n{shown}"], tmp_path)
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.strip() == "(1024, 100, 6) 2 True"


@pytest.mark.parametrize(
    ("num_envs", "said"),
    [
        (3, "3 environments can't be split evenly over 2 devices"),
        (4, "Number of devices 1 must be"),
    ],
)
def test_what_cannot_be_split_is_refused(num_envs: int, said: str) -> None:
    """This process has one device, as JAX has begun with one."""
    assert len(jax.devices()) == 1
    with pytest.raises(ValueError, match=said):
        make_loop(yardstick_task(), num_envs, 1, devices=2)
