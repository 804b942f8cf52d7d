"""The scripts in `examples/` run as they are, and what they return is a number of the games."""

import math
import runpy
from pathlib import Path

import pytest

# Tested in tests/trainers and tests/models (a reward and a policy have no `main`), and in
# test_sweep_clusters.py.
ELSEWHERE = ("giver_credit", "ppo_single_file", "sweep_ray", "sweep_slurm", "text_player")
EXAMPLES = sorted(
    path
    for path in (Path(__file__).parents[2] / "examples").glob("*.py")
    if path.stem not in ELSEWHERE
)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_it_runs(path: Path) -> None:
    result = runpy.run_path(str(path))["main"]()
    assert math.isfinite(result)


def test_every_adapter_has_one() -> None:
    adapters = {"jaxmarl", "socialjax", "pettingzoo", "gymnasium", "stable_baselines3", "dm_env"}
    assert {
        adapter for adapter in adapters for path in EXAMPLES if path.stem.startswith(adapter)
    } == adapters
    docs = Path(__file__).parents[2] / "docs/interop"
    assert {path.stem for path in docs.glob("*.md")} >= adapters
