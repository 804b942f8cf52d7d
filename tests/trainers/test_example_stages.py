"""The presets with stages in `examples/`, and the reward that one of them names."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import jax
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


@pytest.mark.thorough
def test_all_credit_is_for_tokens_that_were_created(monkeypatch: pytest.MonkeyPatch) -> None:
    """In play: a gift takes a token from one agent and brings some to another, so what all receive and give tells how many it created."""
    monkeypatch.chdir(ROOT)
    variant = load_preset("examples/stages_gift_refinement.toml").environment["variant"]
    env = sjdsl.make("gift_refinement", variant=variant, num_agents=15, params={"spawn": 0.02})
    giver_credit = find("reward", f"{ROOT}/examples/giver_credit.py:giver_credit")

    def step(state: Any, key: jax.Array) -> tuple[Any, tuple[jax.Array, jax.Array]]:
        actions = jax.random.randint(key, (15,), 0, env.num_actions)
        _, after, reward, _, info = env.step_env(key, state, actions)
        played = SimpleNamespace(
            reward=reward, state=state, next_state=after, events=info["events"]
        )
        received = sum(info["events"][f"received[{level}]"] for level in ("raw", "cut", "fine"))
        created = (received - info["events"]["given"]).sum()
        full = (state.agent_bag >= 10).any()  # a bag that may lose tokens
        return after, (
            jnp.where(full, 0, (giver_credit(played, credit=1.0) - reward).sum()),
            jnp.where(full, 0, created),
        )

    _, state = env.reset(jax.random.key(0))
    _, (credited, created) = jax.jit(
        lambda state: jax.lax.scan(step, state, jax.random.split(jax.random.key(1), 1000))
    )(state)
    assert credited.tolist() == created.tolist()
    assert created.sum() > 20
