"""The compiled step equals the reference interpreter: every field, observation, reward, event and metric of every step."""

from pathlib import Path

import jax
import pytest

import sjdsl
from tests.differential.compare import Report, run

HERE = Path(__file__).parent
GAMES = ("coins", "harvest_open", "harvest_closed", "harvest_partnership", "clean_up")
LATER = ("coop_mining", "gift_refinement", "mushrooms", "pd_arena")
VARIANTS = [
    ("coins", "socialjax", {}),
    ("harvest_open", "closed+socialjax", {}),
    ("clean_up", "socialjax", {}),
    ("coop_mining", "socialjax", {}),
    ("gift_refinement", "meltingpot", {}),
    ("mushrooms", "socialjax", {}),
    ("pd_arena", "socialjax", {}),
    ("harvest_closed", None, {"respawn_delay": 4}),
    ("clean_up", None, {"respawn_delay": 2, "grace": 0, "best_rate": 0.5, "pollution": 1.0}),
    ("mushrooms", None, {"respawn_delay": 3}),
    ("coins", None, {"spawn": 0.05, "length": 30}),
]


def together(env: sjdsl.Environment, seed: int, steps: int, given: dict | None = None) -> Report:
    """Runs both from one key; a draw on the edge of a computed chance ends a run early and is counted, not failed."""
    report = run(env, jax.random.key(seed), steps, given=given)
    assert not report.differences, report.differences
    assert report.near or report.steps == steps
    return report


@pytest.mark.parametrize("name", GAMES)
def test_five_games_over_seeds(name: str) -> None:
    env = sjdsl.make(name)
    reports = [together(env, seed, 200) for seed in range(5)]
    assert sum(r.near for r in reports) <= 1


@pytest.mark.parametrize("name", LATER)
def test_four_more_games(name: str) -> None:
    together(sjdsl.make(name), 11, 60)


@pytest.mark.parametrize(("name", "variant", "params"), VARIANTS, ids=lambda x: str(x))
def test_variants_and_other_numbers(name: str, variant: str | None, params: dict) -> None:
    env = sjdsl.make(name, variant=variant, params=params)
    run_time = {p.name for p in env.game.params}
    given = {k: v for k, v in params.items() if k in run_time}
    from sjdsl.interpreter.numbers import real

    types = {p.name: p.type.kind for p in env.game.params}
    together(env, 5, 60, {k: real(v) if types[k] == "real" else v for k, v in given.items()})


@pytest.mark.parametrize("path", sorted((HERE / "games").glob("*.sj")), ids=lambda p: p.stem)
def test_every_construct(path: Path) -> None:
    """Small crowded games that use every sentence, domain and expression, written to be awkward."""
    env = sjdsl.make(path)
    for seed in range(4):
        together(env, seed, 50)


def test_a_difference_is_found() -> None:
    """The comparison itself: a compiled game against the rules of a slightly different one."""
    env = sjdsl.make("coins", params={"spawn": 0.05})
    assert run(env, jax.random.key(0), 30).differences
