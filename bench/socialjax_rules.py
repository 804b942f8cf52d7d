"""Plays games of SocialJax in the suite's own code and in ours (variant `socialjax`), from the same states and with its trained policies.

    git clone https://github.com/cooperativex/SocialJax && git -C SocialJax checkout 9df972d
    .venv/bin/python -m bench.socialjax_rules SocialJax --episodes 48 > rules.md

It prints three tables. *Steps*: both play one step from states that the suite visits. *Policies*: the policies of the folder
`checkpoints` (commit 7102d03) play whole episodes in both, on observations that the suite's code makes, of our states too.
*Random play*: returns and events of whole episodes of random actions. Only on a CPU are the suite's writes to one cell in a fixed order.
"""

import argparse
import math
import pickle
import statistics
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from bench.socialjax_games import BRIDGES, ORIGINALS, Bridge, suite_game
from sjdsl.interop import socialjax

STEPS = 1000  # of an episode
T_95 = 1.96  # of a difference of two means of at least 48 episodes each


def main() -> None:
    """Prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("checkout", type=Path, help="a checkout of SocialJax")
    parser.add_argument("--games", nargs="*", default=None, help="ours, played from the same states and by policies; all by default")
    parser.add_argument("--ids", nargs="*", default=None, help="the suite's, played at random; all by default")
    parser.add_argument("--episodes", type=int, default=48, help="of each policy in each code")
    parser.add_argument("--random-episodes", type=int, default=100, help="of random play in each code")
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    key = jax.random.key(asked.seed)
    print("| id | what, random play | suite | ours | difference |\n| --- | --- | --: | --: | --: |")
    for identity in ORIGINALS if asked.ids is None else asked.ids:
        random_play(asked.checkout, identity, asked.random_episodes, key)
    bridges = [BRIDGES[name](asked.checkout) for name in (BRIDGES if asked.games is None else asked.games)]
    print()
    print("| game | policy | what | suite | ours | difference |\n| --- | --- | --- | --: | --: | --: |")
    for bridge in bridges:
        compare(bridge, "random", random_policy(bridge), asked.random_episodes, key)
        if bridge.checkpoint:
            compare(bridge, "trained", trained_policy(asked.checkout / "checkpoints" / bridge.checkpoint), asked.episodes, key)


def random_play(checkout: Path, identity: str, episodes: int, key: Array) -> None:
    """Prints the rows of random play in one game of the suite, and in ours behind our adapter."""
    original, agents, steps = ORIGINALS[identity]
    theirs = random_figures(suite_game(checkout, original, steps, num_agents=agents), steps, episodes, key)
    ours = random_figures(socialjax.make(identity, num_agents=agents, shared_rewards=False), steps, episodes, jax.random.fold_in(key, 1))
    for figure in theirs:
        one, two = theirs[figure].tolist(), ours[figure].tolist()
        difference = statistics.fmean(two) - statistics.fmean(one)
        print(
            f"| `{identity}` | {figure} | {mean(one)} | {mean(two)} | {difference:+.2f} ± {math.hypot(half(one), half(two)):.2f} |",
            flush=True,
        )


def random_figures(env: Any, steps: int, episodes: int, key: Array) -> dict[str, Array]:
    """Returns the return and the sums of the infos of each episode of random play, over the agents: of the suite, or of our adapter."""

    @jax.jit
    def run(key: Array) -> dict[str, Array]:
        first, key = jax.random.split(key)
        _, states = jax.vmap(env.reset)(jax.random.split(first, episodes))

        def body(carry: Any, key: Array) -> tuple[Any, dict[str, Array]]:
            states, over = carry
            acting, stepping = jax.random.split(key)
            actions = jax.random.randint(
                acting, (episodes, env.num_agents), 0, env.num_actions if hasattr(env, "num_actions") else env.action_space().n
            )
            _, states, rewards, done, infos = jax.vmap(env.step_env)(jax.random.split(stepping, episodes), states, actions)
            row = {name: infos[name] for name in infos if not name.endswith("_rewards")}
            sums = {
                name: jnp.where(over, 0, jnp.reshape(value, (episodes, -1)).sum(axis=1))
                for name, value in {"return": rewards, **row}.items()
            }
            return (states, over | done["__all__"]), sums

        _, rows = jax.lax.scan(body, (states, jnp.zeros(episodes, bool)), jax.random.split(key, steps - 1))
        return jax.tree.map(lambda each: each.sum(axis=0), rows)

    return run(key)


Policy = Callable[[Array, Array], Array]  # key and observations [E, N, rows, cols, channels] to actions [E, N] of the suite


def random_policy(bridge: Bridge) -> Policy:
    """Returns the policy that takes all actions with equal probability."""
    return lambda key, seen: jax.random.randint(key, seen.shape[:2], 0, bridge.suite.num_actions)


def trained_policy(file: Path) -> Policy:
    """Returns the policy of a checkpoint: three convolutions, three dense layers, sampled actions."""
    layers = pickle.loads(file.read_bytes())["params"]

    def dense(layer: Mapping[str, Array], x: Array) -> Array:
        return x @ layer["kernel"] + layer["bias"]

    def act(key: Array, seen: Array) -> Array:
        x = seen.reshape(-1, *seen.shape[2:]).astype(jnp.float32)
        for number in range(3):
            layer = layers["CNN_0"][f"Conv_{number}"]
            x = jax.lax.conv_general_dilated(x, layer["kernel"], (1, 1), "SAME", dimension_numbers=("NHWC", "HWIO", "NHWC"))
            x = jax.nn.relu(x + layer["bias"])
        x = jax.nn.relu(dense(layers["CNN_0"]["Dense_0"], x.reshape(len(x), -1)))
        logits = dense(layers["Dense_1"], jax.nn.relu(dense(layers["Dense_0"], x)))
        return jax.random.categorical(key, logits).reshape(seen.shape[:2])

    return act


def compare(bridge: Bridge, name: str, policy: Policy, episodes: int, key: Array) -> None:
    """Prints the rows of one policy in one game: means of both codes with 95 % intervals, and the differences."""
    theirs, apart = play_suite(bridge, policy, episodes, key)
    ours = play_ours(bridge, policy, episodes, jax.random.fold_in(key, 1))
    for figure in theirs:
        one, two = theirs[figure].tolist(), ours[figure].tolist()
        difference = statistics.fmean(two) - statistics.fmean(one)
        print(
            f"| `{bridge.name}` | {name} | {figure} | {mean(one)} | {mean(two)} | {difference:+.1f} ± {math.hypot(half(one), half(two)):.1f} |"
        )
    for figure, number in apart.items():
        print(f"| `{bridge.name}` | {name} | {figure} | | | {float(number):.0f} of {episodes * (STEPS - 1):,} |", flush=True)


def mean(values: list[float]) -> str:
    """Returns a mean with its 95 % interval."""
    return f"{statistics.fmean(values):.1f} ± {half(values):.1f}"


def half(values: list[float]) -> float:
    """Returns half the width of the 95 % interval of a mean."""
    return T_95 * statistics.stdev(values) / math.sqrt(len(values))


def play_suite(bridge: Bridge, policy: Policy, episodes: int, key: Array) -> tuple[dict[str, Array], dict[str, Array]]:
    """Returns the figures of each episode in the suite, and of how many of its steps ours differ from the same state."""

    @jax.jit
    def run(key: Array) -> tuple[dict[str, Array], dict[str, Array]]:
        first, key = jax.random.split(key)
        seen, states = jax.vmap(bridge.suite.reset)(jax.random.split(first, episodes))

        def body(carry: Any, key: Array) -> tuple[Any, dict[str, Array]]:
            seen, states = carry
            acting, stepping = jax.random.split(key)
            actions = policy(acting, seen)
            keys = jax.random.split(stepping, episodes)
            seen, after, rewards, _, _ = jax.vmap(bridge.suite.step_env)(keys, states, actions)
            differences = {}
            if bridge.stepwise:
                ours = jax.vmap(bridge.step_from)(keys, states, actions)
                differences = jax.vmap(bridge.differences)(states, actions, after, ours)
            return (seen, after), {"figures": jax.vmap(bridge.suite_figures)(after, rewards, actions), "apart": differences}

        _, rows = jax.lax.scan(body, (seen, states), jax.random.split(key, STEPS - 1))
        apart = jax.tree.map(lambda each: each.sum(), rows["apart"])
        return jax.tree.map(lambda each: each.sum(axis=0), rows["figures"]), apart

    return run(key)


def play_ours(bridge: Bridge, policy: Policy, episodes: int, key: Array) -> dict[str, Array]:
    """Returns the figures of each episode in ours; the policy sees what the suite's code makes of our states."""

    @jax.jit
    def run(key: Array) -> dict[str, Array]:
        first, key = jax.random.split(key)
        _, states = jax.vmap(bridge.ours.reset)(jax.random.split(first, episodes))
        carried = jax.vmap(bridge.begin)(states)
        seen = jax.vmap(bridge.observe)(carried)

        def body(carry: Any, key: Array) -> tuple[Any, dict[str, Array]]:
            seen, states, carried = carry
            acting, stepping = jax.random.split(key)
            actions = policy(acting, seen)
            states, carried, figures = jax.vmap(bridge.step)(jax.random.split(stepping, episodes), states, carried, actions)
            return (jax.vmap(bridge.observe)(carried), states, carried), figures

        _, rows = jax.lax.scan(body, (seen, states, carried), jax.random.split(key, STEPS - 1))
        return jax.tree.map(lambda each: each.sum(axis=0), rows)

    return run(key)


if __name__ == "__main__":
    main()
