"""The state as a vector, the roles of agents, and the state an episode ended in."""

from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import sjdsl
from sjdsl.runtime.env import Environment
from tests.cli.command_line import GAME


@pytest.fixture(scope="module")
def orchard(tmp_path_factory: pytest.TempPathFactory) -> Environment:
    file = tmp_path_factory.mktemp("games") / "orchard.sj"
    file.write_text(GAME)
    return sjdsl.make(file)


def test_its_entries_are_counted_by_hand(orchard: Environment) -> None:
    """A map of 5 by 4 with two agents and three cells of soil, whose fruit is one of two words."""
    _, state = orchard.reset(jax.random.key(0))
    vector = np.asarray(orchard.state_vector(state))
    assert vector.dtype == np.float32
    assert vector.shape == (1 + 2 + 2 + 2 + 2 * 4 + 3 * 2,)
    rows, cols = (np.asarray(axis) for axis in orchard.cells(state))
    assert vector[0] == 0
    np.testing.assert_allclose(vector[1:3], rows / 3)
    np.testing.assert_allclose(vector[3:5], cols / 4)
    np.testing.assert_array_equal(vector[5:7], 1)
    np.testing.assert_array_equal(vector[7:15].reshape(2, 4), np.eye(4)[np.asarray(state.heading)])
    np.testing.assert_array_equal(vector[15:].reshape(3, 2), [[0, 1]] * 3)  # all ripe
    _, later, *_ = orchard.step_env(jax.random.key(1), state, jnp.full(2, 3))
    assert orchard.state_vector(later)[0] == pytest.approx(1 / 6)


def _check_play(env: Environment, steps: int) -> None:
    """Plays at random: entries stay within -1 and 1, and no two states that differ have one vector."""

    def advance(state: object, key: jax.Array) -> tuple[object, tuple[jax.Array, object]]:
        action_key, step_key = jax.random.split(key)
        actions = jax.random.randint(action_key, (env.num_agents,), 0, env.num_actions, jnp.int32)
        _, state, *_ = env.step_env(step_key, state, actions)
        return state, (env.state_vector(state), state)

    _, first = env.reset(jax.random.key(3))
    _, (vectors, states) = jax.jit(
        lambda: jax.lax.scan(advance, first, jax.random.split(jax.random.key(4), steps))
    )()
    vectors = np.asarray(vectors)
    assert np.isfinite(vectors).all()
    assert np.abs(vectors).max() <= 1.0
    assert len(np.unique(vectors, axis=0)) == steps  # the step counts, so that all states differ
    kept = np.asarray(vectors[:, 1:])
    placed = np.concatenate(
        [np.asarray(leaf).reshape(steps, -1) for leaf in (states.position, states.heading)], axis=1
    )
    assert len(np.unique(kept, axis=0)) >= len(np.unique(placed, axis=0)), (
        "agents who stand or look elsewhere make another vector"
    )


def test_entries_are_from_minus_one_to_one(orchard: Environment) -> None:
    _check_play(orchard, 6)


def test_every_part_of_a_state_counts(orchard: Environment) -> None:
    """Whichever field is changed, the vector is another."""
    _, state = orchard.reset(jax.random.key(0))
    before = np.asarray(orchard.state_vector(state))
    for field in ("heading", "soil_fruit", "position"):
        value = getattr(state, field)
        changed = state.replace(
            **{
                field: value.at[0].set(
                    (value[0] + 1) % 4 if field != "soil_fruit" else 1 - value[0]
                )
            }
        )
        assert (np.asarray(orchard.state_vector(changed)) != before).any(), field


MOVERS = """sj 1
game pond "A pond with ducks" {
  episode 6
  kind water "~"
  kind grass "."
  map { "~~~" "..." }
  agents 1 { acts turn_left, turn_right, forward, stay  moves relative }
  movers duck 2 "d" { field tame : { no, yes } = no }
  phase start { each agent { send agent to grass }  each duck { send duck to water facing east } }
  schedule walk -> swim
  phase walk { move each agent }
  phase swim { move each duck at random avoiding grass }
}
"""


def test_movers_are_in_it(tmp_path: Path) -> None:
    """For each duck: whether it is there, its row and column, its heading, and its field, in this order, behind the agents."""
    file = tmp_path / "pond.sj"
    file.write_text(MOVERS)
    env = sjdsl.make(file)
    _, state = env.reset(jax.random.key(2))
    vector = np.asarray(env.state_vector(state))
    assert vector.shape == (1 + 3 + 4 + 2 * 3 + 2 * 4 + 2 * 2,)
    cols = np.asarray(state.duck_position) % env.module.FRAME[1] - env.module.PAD
    np.testing.assert_allclose(vector[8:14].reshape(2, 3), [[1, 0, col / 2] for col in cols])
    np.testing.assert_array_equal(vector[14:22].reshape(2, 4), [[0, 1, 0, 0]] * 2)
    np.testing.assert_array_equal(vector[22:].reshape(2, 2), [[1, 0]] * 2)
    gone = state.replace(duck_position=state.duck_position.at[0].set(0))
    np.testing.assert_array_equal(
        np.asarray(env.state_vector(gone))[8:14], [0, 0, 0, *vector[11:14]]
    )


def test_the_state_an_episode_ended_in(orchard: Environment) -> None:
    _, state = orchard.reset(jax.random.key(0))
    stay = jnp.full(2, 3)
    for number in range(6):
        key = jax.random.key(10 + number)
        _, plain, *_ = orchard.step_env(key, state, stay)
        _, state, _, done, info = orchard.step(key, state, stay)
        assert bool(done) == (number == 5)
        jax.tree.map(np.testing.assert_array_equal, info["terminal_state"], plain)
    assert int(info["terminal_state"].step) == 6
    assert int(state.step) == 0


def test_roles(orchard: Environment) -> None:
    assert orchard.roles is None
    hunt = sjdsl.make("predator_prey")
    (field,) = (field for field in hunt.game.agents.fields if field.name == "role")
    roles = hunt.roles
    assert roles is not None
    _, state = hunt.reset(jax.random.key(99))
    assert roles == tuple(
        np.asarray(
            state.agents_role if hasattr(state, "agents_role") else state.agent_role
        ).tolist()
    )
    assert set(roles) == set(range(len(field.type.words)))
