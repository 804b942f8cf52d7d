"""Twenty agents, the larger number of the paper's speed table: the compiled step equals the interpreter on the crowded maps."""

import jax
import pytest

import sjdsl
from sjdsl.compiler import build
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import find_game
from tests.differential.compare import run
from tests.fuzz import together as quick

# paper: every game of its table but Coins, which is for two, and PD Arena
GAMES = (
    "harvest_open",
    "harvest_closed",
    "harvest_partnership",
    "clean_up",
    "coop_mining",
    "mushrooms",
    "gift_refinement",
)
USUAL = ("harvest_open",)  # the others only with all tests


@pytest.mark.parametrize("name", USUAL)
def test_twenty_agents_on_numpy(name: str) -> None:
    """The generated module with NumPy in the place of JAX."""
    game = build(read_source(find_game(name)), ("crowd",)).game
    assert game.agents.number == 20
    play = quick.random_play(game, seed=3, steps=20)
    report = quick.run(quick.on_numpy(game), play, quick.interpret(game, play))
    assert not report.differences, report.differences
    assert report.steps == 20


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(n, marks=pytest.mark.thorough if n in USUAL else pytest.mark.slow)
        for n in GAMES
    ],
)
def test_twenty_agents(name: str) -> None:
    """Random play from one key; each field, observation, reward and event of each step."""
    env = sjdsl.make(name, variant="crowd")
    assert env.num_agents == 20
    report = run(env, jax.random.key(3), 50)
    assert not report.differences, report.differences
    assert report.steps == 50
