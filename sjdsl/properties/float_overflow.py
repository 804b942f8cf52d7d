"""Describes a float32 overflow: the step, the statement that computes the real, and the reals of the state before."""

from collections.abc import Iterator

import numpy as np

from sjdsl.compiler import ir
from sjdsl.interpreter.state import Value, World
from sjdsl.properties.instances import GameFamily
from sjdsl.properties.trajectory import Trajectory
from sjdsl.trace.rules import Rules

LARGEST = "3.4e38"  # of float32: (2 - 2^-23) * 2^127


def describe_overflow(family: GameFamily, trajectory: Trajectory) -> list[str]:
    """Returns what the agents do in the last step of a trajectory, the statement, and the largest reals before it."""
    assert trajectory.left is not None
    said = f"{file_and_line(family, trajectory.left.node)}  {Rules(family.composition.sources).text(trajectory.left.node)}"
    if not trajectory.worlds:
        return [f"in phase start: {said}"]
    world, names = trajectory.worlds[-1], trajectory.game.agents.actions
    acting = ", ".join(f"{agent} {names[action]}" for agent, action in enumerate(trajectory.actions[-1]))
    told = [f"step {world.step}: {acting}"] if len(trajectory.actions) > len(trajectory.outcomes) else []
    return [*told, f"  {said}: the result is larger than the largest float32, {LARGEST}, or no number", *_reals(world)]


def file_and_line(family: GameFamily, node: ir.Node) -> str:
    """Returns the file and line of a part of the rules."""
    return Rules(family.composition.sources).place(node)


def _reals(world: World) -> Iterator[str]:
    """Yields the largest value of each field of reals."""
    fields = [(f"agent.{name}", values) for name, values in world.agents.items()]
    fields += [(f"{kind}.{name}", values) for (kind, name), values in world.cells.items()]
    fields += [(name, [value]) for name, value in world.fields.items()]
    for name, values in fields:
        reals = [x for value in values for x in _flat(value)]
        if reals and isinstance(reals[0], np.floating):
            yield f"  {name} before this step: up to {max(reals, key=abs):.6g}"


def _flat(value: Value) -> Iterator[Value]:
    if isinstance(value, tuple):
        for entry in value:
            yield from _flat(entry)
    else:
        yield value
