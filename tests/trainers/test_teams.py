"""Which agents share a network, and that sharing changes nothing else."""

import dataclasses
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from probes import FAST_TO_COMPILE, Probe, matching, quick, windows

from sjdsl.trainers import ConfigError, PPOConfig, make_train
from sjdsl.trainers.networks.actor_critics import ActorCritics, make_actor_critics

CENTRAL = {"algorithm": "mappo"}


def three(**changes: Any) -> tuple[Probe, ActorCritics]:
    """Returns a probe of three agents and its networks."""
    env = dataclasses.replace(matching(), num_agents=3)
    config = quick(**changes)
    assert isinstance(config, PPOConfig)
    return env, make_actor_critics(env, config)


@pytest.mark.parametrize(
    ("changes", "teams"),
    [
        ({}, [[0, 1, 2]]),
        ({"sharing": "per_agent"}, [[0], [1], [2]]),
        ({"partners": "1=random"}, [[0, 2]]),
        ({"sharing": "per_agent", "partners": "1=random"}, [[0], [2]]),
    ],
)
def test_agents_that_learn_share_a_network_or_have_one_each(
    changes: dict[str, Any], teams: list[list[int]]
) -> None:
    _, networks = three(**changes)
    assert networks.teams.tolist() == teams


class _Blind:
    """A probe without a vector of its state."""

    def __init__(self, probe: Probe) -> None:
        self.probe = probe

    def __getattr__(self, name: str) -> Any:
        if name == "state_vector":
            raise AttributeError(name)
        return getattr(self.probe, name)


def test_a_critic_of_the_state_needs_one() -> None:
    config = PPOConfig(algorithm="mappo", critic="state")
    with pytest.raises(
        ConfigError,
        match='`matching` has no state_vector for a critic of the state; choose critic = "observations"',
    ):
        make_train(_Blind(matching()), config)  # type: ignore[arg-type]


class _Forgetful(_Blind):
    """A probe that has a vector of its state, but doesn't tell in which state an episode ended."""

    def __getattr__(self, name: str) -> Any:
        return getattr(self.probe, name)

    def step(self, *given: Any) -> Any:
        *stepped, info = self.probe.step(*given)
        return *stepped, {name: value for name, value in info.items() if name != "terminal_state"}


def test_a_critic_of_the_state_needs_that_of_the_end() -> None:
    program = make_train(_Forgetful(matching()), quick(**CENTRAL, critic="state"))  # type: ignore[arg-type]
    with pytest.raises(
        ConfigError,
        match='`matching` gives no terminal_state in the info of a step; choose critic = "observations"',
    ):
        jax.eval_shape(lambda key: program.collect(program.init(key)), jax.random.key(0))


def test_a_pooled_critic_needs_a_network_that_agents_share() -> None:
    config = quick(**CENTRAL, critic="pooled", sharing="per_agent")
    with pytest.raises(ConfigError, match="set sharing=shared, or critic to observations or state"):
        make_train(matching(), config)


# numbers of agents


# one agent


def _alone(sharing: str) -> tuple[Probe, dict[str, Any]]:
    return matching(1), {"sharing": sharing}


def test_one_agent_is_one_network_however_it_is_shared() -> None:
    shapes = []
    for env, changes in map(_alone, ("shared", "per_agent")):
        networks = make_actor_critics(env, quick(**changes))
        assert networks.teams.tolist() == [[0]]
        shapes.append(jax.eval_shape(partial(networks.init, env=env), jax.random.key(0)))
    shared, apart = shapes
    assert apart == shared


# several networks


@pytest.mark.parametrize(
    "changes",
    [
        {"sharing": "per_agent"},
        {"sharing": "per_agent", "reward": "common", "reward_horizons": (2.0, 9.0)},
        pytest.param({"sharing": "per_agent", "algorithm": "mappo"}, marks=pytest.mark.slow),
        pytest.param(
            {"sharing": "per_agent", "memory": "gru", "agent_id": True}, marks=pytest.mark.thorough
        ),
    ],
    ids=["per agent", "rewards of late", "mappo", "memory and numbers"],
)
def test_what_an_agent_does_comes_from_its_teams_network(changes: dict[str, Any]) -> None:
    """Logits, values and memory of all agents at once are those of each team's network on its own."""
    env, networks = three(**changes)
    fresh = jnp.zeros((2, 4), bool)
    seen = jnp.stack(
        [
            jnp.stack([windows(env, [step, env_index % 2, 2]) for env_index in range(4)])
            for step in (0, 1)
        ]
    )
    recent = jnp.linspace(-1, 1, 2 * 4 * 3 * 2).reshape(2, 4, 3, 2)

    def joint_of(agents: np.ndarray) -> jax.Array | None:
        """Returns what the critic of some agents reads besides their windows."""
        if "reward_horizons" in changes:
            return jnp.arcsinh(10 * recent[:, :, agents])
        return seen.reshape(2, 4, 3, 1, 1) if changes.get("algorithm") == "mappo" else None

    def both(key: jax.Array) -> tuple[Any, Any]:
        parameters = networks.init(key, env)
        start = networks.start_memory(4)
        _, logits, values = networks.apply(
            parameters, start, seen, networks.joint(seen, recent), fresh
        )
        apart = []
        for index, agents in enumerate(networks.teams):
            own = jax.tree.map(lambda leaf: leaf[index], parameters)  # noqa: B023
            network = networks.network
            apart.append(
                network.apply(
                    own,
                    network.start_memory(4),
                    seen[:, :, np.asarray(agents)],
                    joint_of(np.asarray(agents)),
                    fresh,
                    np.asarray(agents),
                )[1:]
            )
        return (logits, values), tuple(
            jnp.concatenate(part, axis=2) for part in zip(*apart, strict=True)
        )

    together, apart = jax.jit(both, compiler_options=FAST_TO_COMPILE)(jax.random.key(0))
    jax.tree.map(lambda a, b: np.testing.assert_allclose(a, b, atol=1e-6), together, apart)
    differs = np.abs(np.asarray(together[1])[..., :, None] - np.asarray(together[1])[..., None, :])
    assert differs[..., 0, 1].min() > 1e-6


def test_networks_of_agents_start_different() -> None:
    networks = make_actor_critics(matching(), quick(sharing="per_agent"))
    start = jax.jit(lambda key: networks.init(key, matching()), compiler_options=FAST_TO_COMPILE)
    parameters = start(jax.random.key(0))
    kernels = [np.asarray(leaf) for leaf in jax.tree.leaves(parameters) if leaf.ndim == 3]
    assert len(kernels) == 5
    for kernel in kernels:
        assert np.abs(kernel[0] - kernel[1]).max() > 1e-3
