"""Lowers `send` and `remove`: collects who is sent over the phase, then spawns or respawns them on free cells."""

from dataclasses import dataclass, field

from sjdsl.compiler import ir
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import Axis, Value, as_dtype, both, invert, literal, reduce, select
from sjdsl.compiler.lower.expressions import lower, owner
from sjdsl.compiler.lower.scope import AgentVar, CellVar, Frame, Module, Writer, iota

FACINGS = ("north", "east", "south", "west")


@dataclass(frozen=True)
class Pool:
    """One destination of one phase use; `number` names it in the state of those who are away."""

    number: int
    send: ir.Send
    phase: str


@dataclass
class Sends:
    """The sends of one phase: for each pool who goes at once, and the lines for who goes away first."""

    pools: tuple[Pool, ...]
    away_stored: bool = False
    now: dict[int, list[tuple[ir.Send, str]]] = field(default_factory=dict)
    away: list[tuple[Pool, ir.Send, str, str]] = field(default_factory=list)
    removed: list[str] = field(default_factory=list)

    def add(self, s: ir.Send, frame: Frame, w: Writer) -> None:
        """Notes who is sent, `[N]` bool."""
        sent = w.keep("sent", _per_agent(s.who, frame, w))
        pool = next(p for p in self.pools if p.send.pool == s.pool)
        if s.after is None:
            self.now.setdefault(pool.number, []).append((s, sent.text))
            return
        delay = as_dtype(lower(s.after, frame.always(), w), "i32")
        delays = _delays(s, delay, frame, w)
        if s.after.type.low <= 0:
            at_once = w.keep("at_once", Value(f"{sent.text} & ({delays} == 0)", "bool"))
            self.now.setdefault(pool.number, []).append((s, at_once.text))
            sent = w.keep("leaving", Value(f"{sent.text} & ({delays} > 0)", "bool"))
        self.away.append((pool, s, sent.text, delays))

    def remove(self, s: ir.Remove, frame: Frame, w: Writer) -> None:
        self.removed.append(w.keep("removed", _per_agent(s.who, frame, w)).text)


def _per_agent(e: ir.Expr, frame: Frame, w: Writer) -> Value:
    """Returns which agents a sentence reaches, `[N]` bool."""
    who = owner(e, frame, w)
    assert isinstance(who, AgentVar)
    n = w.module.num_agents
    mask = frame.mask if frame.mask is not None else literal(True, "bool")
    if who.axis is not None:
        hit = reduce("any", mask, tuple(a for a in frame.axes if a != who.axis))
        return hit if hit.axes else Value(f"jnp.full({n}, {hit.text})", "bool")
    at = select(frame.mask, who.index, literal(n, "i32"))
    return Value(f'jnp.zeros({n}, bool).at[{at.text}].set(True, mode="drop")', "bool")


def _delays(s: ir.Send, delay: Value, frame: Frame, w: Writer) -> str:
    """Returns the ticks each agent is away, `[N]` int32 or a number (all sends that reach one agent agree)."""
    if not delay.axes:
        return w.keep("delay", Value(f"jnp.int32({delay.text})" if delay.literal else delay.text, "i32")).text
    who = owner(s.who, frame, w)
    assert isinstance(who, AgentVar)
    if who.axis is not None:
        over = tuple(a for a in delay.axes if a != who.axis)
        if over:
            masked = select(frame.mask, delay, literal(0, "i32"))
            where = tuple(masked.axes.index(a) for a in over if a in masked.axes)
            return w.keep("delay", Value(f"jnp.max({masked.text}, axis={where})", "i32")).text
        return w.keep("delay", delay).text
    n = w.module.num_agents
    at = select(frame.mask, who.index, literal(n, "i32"))
    return w.keep("delay", Value(f'jnp.zeros({n}, jnp.int32).at[{at.text}].set({delay.text}, mode="drop")', "i32")).text


def all_pools(game: ir.Game) -> dict[str, tuple[Pool, ...]]:
    """Returns the pools of every phase, numbered through the game."""
    pools: dict[str, tuple[Pool, ...]] = {}
    number = 0
    for phase in (game.start, *game.schedule):
        if not isinstance(phase, ir.Phase):
            continue
        found: dict[int, Pool] = {}
        for node in ir.walk(phase):
            if isinstance(node, ir.Send) and node.pool not in found:
                found[node.pool] = Pool(number, node, phase.name)
                number += 1
        pools[phase.name] = tuple(found.values())
    return pools


def finish(sends: Sends, w: Writer) -> None:
    """Writes the placing of all who are sent in a phase."""
    can_be_away = any(a.after is not None for p in sends.pools for a in _sends_of(p, w.module)) or sends.away_stored
    for pool in sends.pools:
        parts = sends.now.get(pool.number, [])
        if not parts:
            continue
        w.origin = parts[0][0].origin
        sent = parts[0][1] if len(parts) == 1 else w.keep("sent", Value(" | ".join(t for _, t in parts), "bool")).text
        leaving = [sent, *(text for p, _, text, _ in sends.away if p is pool)]
        left = "" if any(s.stay for s in _sends_of(pool, w.module)) else " | ".join(leaving)
        placed = place(pool, sent, left, w, 0)
        _headings(pool, parts, placed, w)
        if can_be_away:
            w.assign("away", f"jnp.where({placed}, 0, {w.current('away')})")
    for pool, s, sent, delays in sends.away:
        w.origin = s.origin
        w.assign("position", f"jnp.where({sent}, 0, {w.current('position')})")
        w.assign("away", f"jnp.where({sent}, {delays}, {w.current('away')})")
        w.assign("away_pool", f"jnp.where({sent}, {pool.number}, {w.current('away_pool')})")
        facing = 4 if s.facing is None else 5 if s.facing == "same" else FACINGS.index(s.facing)
        w.assign("away_facing", f"jnp.where({sent}, {facing}, {w.current('away_facing')})")
    w.origin = None
    for removed in sends.removed:
        w.assign("position", f"jnp.where({removed}, 0, {w.current('position')})")
        if sends.away_stored:
            w.assign("away", f"jnp.where({removed}, 0, {w.current('away')})")


def _sends_of(pool: Pool, module: Module) -> list[ir.Send]:
    """Returns all sentences that send to a pool."""
    return [s for s in module.sends if s.order_stream == pool.send.order_stream]


def place(pool: Pool, sent: str, leaving: str, w: Writer, stream_change: int) -> str:
    """Writes the placing of one pool; returns who found a cell. The cells of those who are `leaving` count as free."""
    kinds = pool.send.domain.var.kinds
    layout = w.module.layout
    cells = w.module.constant("cells_" + "_".join(kinds), layout.cells_table(kinds), f"cells of {', '.join(kinds)}")
    axis = w.axis("destination", layout.num_cells(kinds))
    n = w.module.num_agents
    agents = AgentVar(Value("", "i32"), Axis("", n, 0))
    starting = pool.phase == "start"
    free: Value | None = None
    if not starting:
        site, _ = state_reads.site_under(agents, kinds, w)
        text = f"jnp.where({leaving}, {axis.size}, {site.text})" if leaving else site.text
        others = w.keep("others", Value(text, "i32"))
        free = Value(f"~occupied({others.text}, {axis.size})", "bool", (axis,))
    if pool.send.domain.where is not None:
        variable = CellVar(iota(axis), kinds, axis)
        test = lower(pool.send.domain.where, Frame(axes=(axis,), variables={pool.send.domain.var.name: variable}), w)
        free = both(free, test)
    stream = pool.send.order_stream ^ stream_change
    free = literal(True, "bool") if free is None else free
    free = w.keep("free", free) if free.axes else Value(f"jnp.full({axis.size}, {free.text})", "bool", (axis,))
    placed = w.names.fresh("placed")
    before = w.current("position")
    if "position" not in w.changed:
        w.changed["position"] = w.names.fresh("position")
    w.line(f"{w.changed['position']}, {placed} = place({cells}, {free.text}, words(key, 0x{stream:08x}, {n}), {before}, {sent})")
    return placed


def _headings(pool: Pool, parts: list[tuple[ir.Send, str]], placed: str, w: Writer) -> None:
    n = w.module.num_agents
    for s, sent in parts:
        if s.facing == "same":
            continue
        who = placed if len(parts) == 1 else f"{sent} & {placed}"
        if s.facing is not None:
            facing = str(FACINGS.index(s.facing))
        else:
            facing = f"below(words(key, 0x{pool.send.heading_stream:08x}, {n}), 4)"
        w.assign("heading", f"jnp.where({who}, {facing}, {w.current('heading')})")


def returns(pools: dict[str, tuple[Pool, ...]], w: Writer) -> None:
    """Writes the part of `tick` that brings back those whose time away is over: pool by pool, each on the map as it then is."""
    n = w.module.num_agents
    w.line("due = (state.position == 0) & (state.away == 1)")
    w.line("state = state.replace(away=state.away - ((state.position == 0) & (state.away > 1)).astype(jnp.int32))")
    w.names.taken |= {"due"}
    for pool in (p for phase in pools.values() for p in phase):
        if not any(s.after is not None for s in _sends_of(pool, w.module)):
            continue
        w.known.clear()
        w.origin = pool.send.origin
        back = w.keep("back", Value(f"due & (state.away_pool == {pool.number})", "bool"))
        placed = place(pool, back.text, "", w, ir.RETURN)
        facing = w.names.fresh("facing")
        stream = pool.send.heading_stream ^ ir.RETURN
        w.line(f"{facing} = jnp.where(state.away_facing == 4, below(words(key, 0x{stream:08x}, {n}), 4), state.away_facing)")
        w.line(f"{facing} = jnp.where(state.away_facing == 5, state.heading, {facing})")
        w.assign("heading", f"jnp.where({placed}, {facing}, state.heading)")
        w.assign("away", f"jnp.where({placed}, 0, state.away)")
        w.line(f"state = state.replace({', '.join(f'{k}={v}' for k, v in w.changed.items())})")
        w.changed.clear()
    w.known.clear()
    w.origin = None


__all__ = ["Pool", "Sends", "all_pools", "finish", "invert", "returns"]
