"""Which forms of the games are measured: own and other numbers of agents, both observations; nothing is compiled by XLA here."""

import pytest

from sjdsl.cli.bench import choose_tasks
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from tests.games.environments import NINE


def test_a_game_without_room_comes_as_its_crowd_and_one_that_refuses_is_named() -> None:
    tasks, refused = choose_tasks(["coins", "clean_up", "pd_arena"], None, ["tokens"], [None, 20])
    assert [(task.name, task.num_agents, task.crowd) for task in tasks] == [
        ("coins", 2, None),
        ("clean_up", 7, None),
        ("clean_up+crowd", 20, 20),
        ("pd_arena", 4, None),
        ("pd_arena", 20, 20),
    ]
    (line,) = refused
    assert line == "coins can't have 20 agents: `players` is 20, outside 2 .. 2 (two colours, an agent for each)"


def test_each_observation_is_a_task() -> None:
    tasks, refused = choose_tasks(["coins"], "socialjax", ["tokens", "onehot"], [None])
    assert [(task.name, task.observation) for task in tasks] == [("coins+socialjax", "tokens"), ("coins+socialjax", "onehot")]
    assert refused == []


def test_all_nine_but_coins_come_with_twenty_agents() -> None:
    tasks, refused = choose_tasks(NINE, None, ["tokens"], [20])
    assert [task.name.split("+")[0] for task in tasks] == [game for game in NINE if game != "coins"]
    assert {task.num_agents for task in tasks} == {20}
    assert len(refused) == 1


def test_what_is_wrong_with_a_game_is_no_refusal_of_a_number() -> None:
    with pytest.raises(CompileError):
        choose_tasks(["coins"], "no_such_variant", ["tokens"], [20])
