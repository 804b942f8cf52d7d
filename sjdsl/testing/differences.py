"""Compares the compiled game with the reference interpreter after the same step: every field and every result."""

from typing import Any

import numpy as np

from sjdsl.compiler.ir.names import attribute_name, attribute_of
from sjdsl.compiler.ir.queries import all_fields, counts_of, marking_phases
from sjdsl.interpreter import observe as interpreter_view
from sjdsl.interpreter.bodies import herds
from sjdsl.interpreter.state import Outcome, World
from sjdsl.interpreter.step import action_mask
from sjdsl.interpreter.stored import stored_values
from sjdsl.runtime.env import Environment

CLOSE = 1e-6  # relative and absolute
MANY = 12  # of longer lists only the entries that differ are shown


def state_differences(
    env: Environment, state: Any, world: World, seen: Any, allowed: Any = None, close: float = CLOSE
) -> list[str]:
    """Returns where two states differ: places, fields, timers, marks, who is away, what is seen and, if given, allowed."""
    game, (_, cols), pad = env.game, env.module.FRAME, env.module.PAD
    pairs: list[tuple[str, Any, Any]] = [
        ("headings", np.asarray(state.heading).tolist(), world.heading),
        ("step", int(state.step), world.step),
    ]
    if allowed is not None:
        pairs.append(("allowed actions", np.asarray(allowed).tolist(), action_mask(game, world)))
    for sort, herd in herds(world).items():
        of, at = (
            f" of {sort.name}" if sort.what == "mover" else "",
            np.asarray(getattr(state, attribute_of("position", sort))).tolist(),
        )
        places = [(p // cols - pad, p % cols - pad) if p else None for p in at]
        pairs.insert(
            0, (f"places{of}", places, [None if p is None else tuple(p) for p in herd.position])
        )
        for name, theirs in (
            ("moved", herd.moved),
            ("away", [a.ticks if a else 0 for a in herd.away]),
        ):
            if hasattr(state, attribute_of(name, sort)):
                pairs.append(
                    (
                        f"{name}{of}",
                        np.asarray(getattr(state, attribute_of(name, sort))).tolist(),
                        theirs,
                    )
                )
    for phase in marking_phases(game):
        cells = np.asarray(getattr(state, f"mark_{phase.name}", ())).tolist()
        marked = sorted({(cell // cols - pad, cell % cols - pad) for cell in cells if cell})
        pairs.append(
            (
                f"marks of {phase.label}",
                marked,
                sorted({(r, c) for name, r, c in world.marks if name == phase.name}),
            )
        )
    found = [shown(name, mine, theirs) for name, mine, theirs in pairs if mine != theirs]
    for declared in all_fields(game):
        stored, wanted = (
            np.asarray(getattr(state, attribute_name(declared))),
            np.asarray(stored_values(declared, world)),
        )
        wanted = (
            wanted if wanted.size else wanted.reshape(stored.shape)
        )  # of no cells, a list does not tell the length of rows
        same = (
            np.allclose(stored, wanted, rtol=close, atol=close)
            if declared.type.kind == "real"
            else stored.tolist() == wanted.tolist()
        )
        if not same:
            found.append(shown(attribute_name(declared), stored.tolist(), wanted.tolist()))
    seen, expected = np.asarray(seen), interpreter_view.observe(game, world)
    if seen.shape != expected.shape:
        found.append(f"observations: {seen.shape} / {expected.shape}")
    elif not np.array_equal(seen, expected):
        where = [tuple(index) for index in np.argwhere(seen != expected)[:5].tolist()]
        found.append(
            "observations at "
            + ", ".join(f"{index}: {seen[index]} / {expected[index]}" for index in where)
        )
    return found


def shown(name: str, mine: Any, theirs: Any) -> str:
    """Returns both values; of long lists the first entries that differ."""
    if isinstance(mine, list) and isinstance(theirs, list) and len(mine) == len(theirs) > MANY:
        differing = [
            f"{i}: {a} / {b}" for i, (a, b) in enumerate(zip(mine, theirs, strict=True)) if a != b
        ]
        return f"{name} at {', '.join(differing[:5])}"
    return f"{name}: {mine} / {theirs}"


def outcome_differences(
    env: Environment, reward: Any, info: dict[str, Any], outcome: Outcome, close: float = CLOSE
) -> list[str]:
    """Returns where rewards, events, metrics and endings of two steps differ."""
    pairs: list[tuple[str, Any, Any]] = [("reward", reward, outcome.reward)]
    for event in env.game.events:
        counts = np.asarray(outcome.events[event.name])
        names = counts_of(event)
        pairs += [
            (f"event {n}", info["events"][n], counts if word is None else counts[..., i])
            for i, (word, n) in enumerate(names)
        ]
    pairs += [
        (f"metric {name}", info["metrics"][name], value) for name, value in outcome.measures.items()
    ]
    pairs.append(("terminated", info["terminated"], outcome.terminated))
    pairs.append(("truncated", info["truncated"], outcome.truncated and not outcome.terminated))
    found = [
        (name, np.asarray(mine, np.float64), np.asarray(theirs, np.float64))
        for name, mine, theirs in pairs
    ]
    return [
        f"{n}: {mine.tolist()} / {theirs.tolist()}"
        for n, mine, theirs in found
        if not np.allclose(mine, theirs, rtol=close, atol=close)
    ]
