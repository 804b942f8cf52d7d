"""An episode on the reference interpreter with the draws of the compiled game; it needs no JAX and starts at once."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import counts_of
from sjdsl.interpreter.state import Value, copied
from sjdsl.interpreter.step import reset, step
from sjdsl.interpreter.threefry import Threefry
from sjdsl.screen.display import Display, make_display
from sjdsl.trace.jax_random import fold_in, key_of


class Interpreted:
    """The episode of a seed: state by state what `sjdsl.replay.EpisodePlayer` plays for the same seed and actions.

    Attributes:
      display: of the moment; seen: nothing, for policies of the compiled game are not asked here.
    """

    def __init__(self, game: ir.Game, params: Mapping[str, Value], seed: int) -> None:
        """Begins the episode. `params`: every parameter of the game, reals as float32."""
        self._game, self._params, self._key = game, params, key_of(seed)
        world = reset(game, params, Threefry(*fold_in(self._key, 0)))
        self.display = make_display(game, copied(world), [0.0] * game.agents.number)
        self.seen = (None, None)

    def step(self, actions: Sequence[int]) -> Display:
        """Takes one step. `actions`: a number of the game for each agent."""
        draws = Threefry(*fold_in(self._key, self.display.world.step + 1))
        world, outcome = step(self._game, self.display.world, actions, self._params, draws)
        rewards = [float(reward) for reward in outcome.reward]
        returns = [before + reward for before, reward in zip(self.display.returns, rewards, strict=True)]
        events = dict(_totals(self._game, outcome.events))
        self.display = make_display(self._game, world, returns, actions, rewards, events, outcome.terminated or outcome.truncated)
        return self.display


def _totals(game: ir.Game, counted: Mapping[str, Any]) -> Iterator[tuple[str, int]]:
    """Yields each count of a step summed over agents; an event with words gives `name[word]` for each."""
    for event in game.events:
        rows = counted[event.name] if event.per_agent else [counted[event.name]]
        for number, (word, name) in enumerate(counts_of(event)):
            yield name, sum(row if word is None else row[number] for row in rows)
