"""Two phases of a game written anew in plain Python from its rule sheet alone: they do what the game does.

The lines they were written from are here; if the sheet says something else one day, they have to be written again.
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
field bag  by { raw, cut, fine } : 0 .. cap capped = 0
field post by { raw, cut, fine } : 0 .. 5 * players capped = 0  # ours: room for the gifts of a step
shape ray = line(reach)
| `reach` | 1 | cells | 0 or more | before compiling | released code |
| `cap` | 15 | count | 0 or more | before compiling | paper: tokens of one level an agent can hold |
| `becomes` | `raw`: `cut`, `cut`: `fine`, `fine`: `fine` | word | one of `raw`, `cut`, `fine` | at any time | paper: at most two refinements |
| `yields` | `raw`: 3, `cut`: 3, `fine`: 1 | count | 0 to 5 | at any time | paper: tripled; released code: the finest stays one |
define offered(who)     = lowest(who.bag)      # released code
phase offer {
  each agent as giver where giver chose gift { mark ray of giver }  # released code: also with nothing to give
  each agent as giver where giver chose gift and sum(giver.bag) > 0 {
    let level = offered(giver)
    first agent as friend in ray of giver {
      when friend.bag[becomes[level]] < cap {
        add -1 to giver.bag[level]
        add yields[level] to friend.post[becomes[level]]
        tally given for giver
      }
    }
  }
}
phase receive(level) {
  each agent where agent.post[level] > 0 {
    add agent.post[level] to agent.bag[level]
    tally received[level] by min(agent.post[level], cap - agent.bag[level]) for agent
    set agent.post[level] = 0
  }
}
"""
MAP = ("PTPPP", "PTPPP")
AGENTS = 8  # on ten cells: they meet
LEVELS = ("raw", "cut", "fine")
AHEAD = ((-1, 0), (0, 1), (1, 0), (0, -1))  # one cell, by heading: north, east, south, west
GAME = TESTS.parent / "games" / "gift_refinement.sj"


def offer(
    bag: list[list[int]],
    post: list[list[int]],
    chose_gift: list[bool],
    places: list,
    headings: list[int],
) -> list[int]:
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
