"""Describes a game as plain values for JSON: agents, actions, observations, parameters, variants."""

import math
from pathlib import Path
from typing import Any

from sjdsl.cli.game_file import open_game
from sjdsl.compiler import ast, build_composition, ir
from sjdsl.compiler.compose import Composition, compose
from sjdsl.compiler.ir.printer import expression
from sjdsl.library.agent_range import agent_range
from sjdsl.library.games_folder import origin


def outline(name: str) -> dict[str, Any]:
    """Returns what fits on a line about a game: title, number of agents, map, actions and variants. Raises CompileError."""
    composed = compose(open_game(name))
    return _outline(build_composition(composed).game, composed)


def _outline(game: ir.Game, composed: Composition) -> dict[str, Any]:
    return {
        "game": game.name,
        "title": game.title,
        "variants": [{"name": v.name.text, "title": v.title.text if v.title else ""} for v in composed.variants.values()],
        "agents": game.agents.number,
        "map": {"rows": len(game.rows), "columns": len(game.rows[0])},
        "actions": list(game.agents.actions),
    }


def describe(name: str) -> dict[str, Any]:
    """Returns everything about a game, and the limits of its numbers; the number of agents the map holds is found by trying. Raises CompileError."""
    source = open_game(name)
    composed = compose(source)
    game = build_composition(composed).game
    agents = agent_range(composed, game.agents.number)
    return {
        **_outline(game, composed),
        "file": source.name,
        "from": origin(Path(source.name)),
        "cites": list(game.cites),
        "about": dict(game.about),
        "episode": expression(game.episode),
        "window": game.window.model_dump(exclude={"origin", "views"}),
        **({"windows": list(map(_view, game.window.views))} if game.window.views else {}),
        "kinds": [{"name": k.name, "fields": {f.name: _values(f.type) for f in k.fields}} for k in game.kinds],
        "params": [_number(p.name, p.type, p.value, (p.type.low, p.type.high)) for p in game.params],
        "sizes": [_number(s.name, s.type, s.value, _limits(agents, composed, s.name)) for s in game.sizes],
        "metrics": [{"name": e.name, "sort": "event", "by": list(e.by.keys) if e.by else [], "per_agent": e.per_agent} for e in game.events]
        + [{"name": m.name, "sort": "mean" if m.mean else "final"} for m in game.measures],
        "policies": [{"name": p.name, "title": p.title} for p in game.policies],
        "scenarios": [
            {"name": s.name, "title": s.title, "slots": [{"number": slots.number, "policy": slots.policy or None} for slots in s.slots]}
            for s in game.scenarios
        ],
    }


def _view(view: ir.View) -> dict[str, Any]:
    """Returns how far some agents see, and when; None: all others."""
    return view.model_dump(exclude={"origin", "condition"}) | {"when": None if view.condition is None else expression(view.condition)}


def _number(name: str, type_: ir.Type, value: Any, limits: tuple[Any, Any]) -> dict[str, Any]:
    low, high = (None if isinstance(x, float) and math.isinf(x) else x for x in limits)
    unit = "word" if type_.kind == "word" else type_.unit
    return {"name": name, "unit": unit, "default": _by_word(value, type_.by), "low": low, "high": high}


def _by_word(value: Any, by: tuple[ir.Level, ...]) -> Any:
    """Returns the nested values of a table as a mapping by word."""
    return {key: _by_word(v, by[1:]) for key, v in zip(by[0].keys, value, strict=True)} if by else value


def _limits(agents: tuple[str, int, int] | None, game: Composition, name: str) -> tuple[str | float | None, str | float | None]:
    """Returns the limits of a size in its file (the compiler narrows them to its value); for agents, how many the map holds."""
    if agents is not None and agents[0] == name:
        return agents[1:]

    def written(bound: ast.Expr | None) -> str | int | None:
        text = "" if bound is None else game.sources[bound.span.file].text[bound.span.start : bound.span.end]
        return int(text) if text.isdecimal() else text or None

    declared = game.constants[name]
    return written(declared.low), written(declared.high)


def _values(type_: ir.Type) -> str | list[str]:
    """Returns the words of a field, or the kind of its values."""
    match type_.kind:
        case "word":
            return list(type_.words)
        case "int" | "real":
            return f"{type_.low:g} .. {type_.high:g}"
        case "agent":
            return "agent"
        case "cell":
            return f"cell of {' or '.join(type_.kinds)}"
        case _:
            return "set of agent"
