"""The actions that an agent may take now, and what steps lead to as far as its window shows."""

from collections.abc import Sequence

from sjdsl.compiler import ir
from sjdsl.compiler.ir.entity_types import AGENTS
from sjdsl.compiler.ir.queries import (
    beginning_phases,
    blocks_always,
    body_type,
    contains,
    kind_named,
)
from sjdsl.compiler.lower.cell_appearance import OTHER_FACING, OUTSIDE
from sjdsl.doc.actions import has_built_in_moves
from sjdsl.runtime.actions import DIRECTIONS, HEADINGS, STEPS, TURNS
from sjdsl.told.codes import UNSEEN
from sjdsl.told.window import Place, Planes, Window


def action_lines(window: Window, seen: Planes, allowed: Sequence[bool]) -> list[str]:
    """Returns lines on the actions that are allowed, those that are steps each with its end.

    Args:
      allowed: for each action, a row of `env.allowed_actions`.
    """
    names = window.game.agents.actions
    legal = [name for name, may in zip(names, allowed, strict=True) if may]
    steps = []
    plain = []
    for name in legal:
        end = end_of_step(name, window, seen)
        if end is None:
            plain.append(name)
        else:
            steps.append(f"{name} -> {end}")
    lines = [*steps, ", ".join(plain)] if plain else steps
    forbidden = [name for name in names if name not in legal]
    return [*lines, f"Not now: {', '.join(forbidden)}"] if forbidden else lines


def can_turn(game: ir.Game) -> bool:
    """Returns whether agents turn as they choose."""
    return has_built_in_moves(game) and bool(set(TURNS) & set(game.agents.actions))


def looks_north(game: ir.Game) -> bool:
    """Returns whether all agents look north all the time, as they do before they are sent."""
    if can_turn(game):
        return False
    nodes = [node for phase in (*beginning_phases(game), *game.schedule) for node in ir.walk(phase)]
    if any(isinstance(node, ir.Face) for node in nodes):
        return False
    return all(
        node.facing in ("north", "same")
        for node in nodes
        if isinstance(node, ir.Send | ir.Shift) and body_type(node.who) == AGENTS
    )


def end_of_step(name: str, window: Window, seen: Planes) -> str | None:
    """Returns what is on the cell that a step leads to; None if that isn't known or it is none."""
    me = window.own_place(seen)
    if name not in STEPS or me is None or not has_built_in_moves(window.game):
        return None
    quarters = STEPS[name]
    if not window.game.agents.relative:
        heading = window.uniform_value(seen, "agent.heading")
        if heading is None and looks_north(window.game):
            heading = "north"
        if heading not in HEADINGS:
            return None
        quarters = (quarters - HEADINGS.index(heading)) % 4
    down, right = DIRECTIONS[quarters]
    place = (me[0] + down, me[1] + right)
    content = window.content(seen, place)
    if content is None:
        return None
    text = content if window.codes[content] != UNSEEN else ""
    who = _who(window, seen, place)
    if _stops_always(content, window.game):
        return f"blocked, {text}"
    return ", ".join(filter(None, (text, who)))


def _who(window: Window, seen: Planes, place: Place) -> str:
    if seen[1][place] >= OTHER_FACING:
        return "an agent is there"
    mover = window.mover(seen, place)
    return "" if mover is None else f"a {mover} is there"


def _stops_always(content: str, game: ir.Game) -> bool:
    """Returns whether nobody can enter a cell that looks so, whatever its state."""
    if content == OUTSIDE:
        return not game.wraps and not contains(game.window, ir.View)
    name = content.split()[0]
    kinds = {kind.name for kind in game.kinds}
    return name in kinds and blocks_always(kind_named(game, name))
