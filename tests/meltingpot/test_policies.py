"""Cooperators and defectors of five substrates do what they are said to do, scene by scene, on the interpreter."""

import numpy as np
import pytest

from sjdsl.policies.interpreted import choose
from sjdsl.testing import Scene, Stage

MARKET = Stage(
    "fruit_market",
    ("P......~", "........", "P.....P~"),
    2,
    params={"apples": 0, "bananas": 0, "skill": 0},
    interpreted=True,
)
RACE = Stage(
    "boat_race",
    (
        "NNNN",
        ".hh.",
        "lnnl",
        "l..l",
        "~bb~",
        "~ww~",
        "~ww~",
        "~BB~",
        "l..l",
        "lssl",
        "lHHl",
        "SSSS",
        "PPPP",
    ),
    2,
    params={"regrow": 0, "flail_moves": 0},
    interpreted=True,
)
FACTORY = Stage(
    "factory_commons",
    ("#########", "#S=...G=#", "#.m...n.#", "#...C...#", "#.......#", "#########"),
    1,
    interpreted=True,
)
DISH = Stage(
    "chemistry",
    ("~~~~~", "~~~~~"),
    1,
    looks={"X": "dish mol=x", "Y": "dish mol=y", "f": "dish mol=food1"},
    interpreted=True,
)

AGENDA = Stage(
    "hidden_agenda", ("..G.O....", ".........", ".........", "PPPVVVDDD"), 3, interpreted=True
)


def act(scene: Scene, policy: str, times: int = 1) -> Scene:
    """Returns the scene after steps in which all agents follow a policy."""
    game, drawn = scene.env.game, np.random.default_rng(0)
    followed = next(p for p in game.policies if p.name == policy)
    for _ in range(times):
        bits = drawn.integers(0, 2**32, (game.agents.number, 2)).tolist()
        chosen = [
            choose(followed, game, scene.world, agent, tuple(bits[agent]))
            for agent in range(game.agents.number)
        ]
        scene.step(", ".join(scene.env.action_names[action] for action in chosen))
    return scene


@pytest.mark.parametrize(("policy", "trades"), [("cooperator", 1), ("defector", 0)])
def test_farmers_meet_to_trade_or_eat_what_they_have(policy: str, trades: int) -> None:
    fields = {
        "agent.farms": ["apple", "banana"],
        "agent.bag[apple]": [5, 0],
        "agent.bag[banana]": [0, 5],
        "agent.hunger": 200,
    }
    scene = MARKET.put(">......~", "........", "P.....<~", fields=fields)
    traded, eaten = 0, {"apple": 0, "banana": 0}
    for _ in range(12):
        act(scene, policy)
        traded += scene.value("event trades")[0]
        eaten = {
            fruit: count + scene.value(f"event eaten[{fruit}]")[0] for fruit, count in eaten.items()
        }
    assert (traded >= 1, eaten["banana"] >= 1, eaten["apple"] >= 5) == (
        bool(trades),
        bool(trades),
        not trades,
    )


@pytest.mark.parametrize(("policy", "rows"), [("cooperator", 3), ("defector", 0)])
def test_rowers_row_together_or_flail(policy: str, rows: int) -> None:
    """From the bank into one boat; in eleven steps cooperators glide three cells, each stroke five steps after the last."""
    picture = [
        *("NNNN", ".hh.", "lnnl", "l..l", "~bb~", "~ww~", "~ww~", "~BB~"),
        "l^^l",
        "lssl",
        "lHHl",
        "SSSS",
        "PPPP",
    ]
    scene = act(RACE.put(*picture, step=100), policy).has({"agent.state": "rowing", "agent.row": 7})
    act(scene, policy, 11)
    assert 7 - scene.value("agent.row")[0] in ({rows} if not rows else {rows, 6}), (
        "three strokes, or on the far bank"
    )
    scene.has({"event hurt": 0})


@pytest.mark.parametrize(
    ("policy", "fed"), [("cooperator", "cube_and_apple"), ("defector", "two_apples")]
)
def test_workers_feed_their_machine(policy: str, fed: str) -> None:
    scene = FACTORY.put(
        "#########", "#S=...G=#", "#.m...n.#", "#...C...#", "#...^...#", "#########"
    )
    total = 0
    for _ in range(14):
        total += act(scene, policy).value(f"event fed[{fed}]")
    assert total == 1


def test_molecules_are_carried_to_the_other_waste_or_eaten() -> None:
    still = {
        table: dict.fromkeys(("background", "low", "medium", "high"), 0.0)
        for table in ("ground", "carried")
    }
    scene = act(DISH.put(">~~~Y", "~~~~~", under={0: "X"}, params=still), "cooperator").has(
        {"agent.mol": "x"}
    )
    act(scene, "cooperator", 4)
    assert scene.places() == [(0, 4)]
    scene = act(DISH.put(">~f~Y", "~~~~~", under={0: "X"}, params=still), "defector", 3).has(
        {"agent.mol": "food1"}
    )
    assert scene.places() == [(0, 2)]


def test_crewmates_carry_gems_and_the_impostor_fires_at_them() -> None:
    fields = {
        "agent.role": ["crewmate", "crewmate", "impostor"],
        "agent.badge": [0, 1, 2],
        "agent.charging": 0,
    }
    scene = AGENDA.put("^.G.O....", "........^", "........^", "PPPVVVDDD", fields=fields).has(
        {"delivered": 0}
    )
    act(scene, "cooperator", 6).has({"delivered": 1, "agent.state": "active"})
    scene = AGENDA.put("^.G.O....", "........^", "........^", "PPPVVVDDD", fields=fields)
    act(scene, "defector").has(
        {"agent.state": ["active", "frozen", "active"], "event tagged": [0, 0, 1]}
    )
