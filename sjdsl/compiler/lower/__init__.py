"""Lowering: from the typed IR to an array program, with tables of the map and one function a phase.

    ir.Game -> Program

Assumes a verified game; guarantees that every index stays in the padded frame and every draw has its stream.
"""

import dataclasses
import re
from collections.abc import Mapping
from typing import get_args

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.ir.hash import game_hash
from sjdsl.compiler.ir.names import attribute_name
from sjdsl.compiler.ir.queries import all_fields, body_sorts, marking_phases, view_size
from sjdsl.compiler.lower import expressions
from sjdsl.compiler.lower.allowed_actions import NUM_ACTIONS, READING, allowed_actions
from sjdsl.compiler.lower.assignments import fields_of_several_lots
from sjdsl.compiler.lower.assignments import finish as finish_writes
from sjdsl.compiler.lower.axes import as_dtype
from sjdsl.compiler.lower.cell_appearance import token_planes
from sjdsl.compiler.lower.map_tables import Layout
from sjdsl.compiler.lower.observations import observe
from sjdsl.compiler.lower.relocation import Pool, Sends, all_pools, bring_back
from sjdsl.compiler.lower.relocation import finish as finish_sends
from sjdsl.compiler.lower.scope import IterationScope, NotSupported
from sjdsl.compiler.lower.shared_phases import Turn, share
from sjdsl.compiler.lower.state import (
    described_fields,
    events,
    outcome_fields,
    params_fields,
    role_attribute,
    state_fields,
)
from sjdsl.compiler.lower.statements import block, mark_size
from sjdsl.compiler.lower.writer import Module, Writer, replaced
from sjdsl.compiler.program import Constant, Fact, Field, Function, Group, Number, Program
from sjdsl.compiler.program import expressions as array
from sjdsl.runtime.fields import StateField

STATE, OUT, PARAMS, ACTIONS, KEY = (
    array.Name(x) for x in ("state", "out", "params", "actions", "key")
)
PHASE = (
    ("state", "State"),
    ("out", "Outcome"),
    ("params", "Params"),
    ("actions", "Array"),
    ("key", "Array"),
)
STAY = array.Name("STAY")


def new_module(game: ir.Game) -> Module:
    """Returns an empty module of a game, to write functions of."""
    return Module(game, Layout(game), expressions.lower)


def lower(game: ir.Game, source: str, sources: Mapping[str, Source] | None = None) -> Program:
    """Returns the array program of a game. Raises NotSupported, with a place, for what it cannot say exactly.

    Args:
      game: its rules; source: the name of the file they come from.
      sources: the texts that the rules come from, by name: functions show those of their phases.
    """
    module = Module(game, Layout(game), expressions.lower, sources or {})
    try:
        return _program(game, source, module)
    except NotSupported as refused:
        around = None if module.writer is None else module.writer.origin
        refused.origin = refused.origin or around or game.agents.origin
        raise


def _program(game: ir.Game, source: str, module: Module) -> Program:
    pools = all_pools(game)
    start = _phase(game.start, pools[game.start.name], module)
    lowered = [
        (t, _tick(pools, module) if isinstance(t, ir.Tick) else _phase(t, pools[t.name], module))
        for t in game.schedule
    ]
    lowered = [
        (t, function) for t, function in lowered if function.body != (array.Return((STATE, OUT)),)
    ]
    shared = iter(share([(t, function) for t, function in lowered if isinstance(t, ir.Phase)]))
    turns = [Turn(function) if isinstance(t, ir.Tick) else next(shared) for t, function in lowered]
    others = [allowed_actions(module), _measures(module), _episode(module), _observe(module)]
    w = Writer(module)
    state, params, outcome = state_fields(game, w), params_fields(game), outcome_fields(game, w)
    made = [
        _made("default_params", "Params", "Returns the numbers as the file has them.", params),
        _made(
            "initial_state",
            "State",
            "Returns the declared starting values, before the phase `start`.",
            state,
        ),
        _made(
            "no_outcome",
            "Outcome",
            "Returns the outcome of a step in which nothing has happened yet.",
            outcome,
        ),
    ]
    phases = dict.fromkeys(turn.function for turn in turns)
    functions = (*made, _reset(), _step(turns, module), start, *phases, *others)
    constants, numbers = _used(functions, module)
    hash_ = game_hash(game)
    return Program(
        name=game.name,
        title=game.title,
        source=source,
        hash=hash_,
        facts=_facts(game, hash_, module),
        map=game.rows,
        planes=token_planes(game),
        numbers=numbers,
        constants=constants,
        state=tuple(state),
        params=tuple(params),
        outcome=tuple(outcome),
        functions=functions,
    )


def _facts(game: ir.Game, hash_: str, module: Module) -> tuple[Fact, ...]:
    """Returns what the module says of itself."""
    actions = game.agents.actions
    facts: tuple[tuple[str, object, str], ...] = (
        ("NAME", game.name, ""),
        ("TITLE", game.title, ""),
        ("HASH", hash_, "of the rules"),
        ("ACTIONS", actions, ""),
        ("STAY", actions.index("stay"), ""),
        ("NUM_AGENTS", game.agents.number, ""),
        ("PAD", module.layout.pad, "cells around the map on each side"),
        ("FRAME", (module.layout.rows, module.layout.cols), "rows and columns of the padded map"),
        ("WINDOW", view_size(game), "rows and columns that an agent sees"),
        ("FORBIDS_ACTIONS", bool(game.agents.forbids), ""),
        ("ROLE", role_attribute(game), "attribute of State that holds the agents' roles"),
        (
            "EVENTS",
            events(game),
            "counts of a step: name, attribute of Outcome, entry of its last axis",
        ),
    )
    fields = array.Sequence(tuple(map(_state_field_call, described_fields(game))))
    return (
        *(Fact(n, array.constant(value), c) for n, value, c in facts),
        Fact("FIELDS", fields, "variables of the game, in State"),
    )


def _state_field_call(field: StateField) -> array.Expression:
    given = {
        f.name: getattr(field, f.name)
        for f in dataclasses.fields(field)
        if getattr(field, f.name) != f.default
    }
    return array.call(
        "StateField", **{name: array.constant(value) for name, value in given.items()}
    )


def _used(
    functions: tuple[Function, ...], module: Module
) -> tuple[tuple[Constant, ...], tuple[Number, ...]]:
    """Returns the constants and numbers of the module that its functions use, in the order in which they were met."""
    nodes = [node for function in functions for node in walk(function)]
    names = {n.identifier for n in nodes if isinstance(n, array.Name)} | {
        n.name for n in nodes if isinstance(n, array.Literal)
    }
    constants = tuple(c for c in module.constants.values() if c.name in names)
    groups = get_args(Group)
    numbers = sorted(
        (n for n in module.numbers.values() if n.name in names), key=lambda n: groups.index(n.group)
    )
    return constants, tuple(numbers)


def _made(name: str, of: str, doc: str, fields: list[Field]) -> Function:
    """Returns the function that makes the first value of a class."""
    made = array.Call(array.Name(of), (), tuple((field.name, field.default) for field in fields))
    return Function(name, (), of, doc, (array.Return((made,)),))


def _function(
    w: Writer, name: str, parameters: tuple[tuple[str, str], ...], returns: str, doc: str
) -> Function:
    return Function(name, parameters, returns, doc, array.live(w.body))


def _reset() -> Function:
    doc = "Returns the first state of an episode. `key`: two uint32 words."
    parameters = (("params", "Params"), ("key", "Array"))
    actions = array.call("jnp.full", array.Name("NUM_AGENTS"), STAY, array.DTYPES["i32"])
    first = array.call(
        "start", array.call("initial_state"), array.call("no_outcome"), PARAMS, actions, KEY
    )
    return Function(
        "reset",
        parameters,
        "State",
        doc,
        (array.Return((array.Index(first, (array.Literal(0),)),)),),
    )


def _step(turns: list[Turn], module: Module) -> Function:
    """Unknown and forbidden actions become `stay`, marks of the last step go, then the phases follow in schedule order."""
    w = Writer(module)
    below, above = (
        array.Binary("<", ACTIONS, array.Literal(0)),
        array.Binary(">=", ACTIONS, NUM_ACTIONS),
    )
    w.set(ACTIONS, array.Where(array.Binary("|", below, above), STAY, ACTIONS))
    if module.game.agents.forbids:
        allowed = array.call("allowed_actions", STATE, PARAMS)
        chosen = array.call("one_hot", ACTIONS, NUM_ACTIONS)
        w.set(
            array.Name("allowed"), array.reduction("any", array.Binary("&", allowed, chosen), (1,))
        )
        w.set(ACTIONS, array.Where(array.Name("allowed"), ACTIONS, STAY))
    w.set(OUT, array.call("no_outcome"))
    marks = [f"mark_{phase.name}" for phase in marking_phases(module.game)]
    if marks:
        w.set(
            STATE,
            replaced(
                "state",
                {mark: array.call("jnp.zeros_like", array.path(f"state.{mark}")) for mark in marks},
            ),
        )
    for turn in turns:
        marked = (array.Name("marked"),) if turn.marks else ()
        w.unpack(
            (STATE, OUT, *marked),
            array.call(turn.function.name, STATE, OUT, PARAMS, ACTIONS, KEY, *turn.given),
        )
        if turn.marks:
            w.set(STATE, replaced("state", {turn.marks: array.Name("marked")}))
    w.give_back(STATE, OUT)
    doc = "Returns the state after one step and what it yielded. `actions`: `[N]` int32; `key`: two uint32 words."
    parameters = (("state", "State"), ("actions", "Array"), ("params", "Params"), ("key", "Array"))
    return _function(w, "step", parameters, "tuple[State, Outcome]", doc)


def _phase(phase: ir.Phase, pools: tuple[Pool, ...], module: Module) -> Function:
    w = Writer(
        module,
        phase.name,
        starting=phase is module.game.start,
        several_lots=fields_of_several_lots(phase),
    )
    sends = Sends(pools)
    block(phase.body, IterationScope(), w, sends)
    w.origin = None
    finish_writes(w)
    finish_sends(sends, w)
    if w.marked:
        missing = mark_size(phase, module.game) - sum(w.marked.values())
        parts: tuple[array.Expression, ...] = (
            *w.marked,
            *(
                [array.call("jnp.zeros", array.Literal(missing), array.DTYPES["i32"])]
                if missing
                else []
            ),
        )
        w.changed[f"mark_{phase.name}"] = (
            parts[0]
            if len(parts) == 1
            else array.call("jnp.concatenate", array.Sequence(parts, is_list=True))
        )
    w.give_back(replaced("state", w.changed), replaced("out", w.outcome))
    return _function(w, phase.name, PHASE, "tuple[State, Outcome]", _written(phase, module.sources))


def _written(phase: ir.Phase, sources: Mapping[str, Source]) -> str:
    """Returns a phase as the rules have it, from its first column on; its name alone where their text is not known."""
    span = phase.origin
    if span is None or span.file not in sources:
        return f"Phase `{phase.label}`."
    first, *rest = sources[span.file].text[span.start : span.end].splitlines()
    margin = re.compile(rf"\s{{0,{span.column - 1}}}")
    return "\n".join([first, *(margin.sub("", line, count=1).rstrip() for line in rest)])


def _tick(pools: dict[str, tuple[Pool, ...]], module: Module) -> Function:
    w = Writer(module, "tick")
    for field in all_fields(module.game):
        if field.timer:
            old = array.path(f"state.{attribute_name(field)}")
            w.origin = field.origin
            w.assign(
                attribute_name(field),
                array.Binary(
                    "-", array.call("jnp.maximum", old, array.Literal(1)), array.Literal(1)
                ),
            )
    w.origin = None
    away = [sort for sort in body_sorts(module.game) if module.stores_away(sort)]
    if away:
        if w.changed:
            w.set(STATE, replaced("state", w.changed))
            w.changed.clear()
        bring_back(pools, away, w)
    w.give_back(replaced("state", w.changed), OUT)
    who = " and ".join(sort.plural for sort in away)
    doc = (
        f"All timers fall by one; {who} whose time away is over return."
        if away
        else "All timers fall by one."
    )
    return _function(w, "tick", PHASE, "tuple[State, Outcome]", doc)


def _measures(module: Module) -> Function:
    w = Writer(module, "measures")
    values = []
    for measure in module.game.measures:
        w.origin = measure.origin
        value = as_dtype(w.value(measure.value, IterationScope()), "f32")
        values.append(
            (measure.name, array.scalar(value.node, "f32") if value.literal else value.node)
        )
    w.origin = None
    w.give_back(array.Mapping(tuple(values)))
    doc = "Returns the `mean` and `final` values at the end of a step: float32 scalars by name."
    return _function(w, "measures", READING, "dict[str, Array]", doc)


def _episode(module: Module) -> Function:
    w = Writer(module)
    w.origin = module.game.episode.origin
    value = w.value(module.game.episode, IterationScope())
    w.give_back(array.as_array(value.node, "i32"))
    doc = "Returns the steps until truncation: int32 scalar."
    return _function(w, "episode_length", (("params", "Params"),), "Array", doc)


def _observe(module: Module) -> Function:
    w = Writer(module, "observe")
    planes = observe(w)
    w.origin = None
    w.give_back(planes)
    rows, cols = view_size(module.game)
    doc = f"Returns what each agent sees: `[N, {len(token_planes(module.game))}, {rows}, {cols}]` uint8; planes as in TOKEN_PLANES."
    return _function(w, "observe", READING, "Array", doc)


__all__ = ["NotSupported", "lower", "new_module", "token_planes"]
