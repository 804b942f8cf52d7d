"""Splits of tasks: which tasks each side plays, in the compiled game and in the interpreter alike."""

import gc
import weakref
from collections import Counter
from collections.abc import Iterator
from fractions import Fraction
from itertools import permutations
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.ir import task_rows
from sjdsl.compiler.ir.hash import game_hash
from sjdsl.compiler.ir.queries import task_space
from sjdsl.compiler.ir.task_rows import rows_of_hold_out, rows_of_training, tasks_with
from sjdsl.compiler.syntax.read import read_source
from sjdsl.interpreter.board import CACHE_SIZE
from sjdsl.interpreter.step import task_of_key
from sjdsl.library.factory import make, with_other_tasks
from sjdsl.library.tasks import with_tasks
from tests.fuzz import together

CASE = Path(__file__).parents[1] / "cases" / "splits.sj"
GAME = build(read_source(CASE)).game
SIDES: dict[str, dict[str, Any]] = {
    "all": {"tasks": "all"},
    "training": {},
    "rules": {"tasks": "held_out", "split": "rules"},
    "rich": {"tasks": "held_out", "split": "rich"},
    "late": {"tasks": "held_out", "split": "late"},
    "given": {"tasks": {"feeding": "blue", "pay[green]": 4, "pay[blue]": 0, "order[red]": "red"}},
    "problem": {"problem": 906},
}
RED, GREEN, BLUE = range(3)  # words and entries of rows, in the order of the file
SMALL = """sj 1
game small "A task of six" {
  episode 3
  task rules { field hue : { red, green, blue }  field dear : 0 .. 1 }
  train on 3 of rules seed 1
  kind grass "."
  map { "..." }
  agents 1 { acts stay, forward  moves relative }
  phase start { each agent { send agent to grass } }
  schedule pay
  phase pay { when hue is red and dear == 1 { give 1 to all } }
}
"""


def side(name: str) -> ir.Game:
    return with_tasks(GAME, **SIDES[name])


def drawn(game: ir.Game, number: int) -> list[tuple[int, ...]]:
    """Returns the tasks of some episodes, as the compiled game on NumPy draws them."""
    env = together.on_numpy(game)
    assert game.task is not None
    tasks = []
    for episode in range(number):
        with np.errstate(over="ignore"):  # of 32 bits, as meant
            state = env.begin((17, episode))
        values = [np.ravel(getattr(state, f"world_{name}")).tolist() for name in game.task.fields]
        tasks.append(tuple(entry for entries in values for entry in entries))
    return tasks


def is_rich(task: tuple[int, ...]) -> bool:
    """Returns whether the condition of `rich` in the file holds: `pay[red] > 2`, and so on."""
    _, pay_red, _, _, _, _, order_blue, _ = task
    return pay_red > 2 and order_blue != GREEN


def is_late(task: tuple[int, ...]) -> bool:
    _, pay_red, _, pay_blue, _, _, _, delay = task
    return delay == 1 and pay_blue + pay_red < 3


@pytest.mark.parametrize("name", SIDES)
def test_compiled_game_and_interpreter_play_the_same_tasks(name: str) -> None:
    game = side(name)
    play = together.random_play(game, seed=4, steps=20)
    report = together.run(together.on_numpy(game), play, together.interpret(game, play))
    assert not report.differences, report.differences
    assert report.steps == 20


def test_a_planted_fault_is_found() -> None:
    """The comparison above: a module that takes its training tasks from another seed."""
    game = side("training")
    text = together.module_text(game)
    assert text.count("STREAM_TASK_NUMBER, 8, 3)") == 2
    faulty = together.of_text(game, text.replace("_NUMBER, 8, 3)", "_NUMBER, 8, 4)"))
    play = together.random_play(game, seed=4, steps=20)
    assert together.run(faulty, play, together.interpret(game, play)).differences


def test_training_episodes_have_few_tasks_and_none_that_is_held_out() -> None:
    tasks = drawn(side("training"), 60)
    assert len(set(tasks)) == 8
    assert not any(is_rich(task) or is_late(task) for task in tasks)
    everything = drawn(side("all"), 60)
    assert len(set(everything)) > 50
    assert any(map(is_rich, everything))
    assert any(map(is_late, everything))


def test_held_out_episodes_have_tasks_of_their_split() -> None:
    assert all(map(is_rich, drawn(side("rich"), 30)))
    assert all(map(is_late, drawn(side("late"), 30)))
    training = set(drawn(side("training"), 60))
    others = drawn(side("rules"), 60)
    assert training.isdisjoint(others)
    assert not any(is_rich(task) or is_late(task) for task in others)
    assert len(set(others)) > 50


def test_rows_of_different_values_stay_so() -> None:
    for name in SIDES:
        for task in drawn(side(name), 15):
            assert len({task[1], task[2], task[3]}) == 3, (name, task)


@pytest.mark.thorough
def test_each_held_out_task_is_equally_likely() -> None:
    """Of `late`, pay[red] and pay[blue] are (0, 1), (0, 2), (1, 0) or (2, 0), and pay[green] is one
    of the three others: 12 rows of a share 1/12 each. Of 1,200 episodes 100 are expected, with a
    deviation of 9.6; five of these are passed with a probability below 1e-5."""
    counts = Counter(task[1:4] for task in drawn(side("late"), 1200))
    assert len(counts) == 12
    assert all(abs(count - 100) < 5 * 9.6 for count in counts.values()), counts


def test_the_tasks_of_a_side_are_counted() -> None:
    task = GAME.task
    assert task is not None
    rich, late = task.hold_outs
    # pay has 5 * 4 * 3 deals, order 27 rows, feeding and delay 3 values each.
    assert task_space(task) == 60 * 27 * 9
    assert tasks_with(rows_of_hold_out(task, rich), task) == 60 * 27 * 9 * 2 // 5 * 2 // 3
    assert tasks_with(rows_of_hold_out(task, late), task) == 12 * 27 * 3
    left = tasks_with(rows_of_training(task), task)
    # Nothing is both: pay[red] > 2 and pay[red] < 3.
    assert left == 60 * 27 * 9 - 60 * 27 * 9 * 4 // 15 - 12 * 27 * 3
    train_on = task.train_on
    assert train_on is not None
    share = Fraction(train_on.number, left)
    assert share**train_on.candidates <= Fraction(1, 2**64) < share ** (train_on.candidates - 1)


def test_the_interpreter_keeps_no_task_that_was_played_long_ago() -> None:
    game = side("rules")
    task_of_key(game, (17, 1))
    assert game.task is not None
    first = weakref.ref(game.task)
    del game
    for _ in range(CACHE_SIZE):
        task_of_key(side("rules"), (17, 1))
    gc.collect()
    assert first() is None


def test_a_reset_draws_64_candidates_at_most() -> None:
    """Half of the tasks to train on: 2^-64 = (1 / 2)^64. The six tasks allow no fourth."""
    task = build(Source("small.sj", SMALL)).game.task
    assert task is not None
    assert task.train_on is not None
    assert task.train_on.candidates == 64
    with pytest.raises(CompileError, match="4 training tasks, out of 6, leave less than half"):
        build(Source("small.sj", SMALL.replace("train on 3", "train on 4")))


def test_tasks_of_a_small_space_are_held_out_too() -> None:
    game = build(Source("small.sj", SMALL)).game
    training = set(drawn(with_tasks(game), 60))
    others = set(drawn(with_tasks(game, "held_out"), 60))
    assert len(training) <= 3
    assert len(training | others) == 6
    assert training.isdisjoint(others)


def test_a_table_names_its_columns_as_they_are_written() -> None:
    assert "rows of pay[red], order[blue]" in together.module_text(side("rich"))


def test_what_is_given_is_not_drawn() -> None:
    tasks = drawn(side("given"), 60)
    for feeding, _, pay_green, pay_blue, order_red, _, _, _ in tasks:
        assert (feeding, pay_green, pay_blue, order_red) == (BLUE, 4, 0, RED)
    assert {task[1] for task in tasks} == {1, 2, 3}
    assert {task[7] for task in tasks} == {-1, 0, 1}


def test_a_problem_is_one_task_of_its_side() -> None:
    problems = [with_tasks(GAME, problem=number) for number in range(10)]
    tasks = set()
    for problem in problems:
        of_problem = set(drawn(problem, 3))
        assert len(of_problem) == 1
        tasks |= of_problem
    assert tasks <= set(drawn(side("training"), 60))
    rich = with_tasks(GAME, "held_out", "rich", problem=5)
    assert all(map(is_rich, drawn(rich, 3)))


@pytest.mark.parametrize("before", SIDES)
def test_a_choice_of_tasks_replaces_the_one_before(before: str) -> None:
    for name, arguments in SIDES.items():
        assert with_tasks(side(before), **arguments).task == side(name).task, name
    assert with_tasks(side("given"), {}).task == side("all").task


def test_other_tasks_of_an_environment_are_not_those_given_before() -> None:
    env = with_other_tasks(make(CASE, problem=906), "held_out", "rich")
    assert (env.tasks, env.split) == ("held_out", "rich")


def test_splits_change_no_draw_of_a_game_that_plays_all() -> None:
    text = CASE.read_text("utf-8")
    lines = text.splitlines(keepends=True)
    without = "".join(line for line in lines if not line.startswith(("  train on", "  hold out")))
    plain = build(Source("splits.sj", without)).game
    assert drawn(plain, 30) == drawn(side("all"), 30)
    assert game_hash(plain) != game_hash(GAME)
    assert {game_hash(side(name)) for name in SIDES} == {game_hash(GAME)}


def test_the_rows_of_a_condition_are_listed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 5 of 7 different values there are 7! / 2! = 2,520 rows; that some are held out shows at
    the first that is."""
    listed = Counter[str]()
    all_rows = task_rows._all_rows

    def counted(*arguments: Any) -> Iterator[task_rows.Row]:
        for row in all_rows(*arguments):
            listed["rows"] += 1
            yield row

    monkeypatch.setattr(task_rows, "_all_rows", counted)
    task = "field hue by { a, b, c, d, e, f, g } : different 0 .. 6  "
    condition = "hue[a] + hue[b] + hue[c] + hue[d] + hue[e] > 15"
    text = SMALL.replace("field hue", f"{task}field shade")
    text = text.replace("train on 3", f"hold out dark of rules where {condition}\n  train on 3")
    game = build(Source("small.sj", text.replace("hue is red", "shade is red"))).game
    assert game.task is not None
    dark = sum(sum(row) > 15 for row in permutations(range(7), 5))
    assert tasks_with(rows_of_training(game.task), game.task) == (2520 - dark) * 2 * 3 * 2
    listed.clear()
    build(Source("small.sj", text.replace("hue is red", "shade is red")))
    assert 2520 < listed["rows"] < 2 * 2520


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"tasks": "held_out"}, "several splits, rules, rich, late"),
        ({"tasks": "heldout"}, "did you mean `held_out`"),
        ({"tasks": "held_out", "split": "rick"}, "did you mean `rich`"),
        ({"split": "rich"}, "training are played"),
        ({"tasks": {"feding": "red"}}, "did you mean `feeding`"),
        ({"tasks": {"feeding": "rod"}}, "one of red, green, blue"),
        ({"tasks": {"feeding[red]": "red"}}, "one value, not a row"),
        ({"tasks": {"pay": 3}}, r"pay\[red\], pay\[green\], pay\[blue\]"),
        ({"tasks": {"pay[rod]": 3}}, r"did you mean `pay\[red\]`"),
        ({"tasks": {"delay": 2}}, "-1 .. 1, not 2"),
        ({"tasks": {"pay": {"red": 1, "blue": 1}}}, "the entries of this row are different"),
        ({"tasks": {"pay": {"red": 1}, "pay[red]": 2}}, "given twice"),
        ({"tasks": {"delay": 1}, "split": "rich"}, "leave out split"),
        ({"problem": -1}, "from 0 to 4294967295"),
    ],
)
def test_arguments_that_do_not_fit_are_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make(CASE, **arguments)


def test_a_game_without_a_task_or_a_split_says_so() -> None:
    with pytest.raises(ValueError, match="has no task"):
        make("coins", tasks="all")
    with pytest.raises(ValueError, match="no split"):
        make(CASE.with_name("tasks.sj"), tasks="training")
    with pytest.raises(TypeError, match="a mapping from fields"):
        make(CASE, tasks=3)  # type: ignore[arg-type]
    assert make(CASE.with_name("tasks.sj")).tasks == "all"
    assert make("coins").tasks is None
    env = make(CASE, **SIDES["given"])
    assert (env.tasks, env.split) == (SIDES["given"]["tasks"], "")
    env = make(CASE, **SIDES["rich"])
    assert (env.tasks, env.split) == ("held_out", "rich")


def test_held_out_tasks_compiled_by_xla() -> None:
    """The training tasks are computed while a reset is traced, inside `vmap` too."""
    env = make(CASE, **SIDES["rules"])
    keys = jnp.asarray([(17, episode) for episode in range(20)], jnp.uint32)
    _, states = jax.jit(jax.vmap(env.reset))(keys)
    assert env.game.task is not None
    columns = []
    for name in env.game.task.fields:
        columns.append(np.asarray(getattr(states, f"world_{name}")).reshape(20, -1))
    tasks = [tuple(row) for row in np.concatenate(columns, axis=1).tolist()]
    assert tasks == drawn(side("rules"), 20)
