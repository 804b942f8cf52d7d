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
from functools import partial
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
    print_heading("suite", "ours")
    for name in asked.ids:
        original, agents, steps = ORIGINALS[name]
        game = suite_game(asked.checkout, original, steps, num_agents=agents)
        adapter = socialjax.make(name, num_agents=agents, shared_rewards=False)
        theirs = play_at_random(game, game.num_actions, steps, asked.random_episodes, key)
        actions = adapter.action_space().n
        ours = play_at_random(adapter, actions, steps, asked.random_episodes, another)
        print_rows(f"`{name}`, random", theirs, ours)
    print()
    print_heading("suite", "ours")
    for name in asked.games:
        bridge = BRIDGES[name](asked.checkout)
        policies = {"random": (random_policy(bridge), asked.random_episodes)}
        if bridge.checkpoint:
            file = asked.checkout / "checkpoints" / bridge.checkpoint
            policies["trained"] = (trained_policy(file), asked.episodes)
        for kind, (policy, episodes) in policies.items():
            theirs, differences = play_suite(bridge, policy, episodes, key, bridge.stepwise)
            ours = play_ours(bridge, policy, episodes, another)
            print_rows(f"`{name}`, {kind}", theirs, ours)
            for difference, count in differences.items():
                share = f"{float(count):.0f} of {episodes * (STEPS - 1):,}"
                print(f"| `{name}`, {kind} | {difference} | | | {share} |", flush=True)


def print_heading(one: str, other: str) -> None:
    """Prints the head of a table that compares two columns."""
    print(
        f"| game, policy | what | {one} | {other} | difference |\n| --- | --- | --: | --: | --: |"
    )


def print_rows(first: str, one: Figures, other: Figures) -> None:
    """Prints the means of two sets of episodes with their 95 % intervals, and the differences; figures are `[E]`."""
    for figure in one:
        values = one[figure].tolist()
        other_values = other[figure].tolist()
        difference = statistics.fmean(other_values) - statistics.fmean(values)
        width = math.hypot(half_width(values), half_width(other_values))
        means = f"{mean_text(values)} | {mean_text(other_values)}"
        print(f"| {first} | {figure} | {means} | {difference:+.1f} ± {width:.1f} |", flush=True)


def mean_text(values: list[float]) -> str:
    """Returns a mean with its 95 % interval: `1.5 ± 0.2`."""
    return f"{statistics.fmean(values):.1f} ± {half_width(values):.1f}"


def half_width(values: list[float]) -> float:
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
    """Returns the return and the sums of the infos of each episode of random play, over the agents, `[E]` each."""

    def figures(rewards: Array, infos: Figures) -> Figures:
        values = {"return": rewards}
        values |= {name: infos[name] for name in infos if not name.endswith("_rewards")}
        return {name: jnp.reshape(value, (episodes, -1)).sum(1) for name, value in values.items()}

    def body(carry: Any, key: Array) -> tuple[Any, Figures]:
        states, is_over = carry
        action_key, step_key = jax.random.split(key)
        chosen = jax.random.randint(action_key, (episodes, env.num_agents), 0, actions)
        keys = jax.random.split(step_key, episodes)
        _, states, rewards, done, infos = jax.vmap(env.step_env)(keys, states, chosen)
        counted = {
            name: jnp.where(is_over, 0, value) for name, value in figures(rewards, infos).items()
        }
        return (states, is_over | done["__all__"]), counted

    reset_key, key = jax.random.split(key)
    _, states = jax.vmap(env.reset)(jax.random.split(reset_key, episodes))
    return sum_over_steps(body, (states, jnp.zeros(episodes, bool)), key, steps)


@partial(jax.jit, static_argnums=(0, 3))
def sum_over_steps(
    body: Callable[[Any, Array], tuple[Any, Any]], start: Any, key: Array, steps: int
) -> Any:
    """Returns the sums of what each step but the last of an episode gives. body: as of `scan`."""
    _, by_step = jax.lax.scan(body, start, jax.random.split(key, steps - 1))
    return jax.tree.map(lambda values: values.sum(axis=0), by_step)


def play_suite(
    bridge: Bridge, policy: Policy, episodes: int, key: Array, stepwise: bool
) -> tuple[Figures, Figures]:
    """Returns the figures of each episode in the suite, `[E]`, and differences: scalars.

    differences: with `stepwise`, in how many steps ours, from the same state, differs in which way; else none.
    """

    def body(carry: Any, key: Array) -> tuple[Any, tuple[Figures, Figures]]:
        observations, states = carry
        action_key, step_key = jax.random.split(key)
        actions = policy(action_key, observations)
        keys = jax.random.split(step_key, episodes)
        observations, after, rewards, _, _ = jax.vmap(bridge.suite.step_env)(keys, states, actions)
        totals = jax.vmap(bridge.suite_return)(rewards)
        figures = jax.vmap(bridge.figures)(after, totals, actions)
        differences: Figures = {}
        if stepwise:
            ours = jax.vmap(bridge.step_from)(keys, states, actions)
            differences = jax.vmap(bridge.differences)(states, actions, after, ours)
        return (observations, after), (figures, differences)

    reset_key, key = jax.random.split(key)
    start = jax.vmap(bridge.suite.reset)(jax.random.split(reset_key, episodes))
    figures, differences = sum_over_steps(body, start, key, STEPS)
    return figures, jax.tree.map(jnp.sum, differences)


def play_ours(bridge: Bridge, policy: Policy, episodes: int, key: Array) -> Figures:
    """Returns the figures of each episode in ours, `[E]`; the policy sees what the suite's code makes of our states."""

    def body(carry: Any, key: Array) -> tuple[Any, Figures]:
        states, shown = carry
        action_key, step_key = jax.random.split(key)
        actions = policy(action_key, jax.vmap(bridge.see)(shown))
        keys = jax.random.split(step_key, episodes)
        states, shown, figures = jax.vmap(bridge.step)(keys, states, shown, actions)
        return (states, shown), figures

    reset_key, key = jax.random.split(key)
    _, states = jax.vmap(bridge.ours.reset)(jax.random.split(reset_key, episodes))
    return sum_over_steps(body, (states, jax.vmap(bridge.begin)(states)), key, STEPS)


if __name__ == "__main__":
    main()
