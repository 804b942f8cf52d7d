"""Whether what agents see, and which actions they are allowed, tells the fields of the task that
the game doesn't show."""

import random
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from sjdsl.compiler import ir
from sjdsl.interpreter.observe import observe
from sjdsl.interpreter.state import World, copied, default_params
from sjdsl.interpreter.step import action_mask, reset, step, task_of_key
from sjdsl.interpreter.threefry import Threefry

STATES = 40
STEPS = 5  # of random play before each state, at most
WORLD = ir.EntityType("world")


@dataclass(frozen=True)
class HiddenTask:
    """What is known of the fields of a task that aren't shown.

    fields: those. how: `proved` if nothing that agents see reads them; else `tried` if no random
    state looked different with another task, `told` if one did. lines: where they are read.
    """

    name: str
    fields: tuple[str, ...]
    how: Literal["proved", "tried", "told"]
    lines: tuple[int, ...] = ()

    def __str__(self) -> str:
        """Returns one line of a report."""
        if not self.fields:
            return f"task {self.name}: every field is shown"
        names = ", ".join(self.fields)
        what = "two states that are equal but for"
        same = f"{what} {names} give equal observations and allowed actions"
        lines = ", ".join(map(str, self.lines))
        match self.how:
            case "proved":
                return f"task {self.name}: {same}  [proved: nothing that is seen reads them]"
            case "tried":
                return f"task {self.name}: {same}  [in {STATES} random states; line {lines} reads them]"
            case "told":
                return f"task {self.name}: agents see something of {names}, by line {lines}"


def hidden_task(game: ir.Game) -> HiddenTask | None:
    """Returns what agents are told of a task beside the fields that are shown; None without one."""
    if game.task is None:
        return None
    shown = {
        o.field for o in game.observables if o.what == "world" and not o.labels and not o.value
    }
    hidden = tuple(name for name in game.task.fields if name not in shown)
    lines = tuple(sorted(set(_lines(game, hidden))))
    if not lines:
        return HiddenTask(game.task.name, hidden, "proved")
    how: Literal["tried", "told"] = "told" if _differs(game, hidden) else "tried"
    return HiddenTask(game.task.name, hidden, how, lines)


def _lines(game: ir.Game, hidden: tuple[str, ...]) -> Iterator[int]:
    """Yields the lines of what agents see, or may do, that reads hidden fields of the task."""
    seen: tuple[ir.Node, ...] = (
        *game.observables,
        *game.hidden,
        *game.window.views,
        *game.agents.forbids,
    )
    for part in seen:
        for node in ir.walk(part):
            if not isinstance(node, ir.FieldRead) or node.held_by != WORLD:
                continue
            if node.name in hidden:
                origin = node.origin or part.origin
                yield 0 if origin is None else origin.line
        if isinstance(part, ir.Observable) and part.what == "world" and part.field in hidden:
            yield 0 if part.origin is None else part.origin.line


def _differs(game: ir.Game, hidden: tuple[str, ...]) -> bool:
    """Returns whether some random state looks different with the hidden fields of another task."""
    chance = random.Random(0)
    for number in range(STATES):
        world = _random_state(game, number, chance)
        other = copied(world)
        task = task_of_key(game, (1, number))
        for name in hidden:
            other.fields[name] = task[name]
        if (observe(game, world) != observe(game, other)).any():
            return True
        if action_mask(game, world) != action_mask(game, other):
            return True
    return False


def _random_state(game: ir.Game, number: int, chance: random.Random) -> World:
    """Returns the state after some random steps of an episode."""
    params = default_params(game)
    world = reset(game, params, Threefry(0, number))
    actions = range(len(game.agents.actions))
    for _ in range(chance.randint(0, STEPS)):
        chosen = [chance.choice(actions) for _ in range(game.agents.number)]
        draws = Threefry(chance.getrandbits(32), chance.getrandbits(32))
        world, outcome = step(game, world, chosen, params, draws)
        if outcome.terminated or outcome.truncated:
            break
    return world
