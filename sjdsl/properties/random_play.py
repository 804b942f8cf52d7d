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
FAIR = 0.5  # how often the draws of a segment have no bias
HABIT = 0.5  # how often an agent takes its habitual action, and how often that is no move
CHANGED = 0.3  # how often a trajectory has other parameters than the file
OTHERS = 0.7  # how often each of these is not the file's
WORTHS = (0.0, 1.0, -1.0, 2.5)  # of a real number without limits, beside the file's
COUNTS = (0, 1, 2, 5)  # of a whole number without limits


def random_params(game: ir.Game, random: Random) -> tuple[tuple[str, Value], ...]:
    """Returns parameters that differ from the file's and keep every `require`; the length of an episode stays."""
    fixed = {n.name for n in ir.walk(game.episode) if isinstance(n, ir.ParamRef)}
    different = [p for p in game.params if p.name not in fixed and random.random() < OTHERS]
    changed = tuple((p.name, _value(p.value, p.type, random)) for p in different)
    own = {p.name: p.value for p in game.params}
    requires = [c for c in game.checks if c.sort == "require"]
    for check in requires:
        if not holds(check.values[0], own | dict(changed)):
            named = {n.name for n in ir.walk(check) if isinstance(n, ir.ParamRef)}
            changed = tuple((name, value) for name, value in changed if name not in named)
    values = own | dict(changed)
    fitting = all(holds(c.values[0], values) for c in requires) and not (
        changed and beyond_int32(game, values)
    )
    return changed if fitting else ()


def _value(own: Any, type_: ir.Type, random: Random) -> Value:
    if type_.by:
        inner = type_.model_copy(update={"by": type_.by[1:]})
        return tuple(_value(entry, inner, random) for entry in own)
    if type_.kind == "word":
        return random.choice(type_.words)
    ends = [x for x in (type_.low, type_.high) if abs(x) < 2**31]
    inside = [
        x for x in (COUNTS if type_.kind == "int" else WORTHS) if type_.low <= x <= type_.high
    ]
    if len(ends) == 2:
        inside.append(
            (type_.low + type_.high) // 2
            if type_.kind == "int"
            else random.uniform(type_.low, type_.high)
        )
    value = random.choice([own, *ends, *inside])
    return int(value) if type_.kind == "int" else float(value)


def random_scenario(game: ir.Game, steps: int, random: Random) -> Scenario:
    """Returns a scenario of random actions: each agent often repeats one of them, more often one that is no move; sometimes all chances come true."""
    names, agents = game.agents.actions, range(game.agents.number)
    special = [action for action, name in enumerate(names) if name not in MOVES]
    bias, actions = list[Bias](), list[tuple[int, ...]]()
    while len(actions) < steps:
        bias += ["fair" if random.random() < FAIR else random.choice(BIASES)] * SEGMENT
        habits = [
            random.choice(special)
            if special and random.random() < HABIT
            else random.randrange(len(names))
            for _ in agents
        ]
        actions += [
            tuple(h if random.random() < HABIT else random.randrange(len(names)) for h in habits)
            for _ in range(SEGMENT)
        ]
    params = random_params(game, random) if random.random() < CHANGED else ()
    return Scenario(
        random.randrange(2**16),
        params=params,
        bias=tuple(bias[:steps]),
        actions=tuple(actions[:steps]),
    )
