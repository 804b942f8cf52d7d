"""Converts observations to the one-hot channels of SocialJax, in its order."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import jax.numpy as jnp
from jax import Array

from sjdsl.interop.socialjax_table import EVERYONE, Entry, Source, channels_of
from sjdsl.runtime.env import Environment

TURNED = ("same heading", "turned left", "opposite", "turned right")


def make_channels(env: Environment, entry: Entry) -> tuple[int, Callable[[Array], Array]]:
    """Returns the number of channels, and the function that makes them.

    It is `(observation [N, C, rows, cols]) -> [N, rows, cols, C'] float32`.

    Args:
      env: with one-hot observations.
    """
    if entry.layers:
        return len(entry.layers), partial(_layers, entry.layers, env.channel_names)
    index = {name: number for number, name in enumerate(env.channel_names)}
    same, left, opposite, right = TURNED
    order = (same, left, opposite, right)
    if entry.headings == "right first":
        order = (same, right, opposite, left)
    headings = [f"agent: other {heading}" for heading in order]
    sources: list[Source] = ["agent: self", headings, *headings]
    for source in entry.rest:  # one channel, or one for each agent
        if source.startswith(EVERYONE):
            sources.extend(channels_of(source, env.num_agents))
        else:
            sources.append(source)

    def plane_of(observation: Array, source: Source) -> Array:
        """Returns the sum of the channels of a source, `[N, rows, cols]`."""
        planes = [observation[:, index[name]] for name in channels_of(source, env.num_agents)]
        return sum(planes[1:], planes[0]) if planes else jnp.zeros_like(observation[:, 0])

    def channels(observation: Array) -> Array:
        has_no_agent = observation[:, index["agent: none"]]
        planes = [plane_of(observation, source) * has_no_agent for source in entry.tiles]
        planes += [plane_of(observation, source) for source in sources]
        return jnp.stack([plane.astype(jnp.float32) for plane in planes], axis=-1)

    return len(entry.tiles) + len(sources), channels


def _layers(layers: Sequence[Mapping[str, int]], names: Sequence[str], observation: Array) -> Array:
    """Returns weighted sums of channels, `[N, rows, cols, layers]` float32.

    Channels of the observer itself, `agent.…`, count at its cell only.
    """
    planes = {name: observation[:, number].astype(jnp.float32) for number, name in enumerate(names)}
    is_self = planes["agent: self"]
    for name in planes:
        if name.startswith("agent."):
            planes[name] = planes[name] * is_self
    # A layer of the suite adds up channels of ours, by name.
    sums = [sum(weight * planes[name] for name, weight in layer.items()) for layer in layers]
    return jnp.stack(sums, axis=-1)
