"""The compiled step equals the reference interpreter: every field, observation, reward, event and metric of every step.

Every bundled game in every variant is compared in `tests/games/test_contract.py`, over whole episodes; here are small games that use
every construct.
"""

from pathlib import Path

import jax
import pytest

import sjdsl
from sjdsl.compiler import build
from sjdsl.compiler.syntax.read import read_source
from tests.differential.compare import run
from tests.fuzz import together as quick

HERE = Path(__file__).parent


GAMES = sorted((HERE / "games").glob("*.sj"))
BY_XLA = ("rows_by_agent", "worlds")  # compiled in each run of the tests; the others in the thorough ones: it takes longer than all else


@pytest.mark.parametrize("path", GAMES, ids=lambda p: p.stem)
def test_every_construct(path: Path) -> None:
    """Small crowded games that use every sentence, domain and expression, written to be awkward; the generated module runs on NumPy."""
    game = build(read_source(path)).game
    play = quick.random_play(game, seed=0, steps=30)
    history = quick.interpret(game, play)
    report = quick.run(quick.on_numpy(game), play, history)
    assert not report.differences, report.differences
    assert report.near or report.steps == 30


@pytest.mark.parametrize("seeds", [(0,), pytest.param((1, 2, 3), marks=pytest.mark.thorough)], ids=["one", "three"])
@pytest.mark.parametrize(
    "path", [pytest.param(p, marks=[] if p.stem in BY_XLA else pytest.mark.thorough) for p in GAMES], ids=lambda p: p.stem
)
def test_every_construct_compiled_by_xla(path: Path, seeds: tuple[int, ...]) -> None:
    """The same games in the environment that users have."""
    env = sjdsl.make(path)
    for seed in seeds:
        report = run(env, jax.random.key(seed), 50)
        assert not report.differences, report.differences
        assert report.near or report.steps == 50  # a draw on the edge of a computed chance ends a run early


def test_a_difference_is_found() -> None:
    """The comparison itself: a compiled game against the rules of a slightly different one."""
    env = sjdsl.make("coins", params={"spawn": 0.05})
    assert run(env, jax.random.key(0), 30).differences
