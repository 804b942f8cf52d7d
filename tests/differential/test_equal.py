"""The compiled step equals the reference interpreter: every field, observation, reward, event and metric of every step.

Every bundled game in every variant is compared in `tests/games/test_contract.py`, over whole episodes; here are small games that use
every construct, and the bundled ones with other numbers than any variant has.
"""

from pathlib import Path

import jax
import pytest

import sjdsl
from sjdsl.interpreter.numbers import real
from tests.differential.compare import Report, run

HERE = Path(__file__).parent
OTHER_NUMBERS = [
    ("clean_up", {"respawn_delay": 2, "grace": 0, "best_rate": 0.5, "pollution": 1.0}),
    ("mushrooms", {"respawn_delay": 3}),
    ("coins", {"spawn": 0.05, "length": 30}),
]


def together(env: sjdsl.Environment, seed: int, steps: int, given: dict | None = None) -> Report:
    """Runs both from one key; a draw on the edge of a computed chance ends a run early and is counted, not failed."""
    report = run(env, jax.random.key(seed), steps, given=given)
    assert not report.differences, report.differences
    assert report.near or report.steps == steps
    return report


FEW = [*OTHER_NUMBERS[:1], *(pytest.param(*other, marks=pytest.mark.slow) for other in OTHER_NUMBERS[1:])]


@pytest.mark.parametrize(("name", "params"), FEW, ids=lambda x: str(x))
def test_other_numbers(name: str, params: dict) -> None:
    env = sjdsl.make(name, params=params)
    types = {p.name: p.type.kind for p in env.game.params}
    together(env, 5, 60, {k: real(v) if types[k] == "real" else v for k, v in params.items() if k in types})


@pytest.mark.parametrize("seeds", [(0,), pytest.param((1, 2, 3), marks=pytest.mark.thorough)], ids=["one", "three"])
@pytest.mark.parametrize("path", sorted((HERE / "games").glob("*.sj")), ids=lambda p: p.stem)
def test_every_construct(path: Path, seeds: tuple[int, ...]) -> None:
    """Small crowded games that use every sentence, domain and expression, written to be awkward."""
    env = sjdsl.make(path)
    for seed in seeds:
        together(env, seed, 50)


def test_a_difference_is_found() -> None:
    """The comparison itself: a compiled game against the rules of a slightly different one."""
    env = sjdsl.make("coins", params={"spawn": 0.05})
    assert run(env, jax.random.key(0), 30).differences
