"""Which forms of the games are measured: with many agents too, both observations; nothing is compiled by XLA here."""

import pytest

from bench.speed.__main__ import forms_of
from tests.games.environments import NINE


def test_a_game_without_room_comes_as_its_crowd_and_one_that_refuses_is_named() -> None:
    tasks, refused = forms_of(["coins", "clean_up", "pd_arena"], ["tokens"], crowd=True)
    assert [(task.name, task.num_agents, task.crowd) for task in tasks] == [
        ("coins", 2, None),
        ("clean_up", 7, None),
        ("clean_up+crowd", 20, 20),
        ("pd_arena", 4, None),
        ("pd_arena", 20, 20),
    ]
    (line,) = refused
    assert (
        line
        == "coins can't have 20 agents: `players` is 20, outside 2 .. 2 (two colours, an agent for each)"
    )


@pytest.mark.thorough
def test_all_nine_but_coins_come_with_twenty_agents() -> None:
    tasks, refused = forms_of(NINE, ["tokens"], crowd=True)
    crowds = [task for task in tasks if task.crowd]
    assert [task.name.split("+")[0] for task in crowds] == [
        game for game in NINE if game != "coins"
    ]
    assert {task.num_agents for task in crowds} == {20}
    assert len(refused) == 1
