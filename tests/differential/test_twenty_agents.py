"""Twenty agents, the larger number of the paper's speed table: the compiled step equals the interpreter on the crowded maps."""

import jax
import pytest

import sjdsl
from tests.differential.compare import run

# paper: every game of its table but Coins, which is for two, and PD Arena
GAMES = ("harvest_open", "harvest_closed", "harvest_partnership", "clean_up", "coop_mining", "mushrooms", "gift_refinement")
USUAL = ("harvest_open",)  # the others only with all tests


@pytest.mark.parametrize("name", [name if name in USUAL else pytest.param(name, marks=pytest.mark.slow) for name in GAMES])
def test_twenty_agents(name: str) -> None:
    """Random play from one key; each field, observation, reward and event of each step. A draw on the edge of a chance would end it."""
    env = sjdsl.make(name, variant="crowd")
    assert env.num_agents == 20
    report = run(env, jax.random.key(3), 50)
    assert not report.differences, report.differences
    assert (report.steps, report.near) == (50, 0)
