"""Lowers reads of the state: fields, positions and attributes of the variables in scope."""

from dataclasses import replace

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_name
from sjdsl.compiler.lower.axes import Axis, Value, as_dtype, binary, literal, wrapped
from sjdsl.compiler.lower.scope import AgentVar, CellVar, NotSupported, Writer


def field(e: ir.FieldRead, owner: AgentVar | CellVar | None, w: Writer) -> Value:
    """Returns a field of the snapshot; words as uint8 numbers, integers as int32."""
    levels = len(e.type.by)
    seen = getattr(owner, "values", None)
    if seen is not None:  # a cell of a window: its painted value; agents are painted one up, 0 is nobody
        value = seen[e.name]
        if e.type.kind == "agent":
            return Value(f"{wrapped(value)}.astype(jnp.int32) - 1", "i32", value.axes)
        return as_dtype(value, "i32") if e.type.kind == "int" else value
    if owner is None:
        declared = w.module.field(e)
        return _widened(Value(f"state.{attribute_name(declared)}", storage(declared, w), (), levels), declared)
    if isinstance(owner, CellVar) and len(owner.kinds) > 1:
        return _group_field(e, owner, w)
    declared = w.module.field(e)
    stored = Value(f"state.{attribute_name(declared)}", storage(declared, w), (), levels)
    return _widened(_at(stored, owner), declared)


def _at(stored: Value, owner: AgentVar | CellVar) -> Value:
    if owner.axis is not None:
        return replace(stored, axes=(owner.axis,))
    index = owner.index if isinstance(owner, AgentVar) else owner.site
    return replace(stored, text=f"{stored.text}[{index.text}]", axes=index.axes)


def _group_field(e: ir.FieldRead, owner: CellVar, w: Writer) -> Value:
    """A group's field: the kinds' vectors one after another, put into reading order."""
    parts = [w.module.field(e, kind) for kind in owner.kinds]
    layout = w.module.layout
    order = np.concatenate([layout.site_of(owner.kinds)[layout.cells((k,))] for k in owner.kinds])
    name = w.module.constant("order_" + "_".join(owner.kinds), np.argsort(order).astype(np.int32), "cells of a group in reading order")
    vector = ", ".join(f"state.{attribute_name(p)}" for p in parts)
    whole = w.keep(f"{'_'.join(owner.kinds)}_{e.name}", Value(f"jnp.concatenate([{vector}])[{name}]", storage(parts[0], w)))
    return _widened(_at(replace(whole, levels=len(e.type.by)), owner), parts[0])


def _widened(value: Value, declared: ir.VarField) -> Value:
    if declared.type.kind == "int":
        return as_dtype(value, "i32")
    return value


def storage(declared: ir.VarField, w: Writer) -> str:
    """Returns the dtype a field is kept in: words and small ranges in a byte, sets of agents as bits."""
    type_ = declared.type
    match type_.kind:
        case "word":
            return "u8"
        case "int":
            high = timer_bound(declared, w.module.game) if declared.timer else type_.high
            return "u8" if type_.low >= 0 and high <= 255 else "i32"
        case "real":
            return "f32"
        case "agent":
            return "i32"
        case "agents":
            return w.module.set_dtype
        case _:
            raise AssertionError(type_)


def timer_bound(declared: ir.VarField, game: ir.Game) -> float:
    """Returns the largest value any sentence sets a timer to."""
    bound = 0.0
    for node in ir.walk(game):
        if isinstance(node, ir.Set) and isinstance(node.target, ir.FieldRead) and node.target.name == declared.name:
            if node.target.place == declared.place and (declared.place != "cell" or declared.kind in node.target.kinds):
                bound = max(bound, node.value.type.high)
    return bound


def position(owner: AgentVar, w: Writer) -> Value:
    """Returns the cells of agents."""
    if owner.axis is not None:
        return Value("state.position", "i32", (owner.axis,))
    return w.keep("position", Value(f"state.position[{owner.index.text}]", "i32", owner.index.axes))


def heading(owner: AgentVar) -> Value:
    """Returns the headings of agents, int32."""
    if owner.axis is not None:
        return Value("state.heading", "i32", (owner.axis,))
    return Value(f"state.heading[{owner.index.text}]", "i32", owner.index.axes)


def present(owner: AgentVar, w: Writer) -> Value | None:
    """Returns who is on the map; None if nobody can be away."""
    if not w.module.can_be_away or w.starting:
        return None
    here = binary("!=", position(owner, w), literal(0, "i32"), "bool")
    return w.keep("present", here)


def cell(owner: CellVar, w: Writer) -> Value:
    """Returns the cells of a cell variable in the frame."""
    check_placed(owner)
    name = w.module.constant(
        "cells_" + "_".join(owner.kinds), w.module.layout.cells_table(owner.kinds), f"cells of {', '.join(owner.kinds)}"
    )
    if owner.axis is not None:
        return Value(name, "i32", (owner.axis,))
    return Value(f"{name}[{owner.site.text}]", "i32", owner.site.axes)


def check_placed(owner: CellVar) -> None:
    """A cell of a window is known by its looks alone: where it is, and what is around it, cannot be asked."""
    if getattr(owner, "values", None) is not None:
        what = "a label or `hide` that depends on where a cell is, on who is on it, or on what is around it"
        raise NotSupported(what, None, "keep what it asks for in a field of the kind: labels read the cell's own fields and the observer's")


def site_under(owner: AgentVar, kinds: tuple[str, ...], w: Writer) -> tuple[Value, Value]:
    """Returns the number of the cell of `kinds` under each agent, and whether there is one."""
    table = w.module.layout.site_table(kinds)
    name = w.module.constant("site_of_" + "_".join(kinds), table, f"number of each cell among {', '.join(kinds)}; past the end: none")
    size = w.module.layout.num_cells(kinds)
    at = position(owner, w)
    site = w.keep("_".join(kinds) + "_under", Value(f"{name}[{wrapped(at)}]", "i32", at.axes))
    return site, binary("<", site, literal(size, "i32"), "bool")


def index_of(owner: AgentVar) -> Value:
    """Returns the ids of agents, int32."""
    return owner.index


def member_number(owner: AgentVar | CellVar) -> Value:
    """Returns the number of a member among all agents, or all cells of its kinds."""
    return owner.index if isinstance(owner, AgentVar) else owner.site


def member_total(owner: AgentVar | CellVar, w: Writer) -> int:
    """Returns how many members there are."""
    if isinstance(owner, AgentVar):
        return w.module.num_agents
    return w.module.layout.num_cells(owner.kinds)


def occupied(owner: CellVar, w: Writer) -> Value:
    """Returns which cells have an agent on them."""
    agents = AgentVar(Value("", "i32"), Axis("", w.module.num_agents, 0))
    if owner.axis is not None:
        site, _ = site_under(agents, owner.kinds, w)
        size = w.module.layout.num_cells(owner.kinds)
        vector = w.keep("covered", Value(f"occupied({site.text}, {size})", "bool", ()))
        return replace(vector, axes=(owner.axis,))
    at = cell(owner, w)
    if not at.axes:
        return Value(f"jnp.any({wrapped(at)} == state.position)", "bool")
    return Value(f"jnp.any({wrapped(at)}[..., None] == state.position{_lead(at)}, axis=-1)", "bool", at.axes)


def _lead(value: Value) -> str:
    return f"[{', '.join(['None'] * len(value.axes))}, :]" if value.axes else ""
