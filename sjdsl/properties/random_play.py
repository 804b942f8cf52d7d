"""Random parameters of a game, within their limits, and random actions."""

from random import Random
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.checks.whole_numbers import beyond_int32
from sjdsl.compiler.ir.values import holds
from sjdsl.interpreter.state import Value
from sjdsl.properties.biased_draws import BIASES, Bias
from sjdsl.properties.trajectory import Scenario
from sjdsl.runtime.actions import STEPS, TURNS

MOVES = {*STEPS, *TURNS, "stay"}
SEGMENT = 5  # steps with the same bias of the draws and the same habits
# Probabilities.
FAIR = 0.5  # that the draws of a segment have no bias
HABIT = 0.5  # that an agent takes its habitual action, and that this is no move
CHANGED = 0.3  # that a trajectory has other parameters than the file
OTHERS = 0.7  # that each of these differs from the file's
# Values that are tried of a number without limits, beside the file's.
REALS = (0.0, 1.0, -1.0, 2.5)
COUNTS = (0, 1, 2, 5)


def random_params(game: ir.Game, random: Random) -> tuple[tuple[str, Value], ...]:
    """Returns parameters that differ from the file's and keep every `require`.

    The length of an episode stays.
    """
    fixed = {n.name for n in ir.walk(game.episode) if isinstance(n, ir.ParamRef)}
    different = [p for p in game.params if p.name not in fixed and random.random() < OTHERS]
    changed = {p.name: _random_value(p.value, p.type, random) for p in different}
    of_file = {p.name: p.value for p in game.params}
    requires = [check for check in game.checks if check.kind == "require"]
    for check in requires:
        if not holds(check.values[0], of_file | changed):
            for node in ir.walk(check):
                if isinstance(node, ir.ParamRef):
                    changed.pop(node.name, None)
    values = of_file | changed
    if not all(holds(check.values[0], values) for check in requires):
        return ()
    if changed and beyond_int32(game, values):
        return ()
    return tuple(changed.items())


def _random_value(of_file: Any, type_: ir.Type, random: Random) -> Value:
    """Returns a value of a parameter: the file's, an end of its range, or one inside."""
    if type_.indexed_by:
        inner = type_.changed(indexed_by=type_.indexed_by[1:])
        return tuple(_random_value(entry, inner, random) for entry in of_file)
    if type_.kind == "word":
        return random.choice(type_.words)
    low = type_.low
    high = type_.high
    is_int = type_.kind == "int"
    ends = [end for end in (low, high) if abs(end) < 2**31]
    inside = [value for value in (COUNTS if is_int else REALS) if low <= value <= high]
    if len(ends) == 2:
        inside.append((low + high) // 2 if is_int else random.uniform(low, high))
    value = random.choice([of_file, *ends, *inside])
    return int(value) if is_int else float(value)


def random_scenario(game: ir.Game, steps: int, random: Random) -> Scenario:
    """Returns a scenario of random actions.

    Each agent often repeats an action, more often one that is no move; at times all chances come
    true.
    """
    names = game.agents.actions
    special = [action for action, name in enumerate(names) if name not in MOVES]
    bias: list[Bias] = []
    actions: list[tuple[int, ...]] = []
    while len(actions) < steps:
        bias += ["fair" if random.random() < FAIR else random.choice(BIASES)] * SEGMENT
        habits = []
        for _ in range(game.agents.number):
            is_special = bool(special) and random.random() < HABIT
            habits.append(random.choice(special) if is_special else random.randrange(len(names)))
        for _ in range(SEGMENT):
            chosen = (
                habit if random.random() < HABIT else random.randrange(len(names))
                for habit in habits
            )
            actions.append(tuple(chosen))
    params = random_params(game, random) if random.random() < CHANGED else ()
    return Scenario(
        random.randrange(2**16),
        params=params,
        bias=tuple(bias[:steps]),
        actions=tuple(actions[:steps]),
    )
