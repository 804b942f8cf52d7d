"""Cooperators and defectors of the nine games do what they are said to do: what they choose and count, on the interpreter.

Small crowds play short episodes. Bounds are far from what was counted, and seeds are fixed.
"""

from collections import Counter
from functools import cache
from itertools import pairwise
from math import hypot
from typing import NamedTuple

import numpy as np
import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.elaborate import Overrides
from sjdsl.compiler.ir.queries import counts_of
from sjdsl.compiler.syntax.read import read_source
from sjdsl.interpreter.state import World, default_params
from sjdsl.interpreter.step import reset, step
from sjdsl.interpreter.threefry import Threefry
from sjdsl.library.games_folder import find_game
from sjdsl.policies.interpreted import choose
from sjdsl.trace.jax_random import fold_in, key_of

from .environments import HARVESTS, NINE

AGENTS = {"coins": 2}  # three elsewhere
STEPS = {"coop_mining": 30}  # 60 elsewhere
SEVEN = tuple(
    name for name in NINE if name not in HARVESTS[1:]
)  # two Harvests have the policies of the open one
MORE = {  # chances that make a short episode as busy as a long one
    "coins": {"spawn": 0.01},
    "coop_mining": {"spawn_gold": 0.002, "spawn_iron": 0.002},
    "gift_refinement": {"spawn": 0.002},
    "harvest_open": {
        "regrow_1": 0.0,
        "regrow_2": 0.0,
        "regrow_3": 0.0,
    },  # no apple ripens under an agent's foot
}


class Played(NamedTuple):
    """The first steps of an episode: what each agent counted and how often it chose what; the states before each step and the last."""

    game: ir.Game
    events: tuple[Counter, ...]
    chosen: tuple[Counter, ...]
    worlds: tuple[World, ...]
    actions: tuple[list[str], ...]  # of all agents, step by step


@cache
def play(name: str, who: tuple[str, ...]) -> Played:
    """Plays a policy for each agent."""
    game = build(read_source(find_game(name)), (), Overrides(num_agents=len(who))).game
    policies = {policy.name: policy for policy in game.policies}
    params, drawn, key = (
        default_params(game) | MORE.get(name, {}),
        np.random.default_rng(0),
        key_of(0),
    )
    worlds = [reset(game, params, Threefry(*fold_in(key, 0)))]
    events, chosen, names = tuple(Counter() for _ in who), tuple(Counter() for _ in who), []
    for number in range(STEPS.get(name, 60)):
        bits = drawn.integers(0, 2**32, (len(who), 2)).tolist()
        actions = [
            choose(policies[policy], game, worlds[-1], agent, tuple(bits[agent]))
            for agent, policy in enumerate(who)
        ]
        world, outcome = step(
            game, worlds[-1], actions, params, Threefry(*fold_in(key, number + 1))
        )
        worlds.append(world)
        names.append([game.agents.actions[action] for action in actions])
        for counter, action in zip(chosen, names[-1], strict=True):
            counter[action] += 1
        for event in game.events:
            for place, (word, label) in enumerate(counts_of(event)):
                if event.per_agent:
                    for agent, counted in enumerate(outcome.events[event.name]):
                        events[agent][label] += int(counted if word is None else counted[place])
    return Played(game, events, chosen, tuple(worlds), tuple(names))


def mixed(name: str) -> Played:
    """Returns how cooperators and, last, a defector play."""
    return play(name, ("cooperator",) * (AGENTS.get(name, 3) - 1) + ("defector",))


@pytest.mark.thorough
@pytest.mark.parametrize("name", SEVEN)
def test_nobody_zaps_and_everybody_does_something(name: str) -> None:
    for chosen in mixed(name).chosen:
        assert chosen["zap"] == 0
        assert chosen["stay"] < chosen.total(), "who stays all the time plays nothing"


def test_coins() -> None:
    cooperator, defector = mixed("coins").events
    assert cooperator["own_coins"] >= 5
    assert cooperator["other_coins"] <= 1, "but for a coin that falls where it steps in that moment"
    assert defector["own_coins"] >= 3 and defector["other_coins"] >= 3


def test_harvest() -> None:
    """A cooperator bites where three others are ripe around, of all bites; a defector bites elsewhere, too."""
    played = mixed("harvest_open")
    around = [_ripe_around(played, agent) for agent in range(3)]
    assert all(len(bites) >= 5 and min(bites) >= 3 for bites in around[:2])
    assert len(around[2]) >= 5 and min(around[2]) < 3


def _ripe_around(played: Played, agent: int) -> list[int]:
    """Returns how many other apples were ripe within a radius of 2 of each that an agent ate, when it chose to step there."""
    soil = {g.glyph for g in played.game.glyphs if g.kind == "soil"}
    cells = [
        (r, c)
        for r, row in enumerate(played.game.rows)
        for c, glyph in enumerate(row)
        if glyph in soil
    ]
    found = []
    for before, after in pairwise(played.worlds):
        ripe = {
            cell
            for cell, fruit in zip(cells, before.cells["soil", "fruit"], strict=True)
            if fruit == "ripe"
        }
        here = after.position[agent]
        if here in ripe:
            found.append(sum(0 < hypot(row - here.row, col - here.col) <= 2 for row, col in ripe))
    return found


def test_clean_up() -> None:
    played = mixed("clean_up")
    for events, chosen in zip(played.events[:2], played.chosen[:2], strict=True):
        assert events["cleaned"] >= 5 and chosen["clean"] >= 5
    assert played.chosen[2]["clean"] == 0 and played.events[2]["eaten"] >= 3


@pytest.mark.thorough
def test_coop_mining() -> None:
    played = mixed("coop_mining")
    for events in played.events[:2]:
        assert events["iron_mined"] == 0 and events["gold_mined"] >= 1
    assert played.events[2]["gold_mined"] == 0 and played.events[2]["iron_mined"] >= 3


@pytest.mark.thorough
def test_mushrooms() -> None:
    played = mixed("mushrooms")
    for events in played.events[:2]:
        assert events["eaten[blue]"] >= 1 and events["eaten[red]"] == events["eaten[orange]"] == 0
    assert (
        played.events[2]["eaten[red]"] >= 1
        and played.events[2]["eaten[blue]"] == played.events[2]["eaten[orange]"] == 0
    )


@pytest.mark.thorough
def test_gift_refinement() -> None:
    played = mixed("gift_refinement")
    assert all(events["given"] >= 1 for events in played.events[:2])
    assert sum(events["received[cut]"] for events in played.events) >= 3
    assert played.chosen[2]["gift"] == 0 and played.events[2]["consumed"] >= 3


def test_pd_arena() -> None:
    played = mixed("pd_arena")
    for events in played.events[:2]:
        assert events["collected[coop]"] >= 2 and events["collected[defect]"] == 0
    assert played.events[2]["collected[defect]"] >= 5 and played.events[2]["collected[coop]"] == 0
    assert sum(events["met"] for events in played.events) >= 2
    bags = [
        sum(world.agents["bag"][agent])
        for world, actions in zip(played.worlds[:-1], played.actions, strict=True)
        for agent, action in enumerate(actions)
        if action == "interact"
    ]
    assert bags and min(bags) >= 5


@pytest.mark.parametrize("name", NINE)
def test_scenarios_fit_every_variant_and_two_agents(name: str) -> None:
    source = read_source(find_game(name))
    variants = build(source).game.variants
    forms = [build(source, (variant,) if variant else ()) for variant in ("", *variants)]
    for game in (form.game for form in (*forms, build(source, (), Overrides(num_agents=2)))):
        assert len(game.scenarios) >= 3
        for scenario in game.scenarios:
            assert sum(part.number for part in scenario.slots) == game.agents.number
            assert all(part.number >= 0 for part in scenario.slots)
            assert sum(part.number for part in scenario.slots if not part.policy) >= 1
