"""Line of sight at run time: where a beam ends at cells whose state decides it; constant walls: `geometry.lane_reach`."""

import jax.numpy as jnp
from jax import Array


def reached(blocked: Array, on_map: Array, first: Array) -> Array:
    """Returns which shape cells a lane reaches when some cells end lanes.

    Args:
      blocked: `[..., K]` bool, cells that are the last of their lane.
      on_map: `[..., K]` bool, cells that exist.
      first: `[K]` bool, first cells of the lanes.
    """
    live, out = jnp.ones(blocked.shape[:-1], bool), []
    for k in range(blocked.shape[-1]):
        live = live | first[k]
        out.append(live & on_map[..., k])
        live = live & ~(blocked[..., k] & on_map[..., k])
    return jnp.stack(out, axis=-1)
