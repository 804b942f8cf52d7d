"""The presets with stages in `examples/`, and the reward that one of them names."""

from pathlib import Path
from types import SimpleNamespace

import jax.numpy as jnp
import pytest

import sjdsl
from sjdsl.trainers import Stage, check_stages, load_preset
from sjdsl.trainers.settings.extensions import find

ROOT = Path(__file__).parents[2]
PRESETS = sorted(path.name for path in (ROOT / "examples").glob("stages_*.toml"))


@pytest.mark.thorough
@pytest.mark.parametrize("name", PRESETS)
def test_stages_fit_each_other(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    preset = load_preset(f"examples/{name}")
    assert preset.game is not None
    check_stages(
        [
            Stage(sjdsl.make(preset.game, **part.environment), part.config)
            for part in (*preset.earlier, preset)
        ]
    )


def test_a_giver_is_credited_for_what_can_be_refined() -> None:
    """One agent gives raw, one receives it, one gives fine, one collects and gives at once, one consumes."""
    before = [[1, 0, 0], [0, 0, 0], [0, 0, 1], [0, 0, 0], [2, 0, 0]]
    after = [[0, 0, 0], [0, 3, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]]
    counts = {
        "given": [1, 0, 1, 1, 0],
        "consumed": [0, 0, 0, 0, 2],
        "received[raw]": [0] * 5,
        "received[cut]": [0, 3, 0, 0, 0],
    }
    step = SimpleNamespace(
        reward=jnp.array([0.0, 0.0, 0.0, 0.0, 2.0]),
        state=SimpleNamespace(agent_bag=jnp.array(before, jnp.uint8)),
        next_state=SimpleNamespace(agent_bag=jnp.array(after, jnp.uint8)),
        events={
            name: jnp.array(count) for name, count in {**counts, "received[fine]": [0] * 5}.items()
        },
    )
    giver_credit = find("reward", f"{ROOT}/examples/giver_credit.py:giver_credit")
    assert giver_credit(step).tolist() == [4, 0, 0, 4, 2]
    assert giver_credit(step, credit=5.0).tolist() == [10, 0, 0, 10, 2]
