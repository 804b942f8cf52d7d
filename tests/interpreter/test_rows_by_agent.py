"""Rows by agent, by role and by numbers on the interpreter, against plain loops over NumPy arrays; entries of tables from Python."""

import numpy as np
import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.elaborate import Overrides
from sjdsl.interpreter.numbers import real
from sjdsl.interpreter.state import default_params
from sjdsl.interpreter.step import reset, step
from sjdsl.interpreter.threefry import Threefry
from sjdsl.library.parameters import param_values

GAME = """sj 1
game frame "Memory" {
  size players : count = 4
  param taste by agent : reward = { 0: 2, 2: 5, otherwise: 0.5 }
  param wage by { farmer, cleaner } : reward = { farmer: 3, otherwise: 1 }
  param pace by 0 .. 3 : count = { 0 .. 1: 1, 2: 2, 3..: 3 } in 0 .. 3
  episode 99
  kind grass "."
  map { "...." "...." }
  agents players {
    acts stay, help
    field role : { farmer, cleaner } = farmer
    field last by agent : { refused, helped } = refused
    field trust by agent : 0 .. 5 = 3
    field kept by 0 .. 3 : 0 .. 200 capped = 0
    field place : 0 .. 3 = 0
  }
  field standing by agent : 0 .. 60 capped = 0
  phase start { each agent { send agent to grass  when agent.index % 2 == 1 { set agent.role = cleaner } } }
  schedule answer -> remember
  phase answer {
    each agent as a where a chose help {
      each agent as b where b is not a and b.last[a] is helped { give taste[b] + wage[b.role] to b  add 1 to standing[a] }
    }
  }
  phase remember {
    each agent as a {
      each agent as b where b is not a {
        set b.last[a] = case a chose help { yes: helped, no: refused }
        when a chose help and b.trust[a] < 5 { set b.trust[a] = b.trust[a] + 1 }
        when a chose stay and b.trust[a] > 0 { set b.trust[a] = b.trust[a] - 1 }
      }
      add pace[a.place] to a.kept[3 - a.place]
      set a.place = (a.place + 1) % 4
    }
  }
}
"""
STAY, HELP = 0, 1


def made(text: str = GAME, number: int | None = None) -> ir.Game:
    return build(Source("frame.sj", text), (), Overrides(num_agents=number)).game


def test_memory_of_partners_follows_a_plain_loop() -> None:
    game, random = made(), np.random.default_rng(0)
    params = default_params(game)
    world = reset(game, params, Threefry(0, 0))
    n = game.agents.number
    last, trust, standing = np.zeros((n, n), bool), np.full((n, n), 3), np.zeros(n, int)
    taste, wage = [2, 0.5, 5, 0.5], [3, 1, 3, 1]
    kept, pace = np.zeros(4, int), [1, 1, 2, 3]
    for t in range(30):
        actions = random.integers(0, 2, n)
        world, outcome = step(game, world, actions.tolist(), params, Threefry(1, t))
        reward = np.zeros(n)
        for a in range(n):
            for b in range(n):
                if a != b and actions[a] == HELP and last[b, a]:
                    reward[b] += taste[b] + wage[b]
                    standing[a] += 1
        for a in range(n):
            for b in range(n):
                if a != b:
                    last[b, a] = actions[a] == HELP
                    trust[b, a] = np.clip(trust[b, a] + (1 if actions[a] == HELP else -1), 0, 5)
        kept[3 - t % 4] += pace[t % 4]
        np.testing.assert_allclose(outcome.reward, reward)
        assert [[word == "helped" for word in row] for row in world.agents["last"]] == last.tolist()
        assert np.array_equal(world.agents["trust"], trust)
        assert np.array_equal(world.fields["standing"], np.minimum(standing, 60))
        assert all(row == tuple(kept) for row in world.agents["kept"])


@pytest.mark.parametrize(
    "given", [{0: 7.0, 2: 1}, {"0": 7.0, "2": 1}, [7.0, 0.5, 1, 0.5], np.array([7, 0.5, 1, 0.5])]
)
def test_entries_are_given_by_number(given: object) -> None:
    assert param_values(made(), {"taste": given})["taste"] == (7.0, 0.5, 1.0, 0.5)


def test_a_changed_entry_pays() -> None:
    game = made()
    params = default_params(game) | {
        name: real(value)
        for name, value in param_values(game, {"taste": {1: 10}}).items()
        if name == "taste"
    }
    world = reset(game, params, Threefry(0, 0))
    world, _ = step(game, world, [HELP, STAY, STAY, STAY], params, Threefry(1, 0))
    _, outcome = step(game, world, [HELP, STAY, STAY, STAY], params, Threefry(1, 1))
    assert [float(r) for r in outcome.reward] == [0, 11, 8, 1.5]
