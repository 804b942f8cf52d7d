"""Compares the compiled game with the reference interpreter after the same step.

Every field and every result.
"""

from typing import Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_name, attribute_of
from sjdsl.compiler.ir.queries import all_fields, counts_of, marking_phases
from sjdsl.interpreter import observe as interpreter_view
from sjdsl.interpreter.bodies import herds
from sjdsl.interpreter.state import Outcome, World
from sjdsl.interpreter.step import action_mask
from sjdsl.interpreter.stored import stored_values
from sjdsl.runtime.env import Environment

CLOSE = 1e-6  # relative and absolute tolerance of reals
LONG = 12  # of longer lists only the entries that differ are shown


def state_differences(
    env: Environment, state: Any, world: World, seen: Any, allowed: Any = None, close: float = CLOSE
) -> list[str]:
    """Returns where the compiled state and the interpreter's world differ.

    Compares places, fields, timers, marks and who is away.

    Args:
      seen: the observations of the compiled game, `[N, rows, cols, planes]`, compared too.
      allowed: its mask of allowed actions, `[N, actions]`, compared unless it is None.
    """
    game = env.game
    places: list[tuple[str, Any, Any]] = []  # a name, and both values
    pairs: list[tuple[str, Any, Any]] = [
        ("headings", np.asarray(state.heading).tolist(), world.heading),
        ("step", int(state.step), world.step),
    ]
    if allowed is not None:
        pairs.append(("allowed actions", np.asarray(allowed).tolist(), action_mask(game, world)))
    for entity_type, herd in herds(world).items():
        suffix = f" of {entity_type.name}" if entity_type.what == "mover" else ""
        cells = np.asarray(getattr(state, attribute_of("position", entity_type))).tolist()
        compiled = [_row_and_col(env, cell) if cell else None for cell in cells]
        interpreted = [None if place is None else tuple(place) for place in herd.position]
        places.insert(0, (f"places{suffix}", compiled, interpreted))
        ticks = [away.ticks if away else 0 for away in herd.away]
        for name, values in (("moved", herd.moved), ("away", ticks)):
            if hasattr(state, attribute_of(name, entity_type)):
                compiled = np.asarray(getattr(state, attribute_of(name, entity_type))).tolist()
                pairs.append((f"{name}{suffix}", compiled, values))
    for phase in marking_phases(game):
        cells = np.asarray(getattr(state, f"mark_{phase.name}", ())).tolist()
        compiled_marks = sorted({_row_and_col(env, cell) for cell in cells if cell})
        marks = sorted({(row, col) for name, row, col in world.marks if name == phase.name})
        pairs.append((f"marks of {phase.label}", compiled_marks, marks))
    differences = [
        difference_text(name, compiled, interpreted)
        for name, compiled, interpreted in [*places, *pairs]
        if compiled != interpreted
    ]
    for declared in all_fields(game):
        stored = np.asarray(getattr(state, attribute_name(declared)))
        expected = np.asarray(stored_values(declared, world))
        if not expected.size:  # an empty list of rows doesn't have the length of the rows
            expected = expected.reshape(stored.shape)
        if declared.type.kind == "real":
            is_same = np.allclose(stored, expected, rtol=close, atol=close)
        else:
            is_same = stored.tolist() == expected.tolist()
        if not is_same:
            differences.append(
                difference_text(attribute_name(declared), stored.tolist(), expected.tolist())
            )
    seen = np.asarray(seen)
    expected = interpreter_view.observe(game, world)
    if seen.shape != expected.shape:
        differences.append(f"observations: {seen.shape} / {expected.shape}")
    elif not np.array_equal(seen, expected):
        entries = map(tuple, np.argwhere(seen != expected)[:5].tolist())
        listed = [f"{entry}: {seen[entry]} / {expected[entry]}" for entry in entries]
        differences.append(f"observations at {', '.join(listed)}")
    return differences


def _row_and_col(env: Environment, cell: int) -> tuple[int, int]:
    """Returns the row and column of a compiled state's cell number; 0 is no cell."""
    _, cols = env.module.FRAME
    row, col = divmod(cell, cols)
    return row - env.module.PAD, col - env.module.PAD


def difference_text(name: str, compiled: Any, interpreted: Any) -> str:
    """Returns both values; of long lists the first entries that differ."""
    are_lists = isinstance(compiled, list) and isinstance(interpreted, list)
    if are_lists and len(compiled) == len(interpreted) > LONG:
        entries = enumerate(zip(compiled, interpreted, strict=True))
        differing = [f"{index}: {a} / {b}" for index, (a, b) in entries if a != b]
        return f"{name} at {', '.join(differing[:5])}"
    return f"{name}: {compiled} / {interpreted}"


def outcome_differences(
    env: Environment, reward: Any, info: dict[str, Any], outcome: Outcome, close: float = CLOSE
) -> list[str]:
    """Returns where rewards, events, metrics and endings of two steps differ."""
    pairs: list[tuple[str, Any, Any]] = [("reward", reward, outcome.reward)]
    for event in env.game.events:
        for name, counts in named_counts(event, outcome).items():
            pairs.append((f"event {name}", info["events"][name], counts))
    for name, value in outcome.measures.items():
        pairs.append((f"metric {name}", info["metrics"][name], value))
    pairs.append(("terminated", info["terminated"], outcome.terminated))
    pairs.append(("truncated", info["truncated"], outcome.truncated and not outcome.terminated))
    if "trial_ended" in info:
        pairs.append(("trial_ended", info["trial_ended"], outcome.trial_ended))
    differences = []
    for name, compiled, interpreted in pairs:
        compiled = np.asarray(compiled, np.float64)
        interpreted = np.asarray(interpreted, np.float64)
        if not np.allclose(compiled, interpreted, rtol=close, atol=close):
            differences.append(f"{name}: {compiled.tolist()} / {interpreted.tolist()}")
    return differences


def named_counts(event: ir.Event, outcome: Outcome) -> dict[str, np.ndarray]:
    """Returns the counts of an event as `info["events"]` has them: one, or one by enum value."""
    counts = np.asarray(outcome.events[event.name])
    return {
        name: counts if enum_value is None else counts[..., index]
        for index, (enum_value, name) in enumerate(counts_of(event))
    }
