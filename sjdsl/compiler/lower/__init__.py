"""Lowering: from the typed IR to an array program, with tables of the map and a function a phase.

    ir.Game -> Program

Assumes a verified game; guarantees that every index stays in the padded frame and every draw has
its stream.

A statement of a game, which runs once for each member of the quantifiers around it (its
*instances*), becomes array code for all instances at once:

    each agent as zapper where zapper chose zap {      chose_zap = actions == ACTION_ZAP
      each agent as victim in beam of zapper { ... }   victim_in_beam = chose_zap[:, None] & in_beam
    }

Words that all files here use:

- axis: of a quantifier that loops, here `zapper` and `victim`. An array has the axes of the
  quantifiers on which its value depends, in the order in which they were entered (`axes.Value`).
- scope: what a statement sees of the quantifiers around it: their axes, their variables, and the
  mask that says which instances happen (`scope.IterationScope`).
- `w`: the writer of the function that is being generated. `w.keep(name, value)` writes
  `name = value` into it and returns the value under that name; what is equal is written once.
- frame: the map with padding around it. A cell of the frame is a number, row by row; cell 0 is no
  cell of the map, and is where those stand who are away.
- site: the number of a cell among all cells of a kind, which indexes the fields of that kind. It is
  past the end for a cell of another kind, where writes are dropped.
"""

import dataclasses
import re
from collections.abc import Mapping
from typing import get_args

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.ir.entity_types import AGENTS
from sjdsl.compiler.ir.hash import game_hash
from sjdsl.compiler.ir.names import attribute_name, param_attribute
from sjdsl.compiler.ir.queries import (
    all_fields,
    beginning_phases,
    body_types,
    marking_phases,
    view_size,
)
from sjdsl.compiler.lower import expressions, state_reads
from sjdsl.compiler.lower.allowed_actions import NUM_ACTIONS, READING, allowed_actions
from sjdsl.compiler.lower.assignments import fields_of_several_lots
from sjdsl.compiler.lower.assignments import finish as finish_writes
from sjdsl.compiler.lower.axes import as_dtype
from sjdsl.compiler.lower.beginning import begun
from sjdsl.compiler.lower.cell_appearance import token_planes
from sjdsl.compiler.lower.draws import KEY
from sjdsl.compiler.lower.map_tables import Layout
from sjdsl.compiler.lower.observations import observe
from sjdsl.compiler.lower.pools import Pool, Pools, all_pools
from sjdsl.compiler.lower.returning import bring_back
from sjdsl.compiler.lower.scope import IterationScope, NotSupported
from sjdsl.compiler.lower.sending import Sends
from sjdsl.compiler.lower.sending import finish as finish_sends
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
from sjdsl.compiler.lower.tasks import functions_of_task, task_of_episode
from sjdsl.compiler.lower.trials import next_trial
from sjdsl.compiler.lower.writer import Module, Writer, replaced
from sjdsl.compiler.program import Constant, Fact, Field, Function, Group, Number, Program
from sjdsl.compiler.program.expressions import (
    Cast,
    Expression,
    Literal,
    Name,
    Return,
    Sequence,
    Where,
    as_array,
    call,
    concatenated,
    constant,
    live,
    path,
    reduction,
    zeros,
)
from sjdsl.runtime.fields import StateField

STATE = Name("state")
OUT = Name("out")
PARAMS = Name("params")
ACTIONS = Name("actions")
PHASE = (
    ("state", "State"),
    ("out", "Outcome"),
    ("params", "Params"),
    ("actions", "Array"),
    ("key", "Array"),
)
STAY = Name("STAY")


def new_module(game: ir.Game, sources: Mapping[str, Source] | None = None) -> Module:
    """Returns an empty module of a game, to write functions of. sources: as of `lower`."""
    return Module(game, Layout(game), expressions.lower, sources or {})


def lower(game: ir.Game, source: str, sources: Mapping[str, Source] | None = None) -> Program:
    """Returns the array program of a game.

    Args:
      game: its rules.
      source: the name of the file they come from.
      sources: the texts that the rules come from, by name: functions show those of their phases.
    Raises:
      NotSupported: with a place, for what the program can't express exactly.
    """
    module = new_module(game, sources)
    try:
        return _program(game, source, module)
    except NotSupported as refused:
        last = None if module.writer is None else module.writer.origin
        refused.origin = refused.origin or last or game.agents.origin
        raise


def _program(game: ir.Game, source: str, module: Module) -> Program:
    """Returns the module of a game."""
    pools = all_pools(game)
    starts = [_phase(phase, pools[phase.name], module) for phase in beginning_phases(game)]
    turns = _turns(pools, module)
    others = [allowed_actions(module), _measures(module), *_lengths(module), _observe(module)]
    w = Writer(module)
    state = state_fields(game, w)
    params = params_fields(game)
    outcome = outcome_fields(game, w)
    constructors = [
        _constructor(
            "default_params", "Params", "Returns the numbers as the file has them.", params
        ),
        _constructor(
            "initial_state",
            "State",
            "Returns the declared starting values, before the phase `start`.",
            state,
        ),
        _constructor(
            "no_outcome",
            "Outcome",
            "Returns the outcome of a step in which nothing has happened yet.",
            outcome,
        ),
    ]
    phases = dict.fromkeys(turn.function for turn in turns)
    beginning = [_reset(game, module)]
    if game.trials is not None:
        beginning.append(next_trial(game, game.trials, _laid(game, module), module))
    if game.task is not None:
        beginning.append(_phase(game.task.draw, (), module))
        beginning += functions_of_task(game.task, module)
    functions = (*constructors, *beginning, _step(turns, module), *starts, *phases, *others)
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


def _turns(pools: Pools, module: Module) -> list[Turn]:
    """Returns the calls of a step, without those of functions that do nothing."""
    lowered: list[tuple[ir.Turn, Function]] = []
    for turn in module.game.schedule:
        if isinstance(turn, ir.Tick):
            function = _tick(pools, module)
        else:
            function = _phase(turn, pools[turn.name], module)
        if function.body != (Return((STATE, OUT)),):
            lowered.append((turn, function))
    return share(lowered)


def _facts(game: ir.Game, hash_: str, module: Module) -> tuple[Fact, ...]:
    """Returns the constants by which a module describes itself."""
    actions = game.agents.actions
    layout = module.layout
    events_comment = "counts of a step: name, attribute of Outcome, entry of its last axis"
    facts: tuple[tuple[str, object, str], ...] = (
        ("NAME", game.name, ""),
        ("TITLE", game.title, ""),
        ("HASH", hash_, "of the rules"),
        ("ACTIONS", actions, ""),
        ("STAY", actions.index("stay"), ""),
        ("NUM_AGENTS", game.agents.number, ""),
        ("PAD", layout.pad, "cells around the map on each side"),
        ("FRAME", (layout.rows, layout.cols), "rows and columns of the padded map"),
        ("WINDOW", view_size(game), "rows and columns that an agent sees"),
        ("FORBIDS_ACTIONS", bool(game.agents.forbids), ""),
        ("ROLE", role_attribute(game), "attribute of State that holds the agents' roles"),
        ("EVENTS", events(game), events_comment),
    )
    if game.trials is not None:
        facts = (*facts, ("NUM_TRIALS", game.trials.number, "of an episode"))
    fields = Sequence(tuple(map(_state_field_call, described_fields(game))))
    return (
        *(Fact(name, constant(value), comment) for name, value, comment in facts),
        Fact("FIELDS", fields, "variables of the game, in State"),
    )


def _state_field_call(field: StateField) -> Expression:
    """Returns the call that describes a field of the state; defaults are left out."""
    arguments = {}
    for declared in dataclasses.fields(field):
        value = getattr(field, declared.name)
        if value != declared.default:
            arguments[declared.name] = value
    return call("StateField", **arguments)


def _used(
    functions: tuple[Function, ...], module: Module
) -> tuple[tuple[Constant, ...], tuple[Number, ...]]:
    """Returns the constants and numbers that functions use, in the order of their first use."""
    names = set()
    for function in functions:
        for node in walk(function):
            if isinstance(node, Name):
                names.add(node.identifier)
            elif isinstance(node, Literal):
                names.add(node.name)
    constants = tuple(c for c in module.constants.values() if c.name in names)
    numbers = [n for n in module.numbers.values() if n.name in names]
    groups = get_args(Group)
    return constants, tuple(sorted(numbers, key=lambda n: groups.index(n.group)))


def _constructor(name: str, class_: str, doc: str, fields: list[Field]) -> Function:
    """Returns the function that constructs the first value of a class."""
    defaults = {field.name: field.default for field in fields}
    return Function(name, (), class_, doc, (Return((call(class_, **defaults),)),))


def _reset(game: ir.Game, module: Module) -> Function:
    w = Writer(module)
    state = begun(game.start, _laid(game, module))
    for phase in game.starting:
        w.set(STATE, state)
        state = begun(phase, STATE)
    w.give_back(state)
    doc = "Returns the first state of an episode. `key`: two uint32 words."
    parameters = (("params", "Params"), ("key", "Array"))
    return Function("reset", parameters, "State", doc, live(w.body))


def _laid(game: ir.Game, module: Module) -> Expression:
    """Returns the state before `start`: what is declared, and the task of the episode."""
    if game.task is None:
        return call("initial_state")
    return task_of_episode(game.task, module)


def _step(turns: list[Turn], module: Module) -> Function:
    """Returns the function of a step.

    Unknown and forbidden actions become `stay`, marks of the last step go, then the phases follow
    in the order of the schedule.
    """
    w = Writer(module)
    is_unknown = (ACTIONS < 0) | (ACTIONS >= NUM_ACTIONS)
    w.set(ACTIONS, Where(is_unknown, STAY, ACTIONS))
    if module.game.agents.forbids:
        chosen = call("one_hot", ACTIONS, NUM_ACTIONS)
        is_open = call("allowed_actions", STATE, PARAMS) & chosen
        allowed = Name("allowed")
        w.set(allowed, reduction("any", is_open, (1,)))
        w.set(ACTIONS, Where(allowed, ACTIONS, STAY))
    w.set(OUT, call("no_outcome"))
    marks = [f"mark_{phase.name}" for phase in marking_phases(module.game)]
    if marks:
        changes: dict[str, Expression] = {}
        for mark in marks:
            changes[mark] = call("jnp.zeros_like", path(f"state.{mark}"))
        w.set(STATE, replaced("state", changes))
    marked = Name("marked")
    for turn in turns:
        results = (STATE, OUT, marked) if turn.marks else (STATE, OUT)
        arguments = (STATE, OUT, PARAMS, ACTIONS, KEY, *turn.arguments)
        w.unpack(results, call(turn.function.name, *arguments))
        if turn.marks:
            w.set(STATE, replaced("state", {turn.marks: marked}))
    counts = _shown_counts(w)
    if counts:
        w.set(STATE, replaced("state", counts))
    w.give_back(STATE, OUT)
    doc = (
        "Returns the state after one step and what it yielded. "
        "`actions`: `[N]` int32; `key`: two uint32 words."
    )
    parameters = (("state", "State"), ("actions", "Array"), ("params", "Params"), ("key", "Array"))
    return Function("step", parameters, "tuple[State, Outcome]", doc, live(w.body))


def _shown_counts(w: Writer) -> dict[str, Expression]:
    """Returns the counts of the step by the attribute of State that agents see."""
    game = w.game
    counts: dict[str, Expression] = {}
    shown = {(event.name, event.per_agent) for event in game.events if event.shown}
    for field in (*game.agents.fields, *game.fields):
        if (field.name, field.held_by == AGENTS) in shown:
            count = path(f"out.event_{param_attribute(field.name)}")
            most = call("jnp.minimum", count, int(field.type.high))
            counts[attribute_name(field)] = Cast(most, state_reads.storage(field, w))
    return counts


def _phase(phase: ir.Phase, pools: tuple[Pool, ...], module: Module) -> Function:
    """Returns the function of a phase."""
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
        w.changed[f"mark_{phase.name}"] = _all_marks(phase, w)
    w.give_back(replaced("state", w.changed), replaced("out", w.outcome))
    return Function(
        phase.name, PHASE, "tuple[State, Outcome]", _written(phase, module.sources), live(w.body)
    )


def _all_marks(phase: ir.Phase, w: Writer) -> Expression:
    """Returns the cells that a phase marks, with zeros for statements that never happen."""
    parts: list[Expression] = list(w.marked)
    missing = mark_size(phase, w.game) - sum(w.marked.values())
    if missing:
        parts.append(zeros("i32", missing))
    return concatenated(parts)


def _written(phase: ir.Phase, sources: Mapping[str, Source]) -> str:
    """Returns the text of a phase, from its first column on, or its name if that isn't known."""
    span = phase.origin
    if span is None or span.file not in sources:
        return f"Phase `{phase.label}`."
    text = sources[span.file].text[span.start : span.end]
    first, *others = text.splitlines()
    margin = re.compile(rf"\s{{0,{span.column - 1}}}")
    lines = [first]
    for line in others:
        lines.append(margin.sub("", line, count=1).rstrip())
    return "\n".join(lines)


def _tick(pools: Pools, module: Module) -> Function:
    """Returns the function between steps: timers fall, and agents that were away come back."""
    w = Writer(module, "tick")
    for field in all_fields(module.game):
        if field.timer:
            attribute = attribute_name(field)
            before = path(f"state.{attribute}")
            w.origin = field.origin
            w.assign(attribute, call("jnp.maximum", before, 1) - 1)
    w.origin = None
    doc = "All timers fall by one."
    away = [
        entity_type for entity_type in body_types(module.game) if module.stores_away(entity_type)
    ]
    if away:
        if w.changed:
            w.set(STATE, replaced("state", w.changed))
            w.changed.clear()
        bring_back(pools, away, w)
        plurals = " and ".join(entity_type.plural for entity_type in away)
        doc = f"All timers fall by one; {plurals} whose time away is over return."
    w.give_back(replaced("state", w.changed), OUT)
    return Function("tick", PHASE, "tuple[State, Outcome]", doc, live(w.body))


def _measures(module: Module) -> Function:
    """Returns the function that computes the metrics of a state."""
    w = Writer(module, "measures")
    values = {}
    for measure in module.game.measures:
        w.origin = measure.origin
        value = as_dtype(w.value(measure.value, IterationScope()), "f32")
        values[measure.name] = value.array.node
    w.origin = None
    w.give_back(constant(values))
    doc = "Returns the `mean` and `final` values at the end of a step: float32 scalars by name."
    return Function("measures", READING, "dict[str, Array]", doc, live(w.body))


def _lengths(module: Module) -> list[Function]:
    """Returns the functions of the steps of an episode, and of a trial if there are trials."""
    w = Writer(module)
    w.origin = module.game.episode.origin
    value = w.value(module.game.episode, IterationScope())
    w.give_back(as_array(value.node, "i32"))
    parameters = (("params", "Params"),)
    doc = "Returns the steps until truncation: int32 scalar."
    if module.game.trials is None:
        return [Function("episode_length", parameters, "Array", doc, live(w.body))]
    of_trial = "Returns the steps until a trial ends, unless an `end` does so: int32 scalar."
    trial = Function("trial_length", parameters, "Array", of_trial, live(w.body))
    length = Name("NUM_TRIALS") * call("trial_length", PARAMS)
    return [trial, Function("episode_length", parameters, "Array", doc, (Return((length,)),))]


def _observe(module: Module) -> Function:
    """Returns the function that makes observations."""
    w = Writer(module, "observe")
    planes = observe(w)
    w.origin = None
    w.give_back(planes)
    rows, cols = view_size(module.game)
    num_planes = len(token_planes(module.game))
    doc = (
        f"Returns what each agent sees: `[N, {num_planes}, {rows}, {cols}]` uint8; "
        "planes as in TOKEN_PLANES."
    )
    return Function("observe", READING, "Array", doc, live(w.body))


__all__ = ["NotSupported", "lower", "new_module", "token_planes"]
