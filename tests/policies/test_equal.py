"""Compiled policies choose what interpreted ones do, agent by agent, in states that random agents and the policies themselves lead to."""

from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import sjdsl
from sjdsl.compiler import build
from sjdsl.compiler.syntax.read import read_source
from sjdsl.policies.compiled import Chooser
from sjdsl.policies.interpreted import choose
from sjdsl.properties.state_conversion import world_of
from tests.fuzz.policies import different_choice
from tests.fuzz.together import interpret, moments, on_numpy, random_play

GAMES = Path(__file__).parent / "games"
STEPS = 20


def played(env: sjdsl.Environment, seed: int) -> Any:
    """Returns T states, the random numbers of each `[T, N, 2]`, and what each policy chooses in it `[T, policies, N]`, as NumPy arrays.

    In each step an agent follows one of the policies or takes a random action.
    """
    choosers = [Chooser(env, policy) for policy in env.game.policies]

    def advance(state: Any, key: jax.Array) -> Any:
        bits_key, who_key, random_key, step_key = jax.random.split(key, 4)
        bits = jax.random.bits(bits_key, (env.num_agents, 2), jnp.uint32)
        chosen = jnp.stack([chooser(state, bits) for chooser in choosers])
        anything = jax.random.randint(
            random_key, (1, env.num_agents), 0, env.num_actions, jnp.int32
        )
        who = jax.random.randint(who_key, (1, env.num_agents), 0, len(choosers) + 1, jnp.int32)
        actions = jnp.take_along_axis(jnp.concatenate([chosen, anything]), who, axis=0)[0]
        return env.step(step_key, state, actions)[1], (state, bits, chosen)

    @jax.jit
    def play(key: jax.Array) -> Any:
        reset_key, steps_key = jax.random.split(key)
        return jax.lax.scan(advance, env.reset(reset_key)[1], jax.random.split(steps_key, STEPS))[1]

    return jax.tree.map(np.asarray, play(jax.random.key(seed)))


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, marks=pytest.mark.thorough)
        if path.stem in ("compass", "turning")
        else path
        for path in sorted(GAMES.glob("*.sj"))
    ],
    ids=lambda path: path.stem,
)
def test_compiled_equals_interpreted(path: Path) -> None:
    """In states that random agents lead to; the choices alone are compiled by XLA, and the steps run on NumPy."""
    game = build(read_source(path)).game
    play = random_play(game, seed=1, steps=STEPS)
    history, env = interpret(game, play), on_numpy(game)
    states = [state for state, *_ in moments(env, play, len(history.moments))]
    assert len(states) == STEPS + 1
    assert not different_choice(
        game, env, states[1:], [moment.ended for moment in history.moments], seed=0
    )


@pytest.mark.thorough
@pytest.mark.usefixtures("strict_jax")
@pytest.mark.parametrize("path", sorted(GAMES.glob("*.sj")), ids=lambda path: path.stem)
def test_compiled_equals_interpreted_where_the_policies_lead(path: Path) -> None:
    env = sjdsl.make(path)
    params = {param.name: param.value for param in env.game.params}
    states, bits, chosen = played(env, seed=0)
    for at in range(STEPS):
        world = world_of(env, jax.tree.map(lambda leaf, at=at: leaf[at], states), params)
        for policy, compiled in zip(env.game.policies, chosen[at], strict=True):
            expected = [
                choose(policy, env.game, world, agent, tuple(map(int, bits[at, agent])))
                for agent in range(env.num_agents)
            ]
            assert compiled.tolist() == expected, (policy.name, world)
    for number, policy in enumerate(env.game.policies):
        assert len(set(chosen[:, number].flat)) > 1, f"{policy.name} always does the same"
