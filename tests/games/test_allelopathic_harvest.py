"""Allelopathic Harvest, scene by scene and counted: meals and tastes, replanting, sanctions, and growth by the number of a colour."""

from collections.abc import Mapping
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.testing import Scene

from .chance import BATCH, assert_share, distance, many
from .environments import cells_of, placed, stage_of

pytestmark = pytest.mark.optimised

ROWS = ("rgb.....", "........", "..rrgb..", "........")
LOOKS = {
    "R": "bush colour=red fruit=ripe",
    "G": "bush colour=green fruit=ripe",
    "B": "bush colour=blue fruit=ripe",
}
STAGE = stage_of("allelopathic_harvest", ROWS, 3, looks=LOOKS)
STAY = 6
SMALLEST_CHANCE = {"growth": 0}


def put(*picture: str, params: Mapping[str, Any] = SMALLEST_CHANCE, **facts: Any) -> Scene:
    """Returns a scene of old bushes in which nothing ripens; agents 0 and 2 like red, agent 1 likes green, as at the start."""
    return STAGE.put(*picture, params=params, fields={"bush.young": 0}, **facts)


# Meals


def test_a_berry_of_the_colour_one_likes_is_worth_two() -> None:
    """Any other is worth one; the bush keeps its colour and bears again after ten steps at the earliest."""
    scene = put("RGB..<..  2", "^^......  01", "..rrgb..", "........").step("forward, forward")
    scene.shows("^^B..<..", "........", "..rrgb..", "........", under={0: "r", 1: "g"})
    scene.has({"reward": [2, 2, 0], "event eaten[red]": [1, 0, 0], "event eaten[green]": [0, 1, 0]})
    scene.has({"bush.young": [10, 10, 0, 0, 0, 0, 0], "agent.taste": ["red", "green", "red"]})
    scene.step("stay, step_right").has(
        {"reward": [0, 1, 0], "event eaten[blue]": [0, 1, 0], "bush.young": {(0, 0): 9, (0, 2): 10}}
    )


def test_unripe_berries_are_no_meal() -> None:
    scene = (
        put("rgb..<..", "^.......", "..rrgb..", ".......^")
        .step("stay, forward")
        .shows("^gb..<..", "........", "..rrgb..", ".......^", under={1: "r"})
    )
    scene.has({"reward": 0, "event eaten[red]": 0})


# Planting


@pytest.mark.parametrize(("deed", "hue"), [("sow_red", "r"), ("sow_green", "g"), ("sow_blue", "b")])
def test_the_first_bush_within_three_cells_is_recoloured(deed: str, hue: str) -> None:
    """Unless it has that colour already: then nothing is planted, and the coat stays as it was."""
    scene = put("rgb.<...  0", "........", "..rrgb..", ".>>.....  12").step(deed)
    scene.shows(f"rg{hue}.<...", "........", "..rrgb..", ".>>.....")
    word = {"r": "red", "g": "green", "b": "blue"}[hue]
    planted = hue != "b"
    scene.has(
        {
            "agent.coat": [word if planted else "none", "none", "none"],
            f"event planted[{word}]": [int(planted), 0, 0],
        }
    )
    scene.has(
        {
            "bush.young": {(0, 2): 10 if planted else 0},
            "agent.bag": {0: word},
            "agent.empty": [2, 0, 0],
            "reward": 0,
        }
    )


def test_seeds_fall_on_the_first_bush_ripe_or_not() -> None:
    """A ripe one keeps its colour, and hides what is behind; the fourth cell is out of reach."""
    scene = (
        put("rgB.<...  0", "........", "..rrgb..", ".>>.....  12")
        .step("sow_red")
        .shows("rgB.<...", "........", "..rrgb..", ".>>.....")
    )
    scene.has({"agent.coat": "none"})
    put("rgb..^<.  20", "........", "..rrgb..", ".>......  1").step("sow_red").shows(
        "rgb..^<.", "........", "..rrgb..", ".>......"
    )
    put("rgb..<^.  02", "........", "..rrgb..", ".>......  1").step("sow_red").shows(
        "rgr..<^.", "........", "..rrgb..", ".>......"
    )


def test_of_two_who_sow_one_plants() -> None:
    """Each now and then; only the coat of who has planted changes."""
    winners = set()
    for seed in range(20):
        scene = put("rgb.....", "....v...  0", "..rrgb..", "....^..>  12", seed=seed).step(
            "sow_red, sow_blue"
        )
        coats = scene.value("agent.coat")
        colour = scene.value("bush.colour")[5]
        assert coats in (["red", "none", "none"], ["none", "blue", "none"])
        assert colour == next(coat for coat in coats if coat != "none")
        winners.add(colour)
    assert winners == {"red", "blue"}


def test_who_has_sown_waits_two_steps() -> None:
    scene = (
        put("rgb.<...  0", "........", "..rrgb..", ".>>.....  12")
        .step("sow_red")
        .has({"allowed sow_blue": [False, True, True]})
    )
    scene.step("sow_blue", times=2).shows("rgr.<...", "........", "..rrgb..", ".>>.....").step(
        "sow_blue"
    ).shows("rgb.<...", "........", "..rrgb..", ".>>.....")


# Sanctions


def test_the_first_hit_stuns() -> None:
    """The nearest in each of three lanes, for 25 steps; nothing is paid. Who zaps waits four steps."""
    scene = (
        put("rgb...^.  1", "........", "..rrgb^.  0", "......^.  2")
        .step("zap")
        .has({"agent.hits": [0, 1, 0], "agent.stunned": [0, 25, 0]})
    )
    scene.has(
        {
            "reward": 0,
            "agent.hot": [4, 0, 0],
            "allowed zap": [False, False, True],
            "allowed forward": [True, False, True],
        }
    )
    scene.step("stay, turn_left", times=25).has({"agent.heading": {1: "north"}}).step(
        "stay, turn_left"
    ).has({"agent.heading": {1: "west"}})


def test_the_second_hit_within_fifty_steps_sends_away() -> None:
    scene = (
        put(
            "rgb...^.  1",
            "........",
            "..rrgb^.  0",
            "......^.  2",
            params=SMALLEST_CHANCE | {"cooling": 0},
        )
        .step("zap")
        .step(times=49)
    )
    scene.has({"agent.hits": [0, 1, 0]}).step("zap").has(
        {"reward": [0, -10, 0], "agent.away": [False, True, False], "event banished": [0, 1, 0]}
    )
    scene.step(times=24).has({"agent.away": {1: True}}).step().has(
        {"agent.away": {1: False}, "agent.hits": 0, "agent.stunned": 0}
    )


def test_hits_are_forgotten_after_fifty_steps() -> None:
    scene = (
        put(
            "rgb...^.  1",
            "........",
            "..rrgb^.  0",
            "......^.  2",
            params=SMALLEST_CHANCE | {"cooling": 0},
        )
        .step("zap")
        .step(times=50)
    )
    scene.has({"agent.hits": 0}).step("zap").has({"reward": 0, "agent.hits": [0, 1, 0]})


# Growth, counted


@pytest.mark.thorough
def test_a_berry_ripens_the_faster_the_more_have_its_colour() -> None:
    """In proportion; not while it is young, not under an agent; each bush for itself. Source: Melting Pot."""
    env, steps = STAGE.env, 16 * BATCH
    bushes = cells_of(env, "bush")
    assert bushes == [(0, 0), (0, 1), (0, 2), (2, 2), (2, 3), (2, 4), (2, 5)]
    state = placed(
        env,
        [(2, 2), (1, 0), (1, 1)],
        bush_colour=[0, 1, 2, 0, 0, 1, 0],
        bush_young=[0, 0, 0, 0, 0, 0, 2],
    )
    growth = 0.002  # red: four bushes, one of them young, one under an agent; green: two; blue: one

    def look(_: Any, after: Any, __: Any) -> Any:
        ripe = after.bush_fruit == 1
        return {"ripe": ripe, "both": ripe[0] & ripe[4]}

    seen = many(env, look)(0, state, [STAY] * 3, env.params.replace(growth=jnp.float32(growth)), 16)
    assert seen["ripe"][[3, 6]].tolist() == [0, 0]
    assert_share(seen["ripe"][0] + seen["ripe"][4], 2 * steps, 4 * growth, 0.2)
    assert_share(seen["ripe"][1] + seen["ripe"][5], 2 * steps, 2 * growth, 0.3)
    assert_share(seen["ripe"][2], steps, growth, 0.6)
    assert seen["both"] <= steps * (4 * growth) ** 2 + distance(
        steps, (4 * growth) ** 2
    )  # as of independent draws
    assert float(env.params.growth) == np.float32(0.000005)


# The map
