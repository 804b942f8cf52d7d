"""Converts observations to the one-hot channels of SocialJax, in its order."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import jax.numpy as jnp
from jax import Array

from sjdsl.interop.socialjax_table import EVERYONE, Entry, Source, channels_of
from sjdsl.runtime.env import Environment

TURNED = ("same heading", "turned left", "opposite", "turned right")


def make_channels(env: Environment, entry: Entry) -> tuple[int, Callable[[Array], Array]]:
    """Returns the number of channels, and the function `(observation [N, C, rows, cols]) -> [N, rows, cols, C'] float32`.

    Args:
      env: with one-hot observations.
    """
    if entry.layers:
        return len(entry.layers), partial(_layers, entry.layers, env.channel_names)
    index = {name: number for number, name in enumerate(env.channel_names)}
    turned = (
        TURNED if entry.headings == "left first" else (TURNED[0], TURNED[3], TURNED[2], TURNED[1])
    )
    headings = [f"agent: other {name}" for name in turned]
    others: list[Source] = ["agent: self", headings, *headings]
    rest: list[str] = []
    for source in entry.rest:  # one channel, or one for each agent
        rest += channels_of(source, env.num_agents) if source.startswith(EVERYONE) else [source]

    def any_of(observation: Array, source: Source) -> Array:
        planes = [observation[:, index[name]] for name in channels_of(source, env.num_agents)]
        return sum(planes[1:], planes[0]) if planes else jnp.zeros_like(observation[:, 0])

    def channels(observation: Array) -> Array:
        bare = observation[:, index["agent: none"]]
        tiles = [any_of(observation, source) * bare for source in entry.tiles]
        agents = [any_of(observation, source) for source in others]
        further = [any_of(observation, source) for source in rest]
        return jnp.stack(
            [plane.astype(jnp.float32) for plane in (*tiles, *agents, *further)], axis=-1
        )

    return len(entry.tiles) + 2 + len(TURNED) + len(rest), channels


def _layers(layers: Sequence[Mapping[str, int]], names: Sequence[str], observation: Array) -> Array:
    """Returns `[N, rows, cols, layers]` float32: weighted sums of channels. The observer's own channels count at its own cell only."""
    planes = {name: observation[:, number].astype(jnp.float32) for number, name in enumerate(names)}
    own = planes["agent: self"]
    sums = [
        sum(
            weight * planes[name] * (own if name.startswith("agent.") else 1.0)
            for name, weight in layer.items()
        )
        for layer in layers
    ]
    return jnp.stack(sums, axis=-1)
