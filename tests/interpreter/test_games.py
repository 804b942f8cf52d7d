"""The games of the repository, played at random: their own checks hold in every state."""

import random
from pathlib import Path

import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.syntax.read import read_source
from sjdsl.interpreter.observe import observe
from sjdsl.interpreter.planes import planes
from sjdsl.interpreter.state import Outcome, World, default_params
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
