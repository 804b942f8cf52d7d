"""Lowers `move`: looks up the target of each action in tables of the map, then settles collisions of all at once."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_of
from sjdsl.compiler.ir.sorts import AGENTS
from sjdsl.compiler.lower import state_reads
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
    table = w.module.constant("next_cell", layout.next_table(), "where a step leads, by cell and direction; the cell itself if blocked")
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
    conditional_blocks(agent, target, w)
    settle(s, AGENTS, target, w)


def nobody_moves(s: ir.Move, w: Writer) -> None:
    """Writes a movement phase of a domain that has no members on this map."""
    sort = s.domain.var.sort
    if w.module.stores_moved(sort):
        attribute = attribute_of("moved", sort)
        w.assign(attribute, call("jnp.zeros_like", path(f"state.{attribute}")))


def settle(s: ir.Move, sort: ir.Sort, target: Name, w: Writer) -> None:
    """Writes where agents, or the movers of a sort, stand after all of them have wanted their targets."""
    position = state_reads.positions(w, sort)
    others = state_reads.all_positions(w, but=sort)
    if others is not None:  # they stay, so whoever wants their cells stays as well
        w.set(target, Where(call("is_one_of", target, others), position, target))
    bits = call("random_bits", KEY, w.stream(s.stream), w.module.extent(sort))
    w.assign(attribute_of("position", sort), call("resolve", position, target, bits))
    if w.module.stores_moved(sort):
        w.assign(attribute_of("moved", sort), Binary("!=", w.current(attribute_of("position", sort)), position))


def conditional_blocks(body: AgentVar, target: Name, w: Writer) -> None:
    """Cells that block only in some states: who wants to enter stays."""
    position = state_reads.positions(w, body.sort)
    for block, kind in blocks_of(body.sort, w):
        if body.axis is None:
            raise NotSupported("`move each` of agents named one by one where cells block under a condition", w.origin)
        blocked = blocked_by(block, kind, Value(target, "i32", (body.axis,)), w, body)
        moves = Value(Binary("!=", target, position), "bool", (body.axis,))
        w.set(target, Where(binary("&", blocked, moves, "bool").node, position, target))
        w.forget()


def blocks_of(sort: ir.Sort, w: Writer) -> list[tuple[ir.Block, ir.Kind]]:
    """Returns what blocks agents or a sort of movers under conditions, each with the kind of the cells."""
    kinds = [kind for kind in w.module.game.kinds if w.module.layout.num_cells((kind.name,))]
    return [(block, kind) for kind in kinds for block in kind.blocks if block.what == sort.plural and block.condition is not None]
