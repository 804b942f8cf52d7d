"""The chances of the Prisoner's Dilemma arena, counted: growth, rests, homes, who meets whom."""

from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from .chance import BATCH, assert_share, assert_shares, assert_uniform, many
from .environments import cells_of, environment, frame_cells, placed

pytestmark = pytest.mark.optimised

GAME = "pd_arena"
STAY, INTERACT = 6, 7
MIDDLE = (6, 10)  # a cell of floor with floor around it
WEST, EAST, SOUTH = (6, 9), (6, 11), (7, 10)
SHORTEST, LONGEST = 10, 100  # steps of rest. Source: the paper
COOP, DEFECT, EMPTY = (1, 0), (0, 1), (0, 0)


@cache
def counter(variant: str | None) -> Any:
    """Counts, over many steps from one state: patches grown, and how long agents rest, where they stand and look, what they earn.

    `halves`: are the rests of agents 0 and 1 among the longer ones, are they in the southern half, as four bits.
    """
    env = environment(GAME, variant)
    sizes = env.module.FRAME[0] * env.module.FRAME[1]
    south = int(frame_cells(env, (12, 0)))

    def number(bits: Any) -> Any:
        return jnp.sum(
            jnp.stack(bits).astype(jnp.int32) * 2 ** jnp.arange(len(bits)), dtype=jnp.int32
        )

    def look(before: Any, after: Any, reward: Any) -> Any:
        grown = (before.patch_stock == 0) & (after.patch_stock == 1)
        rest = after.agent_resting.astype(jnp.int32)
        halves = [*(rest[:2] > (SHORTEST + LONGEST) // 2), *(after.position[:2] >= south)]
        return {
            "grown": grown,
            "both": grown & jnp.roll(grown, 1),
            "rest": jax.nn.one_hot(rest, 128, dtype=jnp.int32),
            "alike": (rest[0] == rest[1]) & (rest[0] > 0),
            "resting": jax.nn.one_hot(number([*(rest > 0)]), 16, dtype=jnp.int32),
            "halves": jax.nn.one_hot(number(halves), 16, dtype=jnp.int32),
            "place": jax.nn.one_hot(after.position, sizes, dtype=jnp.int32),
            "headings": jax.nn.one_hot(
                after.heading[0] * 4 + after.heading[1], 16, dtype=jnp.int32
            ),
            "suckers": reward == -1,
        }

    return many(env, look)


def gates() -> list[tuple[int, int]]:
    """Returns the cells of the gates: four blocks of four by four."""
    found = cells_of(environment(GAME), "gate")
    assert len(found) == 64
    return found


def meeting(
    *places: tuple[int, int],
    headings: tuple[int, ...],
    bags: Any = COOP,
    variant: str | None = None,
) -> Any:
    """Returns a state with some agents in the middle, the others on gates; all carry the same, unless told."""
    others = gates()[:16:5][len(places) :]
    looks = [*headings, *[0] * len(others)]
    bag = np.broadcast_to(bags, (4, 2))
    return placed(environment(GAME, variant), [*places, *others], looks, agent_bag=bag)


@pytest.mark.thorough
@pytest.mark.parametrize("variant", [None, "socialjax"])
def test_growth(variant: str | None) -> None:
    """A tenth of the bare patches in a step: each alike, neighbours in the numbering independent. Source: the released code."""
    env = environment(GAME, variant)
    seen = counter(variant)(
        0, placed(env, gates()[:16:5], patch_stock=np.zeros(12)), [STAY] * 4, env.params, 8
    )
    assert seen["grown"].shape == (12,)
    for site in range(12):
        assert_share(seen["grown"][site], 8 * BATCH, 0.1, 0.12)
    assert_share(seen["grown"].sum(), 12 * 8 * BATCH, 0.1, 0.04)
    assert_share(seen["both"].sum() / 12, 8 * BATCH, 0.01, 0.4)


def test_both_rest_each_for_its_own_time() -> None:
    """10 to 100 steps, each as often, and the one's time tells nothing of the other's; others do not rest."""
    env = environment(GAME)
    state = meeting(MIDDLE, EAST, headings=(1, 0))
    seen = counter(None)(2, state, [INTERACT, STAY, STAY, STAY], env.params, 16)
    steps = 16 * BATCH
    assert seen["resting"][0b0011] == steps
    for agent in (0, 1):
        rests = seen["rest"][agent]
        assert rests[SHORTEST : LONGEST + 1].sum() == steps
        assert_uniform(rests[SHORTEST : LONGEST + 1], 0.25)
    assert_share(seen["alike"], steps, 1 / 91, 0.25)
    # the shorter half is 10 to 55, 46 of the 91 lengths
    later = np.array([46, 45]) / 91
    times_alone = (
        seen["halves"].reshape(2, 2, 2, 2).sum(axis=(0, 1)).T
    )  # longer rest of agent 0, of agent 1
    assert_shares(times_alone, np.outer(later, later), 0.02)


def test_both_come_to_free_gates() -> None:
    """Each of the 62, each way; where tells nothing of the way, of where the other goes, or of how long it rests."""
    env = environment(GAME)
    state = meeting(MIDDLE, EAST, headings=(1, 0))
    seen = counter(None)(3, state, [INTERACT, STAY, STAY, STAY], env.params, 16)
    free = [gate for gate in gates() if gate not in gates()[:16:5][2:]]
    assert len(free) == 62
    for agent in (0, 1):
        homes = seen["place"][agent, frame_cells(env, free)]
        assert homes.sum() == 16 * BATCH
        assert_uniform(homes, 0.2)
    assert_uniform(seen["headings"], 0.1)
    # 32 gates are in the south and 30 free ones in the north; two different ones
    length = np.array([46, 45]) / 91
    place = np.array([[30 * 29, 30 * 32], [32 * 30, 32 * 31]]) / (62 * 61)
    found = seen["halves"].reshape(
        2, 2, 2, 2
    )  # southern half of agent 1, of 0, longer rest of 1, of 0
    assert_shares(found, place[:, :, None, None] * length[:, None] * length, 0.02)


def test_a_contested_partner_meets_each_alike() -> None:
    """Agents 0 and 2 turn to agent 1: it meets one of them, and nothing happens to the other."""
    env = environment(GAME)
    state = meeting(WEST, MIDDLE, EAST, headings=(1, 0, 3))
    seen = counter(None)(4, state, [INTERACT, STAY, INTERACT, STAY], env.params, 6)
    pairs = seen["resting"][[0b0011, 0b0110]]
    assert pairs.sum() == 6 * BATCH
    assert_uniform(pairs, 0.05)
    for agent, cell, pair in ((0, WEST, 1), (2, EAST, 0)):
        assert seen["place"][agent, frame_cells(env, cell)] == pairs[pair]


def test_of_a_chain_of_four_the_middle_pair_meets_in_a_third() -> None:
    """Three pairs in random order, each taken if both are still free: the middle one only if it comes first."""
    env = environment(GAME)
    state = meeting(WEST, MIDDLE, EAST, (6, 12), headings=(1, 1, 1, 1))
    seen = counter(None)(5, state, [INTERACT, INTERACT, INTERACT, STAY], env.params, 6)
    assert seen["resting"][[0b0110, 0b1111]].sum() == 6 * BATCH
    assert_share(seen["resting"][0b0110], 6 * BATCH, 1 / 3, 0.06)


def test_of_a_round_of_four_either_two_pairs_meet() -> None:
    """0 turns to 1, 1 to 2, 2 to 3, 3 to 0, and 1 alone defects: it meets 0 or 2, each in half of the steps."""
    env = environment(GAME)
    state = meeting(
        MIDDLE, EAST, (7, 11), SOUTH, headings=(1, 2, 3, 0), bags=[COOP, DEFECT, COOP, COOP]
    )
    seen = counter(None)(6, state, [INTERACT] * 4, env.params, 6)
    assert seen["resting"][0b1111] == 6 * BATCH
    assert seen["suckers"].sum() == 6 * BATCH
    assert_uniform(seen["suckers"][[0, 2]], 0.05)


@pytest.mark.thorough
def test_as_released_only_targets_rest() -> None:
    """Each for its own time, a step less after the tick, at a gate of its own; also with nothing in the bag. Who acted stays free."""
    env = environment(GAME, "socialjax")
    state = meeting(
        WEST,
        MIDDLE,
        EAST,
        (6, 12),
        headings=(1, 3, 1, 0),
        bags=[COOP, DEFECT, COOP, EMPTY],
        variant="socialjax",
    )
    seen = counter("socialjax")(8, state, [INTERACT, INTERACT, INTERACT, STAY], env.params, 16)
    steps = 16 * BATCH
    assert seen["resting"][0b1011] == steps
    assert seen["place"][2, frame_cells(env, EAST)] == steps
    for agent in (0, 1, 3):
        rests = seen["rest"][agent][SHORTEST - 1 : LONGEST]
        homes = seen["place"][agent, frame_cells(env, gates())]
        assert (rests.sum(), homes.sum()) == (steps, steps)
        assert_uniform(rests, 0.25)
        assert_uniform(homes, 0.2)
    assert_share(seen["alike"], steps, 1 / 91, 0.25)
    assert_uniform(seen["headings"], 0.1)
    length = np.array([47, 44]) / 91  # 9 to 55, a step of the time being over
    assert_shares(
        seen["halves"].reshape(2, 2, 2, 2).sum(axis=(0, 1)), np.outer(length, length), 0.02
    )
