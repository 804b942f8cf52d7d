"""Policies of a file by their names: for partners of a run, for the others of a Gymnasium environment; and one that cannot be compiled."""

import warnings
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import sjdsl
from sjdsl.compiler.lower import NotSupported
from sjdsl.interpreter.state import default_params
from sjdsl.policies import compiled
from sjdsl.policies.interpreted import choose
from sjdsl.properties.state_conversion import world_of
from sjdsl.runtime.env import Environment
from sjdsl.trainers import PolicyError, make_config
from sjdsl.trainers.policies.loading import find_policy, make_partners

ORCHARD = Path(__file__).with_name("orchard.sj")


@pytest.fixture(scope="module")
def env() -> Environment:
    return sjdsl.make(ORCHARD)


def expected(env: Environment, state: object) -> list[int]:
    """Returns what the agents do by the only policy of the file where nobody is in the way."""
    (policy,), world = env.game.policies, world_of(env, state)
    assert world.params == default_params(env.game)
    return [
        choose(policy, env.game, world, agent, (0, 2**32 - 1)) for agent in range(env.num_agents)
    ]


def test_partners_of_a_run(env: Environment) -> None:
    partners = make_partners(env, make_config(partners={1: "eater"}))
    observation, states = jax.jit(jax.vmap(env.reset))(jax.random.split(jax.random.key(0), 3))
    memory = partners.policy.starts(3)
    act = jax.jit(lambda *seen: partners.act(env, memory, *seen))
    nothing = jnp.zeros((3, env.num_agents), jnp.int32)
    _, actions = act(jax.random.key(1), observation, states, jnp.ones(3, bool), nothing)
    for number in range(3):
        assert (
            actions[number, 1]
            == expected(env, jax.tree.map(lambda leaf, at=number: leaf[at], states))[1]
        )


def test_the_others_of_a_gymnasium_environment() -> None:
    pytest.importorskip("gymnasium")
    from sjdsl.interop.gymnasium import AgentGame

    played = AgentGame(str(ORCHARD), agent=0, others="eater")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        played.reset(seed=3)
    earned = [played.step(3)[-1]["rewards"] for _ in range(8)]  # 3 is `stay`
    assert np.sum(earned, axis=0)[0] == 0
    assert np.sum(earned, axis=0)[1] > 0


def test_a_policy_that_cannot_be_compiled_is_named_with_its_place(
    env: Environment, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(*_: object) -> None:
        raise NotSupported("a shape of moonlight", env.game.policies[0].origin, "write one of wood")

    monkeypatch.setattr(compiled, "lower_policy", refused)
    said = r"the policy `eater` can't be compiled: a shape of moonlight is not supported yet \(.*orchard.sj, line 39\); write one of wood"
    with pytest.raises(PolicyError, match=said):
        find_policy("eater", env)
