"""Sweeps: one program with many values plays as the programs with one value each do."""

from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import pytest
from click.testing import CliRunner

import sjdsl
from bench.speed.__main__ import main
from bench.speed.sweep import make_sweep_loop, swept_params
from sjdsl.bench import game_task
from sjdsl.bench.loop import make_loop
from sjdsl.runtime.env import Environment

GAME = """sj 1
game orchard "Orchard" {
  episode 3
  param apple : reward = 2 in 0 .. 4
  param worth : reward = { none: 1, ripe: -2 }
  param rest  : steps  = 10 in 0 .. 12
  param turns : word   = { none: ripe, ripe: none }
  kind soil "A" { field fruit : { none, ripe } = ripe }
  map { "AAA" }
  agents 2 { acts forward, stay  moves relative  timer resting  forbid all when agent.resting > 0 }
  phase start { each agent { send agent to soil } }
  schedule tick -> walk -> eat
  phase walk { move each agent }
  phase eat {
    each agent on soil where soil.fruit is ripe {
      set soil.fruit = turns[soil.fruit]  give apple + worth[soil.fruit] to agent  set agent.resting = rest
    }
  }
  observe { window ahead 1, behind 0, left 1, right 1 }
}
"""


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("games") / "orchard.sj"
    path.write_text(GAME)
    return path


@pytest.fixture(scope="module")
def env(file: Path) -> Environment:
    return sjdsl.make(file)


@pytest.mark.parametrize(
    ("name", "number", "said"),
    [
        ("aple", 3, "did you mean `apple`"),
        ("zzzzzz", 3, "it has apple, worth, rest, turns"),
        ("turns", 3, "is a word"),
        ("rest", 9, "only 5 different values"),
    ],
)
def test_what_cannot_be_swept_is_told(env: Environment, name: str, number: int, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        swept_params(env, name, number)


@pytest.mark.thorough
def test_values_as_arguments_play_as_constants_do(env: Environment) -> None:
    key, own = jax.random.key(0), env.params
    loop = jax.jit(make_sweep_loop(env, 4, 6))

    def together(*values: Any) -> float:
        return float(loop(key, jax.tree.map(lambda *each: jnp.stack(each), *values)))

    assert together(own, own, own, own) == float(jax.jit(make_loop(game_task(env), 4, 6))(key))
    dear = own.replace(apple=own.apple * 2)
    assert (
        together(own, own, own, own)
        < together(own, own, dear, own)
        < together(dear, dear, dear, dear)
    )


def test_a_mistake_is_told(file: Path) -> None:
    found = CliRunner().invoke(main, ["sweep", str(file), "aple"])
    assert found.exit_code == 1
    assert "did you mean `apple`" in found.output
