"""Stag Hunt and Chicken in the matrix: what a meeting pays, what is collected, and that all else is the arena's."""

import numpy as np
import pytest

from sjdsl.testing import Scene

from .environments import stage_of
from .found import Form, rules_of, variants_of
from .map_reading import read_map

ROWS = ("........", "..CD....", "........", "PPPPPPPP")
# the two words, and what one who plays the row gets from one who plays the column. Source: Melting Pot
GAMES = {
    "stag_hunt": (("stag", "hare"), ((4, 0), (2, 2))),
    "chicken": (("dove", "hawk"), ((3, 2), (5, 0))),
}
STAGES = {game: stage_of(game, ROWS, 4) for game in GAMES}
EACH = pytest.mark.parametrize("game", GAMES)


def meeting(game: str, mine: tuple[int, int], theirs: tuple[int, int]) -> Scene:
    """Returns a scene in which agent 0 meets agent 1, after the meeting."""
    words, _ = GAMES[game]
    bags = {0: dict(zip(words, mine, strict=True)), 1: dict(zip(words, theirs, strict=True))}
    picture = (*ROWS[:2], "..><....  01", "PPPPPPvv  23")
    return (
        STAGES[game]
        .put(*picture, fields={"agent.bag": bags}, under={2: "P", 3: "P"}, params={"regrow": 0})
        .step("interact")
    )


@EACH
@pytest.mark.parametrize("mine", [0, 1])
@pytest.mark.parametrize("theirs", [0, 1])
def test_payoffs_of_pure_strategies(game: str, mine: int, theirs: int) -> None:
    table = GAMES[game][1]
    scene = meeting(game, *(((1, 0), (0, 1))[plays] for plays in (mine, theirs)))
    scene.has(
        {"reward": [table[mine][theirs], table[theirs][mine], 0, 0], "event met": [1, 1, 0, 0]}
    )


@EACH
def test_payoffs_of_mixtures(game: str) -> None:
    """Source: v_row A v_col and v_col A v_row for the shares v of what the two hold."""
    table = np.array(GAMES[game][1])
    for mine, theirs in [((3, 1), (1, 1)), ((1, 4), (2, 0)), ((50, 50), (1, 99))]:
        row, column = np.array(mine) / sum(mine), np.array(theirs) / sum(theirs)
        scene = meeting(game, mine, theirs)
        assert scene.reward[:2] == pytest.approx(
            [row @ table @ column, column @ table @ row], abs=1e-5
        )


@EACH
def test_one_collects_what_the_arena_has(game: str) -> None:
    """Where the Prisoner's Dilemma has patches to cooperate, the first word is collected; the second where it has the others."""
    first, second = GAMES[game][0]
    scene = (
        STAGES[game]
        .put(
            "..vv....  01", *ROWS[1:3], "PPPPPPvv  23", under={2: "P", 3: "P"}, params={"regrow": 0}
        )
        .step("forward, forward")
    )
    scene.has(
        {
            f"agent.bag[{first}]": [1, 0, 0, 0],
            f"agent.bag[{second}]": [0, 1, 0, 0],
            "patch.stock": "none",
            "reward": 0,
        }
    )
    scene.has(
        {f"event collected[{first}]": [1, 0, 0, 0], f"event collected[{second}]": [0, 1, 0, 0]}
    )


@EACH
def test_the_map_is_the_arena_s_and_nothing_is_called_released(game: str) -> None:
    """The released suite has the arena, but not these two games. Of the numbers the payoff alone is another."""
    rules, arena = rules_of(Form(game)), rules_of(Form("pd_arena"))
    assert rules.rows == read_map("pd_arena")
    assert {param.name for param in rules.params if param not in arena.params} == {"payoff"}
    assert variants_of("pd_arena") == ("socialjax",)
    assert variants_of(game) == ()
