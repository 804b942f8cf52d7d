"""Plays games of SocialJax in the suite's own code and in ours (variant `socialjax`), from the same states and with its trained policies.

    git clone https://github.com/cooperativex/SocialJax && git -C SocialJax checkout 9df972d
    .venv/bin/python -m bench.socialjax_rules SocialJax > rules.md

It prints two tables. The first has random play of each game of the suite, and of ours behind our adapter for it. The second has
games in which the suite's code computes the observation of our states, too: whole episodes of random play and of the policies
of the folder `checkpoints` (commit 7102d03), and how often single steps from one state differ. The suite's writes to one cell
have a fixed order only on a CPU.
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

from bench.socialjax_games import BRIDGES, ORIGINALS, Bridge, Figures, suite_game
from sjdsl.interop import socialjax

STEPS = 1000  # of an episode; the last one isn't played, because the suite begins anew in it
Z_95 = 1.96  # of the mean of at least 48 episodes
Policy = Callable[[Array, Array], Array]  # key and observations [E, N, H, W, C] to actions [E, N]


def main() -> None:
    """Prints the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add = parser.add_argument
    add("checkout", type=Path, help="a checkout of SocialJax")
    add("--ids", nargs="*", default=[*ORIGINALS], help="the suite's, of the first table")
    add("--games", nargs="*", default=[*BRIDGES], help="ours, of the second table")
    add("--episodes", type=int, default=48, help="of each policy in each code")
    add("--random-episodes", type=int, default=100, help="of random play in each code")
    add("--seed", type=int, default=1)
    asked = parser.parse_args()
    key = jax.random.key(asked.seed)
    another = jax.random.fold_in(key, 1)
    heading("suite", "ours")
    for name in asked.ids:
        original, agents, steps = ORIGINALS[name]
        game = suite_game(asked.checkout, original, steps, num_agents=agents)
        adapter = socialjax.make(name, num_agents=agents, shared_rewards=False)
        theirs = play_at_random(game, game.num_actions, steps, asked.random_episodes, key)
        actions = adapter.action_space().n
        ours = play_at_random(adapter, actions, steps, asked.random_episodes, another)
        print_rows(f"`{name}`, random", theirs, ours)
    print()
    heading("suite", "ours")
    for name in asked.games:
        bridge = BRIDGES[name](asked.checkout)
        policies = {"random": (random_policy(bridge), asked.random_episodes)}
        if bridge.checkpoint:
            file = asked.checkout / "checkpoints" / bridge.checkpoint
            policies["trained"] = (trained_policy(file), asked.episodes)
        for kind, (policy, episodes) in policies.items():
            theirs, apart = play_suite(bridge, policy, episodes, key, bridge.stepwise)
            ours = play_ours(bridge, policy, episodes, another)
            print_rows(f"`{name}`, {kind}", theirs, ours)
            for what, count in apart.items():
                share = f"{float(count):.0f} of {episodes * (STEPS - 1):,}"
                print(f"| `{name}`, {kind} | {what} | | | {share} |", flush=True)


def heading(one: str, other: str) -> None:
    """Prints the head of a table of two codes."""
    print(
        f"| game, policy | what | {one} | {other} | difference |\n| --- | --- | --: | --: | --: |"
    )


def print_rows(first: str, one: Figures, other: Figures) -> None:
    """Prints the means of two sets of episodes with their 95 % intervals, and the differences; figures are `[E]`."""
    for figure in one:
        before, after = one[figure].tolist(), other[figure].tolist()
        difference = statistics.fmean(after) - statistics.fmean(before)
        width = math.hypot(half(before), half(after))
        means = f"{mean(before)} | {mean(after)}"
        print(f"| {first} | {figure} | {means} | {difference:+.1f} ± {width:.1f} |", flush=True)


def mean(values: list[float]) -> str:
    """Returns a mean with its 95 % interval."""
    return f"{statistics.fmean(values):.1f} ± {half(values):.1f}"


def half(values: list[float]) -> float:
    """Returns half the width of the 95 % interval of a mean."""
    return Z_95 * statistics.stdev(values) / math.sqrt(len(values))


def random_policy(bridge: Bridge) -> Policy:
    """Returns the policy that takes all actions with equal probability."""
    return lambda key, seen: jax.random.randint(key, seen.shape[:2], 0, bridge.suite.num_actions)


def trained_policy(file: Path) -> Policy:
    """Returns the policy of a checkpoint: three convolutions, three dense layers, sampled actions."""
    layers = pickle.loads(file.read_bytes())["params"]

    def dense(layer: Mapping[str, Array], x: Array) -> Array:
        return x @ layer["kernel"] + layer["bias"]

    def convolution(layer: Mapping[str, Array], x: Array) -> Array:
        axes = ("NHWC", "HWIO", "NHWC")
        x = jax.lax.conv_general_dilated(x, layer["kernel"], (1, 1), "SAME", dimension_numbers=axes)
        return x + layer["bias"]

    def act(key: Array, seen: Array) -> Array:
        x = seen.reshape(-1, *seen.shape[2:]).astype(jnp.float32)
        for number in range(3):
            x = jax.nn.relu(convolution(layers["CNN_0"][f"Conv_{number}"], x))
        x = jax.nn.relu(dense(layers["CNN_0"]["Dense_0"], x.reshape(len(x), -1)))
        logits = dense(layers["Dense_1"], jax.nn.relu(dense(layers["Dense_0"], x)))
        return jax.random.categorical(key, logits).reshape(seen.shape[:2])

    return act


def play_at_random(env: Any, actions: int, steps: int, episodes: int, key: Array) -> Figures:
    """Returns the return and the sums of the infos of each episode of random play, over the agents."""

    def figures(rewards: Array, infos: Figures) -> Figures:
        shown = {name: infos[name] for name in infos if not name.endswith("_rewards")}
        rows = {"return": rewards, **shown}
        return {name: jnp.reshape(row, (episodes, -1)).sum(axis=1) for name, row in rows.items()}

    def body(carry: Any, key: Array) -> tuple[Any, Figures]:
        states, over = carry
        acting, stepping = jax.random.split(key)
        chosen = jax.random.randint(acting, (episodes, env.num_agents), 0, actions)
        keys = jax.random.split(stepping, episodes)
        _, states, rewards, done, infos = jax.vmap(env.step_env)(keys, states, chosen)
        row = {name: jnp.where(over, 0, value) for name, value in figures(rewards, infos).items()}
        return (states, over | done["__all__"]), row

    @jax.jit
    def run(key: Array) -> Figures:
        first, key = jax.random.split(key)
        _, states = jax.vmap(env.reset)(jax.random.split(first, episodes))
        start = (states, jnp.zeros(episodes, bool))
        _, rows = jax.lax.scan(body, start, jax.random.split(key, steps - 1))
        return jax.tree.map(lambda each: each.sum(axis=0), rows)

    return run(key)


def play_suite(
    bridge: Bridge, policy: Policy, episodes: int, key: Array, stepwise: bool
) -> tuple[Figures, Figures]:
    """Returns the figures of each episode in the suite, `[E]`.

    With `stepwise`, also in how many of all its steps ours differ from the same state.
    """

    def body(carry: Any, key: Array) -> tuple[Any, tuple[Figures, Figures]]:
        seen, states = carry
        acting, stepping = jax.random.split(key)
        actions = policy(acting, seen)
        keys = jax.random.split(stepping, episodes)
        seen, after, rewards, _, _ = jax.vmap(bridge.suite.step_env)(keys, states, actions)
        totals = jax.vmap(bridge.suite_return)(rewards)
        figures = jax.vmap(bridge.figures)(after, totals, actions)
        apart: Figures = {}
        if stepwise:
            ours = jax.vmap(bridge.step_from)(keys, states, actions)
            apart = jax.vmap(bridge.differences)(states, actions, after, ours)
        return (seen, after), (figures, apart)

    @jax.jit
    def run(key: Array) -> tuple[Figures, Figures]:
        first, key = jax.random.split(key)
        start = jax.vmap(bridge.suite.reset)(jax.random.split(first, episodes))
        _, (figures, apart) = jax.lax.scan(body, start, jax.random.split(key, STEPS - 1))
        sums = jax.tree.map(lambda each: each.sum(axis=0), figures)
        return sums, jax.tree.map(lambda each: each.sum(), apart)

    return run(key)


def play_ours(bridge: Bridge, policy: Policy, episodes: int, key: Array) -> Figures:
    """Returns the figures of each episode in ours, `[E]`; the policy sees what the suite's code makes of our states."""

    def body(carry: Any, key: Array) -> tuple[Any, Figures]:
        states, shown = carry
        acting, stepping = jax.random.split(key)
        actions = policy(acting, jax.vmap(bridge.see)(shown))
        keys = jax.random.split(stepping, episodes)
        states, shown, figures = jax.vmap(bridge.step)(keys, states, shown, actions)
        return (states, shown), figures

    @jax.jit
    def run(key: Array) -> Figures:
        first, key = jax.random.split(key)
        _, states = jax.vmap(bridge.ours.reset)(jax.random.split(first, episodes))
        start = (states, jax.vmap(bridge.begin)(states))
        _, rows = jax.lax.scan(body, start, jax.random.split(key, STEPS - 1))
        return jax.tree.map(lambda each: each.sum(axis=0), rows)

    return run(key)


if __name__ == "__main__":
    main()
