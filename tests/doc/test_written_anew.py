"""Two phases of a game written anew in plain Python from its rule sheet alone: they do what the game does.

The sentences they were written from are here; if the sheet says something else one day, they have to be written again.
"""

import random
from copy import deepcopy

from sjdsl.compiler import build
from sjdsl.compiler.elaborate import Overrides
from sjdsl.compiler.syntax.read import read_source
from sjdsl.doc import read_written, rule_sheet
from sjdsl.interpreter.account import Account
from sjdsl.interpreter.state import default_params
from sjdsl.interpreter.step import reset, step
from sjdsl.interpreter.threefry import Threefry

from .corpus import TESTS

STATEMENTS = """
- `bag`, one for each of `raw`, `cut` and `fine`: a whole number from 0 to 15, at first 0; what would leave this range by adding is cut off.
- `offered` of agent *x* is the first of the words `raw`, `cut` and `fine` whose entry in the `bag` of agent *x* is above 0 (`raw` if none is).
- Each agent *giver* that chose `gift` and for which the sum of all entries of the `bag` of agent *giver* is more than 0:
  - Let *level* be `offered` of agent *giver*.
  - In each lane of the `ray` of agent *giver*, for the nearest agent *friend*:
    - If the entry of the `bag` of agent *friend* for (the entry of `becomes` for *level*) is less than 15:
      - 1 is taken from the entry of the `bag` of agent *giver* for *level* (which stays within 0 to 15).
      - The event `given` is counted once for agent *giver*.
- Each agent for which the `cut` entry of the `post` of the agent is more than 0:
  - The `cut` entry of the `post` of the agent is added to the `cut` entry of the `bag` of the agent (which stays within 0 to 15).
  - The `cut` entry of the `post` of the agent becomes 0.
"""
ADDED = "      - The entry of `yields` for *level* is added to the entry of the `post` of agent *friend* for (the entry of `becomes` for *level*)"
MAP = ("PTPPP", "PTPPP")
AGENTS = 8  # on ten cells: they meet
LEVELS = ("raw", "cut", "fine")
AHEAD = ((-1, 0), (0, 1), (1, 0), (0, -1))  # one cell, by heading: north, east, south, west
GAME = TESTS.parent / "games" / "gift_refinement.sj"


def offer(bag: list[list[int]], post: list[list[int]], chose_gift: list[bool], places: list, headings: list[int]) -> list[int]:
    """Changes bags and posts as `offer` says; returns how often `given` is counted for each agent."""
    becomes, yields = {"raw": "cut", "cut": "fine", "fine": "fine"}, {"raw": 3, "cut": 3, "fine": 1}
    before, given = deepcopy(bag), [0] * len(bag)
    for giver, tokens in enumerate(before):
        if not chose_gift[giver] or sum(tokens) == 0:
            continue
        level = next(w for w, n in zip(LEVELS, tokens, strict=True) if n > 0)
        row, col = (p + d for p, d in zip(places[giver], AHEAD[headings[giver]], strict=True))
        for friend, place in enumerate(places):
            new = LEVELS.index(becomes[level])
            if tuple(place) == (row, col) and before[friend][new] < 15:
                bag[giver][LEVELS.index(level)] -= 1
                post[friend][new] += yields[level]
                given[giver] += 1
    return given


def receive(bag: list[list[int]], post: list[list[int]], level: str) -> None:
    """Changes bags and posts as `receive(level)` says."""
    entry = LEVELS.index(level)
    for mine, sent in zip(bag, post, strict=True):
        mine[entry] = min(15, mine[entry] + sent[entry])
        sent[entry] = 0


def test_the_sheet_still_says_what_this_was_written_from() -> None:
    sheet = rule_sheet(read_written(read_source(GAME))).splitlines()
    assert [line for line in STATEMENTS.strip().splitlines() if line not in sheet] == []
    assert any(line.startswith(ADDED) for line in sheet)


def test_phases_written_from_the_sheet_do_what_the_game_does() -> None:
    game = build(read_source(GAME), (), Overrides(rows=MAP, num_agents=AGENTS)).game
    params, choose, told = default_params(game) | {"spawn": 0.9}, random.Random(0), []
    world = reset(game, params, Threefry(0, 0))
    gift, seen = game.agents.actions.index("gift"), 0
    for number in range(1, 250):
        actions = [gift if choose.random() < 0.6 else choose.randrange(7) for _ in range(AGENTS)]
        told.clear()
        world, outcome = step(game, world, actions, params, Threefry(0, number), told.append)
        given = [0] * AGENTS
        for account in told:
            bag, post = holdings(account, "before")
            name = account.turn.label  # type: ignore[union-attr]
            if name == "offer":
                here = account.before
                given = offer(bag, post, [a == gift for a in actions], here.position, here.heading)
            elif name.startswith("receive"):
                receive(bag, post, name[8:-1])
            else:
                continue
            assert (bag, post) == holdings(account, "after"), (number, name)
        assert outcome.events["given"] == given
        seen += sum(given)
    assert seen > 100, seen
    assert max(n for row in world.agents["bag"] for n in row) == 15  # so that full bags were met


def holdings(account: Account, when: str) -> tuple[list[list[int]], list[list[int]]]:
    """Returns every agent's bag and post before or after a phase, in the order of the levels."""
    fields = getattr(account, when).agents
    return [list(row) for row in fields["bag"]], [list(row) for row in fields["post"]]
