"""The contents of the screen at one moment of an episode, as plain values."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sjdsl.compiler import ir
from sjdsl.interpreter.state import World
from sjdsl.interpreter.step import action_mask


@dataclass(frozen=True)
class Display:
    """One moment.

    held: who can only stay. actions: of the step that led here, none at the start; rewards: of that step; events: its counts that are
    not zero, summed over agents; returns: of the episode so far; done: the episode is over.
    """

    world: World
    held: frozenset[int]
    actions: tuple[int, ...]
    rewards: tuple[float, ...]
    returns: tuple[float, ...]
    events: Mapping[str, int]
    done: bool


def make_display(
    game: ir.Game,
    world: World,
    returns: Sequence[float],
    actions: Sequence[int] = (),
    rewards: Sequence[float] = (),
    events: Mapping[str, Any] | None = None,
    done: bool = False,
) -> Display:
    """Returns the moment of a state; without a step before it nothing was done and nothing paid."""
    masks = action_mask(game, world) if game.agents.forbids else []
    return Display(
        world=world,
        held=frozenset(agent for agent, mask in enumerate(masks) if sum(mask) == 1),
        actions=tuple(actions),
        rewards=tuple(rewards) or (0.0,) * game.agents.number,
        returns=tuple(map(float, returns)),
        events={name: count for name, count in (events or {}).items() if count},
        done=done,
    )
