"""Messages: what is in a window, what actions lead to, and that nothing hidden is told."""

import random
import re
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import pytest

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import all_fields
from sjdsl.compiler.ir.types import element
from sjdsl.compiler.lower import token_planes
from sjdsl.interpreter.board import Board, board_of
from sjdsl.interpreter.observe import observe
from sjdsl.interpreter.state import World, copied
from sjdsl.interpreter.step import action_mask, reset, step
from sjdsl.interpreter.threefry import Threefry
from sjdsl.told import Past, Window, message, told
from sjdsl.told.legal import action_lines
from sjdsl.told.relevance import relevant

from .corpus import CASES, FILES, GOLDEN, game

Replace = Callable[[World], None]
State = tuple[World, list[int], list[float]]  # with the actions and rewards that led to it


def episode(g: ir.Game, steps: int, seed: int = 0) -> Iterator[State]:
    """Yields states; all act at random."""
    params = {param.name: param.value for param in g.params}
    chance = random.Random(seed)
    world = reset(g, params, Threefry(seed, 0))
    yield world, [], []
    for number in range(steps):
        actions = [chance.randrange(len(g.agents.actions)) for _ in range(g.agents.number)]
        world, outcome = step(g, world, actions, params, Threefry(seed, number + 1))
        if outcome.truncated or outcome.terminated:
            return
        yield world, actions, [float(reward) for reward in outcome.reward]


def messages(g: ir.Game, states: Sequence[State], replace: Replace | None = None) -> str:
    """Returns all messages of an episode; in each state, some fields are replaced first."""
    window = Window(g, token_planes(g))
    past: list[list[Past]] = [[] for _ in range(g.agents.number)]
    texts = []
    for world, actions, rewards in states:
        for agent, action in enumerate(actions):
            past[agent].append(Past(g.agents.actions[action], rewards[agent]))
        shown = copied(world)
        if replace is not None:
            replace(shown)
        seen = observe(g, shown)
        mask = action_mask(g, shown)
        for agent in range(g.agents.number):
            trial = world.fields.get("trial", 0)
            told_now = message(window, seen[agent], mask[agent], past[agent], ["a note"], (), trial)
            texts.append(told_now)
    return "\n".join(texts)


def hidden_fields(g: ir.Game) -> list[ir.VarField]:
    """Returns the fields that neither what agents see nor what they may do speaks of by name."""
    blocks = [block for kind in g.kinds for block in kind.blocks]
    shown = (g.window, *g.observables, *g.hidden, *g.agents.forbids, *g.agents.blocks, *blocks)
    names = {observable.field for observable in g.observables}
    for part in shown:
        names |= {node.name for node in ir.walk(part) if isinstance(node, ir.FieldRead)}
    return [field for field in all_fields(g) if field.name not in names and field.name != "trial"]


def drawn(type_: ir.Type, chance: random.Random, board: Board) -> Any:
    """Returns any value of a type."""
    if type_.indexed_by:
        keys = range(len(type_.indexed_by[0]))
        return tuple(drawn(element(type_), chance, board) for _ in keys)
    match type_.kind:
        case "word":
            return chance.choice(type_.words)
        case "int":
            return chance.randint(int(type_.low), int(min(type_.high, 10**6)))
        case "real":
            return np.float32(chance.random())
        case "agent":
            return chance.choice([None, *range(board.agents)])
        case "agents":
            agents = range(board.agents)
            return frozenset(chance.sample(agents, chance.randint(0, len(agents))))
        case "cell":
            cells = [cell for cell, kind in board.kind_of.items() if kind in type_.kinds]
            return chance.choice([None, *cells])
    raise AssertionError(type_)


def replaced(g: ir.Game, fields: Sequence[ir.VarField], seed: int) -> Replace:
    """Returns what gives fields other values, drawn anew for each state."""
    chance = random.Random(seed)
    board = board_of(g)

    def replace(world: World) -> None:
        for field in fields:
            holder = field.held_by
            match holder.what:
                case "world":
                    world.fields[field.name] = drawn(field.type, chance, board)
                    continue
                case "cell":
                    values = world.cells[holder.name, field.name]
                case "agent":
                    values = world.agents[field.name]
                case "mover":
                    values = world.movers[holder.name].fields[field.name]
            values[:] = [drawn(field.type, chance, board) for _ in values]

    return replace


# Games whose fields are all seen in windows, or read by what is.
ALL_SHOWN = {
    *("chicken", "coins", "harvest_closed", "harvest_open", "harvest_partnership", "lb_foraging"),
    *("orchard", "pd_arena", "stag_hunt"),
}
HIDING = [
    pytest.param(name, marks=pytest.mark.thorough if path.parent.name == "meltingpot" else ())
    for name, path in {**FILES, "tasks": CASES["tasks"]}.items()
    if name not in ALL_SHOWN
]


def test_other_games_hide_nothing() -> None:
    assert all(hidden_fields(game(name)) == [] for name in ALL_SHOWN)


@pytest.mark.parametrize("name", HIDING)
def test_no_message_depends_on_what_is_hidden(name: str) -> None:
    g = game(name)
    hidden = hidden_fields(g)
    assert hidden
    states = list(episode(g, 3))
    plain = messages(g, states)
    for seed in range(20):
        assert messages(g, states, replaced(g, hidden, seed)) == plain


def test_a_message_depends_on_what_is_shown() -> None:
    """The test above could tell: here a field that is shown is replaced."""
    for name, field in (("tasks", "feeding"), ("two_trees+told", "bears")):
        g = game(name)
        fields = [one for one in all_fields(g) if one.name == field]
        states = list(episode(g, 3))
        assert messages(g, states, replaced(g, fields, 1)) != messages(g, states)


PLAYED = ["clean_up", "clean_up+socialjax", "reputation", "ferry", "two_trees", "predator_prey"]


@pytest.mark.parametrize(
    "name",
    [
        *PLAYED,
        "running_with_scissors_in_the_matrix",
        pytest.param("coop_mining+socialjax", marks=pytest.mark.thorough),
    ],
)
def test_what_is_left_out_changes_nothing(name: str) -> None:
    """The rules that are told give the same observations, rewards and masks as all rules."""
    told_rules = relevant(game(name)).game
    for (full, _, gains), (pruned, _, pruned_gains) in zip(
        episode(game(name), 12), episode(told_rules, 12), strict=True
    ):
        np.testing.assert_array_equal(observe(game(name), full), observe(told_rules, pruned))
        assert gains == pruned_gains
        assert action_mask(game(name), full) == action_mask(told_rules, pruned)


@pytest.mark.parametrize("name", ["clean_up", "territory", "ferry", "collaborative_cooking"])
def test_the_grid_says_what_the_planes_say(name: str) -> None:
    """Read back, its codes are the content of each cell without anybody on it."""
    g = game(name)
    window = Window(g, token_planes(g))
    labels = {code: label for label, code in window.codes.items()}
    assert len(labels) == len(window.codes)
    *_, (world, _, _) = episode(g, 6)
    for seen in observe(g, world):
        height, width = seen.shape[1:]
        rows = window.text(seen).splitlines()[1 : height + 1]
        for row, line in enumerate(rows):
            for col, code in enumerate(line.split()[-width:]):
                content = window.planes[0].labels[seen[0, row, col]]
                assert code in ("ME", "A^", "A>", "Av", "A<", "bo") or labels[code] == content


def test_a_step_leads_to_what_it_says() -> None:
    """Alone and without growth: what `forward -> …` names is under the agent after it."""
    g = game("two_trees")
    window = Window(g, token_planes(g))
    params = {param.name: param.value for param in g.params}
    checked = 0
    for world, _, _ in episode(g, 40):
        seen = observe(g, world)[0]
        allowed = action_mask(g, world)[0]
        for line in action_lines(window, seen, allowed):
            name, arrow, end = line.partition(" -> ")
            if arrow:
                after, _ = step(g, world, [g.agents.actions.index(name)], params, Threefry(5, 0))
                if world.fields["trial"] == after.fields["trial"]:
                    place = (after.position[0] == world.position[0], end.startswith("blocked"))
                    assert place in ((True, True), (False, False))
                    under = observe(g, after)[0]
                    here = window.content(under, window.own_place(under))
                    assert end in (here, "blocked, outside")
                    checked += 1
    assert checked > 50


@pytest.mark.parametrize(("name", "knows"), [("lb_foraging", True), ("ferry", False)])
def test_compass_steps_lead_somewhere_if_the_way_north_is_known(name: str, knows: bool) -> None:
    """In lb_foraging all always look north; in ferry nobody is told which way it looks."""
    g = game(name)
    window = Window(g, token_planes(g))
    params = {param.name: param.value for param in g.params}
    *_, (world, _, _) = episode(g, 5)
    checked = 0
    for agent, seen in enumerate(observe(g, world)):
        for line in action_lines(window, seen, action_mask(g, world)[agent]):
            action, arrow, end = line.partition(" -> ")
            assert knows or not arrow
            if arrow and "agent" not in end:
                stay = g.agents.actions.index("stay")
                actions = [stay] * g.agents.number
                actions[agent] = g.agents.actions.index(action)
                after, _ = step(g, world, actions, params, Threefry(5, 0))
                has_moved = after.position[agent] != world.position[agent]
                is_open = end == "start" or end.endswith("none")
                assert has_moved == is_open
                checked += 1
    assert (checked > 5) == knows


def test_who_is_away_sees_nothing() -> None:
    g = game("predator_prey")
    window = Window(g, token_planes(g))
    nothing = np.zeros((len(window.planes), 11, 11), np.uint8)
    assert window.text(nothing) == "You are away: you see nothing."


def test_a_message_is_as_it_was(golden) -> None:
    texts = [
        messages(game(name), list(episode(game(name), steps)))
        for name, steps in (("two_trees", 2), ("territory", 1))
    ]
    golden(GOLDEN / "messages.txt", "\n=====\n".join(texts))


@pytest.mark.parametrize("name", ["headings", "starting"])
def test_a_hidden_heading_is_not_told(name: str) -> None:
    """Others are `A?` where their plane says `other`, and nothing is said of how they look."""
    g = game(name)
    window = Window(g, token_planes(g))
    hidden = 0
    for world, _, _ in episode(g, 8):
        for seen in observe(g, world):
            labels = [window.planes[1].labels[who] for who in seen[1].flat]
            text = window.text(seen)
            hidden += labels.count("other")
            shown = sum(label.startswith("other ") for label in labels)
            assert text.count("looks ") == shown
            assert len(re.findall(r"A\?(?! an agent)", text)) == labels.count("other")
            assert ("A? an agent whose direction you can't see" in text) == ("other" in labels)
    assert hidden > 0
    assert "A? is an agent whose direction you can't see." in told(g)
    assert ("A^ A> Av A<" in told(g)) == (name == "headings")
