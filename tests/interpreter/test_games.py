"""The games of the repository, played at random: their own checks hold in every state."""

import random
from pathlib import Path

import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.syntax.read import read_source
from sjdsl.interpreter.observe import observe
from sjdsl.interpreter.planes import planes
from sjdsl.interpreter.state import Cell, Outcome, World, default_params
from sjdsl.interpreter.step import action_mask, read, reset, step
from sjdsl.interpreter.threefry import Recorded, Threefry

GAMES = Path(__file__).parents[2] / "games"
NAMES = sorted(path.stem for path in GAMES.glob("*.sj"))


def load(name: str, *variants: str) -> ir.Game:
    return build(read_source(GAMES / f"{name}.sj"), variants).game


RELEASED = [name for name in NAMES if "socialjax" in load(name).variants]
FORMS = [*((name, ()) for name in NAMES), *((name, ("socialjax",)) for name in RELEASED)]


class Play:
    """One episode of random actions, checked after every step."""

    def __init__(self, game: ir.Game, seed: int = 0):
        self.game, self.seed, self.choose = game, seed, random.Random(seed)
        self.params = default_params(game)
        self.totals: dict[tuple[str, str | None], int] = {}
        self.fired: set[int] = set()
        self.draws = Recorded(Threefry(seed, 1))
        self.world = reset(game, self.params, self.draws)
        self.conserved = [read(game, self.world, v) for c in game.checks if c.sort == "conserved" for v in c.values]
        self.check()

    def step(self) -> tuple[World, Outcome]:
        """Returns the state before the step and what the step gave."""
        before = self.world
        number, actions = self.game.agents.number, len(self.game.agents.actions)
        chosen = [self.choose.randrange(actions) for _ in range(number)]
        self.draws = Recorded(Threefry(self.seed + 1, before.step))
        self.world, outcome = step(self.game, before, chosen, self.params, self.draws)
        for event in self.game.events:
            self.count(event, outcome.events[event.name])
        self.check()
        return before, outcome

    def count(self, event: ir.Event, counts) -> None:
        for part in counts if event.per_agent else [counts]:
            for word, amount in zip(event.by.keys if event.by else (None,), part if event.by else [part], strict=True):
                self.totals[event.name, word] = self.totals.get((event.name, word), 0) + amount

    def check(self) -> None:
        walls = {k.glyph for k in self.game.kinds if any(b.what == "agents" and b.condition is None for b in k.blocks)}
        assert not {self.game.rows[p.row][p.col] for p in self.world.position if p is not None} & walls
        for number, check in enumerate(self.game.checks):
            values = [read(self.game, self.world, v, self.totals) for v in check.values if check.sort in ("always", "once")]
            if check.sort == "always":
                assert values == [True], check
            if check.sort == "once":
                self.fired |= {number} if values[0] else set()
                assert values[1] or number not in self.fired, check
        now = [read(self.game, self.world, v) for c in self.game.checks if c.sort == "conserved" for v in c.values]
        assert now == self.conserved


@pytest.mark.parametrize(("name", "variants"), FORMS)
def test_every_game_passes_its_checks(name, variants):
    game = load(name, *variants)
    assert all(read(game, Play(game).world, v) for c in game.checks if c.sort == "require" for v in c.values)
    play = Play(game)
    for _ in range(15):
        play.step()
    window = game.window
    shape = (len(planes(game)), window.ahead + 1 + window.behind, window.left + 1 + window.right)
    picture = observe(game, play.world)
    assert picture.shape == (game.agents.number, *shape)
    assert (picture[:, 1, window.ahead, window.left] == 1).all()
    for index, plane in enumerate(planes(game)):
        if plane.encoding == "word":
            assert picture[:, index].max() < len(plane.labels)
    assert all(row[game.agents.actions.index("stay")] for row in action_mask(game, play.world))


def test_the_commons_only_grow_beside_apples():
    play = Play(load("harvest_open"))
    assert [play.game.rows[p.row][p.col] for p in play.world.position[:2]] == ["Q", "Q"]
    assert {play.game.rows[p.row][p.col] for p in play.world.position[2:]} == {"P"}
    eaten = 0
    for _ in range(200):
        before, outcome = play.step()
        assert outcome.reward == outcome.events["eaten"]
        assert outcome.measures["apples_left"] == play.world.cells["soil", "fruit"].count("ripe")
        grown = play.world.cells["soil", "fruit"].count("ripe") - before.cells["soil", "fruit"].count("ripe")
        assert grown + sum(outcome.events["eaten"]) >= 0
        assert (sum(outcome.events["hits"]) > 0) <= ("fire" in {name for name, _, _ in play.world.marks})
        eaten += sum(outcome.events["eaten"])
    assert eaten > 5


def test_coins_pay_and_harm():
    play = Play(load("coins"))
    assert play.world.agents["colour"] == ["red", "green"]
    taken = [0, 0]
    for _ in range(200):
        _, outcome = play.step()
        own, other = outcome.events["own_coins"], outcome.events["other_coins"]
        assert outcome.reward == [own[i] + other[i] - 2 * other[1 - i] for i in (0, 1)]
        taken = [taken[0] + sum(own), taken[1] + sum(other)]
    assert min(taken) > 0


@pytest.mark.thorough
def test_the_river_gets_dirty_one_cell_at_a_time():
    play = Play(load("clean_up"))
    for number in range(200):
        before, outcome = play.step()
        dirty = [world.cells["water", "state"].count("dirty") for world in (before, play.world)]
        polluted = dirty[1] - dirty[0] + sum(outcome.events["cleaned"])
        assert polluted in ((0, 1) if number >= 50 else (0,)) or sum(outcome.events["cleaned"])
        assert outcome.reward == outcome.events["eaten"]
        assert outcome.measures["clean_water"] == play.world.cells["water", "state"].count("clean")
    assert dirty[1] > 20


def test_who_ate_a_mushroom_rests():
    play = Play(load("mushrooms"))
    length = dict(zip(("red", "green", "blue", "orange"), play.params["digestion"], strict=True))
    meals = 0
    for _ in range(60):
        before, outcome = play.step()
        for agent, row in enumerate(outcome.events["eaten"]):
            for word, count in zip(length, row, strict=True):
                assert not count or before.agents["digesting"][agent] <= 1
                assert not count or play.world.agents["digesting"][agent] == length[word]
            meals += sum(row)
    assert meals > 1
    assert play.world.fields["trials"] == (0, 0, 0, 0)


def test_a_meeting_pays_sends_both_home_and_empties_their_bags():
    game = load("pd_arena")
    params = default_params(game)
    world = reset(game, params, Threefry(0, 0))
    row, col = next((r, c) for r, line in enumerate(game.rows) for c, glyph in enumerate(line) if line[c : c + 2] == "..")
    world.position[:2], world.heading[:2] = [Cell(row, col), Cell(row, col + 1)], [1, 0]
    world.position[2:] = [Cell(r, c) for r, line in enumerate(game.rows) for c, g in enumerate(line) if g == "."][-2:]
    world.agents["bag"] = [(1, 3), (2, 0), (0, 0), (0, 0)]
    interact, stay = (game.agents.actions.index(name) for name in ("interact", "stay"))
    draws = Recorded(Threefry(5, 6))
    world, outcome = step(game, world, [interact, stay, stay, stay], params, draws)
    assert outcome.reward == [3 * 0.25 + 5 * 0.75, 3 * 0.25 - 0.75, 0, 0]
    assert outcome.events["met"] == [1, 1, 0, 0]
    assert world.agents["bag"] == [(0, 0)] * 4
    assert [bool(10 <= n <= 100) for n in world.agents["resting"]] == [True, True, False, False]
    assert {game.rows[p.row][p.col] for p in world.position[:2]} == {"P"}
    assert world.marks == [("meet", row, col + 1)]
    assert not any(action_mask(game, world)[0][a] for a in range(interact + 1) if a != stay)
