"""Lowers `move`: looks up the target of each action in tables of the map, then settles collisions of all agents at once."""

from sjdsl.compiler import ir
from sjdsl.compiler.lower.axes import Value, binary
from sjdsl.compiler.lower.domains import blocked_by, enter
from sjdsl.compiler.lower.draws import KEY
from sjdsl.compiler.lower.scope import AgentVar, IterationScope, NotSupported
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import Binary, Index, Literal, Name, Where, call, constant, path
from sjdsl.runtime.actions import STEPS, TURNS

NO_STEP = 4
POSITION, HEADING = path("state.position"), path("state.heading")


def move(s: ir.Move, scope: IterationScope, w: Writer) -> None:
    """Writes a movement phase."""
    game, layout = w.module.game, w.module.layout
    inner = enter(s.domain, scope, w)
    agent = inner.variables[s.domain.var.name]
    assert isinstance(agent, AgentVar)
    actions = game.agents.actions
    turns, steps = (constant([found.get(a, other) for a in actions]) for found, other in ((TURNS, 0), (STEPS, NO_STEP)))
    turn = w.module.constant("turn", turns, "quarter turns to the right by action", "i32")
    step = w.module.constant("step_by", steps, "direction of a step by action; 4: none", "i32")
    table = w.module.constant("next_cell", layout.next_table, "where a step leads, by cell and direction; the cell itself if blocked")
    chosen = Value(Name("actions"), "i32")
    if inner.mask is not None:
        stay = Literal(actions.index("stay"), "STAY")
        chosen = w.keep("chosen", Value(Where(inner.mask.node, Name("actions"), stay), "i32"))
    w.assign("heading", Binary("&", Binary("+", HEADING, Index(turn, (chosen.node,))), Literal(3)))
    stride = w.bind("stride", Index(step, (chosen.node,)))
    ahead = Binary("+", w.current("heading"), stride) if game.agents.relative else stride
    next_cell = Index(table, (Binary("+", Binary("*", POSITION, Literal(4)), Binary("&", ahead, Literal(3))),))
    stays = Binary("==", stride, w.module.number("no_step", NO_STEP))
    target = w.bind("target", Where(stays, POSITION, next_cell))
    _conditional_blocks(agent, target, w)
    w.assign("position", call("resolve", POSITION, target, call("random_bits", KEY, w.stream(s.stream), w.module.agents)))
    if w.module.stores_moved:
        w.assign("moved", Binary("!=", w.current("position"), POSITION))


def _conditional_blocks(agent: AgentVar, target: Name, w: Writer) -> None:
    """Cells that block agents only in some states: the mover stays where it is."""
    for kind in w.module.game.kinds:
        for block in kind.blocks:
            if block.what == "agents" and block.condition is not None and w.module.layout.num_cells((kind.name,)):
                if agent.axis is None:
                    raise NotSupported("`move each` of agents named one by one where cells block under a condition", w.origin)
                blocked = blocked_by(block, kind, Value(target, "i32", (agent.axis,)), w, agent)
                moves = Value(Binary("!=", target, POSITION), "bool", (agent.axis,))
                w.set(target, Where(binary("&", blocked, moves, "bool").node, POSITION, target))
                w.forget()
