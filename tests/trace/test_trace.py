"""A trace tells all that happened: its changes, one after the other, make each state from the one before."""

from pathlib import Path

import jax
import numpy as np
import pytest

import sjdsl
from sjdsl.compiler import build, ir
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.read import read_source
from sjdsl.interpreter.board import board_of, declared_world
from sjdsl.interpreter.state import HEADINGS, Cell, Mover, World, copied, default_params
from sjdsl.library.tasks import with_tasks
from sjdsl.render.playing import play as play_compiled
from sjdsl.render.playing import random_policy
from sjdsl.trace.actions import RANDOM, read_actions
from sjdsl.trace.choices import ByEpisode
from sjdsl.trace.effects import Effect
from sjdsl.trace.episode import Moment, begin, follow, play
from sjdsl.trace.jax_random import key_of, random_numbers, split
from sjdsl.trace.lines import make_teller, moment_lines
from sjdsl.trace.rules import Rules

REPOSITORY = Path(__file__).parents[2]
FILES = [
    *((path, 12) for path in sorted((REPOSITORY / "games").glob("*.sj"))),
    *(
        (path, 30)
        for folder in ("cases", "differential/games")
        for path in sorted((REPOSITORY / "tests" / folder).glob("*.sj"))
    ),
]


def at_random(game: ir.Game) -> ByEpisode:
    return read_actions(RANDOM, game, None)[0]


def put(effect: Effect, game: ir.Game, world: World) -> None:
    """Makes one change of a state."""
    owner = effect.owner
    match effect.changed:
        case "field":
            name, *words = effect.name.removesuffix("]").replace("][", "[").split("[")
            if owner is None:
                world.fields[name] = entered(world.fields[name], effect, words)
                return
            if isinstance(owner, Mover):
                held = world.movers[owner.entity_type].fields[name]
                held[owner.number] = entered(held[owner.number], effect, words)
                return
            board = board_of(game)
            held = (
                world.cells[board.kind_of[owner], name]
                if isinstance(owner, Cell)
                else world.agents[name]
            )
            number = board.number[owner] if isinstance(owner, Cell) else owner
            held[number] = entered(held[number], effect, words)
        case "heading" if isinstance(owner, Mover):
            headings = world.movers[owner.entity_type].fields["heading"]
            assert headings[owner.number] == HEADINGS[effect.old]
            headings[owner.number] = HEADINGS[effect.new]
        case "place" | "away" | "moved" if isinstance(owner, Mover):
            herd = world.movers[owner.entity_type]
            lists = {"place": herd.position, "away": herd.away, "moved": herd.moved}[effect.changed]
            assert lists[owner.number] == effect.old
            lists[owner.number] = effect.new
        case "place" | "heading" | "away" | "moved":
            states = {
                "place": world.position,
                "heading": world.heading,
                "away": world.away,
                "moved": world.moved,
            }[effect.changed]
            assert states[owner] == effect.old
            states[owner] = effect.new
        case _:
            pass


def entered(whole: object, effect: Effect, words: list[str]) -> object:
    """Returns the value of a field with one entry changed."""
    if not words:
        assert whole == effect.old
        return effect.new
    assert effect.type is not None
    levels = effect.type.indexed_by[len(effect.type.indexed_by) - len(words) :]
    number = levels[0].keys.index(words[0])
    return (*whole[:number], entered(whole[number], effect, words[1:]), *whole[number + 1 :])  # type: ignore[index]


def state_of(world: World) -> tuple:
    return (
        world.cells,
        world.agents,
        world.fields,
        world.position,
        world.heading,
        world.moved,
        world.away,
        world.movers,
    )


def check_step(game: ir.Game, before: World, moment: Moment) -> None:
    """Checks that a moment tells all and only what happened in it, and that all of it can be explained."""
    list(moment_lines(moment, make_teller(board_of(game), Rules({}))))
    world = copied(before)
    effects = [effect for turn in moment.turns for effect in turn.effects]
    for effect in effects:
        put(effect, game, world)
    assert state_of(world) == state_of(moment.world)
    marks = {
        (cell.row, cell.col)
        for effect in effects
        if effect.changed == "mark"
        for cell in effect.new
    }
    assert marks == {(row, col) for _, row, col in moment.world.marks}
    ticks = {id(effect) for turn in moment.turns if turn.label == "tick" for effect in turn.effects}
    assert all(effect.by for effect in effects if id(effect) not in ticks), (
        "a change without a rule"
    )
    if moment.outcome is None:
        return
    rewards = [0.0 for _ in before.position]
    counts = {event.name: 0 for event in game.events}
    for effect in effects:
        if effect.changed == "reward":
            rewards[effect.owner] += effect.new
        if effect.changed == "event":
            counts[effect.name.partition("[")[0]] += effect.new
    np.testing.assert_allclose(
        moment.outcome.reward, rewards, rtol=1e-6, atol=1e-6
    )  # each phase rounds
    assert counts == {name: int(np.sum(count)) for name, count in moment.outcome.events.items()}
    assert moment.outcome.terminated == any(effect.changed == "end" for effect in effects)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("path", "steps"), FILES, ids=lambda value: value.stem if isinstance(value, Path) else ""
)
def test_changes_make_the_next_state(path: Path, steps: int) -> None:
    game = build(read_source(path)).game
    params = default_params(game)
    world = declared_world(board_of(game), params)
    for moment in play(game, params, 5, steps, at_random(game)):
        check_step(
            game,
            world if moment.number is not None else declared_world(board_of(game), params),
            moment,
        )
        world = moment.world


@pytest.mark.parametrize("tasks", ["training", {"feeding": "blue", "pay[red]": 4}])
def test_the_start_tells_the_tasks_that_are_played(tasks: str | dict[str, str | int]) -> None:
    """A side of a split, and fields that are fixed, change what was drawn; the trace says so."""
    path = REPOSITORY / "tests/cases/splits.sj"
    game = with_tasks(build(read_source(path)).game, tasks)
    assert game.task is not None
    number_changed = 0
    for seed in range(5):
        params = default_params(game)
        moment = begin(game, params, key_of(seed))
        world = declared_world(board_of(game), params)
        turns = [turn for turn in moment.turns if turn.label.startswith("task")]
        assert [turn.label for turn in turns] == [
            "task rules",
            "task rules, the tasks that are played",
        ]
        number_changed += len(turns[1].effects)
        for turn in turns:
            for effect in turn.effects:
                put(effect, game, world)
        for name in game.task.fields:
            assert world.fields[name] == moment.world.fields[name]
    assert number_changed > 3


def test_words_are_those_of_jax() -> None:
    for seed in (0, 3, 2**32 - 1, -1):
        assert key_of(seed) == tuple(np.asarray(jax.random.key_data(jax.random.key(seed))).tolist())
    key = jax.random.key(7)
    assert split(key_of(7), 4) == [
        tuple(words) for words in np.asarray(jax.random.key_data(jax.random.split(key, 4))).tolist()
    ]
    for below in (1, 2, 3, 7, 9, 64):
        assert (
            random_numbers(key_of(7), 9, below)
            == np.asarray(jax.random.randint(key, (9,), 0, below, np.int32)).tolist()
        )


def test_a_trace_is_the_episode_that_is_rendered() -> None:
    """Also past the end of an episode."""
    path = REPOSITORY / "tests/cases/sending.sj"
    env = sjdsl.make(path)
    shots = list(play_compiled(env, random_policy(env), 25, 11))
    moments = list(play(env.game, default_params(env.game), 11, 25, at_random(env.game)))
    assert len(moments) == len(shots) == 28
    for shot, moment in zip(shots, moments, strict=True):
        assert shot.step == moment.world.step
        assert [
            None if r < 0 else (r, c) for r, c in zip(shot.row, shot.col, strict=True)
        ] == moment.world.position
        assert shot.heading.tolist() == moment.world.heading


def test_written_actions_go_on_in_the_next_episode() -> None:
    """Of HENS, whose episodes last three steps; the start of the second is that of the next seed."""
    game = build(Source("hens.sj", HENS)).game
    choices, steps = read_actions("forward; stay; stay; forward; stay", game, None)
    assert steps == 5
    for _ in range(2):  # the same choices serve any number of traces
        moments = list(play(game, default_params(game), 4, steps, choices))
        assert [moment.number for moment in moments] == [None, 0, 1, 2, None, 0, 1]
        names = [game.agents.actions[action] for moment in moments for action in moment.actions]
        assert names == ["forward", "stay", "stay", "forward", "stay"]
    (start,) = play(game, default_params(game), 5, 0, choices)
    assert moments[4].world == start.world


def test_the_word_told_is_the_one_that_chose_the_cell() -> None:
    """Agent after agent takes, of the m cells that are left, number floor(w * m / 2^32): section 5 of docs/semantics.md."""
    game = build(Source("seats.sj", SEATS)).game
    for seed in range(5):
        start = next(iter(play(game, default_params(game), seed, 0, at_random(game))))
        free = [(row, col) for row in range(2) for col in range(4)]
        told = {
            effect.owner: effect
            for turn in start.turns
            for effect in turn.effects
            if effect.changed == "place"
        }
        assert [*told] == [0, 1, 2, 3, 4]
        for effect in told.values():
            (used,) = effect.draws
            assert used.purpose == "which cell"
            assert free.pop(used.bits * len(free) >> 32) == tuple(effect.new)


SEATS = """sj 1
game seats "Five agents, eight seats" {
  episode 3
  kind seat "s"
  map { "ssss" "ssss" }
  agents 5 { acts stay, forward  moves compass }
  phase start { each agent { send agent to seat facing north } }
  schedule walk
  phase walk { move each agent }
}
"""
SMALL = """sj 1
game small "One tree, one stone" {
  param luck : probability = 0.25
  episode 9
  kind tree  "T" { field fruit : { none, ripe } = none  timer rest }
  kind stone "o"
  kind house "H"
  map { "ToH" }
  agents 1 {
    acts stay, leave, shout
    field bag by { wood, iron } : 0 .. 9 capped = 0
  }
  phase start { each agent { send agent to stone facing east } }
  schedule tick -> grow -> go -> tell
  phase grow {
    each tree where tree.rest == 0 {
      chance luck { set tree.fruit = ripe  set tree.rest = 2 }
      otherwise chance 0.5 { set tree.rest = 1 }
    }
  }
  phase go { each agent where agent chose leave { send agent to house after 2 facing same } }
  phase tell {
    each agent as who where who chose shout {
      each tree where tree.fruit is ripe { add 1 to who.bag[wood] }
      add 2 to who.bag[wood]
      give 0.5 to who
      tally shouts for who
    }
    when step == 3 { end }
  }
  metrics { event shouts }
}
"""


def test_a_small_game_by_hand() -> None:
    """The words are looked up, all else is worked out from the rules."""
    game = build(Source("small.sj", SMALL)).game
    params = default_params(game)
    shout, leave, stay = (game.agents.actions.index(name) for name in ("shout", "leave", "stay"))
    chance = next(node for node in ir.walk(game) if isinstance(node, ir.Chance))
    fires = next(n for n in range(99) if luck_of((1, n), chance.stream) < 2**29)
    fails = next(n for n in range(99) if luck_of((1, n), chance.stream) >= 2**29 + 3 * 2**28)
    start = begin(game, params, (0, 0))
    assert lines_of(start) == ["place None -> (0, 1) 13", "heading 0 -> 1 13"]

    first = follow(game, start.world, params, (1, fires), [shout])
    assert lines_of(first) == ["fruit none -> ripe 17", "rest 0 -> 2 17", *shouted(0, 3)]
    (grown, *_) = (effect for turn in first.turns for effect in turn.effects)
    (drawn,) = grown.by[0].causes
    assert (drawn.statement, drawn.number, drawn.bits >> 1) == (
        chance,
        0,
        luck_of((1, fires), chance.stream),
    )
    assert drawn.bounds == (2**29,)

    second = follow(game, first.world, params, (1, fails), [leave])
    assert lines_of(second) == ["rest 2 -> 1 -", "place (0, 1) -> None 21", "away None -> 2 21"]
    third = follow(game, second.world, params, (1, fails), [stay])
    assert lines_of(third) == ["rest 1 -> 0 -", "away 2 -> 1 -"]
    (failed,) = third.turns[1].account.drawn
    assert (failed.result, failed.bounds) == (None, (2**29, 2**29 + 3 * 2**28))

    fourth = follow(game, third.world, params, (1, fails), [shout])
    assert lines_of(fourth) == [
        "place None -> (0, 2) 21",
        "away 1 -> None 21",
        *shouted(3, 6),
        "end 29",
    ]
    assert [
        len(effect.by)
        for turn in fourth.turns
        for effect in turn.effects
        if effect.name == "bag[wood]"
    ] == [2]
    assert fourth.outcome is not None
    assert fourth.outcome.terminated


def shouted(before: int, after: int) -> list[str]:
    """The tree is ripe: one for it, two for shouting."""
    return [f"bag[wood] {before} -> {after} 24", "reward +0.5 26", "shouts +1 27"]


def luck_of(key: tuple[int, int], stream: int) -> int:
    from sjdsl.interpreter.threefry import Threefry

    return Threefry(*key).bits(stream, 0) >> 1


def game_line(statement: ir.Stmt) -> int:
    assert statement.origin is not None
    return statement.origin.line


def lines_of(moment: Moment) -> list[str]:
    """Returns the changes of a moment: name, values, line of the rule that comes first."""
    found = []
    for effect in (effect for turn in moment.turns for effect in turn.effects):
        line = game_line(effect.by[0].statement) if effect.by else "-"
        old, new = (
            value.ticks if effect.changed == "away" and value else value
            for value in (effect.old, effect.new)
        )
        old, new = (
            f"({value.row}, {value.col})" if isinstance(value, Cell) else value
            for value in (old, new)
        )
        match effect.changed:
            case "reward" | "event":
                found.append(f"{effect.name or 'reward'} {new:+} {line}")
            case "end":
                found.append(f"end {line}")
            case _:
                found.append(f"{effect.name or effect.changed} {old} -> {new} {line}")
    return found


def test_the_way_told_is_the_one_that_was_drawn() -> None:
    """Of m open cells beside it, north, east, south, west, a mover goes to number floor(w * m / 2^32)."""
    game = build(Source("hens.sj", HENS)).game
    for seed in range(5):
        start, moment = play(game, default_params(game), seed, 1, at_random(game))
        (before,), (after,) = (
            start.world.movers["hen"].position,
            moment.world.movers["hen"].position,
        )
        ways = [
            Cell(before.row + row, before.col + col)
            for row, col in ((-1, 0), (0, 1), (1, 0), (0, -1))
        ]
        (agent,) = start.world.position
        open_ = [cell for cell in ways if cell in board_of(game).kind_of and cell != agent]
        (gone,) = [
            effect for turn in moment.turns for effect in turn.effects if effect.changed == "place"
        ]
        (used,) = (used for used in gone.draws if used.purpose == "which way")
        assert (gone.owner, gone.old, gone.new) == (Mover("hen", 0), before, after)
        assert open_[used.bits * len(open_) >> 32] == after
        assert "hen 0  goes from" in "\n".join(
            moment_lines(moment, make_teller(board_of(game), Rules({})))
        )


HENS = """sj 1
game hens "A hen that wanders"  {
  episode 3
  kind grass "."
  map { "..." "..." "..." }
  agents 1 { acts stay, forward  moves compass }
  movers hen 1 "h"
  phase start { each agent { send agent to grass }  each hen { send hen to grass } }
  schedule roam
  phase roam { move each hen at random }
}
"""


LOTS = """sj 1
game lots "Lots" {
  episode 5
  kind grass "." { field taker : agent  field sign : { none, flag, cross } = none }
  map { "..." }
  agents 3 { acts stay, grab, ask }
  phase start { each agent { send agent to grass } }
  schedule take
  phase take {
    each agent where agent chose grab { each grass where grass.col == 0 { set grass.taker = agent by lot } }
    each agent where agent chose ask { each grass where grass.col == 0 { set grass.taker = nobody by lot  set grass.sign = flag by lot } }
  }
}
"""


def test_losers_of_a_lot_are_named() -> None:
    """In every step with two who grab, one has the cell and the other is told who had it; draws of two statements are one lot."""
    game = build(Source("lots.sj", LOTS, None)).game
    teller = make_teller(board_of(game), Rules({"lots.sj": Source("lots.sj", LOTS, None)}))
    for moment in play(game, default_params(game), 1, 6, lambda *_: lambda *_: [1, 1, 2]):
        lines = [line.strip() for line in moment_lines(moment, teller)]
        lost = [line for line in lines if "lost the lot" in line]
        takers = [
            effect for turn in moment.turns for effect in turn.effects if effect.name == "taker"
        ]
        for effect in takers:
            loser, winner = {0, 1, 2} - {effect.by[0].names["agent"]}, effect.by[0].names["agent"]
            assert len(effect.lost) == 2
            assert {done.names["agent"] for done in effect.lost} == loser
            assert sum(line.endswith(f"lost the lot to agent {winner}") for line in lost) == 2
        assert bool(takers) == bool(lost)
