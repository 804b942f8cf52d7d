"""The entities section of a rule sheet: agents and their actions, kinds of cell, the map, fields and timers."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import kind_named, starts_of
from sjdsl.doc.actions import action_rows, forbidden
from sjdsl.doc.phrases import condition
from sjdsl.doc.shapes import shapes
from sjdsl.doc.vocabulary import Vocabulary
from sjdsl.doc.wording import Line, bullets, code, codes, counted, entries_text, fenced, joined, number, table


def entities(v: Vocabulary) -> list[str]:
    """Returns the section on entities, state and scales."""
    found = ["### Agents", "", *agents(v), *movers(v), "### Kinds of cell", "", *kinds(v), "### Map", "", *world_map(v.game)]
    if v.game.fields:
        found += ["### State of the world", "", *bullets(map(field_line, v.game.fields)), ""]
    return [*found, "### Shapes", "", *shapes(v)] if v.shapes else found


def agents(v: Vocabulary) -> list[str]:
    """Returns who acts, what with, and what an agent carries along."""
    who = v.game.agents
    place = "Each has a number (its `index`, from 0), a cell of its own (its `row` and `col`) and a `heading`: north, east, south or west."
    found = [f"{counted(who.number, 'agent')}. {place}", "", *table(("number", "action", "what it does"), action_rows(v)), ""]
    if who.fields:
        found += ["Each agent has:", "", *bullets(map(field_line, who.fields)), ""]
    found += [*bullets(lane_ends(v)), ""] if who.blocks else []
    if who.forbids:
        found += ["When a step begins, some actions may be forbidden; an agent that chooses one stays:", "", *bullets(forbidden(v)), ""]
    return found


def lane_ends(v: Vocabulary) -> list[Line]:
    """Returns the shapes whose lanes end at agents."""
    ends = [(f"a lane of {code(b.what)} ends at an agent", b.condition) for b in v.game.agents.blocks]
    return [Line(text if test is None else f"{text} if {condition(test, v)}") for text, test in ends]


def movers(v: Vocabulary) -> list[str]:
    """Returns the sorts of movers with their fields."""
    if not v.game.movers:
        return []
    what = "Movers stand on cells of their own as agents do, and go where the rules say. They choose nothing, observe nothing and earn nothing."
    lines = [
        Line(
            f"{counted(sort.number, 'mover')} {code(sort.name)}, drawn as {code(sort.glyph)}; each has", tuple(map(field_line, sort.fields))
        )
        for sort in v.game.movers
    ]
    return ["### Movers", "", what, "", *bullets(lines), ""]


def kinds(v: Vocabulary) -> list[str]:
    """Returns what cells can be: their glyphs with the state that each stands for, what they stop, their fields."""
    game = v.game
    text = "".join(game.rows)
    rows = [(code(g.glyph), g.kind, str(text.count(g.glyph)), starts(g, game)) for g in game.glyphs]
    found = [*table(("glyph", "kind", "cells on the map", "their state at the start"), rows), ""]
    lines = [Line(f"{code(name)} means {joined(members, 'or')} cells") for name, members in game.groups]
    lines += [line for kind in game.kinds for line in blocking(kind, v)]
    lines += [Line(f"each {kind.name} cell has", tuple(map(field_line, kind.fields))) for kind in game.kinds if kind.fields]
    return [*found, *bullets(lines), *([""] if lines else [])]


def starts(glyph: ir.GlyphMeaning, game: ir.Game) -> str:
    """Returns the fields that a glyph of the map stands for, each with its value at the start."""
    own = starts_of(game, glyph)
    return ", ".join(f"{code(f.name)} = {start_text(own[f.name], f)}" for f in kind_named(game, glyph.kind).fields)


def blocking(kind: ir.Kind, v: Vocabulary) -> list[Line]:
    """Returns what the cells of a kind stop."""
    found = []
    for block in kind.blocks:
        sorts = {sort.name: sort.name for sort in v.game.movers} | {"agents": "agent"}
        what = f"a lane of {code(block.what)} ends at a {kind.name} cell"
        if block.what in sorts:
            what = f"no {sorts[block.what]} can enter a {kind.name} cell"
        when = ""
        if block.condition is not None:
            when = f" if {condition(block.condition, v)}"
            when += (
                " (the agent is the one that would enter)"
                if block.what == "agents" and any(isinstance(n, ir.Member) and n.sort.what == "agent" for n in ir.walk(block.condition))
                else ""
            )
        found.append(Line(what + when))
    return found


def world_map(game: ir.Game) -> list[str]:
    """Returns the map with its size."""
    size = f"{counted(len(game.rows), 'row')} of {counted(len(game.rows[0]), 'cell')}; the first row is north, row 0; the first column is column 0."
    edges = ["", "Its edges are joined: what leaves it on one side comes in at the opposite side."] if game.wraps else []
    return [size, *edges, "", *fenced(game.rows), ""]


def field_line(field: ir.VarField) -> Line:
    """Returns a field with its values and its start."""
    if field.timer:
        return Line(
            f"a timer {code(field.name)}: a number of steps, at first {start_text(field.start, field)}, which falls by 1 at every `tick`"
        )
    entries = f", one {entries_text(field.type.by[0])}" if field.type.by else ""
    rest = "; what would leave this range by adding is cut off" if field.capped else ""
    return Line(f"{code(field.name)}{entries}: {_values(field.type)}, at first {start_text(field.start, field)}{rest}")


def _values(type_: ir.Type) -> str:
    if type_.kind == "word":
        return codes(type_.words, "or")
    if type_.kind == "int":
        unit = "" if type_.unit in ("count", "number") else f" ({type_.unit})"
        return f"a whole number from {number(type_.low)} to {number(type_.high)}{unit}"
    cell = f"a cell ({', '.join(type_.kinds)}) or nowhere"
    return {"agent": "an agent or nobody", "cell": cell, "agents": "a set of agents"}.get(type_.kind, "a real number (a reward)")


def start_text(start: int | float | str | None, field: ir.VarField) -> str:
    """Returns the starting value of a field."""
    if start is None:
        return {"agents": "empty", "cell": "nowhere"}.get(field.type.kind, "nobody")
    return code(start) if isinstance(start, str) else number(start)
