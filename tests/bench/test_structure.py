"""What XLA is given for one step of each of the nine games: neither longer nor of other operations than was known.

Lowered only, so the figures are the same on every machine: `structure_cpu.txt` and `structure_gpu.txt` have them in the form of kernels for
CPUs and in that for GPUs, to be written anew by `--update-golden`.
"""

from functools import cache
from pathlib import Path

import jax
import pytest

import sjdsl
from sjdsl.bench.compilation import COUNTED, count_operations, lower_step
from sjdsl.runtime.forms import forced
from tests.games.environments import NINE, environment

FORMS = ("cpu", "gpu")
LINES = 2500  # the most that is aimed at
GROWTH = 1.05  # unnoticed
GAMES = [
    name
    if name in ("coins", "clean_up", "mushrooms")
    else pytest.param(name, marks=pytest.mark.thorough)
    for name in NINE
]


@cache
def step_of(game: str, form: str = "cpu") -> str:
    with forced(form):
        return lower_step(environment(game)).as_text()


def figures_of(game: str, form: str = "cpu") -> dict[str, int]:
    text = step_of(game, form)
    return {"lines": len(text.splitlines()), **count_operations(text)}


def known(form: str) -> Path:
    return Path(__file__).parent / f"structure_{form}.txt"


def known_figures(form: str) -> dict[str, dict[str, int]]:
    head, *rows = (line.split() for line in known(form).read_text(encoding="utf-8").splitlines())
    return {name: dict(zip(head[1:], map(int, figures), strict=True)) for name, *figures in rows}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("game", GAMES)
def test_a_step_has_not_grown(game: str, form: str) -> None:
    before, now = known_figures(form)[game], figures_of(game, form)
    assert now["lines"] <= GROWTH * before["lines"]
    for name in COUNTED:
        assert now[name] <= before[name], name


@pytest.mark.parametrize("game", GAMES)
def test_a_step_is_short(game: str) -> None:
    assert figures_of(game)["lines"] <= LINES


@pytest.mark.parametrize("game", GAMES)
def test_a_step_sorts_nothing_and_stays_in_single_precision(game: str) -> None:
    assert figures_of(game)["sort"] == 0
    assert "f64" not in step_of(game)


@pytest.mark.parametrize("game", GAMES)
def test_a_step_for_a_gpu_waits_for_nothing(game: str) -> None:
    """The host would wait for the predicate of each turn of a loop, and of each branch."""
    found = figures_of(game, "gpu")
    assert found["while"] + found["case"] == 0


@pytest.mark.parametrize(("platform", "form"), [("cpu", "cpu"), ("cuda", "gpu")])
def test_the_platform_chooses_the_form(
    platform: str, form: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where JAX has a GPU, a program for either has its form alone."""
    monkeypatch.setattr(jax, "default_backend", lambda: "gpu")
    env = sjdsl.make("coins")
    key = jax.random.key(0)
    traced = env.step.trace(
        key, jax.eval_shape(env.reset, key)[1], jax.ShapeDtypeStruct((env.num_agents,), "int32")
    )
    found = count_operations(traced.lower(lowering_platforms=(platform,)).as_text())
    choice = {"case": 2}  # by a constant, once for the whole step: XLA takes one side
    assert found == {
        name: number + choice.get(name, 0)
        for name, number in count_operations(step_of("coins", form)).items()
    }
