"""The compiled step equals the reference interpreter: every field, observation, reward, event and metric of every step.

`tests/games/test_contract.py` plays whole episodes of bundled games and variants; here are small games that use every construct, and the
bundled ones for a few steps, and with other numbers than any variant has.
"""

from pathlib import Path

import jax
import pytest

import sjdsl
from sjdsl.compiler import build
from sjdsl.compiler.syntax.read import read_source
from sjdsl.interpreter.numbers import real
from sjdsl.library.games_folder import find_game, main_games
from tests.differential.compare import Report, run
from tests.fuzz import together as quick

HERE = Path(__file__).parent
OTHER_NUMBERS = [
    ("clean_up", {"respawn_delay": 2, "grace": 0, "best_rate": 0.5, "pollution": 1.0}),
    ("mushrooms", {"respawn_delay": 3}),
    ("coins", {"spawn": 0.05, "length": 30}),
]


def together(env: sjdsl.Environment, seed: int, steps: int, given: dict | None = None) -> Report:
    """Runs both from one key."""
    report = run(env, jax.random.key(seed), steps, given=given)
    assert not report.differences, report.differences
    assert report.steps == steps
    return report


FEW = [
    *OTHER_NUMBERS[:1],
    *(pytest.param(*other, marks=pytest.mark.slow) for other in OTHER_NUMBERS[1:]),
]


@pytest.mark.thorough
@pytest.mark.parametrize(("name", "params"), FEW, ids=lambda x: str(x))
def test_other_numbers(name: str, params: dict) -> None:
    env = sjdsl.make(name, params=params)
    types = {p.name: p.type.kind for p in env.game.params}
    together(
        env,
        5,
        60,
        {k: real(v) if types[k] == "real" else v for k, v in params.items() if k in types},
    )


GAMES = sorted((HERE / "games").glob("*.sj"))
CASES = sorted((HERE.parent / "cases").glob("*.sj"))
BY_XLA = (
    "worlds"  # compiled in each run; the others in the thorough ones: it takes longer than all else
)


@pytest.mark.parametrize(
    "path", [*GAMES, *CASES], ids=lambda path: f"{path.parent.name}-{path.stem}"
)
def test_every_construct(path: Path) -> None:
    """Small crowded games that use every statement, domain and expression; the module runs on NumPy."""
    play_on_numpy(path, 20)


@pytest.mark.parametrize("name", main_games())
def test_every_bundled_game(name: str) -> None:
    play_on_numpy(find_game(name), 15)


def play_on_numpy(path: Path, steps: int) -> None:
    """Asserts that the module of a game, on NumPy, and the interpreter take the same steps."""
    game = build(read_source(path)).game
    play = quick.random_play(game, seed=0, steps=steps)
    history = quick.interpret(game, play)
    report = quick.run(quick.on_numpy(game), play, history)
    assert not report.differences, report.differences
    assert report.steps == steps


@pytest.mark.parametrize(
    "seeds", [(0,), pytest.param((1, 2, 3), marks=pytest.mark.thorough)], ids=["one", "three"]
)
@pytest.mark.parametrize(
    "path",
    [pytest.param(p, marks=[] if p.stem == BY_XLA else pytest.mark.thorough) for p in GAMES],
    ids=lambda p: p.stem,
)
def test_every_construct_compiled_by_xla(path: Path, seeds: tuple[int, ...]) -> None:
    """The same games in the environment that users have."""
    env = sjdsl.make(path)
    for seed in seeds:
        together(env, seed, 50)


def test_a_difference_is_found() -> None:
    """The comparison itself: a compiled game against the rules of a slightly different one."""
    env = sjdsl.make("coins", params={"spawn": 0.05})
    assert run(env, jax.random.key(0), 30).differences
