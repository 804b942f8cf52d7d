"""What XLA is given for one step of each of the nine games: neither longer nor of other operations than was known.

Lowered only, so the figures are the same on every machine; they are in `structure.txt`, to be written anew by `--update-golden`.
"""

from functools import cache
from pathlib import Path

import pytest

from sjdsl.bench.compilation import COUNTED, count_operations, lower_step
from sjdsl.runtime.forms import forced
from tests.games.environments import NINE, environment

KNOWN = Path(__file__).parent / "structure.txt"
LINES = 2500  # the most that is aimed at
GROWTH = 1.05  # unnoticed
MANY = ("lines", *COUNTED)


@cache
def step_of(game: str) -> str:
    return lower_step(environment(game)).as_text()


def figures_of(game: str) -> dict[str, int]:
    return {"lines": len(step_of(game).splitlines()), **count_operations(step_of(game))}


def known_figures() -> dict[str, dict[str, int]]:
    head, *rows = (line.split() for line in KNOWN.read_text(encoding="utf-8").splitlines())
    return {name: dict(zip(head[1:], map(int, figures), strict=True)) for name, *figures in rows}


def test_the_table_can_be_written(request: pytest.FixtureRequest) -> None:
    if request.config.getoption("--update-golden"):
        rows = [("game", *MANY), *((game, *(str(n) for n in figures_of(game).values())) for game in NINE)]
        KNOWN.write_text("".join(f"{row[0]:<20}{''.join(f'{cell:>15}' for cell in row[1:])}\n" for row in rows), encoding="utf-8")
    assert tuple(known_figures()) == NINE


@pytest.mark.parametrize("game", NINE)
def test_a_step_has_not_grown(game: str) -> None:
    known, now = known_figures()[game], figures_of(game)
    assert now["lines"] <= GROWTH * known["lines"]
    for name in COUNTED:
        assert now[name] <= known[name], name


@pytest.mark.parametrize("game", NINE)
def test_a_step_is_short(game: str) -> None:
    assert figures_of(game)["lines"] <= LINES


@pytest.mark.parametrize("game", NINE)
def test_a_step_sorts_nothing_and_stays_in_single_precision(game: str) -> None:
    assert figures_of(game)["sort"] == 0
    assert "f64" not in step_of(game)


# Loops and branches of a step for a GPU, each of which may wait for the host: `pick` of several, and the rounds of `match`.
WAITS = {"mushrooms": 1, "pd_arena": 1}


@pytest.mark.parametrize("game", NINE)
def test_a_step_for_a_gpu_has_no_loops_and_branches(game: str) -> None:
    with forced("gpu"):
        found = count_operations(lower_step(environment(game)).as_text())
    assert found["while"] + found["case"] <= WAITS.get(game, 0)


def test_operations_are_counted_once_each() -> None:
    text = """
    %0 = "stablehlo.gather"(%a, %b) <{dimension_numbers = #stablehlo.gather<offset_dims = [1]>}> : tensor<i32>
    %1:2 = stablehlo.while(%iterArg = %c) : tensor<i32>
    %2 = stablehlo.dynamic_slice %a, %b, sizes = [1] : tensor<i32>
    """
    assert {name: number for name, number in count_operations(text).items() if number} == {"gather": 1, "while": 1, "dynamic_slice": 1}
