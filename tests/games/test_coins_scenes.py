"""Coins, scene by scene: who is paid what, where coins come, what the two see."""

import pytest

from sjdsl.testing import Scene, Stage

LOOKS = {"r": "tile coin=red", "g": "tile coin=green"}
STAGE = Stage("coins", ("CCCCP", "CCCCC", "CCCCC", "PCCCC"), 2, looks=LOOKS)
RED, GREEN = 0, 1  # agent 0 is red, agent 1 green


def put(*picture: str, seed: int = 0, step: int = 0, **params: float) -> Scene:
    """Returns a scene in which no coin comes by itself."""
    return STAGE.put(*picture, seed=seed, step=step, params={"spawn": 0} | params)


# what agents 0 and 1 step on -> their rewards. Source: SocialJax, coin_game: payoff_matrix [[1, 1, -2], [1, 1, -2]]
PAYMENTS = [
    ("r", "C", [1, 0]),
    ("g", "C", [1, -2]),
    ("C", "r", [-2, 1]),
    ("C", "g", [0, 1]),
    ("g", "r", [-1, -1]),
    ("r", "g", [1, 1]),
    ("r", "r", [-1, 1]),
    ("g", "g", [1, -1]),
    ("C", "C", [0, 0]),
]


@pytest.mark.parametrize(("red_takes", "green_takes", "reward"), PAYMENTS)
def test_payments(red_takes: str, green_takes: str, reward: list[float]) -> None:
    scene = put("CCCCP", f">{red_takes}CCC  0", f"CCC{green_takes}<  1", "PCCCC")
    scene.step("forward, forward")
    scene.shows("CCCCP", "C>CCC  0", "CCC<C  1", "PCCCC")
    assert scene.reward == reward
    takes = ((red_takes, "r"), (green_takes, "g"))
    assert scene.events["own_coins"] == [int(sign == own) for sign, own in takes]
    assert scene.events["other_coins"] == [int(sign not in ("C", own)) for sign, own in takes]
    assert scene.step("stay, stay").reward == [0, 0]


def test_a_coin_that_two_want_goes_to_one() -> None:
    winners = set()
    for seed in range(12):
        scene = put("CCCCP", "C>gCC  0", "CC^CC  1", "PCCCC", seed=seed).step("forward, forward")
        red_won = scene.places() == [(1, 2), (2, 2)]
        assert red_won or scene.places() == [(1, 1), (1, 2)]
        assert scene.reward == ([1, -2] if red_won else [0, 1])
        winners.add(red_won)
    assert winners == {True, False}


# Where coins come


def test_coins_come_only_on_free_cells() -> None:
    """At the highest rate, 0.5 a colour, every cell that may has a coin after one step: no corner, no cell under an agent."""
    scene = put("CCCCP", "C<CCC", "CCC>C", "PCrgC", spawn=0.5).step("stay, stay")
    rows = [row.split()[0] for row in scene.picture()]
    assert [rows[0][4], rows[3][0]] == ["P", "P"]
    assert "C" not in "".join(rows)
    scene.step("step_left, step_right")  # off their cells, which have a coin only a step later
    rows = [row.split()[0] for row in scene.picture()]
    assert [rows[1][1], rows[2][3]] == ["C", "C"]


def test_a_coin_that_comes_can_be_taken_in_the_same_step() -> None:
    scene = put("CCCCP", "C>CCC", "CCCCC", "<CCCC", spawn=0.5).step("forward, stay")
    assert scene.events["own_coins"][RED] + scene.events["other_coins"][RED] == 1
    assert scene.reward[RED] == 1


# What the two see


def test_colours_are_mine_and_theirs() -> None:
    scene = put("CCrCP", "CCgCC", "CC^CC  0", "<CCCC  1")
    scene.step("stay, turn_right")
    assert scene.seen(0, "content", ahead=1) == "tile coin=theirs"
    assert scene.seen(0, "content", ahead=2) == "tile coin=mine"
    assert scene.seen(1, "content", ahead=2, right=2) == "tile coin=mine"
    assert scene.seen(1, "content", ahead=3, right=2) == "tile coin=theirs"
    assert scene.seen(1, "content", ahead=3, right=4) == "corner"
    assert scene.seen(1, "content", ahead=1) == "tile coin=none"
