"""Line-ups: which policy plays in each slot, which mixtures there are, and in which order an
episode assigns the slots.

A line-up is a tuple of N indices of policies. The order within a mixture means nothing: it is
sorted, and every episode draws its own.
"""

from functools import partial
from itertools import combinations_with_replacement
from math import comb

import jax
import numpy as np
from jax import Array

from sjdsl.experiments.refusals import ExperimentError
from sjdsl.trainers.policies.evaluation import evaluation_key

Lineup = tuple[int, ...]

MAX_MIXTURES = 500  # in one experiment
# "ordr": folded into the key, so that these draws are independent of those of the episodes.
ORDERS = 0x6F726472
REPLICATES = 0x40000000  # above all numbers of updates, which a run folds into its evaluation keys


def all_mixtures(policies: int, slots: int) -> tuple[Lineup, ...]:
    """Returns every way to fill N slots with P policies, regardless of order.

    Raises:
      ExperimentError: there are more than 500.
    """
    number = comb(policies + slots - 1, slots)
    if number > MAX_MIXTURES:
        raise ExperimentError(
            f"{policies} policies fill {slots} slots in {number:,} mixtures, and at most "
            f"{MAX_MIXTURES} are played; name fewer policies, or choose --mix pairs"
        )
    return tuple(combinations_with_replacement(range(policies), slots))


def paired_mixtures(policies: int, slots: int) -> tuple[Lineup, ...]:
    """Returns the mixtures in which one policy has a single slot and another the rest, and of each
    policy with itself.

    Raises:
      ExperimentError: there are more than 500.
    """
    mixtures = {visiting(one, many, slots) for one in range(policies) for many in range(policies)}
    if len(mixtures) > MAX_MIXTURES:
        raise ExperimentError(
            f"{policies} policies make {len(mixtures):,} pairs, and at most {MAX_MIXTURES} are "
            "played; name fewer policies"
        )
    return tuple(sorted(mixtures))


def visiting(one: int, many: int, slots: int) -> Lineup:
    """Returns the mixture in which one policy has a single slot and another all the rest."""
    return tuple(sorted([one] + [many] * (slots - 1)))


def cooperating(number: int, slots: int) -> Lineup:
    """Returns the mixture of k cooperators (policy 0) with defectors (policy 1)."""
    return (0,) * number + (1,) * (slots - number)


def play_key(seed: int, replicate: int) -> Array:
    """Returns the key of a replicate's episodes, the same in every line-up.

    Replicate 0 has the key of `sjdsl evaluate`.
    """
    return evaluation_key(seed, 0 if replicate == 0 else REPLICATES + replicate)


def orders_of(seed: int, replicate: int, episodes: int, slots: int) -> np.ndarray:
    """Returns the order `[E, N]` int32 in which each episode assigns its slots: entry j is the slot
    of member j.

    It is the same in every mixture, and the order of an episode does not depend on the number of
    episodes.
    """
    key = jax.random.fold_in(jax.random.fold_in(jax.random.key(seed), ORDERS), replicate)
    permute = jax.jit(jax.vmap(partial(jax.random.permutation, x=slots)))
    return np.asarray(permute(jax.random.split(key, episodes)), np.int32)


def fixed_orders(episodes: int, slots: int) -> np.ndarray:
    """Returns the order `[E, N]` int32 in which member j always has slot j."""
    return np.broadcast_to(np.arange(slots, dtype=np.int32), (episodes, slots))


def rotated_orders(episodes: int, slots: int) -> np.ndarray:
    """Returns the order `[E, N]` int32 in which slot i of episode e has member (i + e) mod N."""
    member = np.arange(slots, dtype=np.int32)
    episode = np.arange(episodes, dtype=np.int32)
    return (member[None] - episode[:, None]) % slots


def key_bits(key: Array) -> list[int]:
    """Returns the two uint32 numbers of a key."""
    return [int(bits) for bits in jax.random.key_data(key)]
