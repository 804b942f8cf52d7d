"""The released suite's one-hot channels from ours, in its order."""

import re
from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
from jax import Array

from sjdsl.interop.socialjax_table import Entry, Source
from sjdsl.runtime.env import Environment

TURNED = ("same heading", "turned left", "opposite", "turned right")
ALL = re.compile(r"all (\w+)\[(\d+)\]")


def make_channels(env: Environment, entry: Entry) -> tuple[int, Callable[[Array, Any], Array]]:
    """Returns how many channels there are, and the function `(observation [N, C, rows, cols], state) -> [N, rows, cols, C'] float32`.

    Args:
      env: with one-hot observations.
    """
    index = {name: number for number, name in enumerate(env.channel_names)}
    turned = TURNED if entry.headings == "left first" else (TURNED[0], TURNED[3], TURNED[2], TURNED[1])
    headings = [f"agent: other {name}" for name in turned]

    def any_of(observation: Array, source: Source) -> Array:
        names = [source] if isinstance(source, str) else source
        planes = [observation[:, index[name]] for name in names if name]
        return sum(planes[1:], planes[0]) if planes else jnp.zeros_like(observation[:, 0])

    def extra(observation: Array, state: Any, source: str) -> list[Array]:
        everyone = ALL.fullmatch(source)
        if everyone is None:
            return [any_of(observation, source)]
        values = getattr(state, everyone[1])[:, int(everyone[2])]
        return [jnp.broadcast_to(value, observation[:, 0].shape) for value in values]

    def channels(observation: Array, state: Any) -> Array:
        bare = observation[:, index["agent: none"]]
        tiles = [any_of(observation, source) * bare for source in entry.tiles]
        agents = [any_of(observation, source) for source in ("agent: self", headings, *headings)]
        rest = [plane for source in entry.rest for plane in extra(observation, state, source)]
        return jnp.stack([plane.astype(jnp.float32) for plane in (*tiles, *agents, *rest)], axis=-1)

    many = sum(env.num_agents if ALL.fullmatch(source) else 1 for source in entry.rest)
    return len(entry.tiles) + 2 + len(TURNED) + many, channels
