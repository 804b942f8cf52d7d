"""A map may lack a kind of the game: sentences about it then find nobody, and nothing else changes."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl import make
from sjdsl.compiler import build
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.interpreter.state import default_params
from sjdsl.interpreter.step import reset, step
from sjdsl.interpreter.threefry import Threefry

FRAME = """sj 1
game frame "A map without its pond" {{
  episode 10
  kind grass "."
  kind tree  "T" {{ field fruit : {{ none, ripe }} = ripe }}
  kind pond  "o" {{ field fish : {{ none, some }} = some }}
  map {{ ".T.T" }}
  agents 2 {{ acts stay, shake }}
  shape ray = line(2)
  phase start {{ each agent {{ send agent to grass }} }}
  schedule rule
  phase rule {{
    {rule}
  }}
  metrics {{ event seen }}
}}
"""
SHAKE = 1
# a sentence about ponds, and what the two agents are given when all shake
STATEMENTS = [
    ("when count(pond where pond.fish is some) == 0 { give 1 to all }", [1, 1]),
    ("each pond where pond.fish is some { give 1 to all }", [0, 0]),
    ("pick 1 pond where pond.fish is some { give 1 to all } otherwise { give 2 to all }", [2, 2]),
    ("each agent { when agent on pond { give 1 to agent } otherwise { give 2 to agent } }", [2, 2]),
    ("each agent on pond where pond.fish is some { give 1 to agent }", [0, 0]),
    ("each agent { each pond in ray of agent where pond.fish is some { give 1 to agent } }", [0, 0]),
    ("each agent as a { pick 1 pond in ray of a where pond.fish is some { give 1 to a } otherwise { give 2 to a } }", [2, 2]),
    ("each tree { when count(pond in disc(1) of tree where pond.fish is some) == 0 { give 1 to all } }", [2, 2]),
    ("each agent { first pond in ray of agent where pond.fish is some { give 1 to agent } }", [0, 0]),
    ("each agent { when count(pond in ray of agent where pond.fish is some) == 0 { give 1 to agent } }", [1, 1]),
    ("when count(agent on pond where pond.fish is some) == 0 { give 1 to all }", [1, 1]),
    ("match pond with agent in disc(1) of pond { give 1 to agent }", [0, 0]),
    ("match agent with first pond in ray of agent where pond.fish is some { give 1 to agent }", [0, 0]),
    ("each agent where agent chose shake { send agent to pond where pond.fish is some otherwise stay }", [0, 0]),
]  # fmt: skip


@pytest.mark.thorough
@pytest.mark.parametrize(("rule", "reward"), STATEMENTS)
def test_sentences_about_an_absent_kind(rule: str, reward: list[float], tmp_path: Any) -> None:
    """The interpreter agrees on what is given, and where agents are."""
    text = FRAME.format(rule=rule)
    game = build(Source("frame.sj", text)).game
    world = reset(game, default_params(game), Threefry(0, 0))
    world, outcome = step(game, world, [SHAKE, SHAKE], default_params(game), Threefry(0, 1))
    assert [float(r) for r in outcome.reward] == reward
    (tmp_path / "frame.sj").write_text(text)
    env = make(tmp_path / "frame.sj")
    _, state = env.reset(jax.random.key(0))
    _, state, given, *_ = env.step_env(jax.random.key(1), state, jnp.array([SHAKE, SHAKE]))
    assert given.tolist() == reward
    assert list(zip(*(np.asarray(x).tolist() for x in env.cells(state)), strict=True)) == [
        tuple(place) for place in world.position if place
    ]
