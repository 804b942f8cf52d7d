"""Lowering: from the typed IR to an array program, with tables of the map and one function a phase.

    ir.Game -> Program

Assumes a verified game; guarantees that every index stays in the padded frame and every draw has its stream.
"""

from collections.abc import Iterable
from dataclasses import fields

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_name, param_attribute
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.assignments import all_fields
from sjdsl.compiler.lower.assignments import finish as finish_writes
from sjdsl.compiler.lower.axes import as_dtype
from sjdsl.compiler.lower.cell_appearance import marking_phases, token_planes
from sjdsl.compiler.lower.environment import events, role_attribute, state_fields
from sjdsl.compiler.lower.expressions import lower as lower_expression
from sjdsl.compiler.lower.map_tables import Layout
from sjdsl.compiler.lower.movement import stores_moved
from sjdsl.compiler.lower.observations import observe
from sjdsl.compiler.lower.relocation import Sends, all_pools, returns
from sjdsl.compiler.lower.relocation import finish as finish_sends
from sjdsl.compiler.lower.scope import AgentVar, Frame, Module, NotSupported, Writer, iota
from sjdsl.compiler.lower.statements import block, mark_size
from sjdsl.compiler.program import Attribute, Function, Program
from sjdsl.runtime.fields import StateField

STORED = {"u8": "uint8", "u32": "uint32", "i32": "int32", "f32": "float32", "bool": "bool_"}


def lower(game: ir.Game, source: str) -> Program:
    """Returns the array program of a game. Raises NotSupported, with a place, for what it cannot say exactly."""
    module = Module(game, Layout(game))
    try:
        return _program(game, source, module)
    except NotSupported as refused:
        around = None if module.writer is None else module.writer.origin
        refused.origin = refused.origin or around or game.agents.origin
        raise


def _program(game: ir.Game, source: str, module: Module) -> Program:
    pools = all_pools(game)
    functions = [_phase(game.start, pools[game.start.name], module)]
    for turn in game.schedule:
        functions.append(_tick(pools, module) if isinstance(turn, ir.Tick) else _phase(turn, pools[turn.name], module))
    functions += [_allowed(module), _measures(module), _episode(module), _observe(module)]
    state = tuple(_state(game, Writer(module)))
    turns = ", ".join("tick" if isinstance(t, ir.Tick) else t.name for t in game.schedule)
    actions = game.agents.actions
    facts = (
        ("NAME", repr(game.name)),
        ("TITLE", repr(game.title)),
        ("ACTIONS", repr(actions)),
        ("STAY", str(actions.index("stay"))),
        ("NUM_AGENTS", str(game.agents.number)),
        ("PAD", str(module.layout.pad)),
        ("FRAME", repr((module.layout.rows, module.layout.cols))),
        ("SCHEDULE", turns),
        ("WINDOW", repr((game.window.ahead + 1 + game.window.behind, game.window.left + 1 + game.window.right))),
        ("FORBIDS_ACTIONS", repr(bool(game.agents.forbids))),
        ("ROLE", repr(role_attribute(game))),
        ("EVENTS", _rows(events(game), "counts of a step: name, attribute of Outcome, entry of its last axis")),
        ("FIELDS", _rows(map(_described, state_fields(game)), "variables of the game, in State")),
    )
    return Program(
        name=game.name,
        title=game.title,
        source=source,
        constants=tuple(module.constants.values()),
        state=state,
        params=tuple(_params(game)),
        outcome=tuple(_outcome(game)),
        functions=tuple(functions),
        facts=facts,
    )


def _rows(rows: Iterable[object], meaning: str) -> str:
    """Returns a tuple as source, a line an entry."""
    return "".join([f"(  # {meaning}\n", *(f"    {row},\n" for row in rows), ")"])


def _described(field: StateField) -> str:
    given = {f.name: getattr(field, f.name) for f in fields(field) if getattr(field, f.name) != f.default}
    return f"StateField({', '.join(f'{name}={value!r}' for name, value in given.items())})"


def _state(game: ir.Game, w: Writer) -> list[Attribute]:
    n = game.agents.number
    found = [
        Attribute("step", "[]", "int32", "finished steps of this episode", "jnp.int32(0)"),
        Attribute(
            "position",
            "[N]",
            "int32",
            "cell of each agent in the padded frame; 0: nowhere",
            f"jnp.zeros({n}, jnp.int32)",
        ),
        Attribute("heading", "[N]", "int32", "0 north, 1 east, 2 south, 3 west", f"jnp.zeros({n}, jnp.int32)"),
    ]
    if stores_moved(game):
        found.append(Attribute("moved", "[N]", "bool_", "did the last movement change the cell", f"jnp.zeros({n}, bool)"))
    if w.module.stores_away:
        found += [
            Attribute(
                "away",
                "[N]",
                "int32",
                "ticks until an agent that is nowhere returns; 0: never",
                f"jnp.zeros({n}, jnp.int32)",
            ),
            Attribute("away_pool", "[N]", "int32", "where it was sent", f"jnp.zeros({n}, jnp.int32)"),
            Attribute("away_facing", "[N]", "int32", "heading it will have; 4: any, 5: the same", f"jnp.zeros({n}, jnp.int32)"),
        ]
    for field in all_fields(game):
        found.append(_field(field, game, w))
    for phase in marking_phases(game):
        size = mark_size(phase, game)
        found.append(
            Attribute(
                f"mark_{phase.name}",
                f"[{size}]",
                "int32",
                f"cells marked by {phase.label}; 0: none",
                f"jnp.zeros({size}, jnp.int32)",
            )
        )
    return found


def _field(field: ir.VarField, game: ir.Game, w: Writer) -> Attribute:
    dtype = STORED[state_reads.storage(field, w)]
    dims = {"cell": "S", "agent": "N", "world": ""}[field.place]
    shape = ", ".join(([dims] if dims else []) + [str(len(by)) for by in field.type.by])
    layout = w.module.layout
    starts = layout.starts(field.kind, field) if field.place == "cell" else {field.start}
    count = layout.num_cells((field.kind,)) if field.place == "cell" else game.agents.number
    size = ([count] if field.place != "world" else []) + [len(by) for by in field.type.by]
    encode = {s: _encoded(s, field) for s in starts | {field.start}}
    if len(starts) <= 1:
        default = f"jnp.full({tuple(size)}, {encode[next(iter(starts), field.start)]}, jnp.{dtype})"
    else:
        encode |= {s: _encoded(s, field) for g in game.glyphs if g.kind == field.kind for n, s in g.starts if n == field.name}
        table = layout.starts_table(field.kind, field, encode, dtype)
        default = w.module.constant(f"{attribute_name(field)}_start", table, f"{field.name} of {field.kind} as on the map")
        if field.type.by:
            default = f"jnp.repeat({default}[:, None], {len(field.type.by[0])}, axis=1)"
    meaning = f"{field.name}: {_meaning(field)}" + (f"; by {', '.join(field.type.by[0])}" if field.type.by else "")
    return Attribute(attribute_name(field), f"[{shape}]", dtype, meaning, default)


def _meaning(field: ir.VarField) -> str:
    match field.type.kind:
        case "word":
            return ", ".join(f"{i} {w}" for i, w in enumerate(field.type.words))
        case "agents":
            return "agents as bits"
        case "agent":
            return "an agent's id, -1 nobody"
        case _ if field.timer:
            return "steps left"
        case _ if field.type.unit == "reward":
            return "a reward"
        case _:
            return f"{field.type.low:g} .. {field.type.high:g}"


def _encoded(value: object, field: ir.VarField) -> float:
    match field.type.kind:
        case "word":
            return field.type.words.index(value)  # type: ignore[arg-type]
        case "agent":
            return -1
        case "agents":
            return 0
        case _:
            return value  # type: ignore[return-value]


def _params(game: ir.Game) -> list[Attribute]:
    found = []
    for param in game.params:
        dtype = {"int": "int32", "real": "float32", "word": "uint8"}[param.type.kind]
        shape = "[" + ", ".join(str(len(by)) for by in param.type.by) + "]"
        value = param_value(param.value, param.type)
        by = "".join(f" by {{ {', '.join(words)} }}" for words in param.type.by)
        unit = "word" if param.type.kind == "word" else param.type.unit
        found.append(Attribute(param_attribute(param.name), shape, dtype, f"{unit}{by}", f"jnp.asarray({value!r}, jnp.{dtype})"))
    return found


def param_value(value: object, type_: ir.Type) -> object:
    """Returns a parameter's value as nested lists of numbers; words as their numbers."""
    if isinstance(value, tuple):
        return [param_value(v, type_) for v in value]
    return type_.words.index(value) if type_.kind == "word" else value  # type: ignore[arg-type]


def _outcome(game: ir.Game) -> list[Attribute]:
    n = game.agents.number
    found = [
        Attribute("reward", "[N]", "float32", "raw rewards of this step", f"jnp.zeros({n}, jnp.float32)"),
        Attribute("ended", "[]", "bool_", "whether an `end` was performed", "jnp.zeros((), bool)"),
    ]
    for event in game.events:
        size = ([n] if event.per_agent else []) + ([len(event.by)] if event.by else [])
        shape = ", ".join((["N"] if event.per_agent else []) + ([str(len(event.by))] if event.by else []))
        by = f", by {', '.join(event.by)}" if event.by else ""
        found.append(
            Attribute(
                f"event_{param_attribute(event.name)}",
                f"[{shape}]",
                "int32",
                f"counts of this step{by}",
                f"jnp.zeros({tuple(size)}, jnp.int32)",
            )
        )
    return found


def _phase(phase: ir.Phase, pools: tuple, module: Module) -> Function:
    w = Writer(module, starting=phase is module.game.start)
    sends = Sends(pools, away_stored=module.stores_away)
    block(phase.body, Frame(), w, sends)
    w.origin = None
    finish_writes(w)
    finish_sends(sends, w)
    if w.marked:
        w.changed[f"mark_{phase.name}"] = _all_marks(w.marked, mark_size(phase, module.game))
    w.line(f"return {_replaced('state', w.changed)}, {_replaced('out', w.outcome)}")
    doc = f"Phase `{phase.label}`." if phase is not module.game.start else "Phase `start`: where the agents begin."
    return Function(phase.name, "state: State, out: Outcome, params: Params, actions: Array, key: Array", doc, tuple(w.lines))


def _all_marks(marked: dict[str, int], size: int) -> str:
    """Returns the cells of all marks of a phase; those of sentences that never happen are missing, and none stand in their places."""
    missing = size - sum(marked.values())
    parts = [*marked, *([f"jnp.zeros({missing}, jnp.int32)"] if missing else [])]
    return parts[0] if len(parts) == 1 else f"jnp.concatenate([{', '.join(parts)}])"


def _replaced(name: str, changes: dict[str, str]) -> str:
    if not changes:
        return name
    return f"{name}.replace({', '.join(f'{k}={v}' for k, v in changes.items())})"


def _tick(pools: dict, module: Module) -> Function:
    w = Writer(module)
    for field in all_fields(module.game):
        if field.timer:
            name = attribute_name(field)
            old = f"state.{name}"
            w.origin = field.origin
            w.assign(name, f"{old} - ({old} > 0).astype({old}.dtype)")
    w.origin = None
    if module.stores_away:
        w.line(f"state = {_replaced('state', w.changed)}")
        w.changed.clear()
        returns(pools, w)
    w.line(f"return {_replaced('state', w.changed)}, out")
    arguments = "state: State, out: Outcome, params: Params, actions: Array, key: Array"
    return Function("tick", arguments, "All timers fall by one; agents whose time away is over return.", tuple(w.lines))


def _allowed(module: Module) -> Function:
    """Which actions are open, and what a forbidden or unknown one becomes."""
    w = Writer(module)
    agents = module.game.agents
    n, count, stay = agents.number, len(agents.actions), agents.actions.index("stay")
    axis = w.axis("agent", n)
    frame = Frame(axes=(axis,), variables={"agent": AgentVar(iota(axis), axis)})
    w.line(f"allowed = jnp.ones(({n}, {count}), bool)")
    for forbid in agents.forbids:
        w.origin = forbid.origin
        test = w.keep("forbidden", lower_expression(forbid.condition, frame, w))
        mask = np.isin(np.arange(count), [a for a in forbid.actions if a != stay])
        name = module.constant("forbids", mask, "actions a `forbid` is about")
        condition = f"{test.text}[:, None]" if test.axes else test.text
        w.line(f"allowed = allowed & ~({condition} & {name}[None])")
    w.origin = None
    w.line("return allowed")
    return Function(
        "allowed_actions",
        "state: State, params: Params",
        "Returns which actions each agent may take: `[N, A]` bool.",
        tuple(w.lines),
    )


def _measures(module: Module) -> Function:
    w = Writer(module)
    values = []
    for measure in module.game.measures:
        w.origin = measure.origin
        value = as_dtype(lower_expression(measure.value, Frame(), w), "f32")
        text = f"jnp.float32({value.text})" if value.literal else value.text
        values.append(f"{measure.name!r}: {text}")
    w.origin = None
    w.line(f"return {{{', '.join(values)}}}")
    return Function(
        "measures",
        "state: State, params: Params",
        "Returns the `mean` and `final` values at the end of a step: float32 scalars by name.",
        tuple(w.lines),
    )


def _episode(module: Module) -> Function:
    w = Writer(module)
    w.origin = module.game.episode.origin
    value = lower_expression(module.game.episode, Frame(), w)
    w.line(f"return jnp.asarray({value.text}, jnp.int32)")
    return Function("episode_length", "params: Params", "Returns the steps until truncation: int32 scalar.", tuple(w.lines))


def _observe(module: Module) -> Function:
    w = Writer(module)
    text = observe(w)
    w.origin = None
    w.line(f"return {text}")
    planes = len(token_planes(module.game))
    window = module.game.window
    view = (window.ahead + 1 + window.behind, window.left + 1 + window.right)
    doc = f"Returns what each agent sees: `[N, {planes}, {view[0]}, {view[1]}]` uint8; planes as in TOKEN_PLANES."
    return Function("observe", "state: State, params: Params", doc, tuple(w.lines))


__all__ = ["NotSupported", "lower", "param_value", "token_planes"]
