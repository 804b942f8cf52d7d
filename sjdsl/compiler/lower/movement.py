"""Lowers `move`: looks up the target of each action in tables of the map, then settles collisions of all agents at once."""

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.lower.axes import Value, wrapped
from sjdsl.compiler.lower.domains import blocked_by, enter
from sjdsl.compiler.lower.scope import AgentVar, Frame, NotSupported, Writer

STEPS = {"forward": 0, "step_right": 1, "backward": 2, "step_left": 3}
TURNS = {"turn_left": 3, "turn_right": 1}
NO_STEP = 4


def move(s: ir.Move, frame: Frame, w: Writer) -> None:
    """Writes the lines of a movement phase."""
    game, layout = w.module.game, w.module.layout
    inner = enter(s.domain, frame, w)
    agent = inner.variables[s.domain.var.name]
    assert isinstance(agent, AgentVar)
    actions = game.agents.actions
    turn = w.module.constant("turn", np.array([TURNS.get(a, 0) for a in actions], np.int32), "quarter turns to the right by action")
    step = w.module.constant(
        "step_by",
        np.array([STEPS.get(a, NO_STEP) for a in actions], np.int32),
        "direction of a step by action; 4: none",
    )
    table = w.module.constant("next_cell", layout.next_table, "where a step leads, by cell and direction; the cell itself if blocked")
    chosen = "actions" if inner.mask is None else f"jnp.where({inner.mask.text}, actions, {actions.index('stay')})"
    chosen = w.keep("chosen", Value(chosen, "i32")).text
    w.line(f"heading = (state.heading + {turn}[{chosen}]) & 3")
    w.names.taken.add("heading")
    w.changed["heading"] = "heading"
    w.line(f"stride = {step}[{chosen}]")
    direction = "(heading + stride) & 3" if game.agents.relative else "stride & 3"
    w.line(f"target = jnp.where(stride == {NO_STEP}, state.position, {table}[state.position * 4 + ({direction})])")
    w.names.taken |= {"stride", "target"}
    _conditional_blocks(agent, w)
    n = w.module.num_agents
    w.assign("position", f"resolve(state.position, target, words(key, 0x{s.stream:08x}, {n}))")
    if stores_moved(game):
        w.assign("moved", f"{w.current('position')} != state.position")


def _conditional_blocks(agent: AgentVar, w: Writer) -> None:
    """Cells that block agents only in some states: the mover stays where it is."""
    for kind in w.module.game.kinds:
        for block in kind.blocks:
            if block.what == "agents" and block.condition is not None and w.module.layout.num_cells((kind.name,)):
                if agent.axis is None:
                    raise NotSupported("`move each` of agents named one by one where cells block under a condition", w.origin)
                blocked = blocked_by(block, kind, Value("target", "i32", (agent.axis,)), w, agent)
                w.line(f"target = jnp.where({wrapped(blocked)} & (target != state.position), state.position, target)")
                w.known.clear()


def stores_moved(game: ir.Game) -> bool:
    """Returns whether any rule reads `moved`."""
    return any(isinstance(n, ir.Attribute) and n.name == "moved" for n in ir.walk(game))
