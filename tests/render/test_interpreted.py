"""The interpreter's states give the pictures of the compiled game's."""

from pathlib import Path

import jax
import numpy as np
import pytest

import sjdsl
from sjdsl.render.board import draw_board
from sjdsl.render.interpreted import snapshot_of
from sjdsl.render.look import make_look
from sjdsl.render.snapshot import take_snapshot
from sjdsl.screen.compiled import marked_world

CASES = Path(__file__).parents[1] / "cases"
STEPS = 6


@pytest.mark.parametrize("game", ["clean_up", "coins", CASES / "moving.sj"], ids=str)
def test_the_same_picture_of_the_same_state(game: str | Path) -> None:
    env = sjdsl.make(game)
    look = make_look(env.game)
    _, state = env.reset(jax.random.key(0))
    actions = np.random.default_rng(0).integers(env.num_actions, size=(STEPS, env.num_agents))
    returns = np.zeros(env.num_agents)
    for number, chosen in enumerate(actions):
        _, state, *_ = env.step_env(jax.random.key(number), state, chosen.astype(np.int32))
        compiled = take_snapshot(env, state, returns)
        interpreted = snapshot_of(env.game, marked_world(env, state), returns)
        assert np.array_equal(draw_board(look, compiled, {}), draw_board(look, interpreted, {}))
        assert interpreted.held.tolist() == compiled.held.tolist()
