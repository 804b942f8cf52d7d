"""What laws are tried on: the nine games and random programs, typed, and states of them in which much happens."""

from collections import deque
from dataclasses import replace
from functools import cache
from random import Random
from typing import Any

import pytest

from sjdsl.compiler import Build, build, ir, lower_build
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.read import read_source
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.shapes import FORWARD
from sjdsl.interpreter.state import Cell, World, default_params
from sjdsl.interpreter.step import reset
from sjdsl.interpreter.threefry import Threefry
from sjdsl.library.games_folder import find_game
from sjdsl.properties.biased_draws import BiasedDraws
from tests.fuzz.judge import written
from tests.fuzz.programs import program
from tests.fuzz.together import interpret, on_numpy, random_play, run
from tests.games.environments import HARVESTS
from tests.laws.symmetry import STEPS

FEW = 4  # random programs in a test; `python -m tests.laws.campaign` tries more
SOME_OF_NINE = [  # the others of the nine come with the thorough tests
    "coins",
    "clean_up",
    "gift_refinement",
    "pd_arena",
    *(
        pytest.param(name, marks=pytest.mark.thorough)
        for name in (*HARVESTS, "coop_mining", "mushrooms")
    ),
]


@cache
def source_of(name: str) -> Source:
    return read_source(find_game(name))


@cache
def game_of(name: str, *variants: str) -> ir.Game:
    """Returns the typed rules of a bundled game."""
    return build(source_of(name), variants).game


def random_text(seed: int) -> tuple[Source, Build] | None:
    """Returns a random program, if this seed gives one that is accepted and does what the interpreter says."""
    with written(program(Random(seed))) as source:
        try:
            made = build(source)
            lower_build(made, source)
            right = run(
                on_numpy(made.game),
                play := random_play(made.game, seed, 4),
                interpret(made.game, play),
            )
        except Exception:  # refused; or compiled wrongly: of that tests/fuzz tells
            return None
        return None if right.differences else (source, made)


@cache
def random_games(number: int, first: int = 80) -> tuple[tuple[int, ir.Game], ...]:
    """Returns the first random games from a seed on, each with its seed; in those from the default on much is drawn."""
    games: list[tuple[int, ir.Game]] = []
    seed = first
    while len(games) < number:
        made = random_text(seed)
        if made is not None:
            games.append((seed, made[1].game))
        seed += 1
    return tuple(games)


def begun(game: ir.Game, random: Random) -> World:
    """Returns the state after a reset."""
    return reset(
        game, default_params(game), Threefry(random.getrandbits(32), random.getrandbits(32))
    )


def crowded(game: ir.Game, random: Random) -> World:
    """Returns a first state with all agents who have a place side by side, facing anywhere: they meet at once."""
    world = begun(game, random)
    board = board_of(game)
    blocking = {
        k.name for k in game.kinds for b in k.blocks if b.what == "agents" and b.condition is None
    }
    taken = {place for herd in world.movers.values() for place in herd.position}
    open_ = [
        cell for cell, kind in board.kind_of.items() if kind not in blocking and cell not in taken
    ]
    here = [agent for agent, place in enumerate(world.position) if place is not None]
    for start in random.sample(open_, len(open_)):
        near = _nearest(start, set(open_), len(here))
        if len(near) == len(here):
            break
    else:
        return world
    random.shuffle(near)
    position: list[Any] = list(world.position)
    for agent, cell in zip(here, near, strict=True):
        position[agent] = cell
    return replace(world, position=position, heading=[random.randrange(4) for _ in position])


def _nearest(start: Cell, cells: set[Cell], number: int) -> list[Cell]:
    """Returns so many cells that can be walked to, nearest first."""
    found, waiting = [start], deque([start])
    while waiting and len(found) < number:
        row, col = waiting.popleft()
        for cell in (
            Cell(row - 1, col),
            Cell(row, col + 1),
            Cell(row + 1, col),
            Cell(row, col - 1),
        ):
            if cell in cells and cell not in found:
                found.append(cell)
                waiting.append(cell)
    return found[:number]


def biased_draws(random: Random) -> BiasedDraws:
    """Returns the draws of a step in which rare events happen often."""
    return BiasedDraws(
        Threefry(random.getrandbits(32), random.getrandbits(32)),
        random.choice(("fair", "mixed", "mixed")),
    )


def some_actions(game: ir.Game, random: Random, world: World | None = None) -> list[int]:
    """Returns an action for each agent, those that are no steps more often. `world`: half of the time all who can enter one cell do."""
    own = [i for i, a in enumerate(game.agents.actions) if i >= 7] or [0]
    every = range(len(game.agents.actions))
    actions = [
        random.choice(own) if random.random() < 0.4 else random.choice(every)
        for _ in range(game.agents.number)
    ]
    here = [] if world is None else [place for place in world.position if place is not None]
    if world is None or not here or random.random() < 0.5:
        return actions
    (rows, cols), (row, col) = random.choice(FORWARD), random.choice(here)
    target = (row + rows, col + cols)
    for agent, place in enumerate(world.position):
        for direction, (rows, cols) in enumerate(FORWARD):
            if place is not None and (place.row + rows, place.col + cols) == target:
                name = STEPS[
                    (direction - world.heading[agent]) % 4 if game.agents.relative else direction
                ]
                actions[agent] = (
                    game.agents.actions.index(name)
                    if name in game.agents.actions
                    else actions[agent]
                )
    return actions
