"""Interprets one reset and one step: forbidden actions, the turns of the schedule, rewards, events, metrics, the end."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, assert_never

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import action_named, event_named
from sjdsl.interpreter.account import Account, Tell
from sjdsl.interpreter.board import Board, board_of, declared_world
from sjdsl.interpreter.bodies import away_of, bodies, where_is
from sjdsl.interpreter.evaluate import arguments_of, entry_place, evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.movement import move
from sjdsl.interpreter.numbers import added_up, check_int32
from sjdsl.interpreter.overflow import watched
from sjdsl.interpreter.perform import perform
from sjdsl.interpreter.sending import bring_back, remove, send
from sjdsl.interpreter.shifting import shift
from sjdsl.interpreter.state import Outcome, Value, World, copied
from sjdsl.interpreter.stored import held_values
from sjdsl.interpreter.threefry import Draws
from sjdsl.interpreter.writes import Counted, Writes, write_fields

Totals = Mapping[
    tuple[str, str | None], int
]  # (event, its word or None) -> its count so far, over all agents


def reset(
    game: ir.Game,
    params: Mapping[str, Value],
    draws: Draws,
    tell: Tell | None = None,
    sends: bool = True,
) -> World:
    """Returns the state an episode starts from; without the `sends` of the phase `start` nobody has a place in it.

    `tell` is given the account of that phase.
    """
    board = board_of(game)
    world = declared_world(board, dict(params))
    stays = (game.agents.actions.index("stay"),) * board.agents
    world = _phase(
        game.start, Instance(board, world, stays, draws), _nothing_yet(board), tell, sends
    )
    placed = all(
        where_is(body, world) is not None or away_of(body, world) is not None
        for body in bodies(world)
    )
    assert placed or not sends, "somebody has no place"
    return world


def step(
    game: ir.Game,
    world: World,
    actions: Sequence[int],
    params: Mapping[str, Value],
    draws: Draws,
    tell: Tell | None = None,
) -> tuple[World, Outcome]:
    """Returns the next state and what happened on the way. `world` is left as it was. `tell` is given an account of every turn.

    Raises LeavesFloat32.
    """
    board = board_of(game)
    world = copied(world)
    world.params = dict(params)
    allowed = _allowed(board, world, actions)
    world.marks = []
    outcome = _nothing_yet(board)
    for turn in game.schedule:
        here = Instance(board, world, allowed, draws)
        match turn:
            case ir.Phase():
                world = _phase(turn, here, outcome, tell)
            case ir.Tick():
                world = _tick(here)
                if tell is not None:
                    tell(Account(turn, here.world, world, actions=allowed))
            case _:
                assert_never(turn)
    outcome.measures = {
        m.name: _measured(m, Instance(board, world, allowed)) for m in game.measures
    }
    world.step += 1
    outcome.truncated = world.step >= evaluate(game.episode, Instance(board, world))
    return world, outcome


def action_mask(game: ir.Game, world: World) -> list[list[bool]]:
    """Returns for each agent which actions would not be forbidden now."""
    board = board_of(game)
    numbers = range(len(game.agents.actions))
    return [
        [number not in _forbidden(board, world, agent) for number in numbers]
        for agent in range(board.agents)
    ]


def read(
    game: ir.Game,
    world: World,
    e: ir.Expr,
    totals: Totals | None = None,
    before: tuple[World, Totals] | None = None,
) -> Value:
    """Returns the value of an expression of `checks`. `before`: the state before the step, and the totals then; None: the same ones."""
    board = board_of(game)
    here = Instance(board, world, totals=totals or {})
    earlier = here if before is None else Instance(board, before[0], totals=before[1])
    with watched(lambda: e, world.step):
        return evaluate(e, replace(here, earlier=earlier))


def _measured(measure: ir.Measure, here: Instance) -> Value:
    with watched(lambda: measure, here.world.step):
        return evaluate(measure.value, here)


def _forbidden(board: Board, world: World, agent: int) -> set[int]:
    here, agents = Instance(board, world, names={"agent": agent}), board.game.agents
    return {action for forbid in agents.forbids for action in _closed(forbid, here)} - {
        agents.actions.index("stay")
    }


def _closed(forbid: ir.Forbid, here: Instance) -> Iterator[int]:
    """Yields the actions that one `forbid` closes; the arguments that it names have their values while it looks at an action."""
    if not forbid.names:
        yield from forbid.actions if evaluate(forbid.condition, here) else ()
        return
    for action in forbid.actions:
        values = arguments_of(action_named(here.board.game, forbid.action), action)
        assert values is not None, (forbid, action)
        named = {name: value for name, value in zip(forbid.names, values, strict=True) if name}
        if evaluate(forbid.condition, here.binding(named)):
            yield action


def _allowed(board: Board, world: World, actions: Sequence[int]) -> tuple[int, ...]:
    """Returns the actions taken; unknown and forbidden ones have become `stay`."""
    names = board.game.agents.actions
    stay = names.index("stay")
    return tuple(
        int(action)
        if 0 <= action < len(names) and action not in _forbidden(board, world, agent)
        else stay
        for agent, action in enumerate(actions)
    )


def _phase(
    phase: ir.Phase, here: Instance, outcome: Outcome, tell: Tell | None, sends: bool = True
) -> World:
    """Returns the state after a phase: everything is read from `here.world`, all writes appear together."""
    writes = Writes() if tell is None else Writes(done=[], drawn=[])
    with watched(lambda: phase, here.world.step):
        perform(phase.body, here, writes)
    world = copied(here.world)
    with watched(lambda: _adding(phase, ir.Add), here.world.step):
        write_fields(writes, here.board, world)
    if id(phase) in here.board.moving:
        assert not writes.sends, f"`{phase.label}` moves and sends"
        move(writes.sort, writes.movers or {}, writes.courses, here, world)
    send(phase.name, writes.sends if sends else [], here, world)
    for agent in writes.removes:
        assert agent not in {s.agent for s in writes.sends}, f"agent {agent} is sent and removed"
        remove(agent, world)
    shift(writes.shifts, here, world)
    world.marks += [(phase.name, *cell) for cell in sorted(writes.marks)]
    with watched(lambda: _adding(phase, ir.Give), here.world.step):
        given: dict[int, list[np.float32]] = {}
        for agent, value in writes.gives:
            given.setdefault(agent, []).append(value)
        for agent, values in given.items():
            outcome.reward[agent] = added_up([outcome.reward[agent], *values])
    for counted in writes.tallies:
        _count(counted, here.board, outcome)
    outcome.terminated = outcome.terminated or writes.end
    _check_places(here.board, world)
    if tell is not None:
        tell(
            Account(
                phase,
                here.world,
                world,
                tuple(writes.done or ()),
                tuple(writes.drawn or ()),
                here.actions,
            )
        )
    return world


def _adding(phase: ir.Phase, sort: type[ir.Add | ir.Give]) -> ir.Node:
    """Returns the statement of a phase in which reals are added up, the last one written; the phase if it has none."""
    found = [n for n in ir.walk(phase) if isinstance(n, sort) and n.value.type.kind == "real"]
    return found[-1] if found else phase


def _tick(here: Instance) -> World:
    """Returns the state after `tick`: timers first, then the agents that come back see the new ones."""
    world = copied(here.world)
    board = here.board
    for declared in board.fields.values():
        if declared.timer and declared.held_by.what == "world":
            world.fields[declared.name] = _fallen(world.fields[declared.name])
        elif declared.timer:
            values = held_values(declared, world)
            values[:] = map(_fallen, values)
    bring_back(Instance(board, copied(world), here.actions, here.draws), world)
    _check_places(board, world)
    return world


def _fallen(value: Value) -> Value:
    return tuple(_fallen(v) for v in value) if isinstance(value, tuple) else max(0, value - 1)


def _nothing_yet(board: Board) -> Outcome:
    events: dict[str, Any] = {}
    for event in board.game.events:
        agents = range(board.agents)
        count = [0] * len(event.by or ())
        events[event.name] = (
            [list(count) if event.by else 0 for _ in agents] if event.per_agent else (count or 0)
        )
    return Outcome(reward=[np.float32(0) for _ in range(board.agents)], events=events)


def _count(counted: Counted, board: Board, outcome: Outcome) -> None:
    event = event_named(board.game, counted.event)
    holder: Any = outcome.events
    place: Any = event.name
    if event.per_agent:
        assert counted.agent is not None, event.name
        holder, place = holder[place], counted.agent
    if event.by:
        assert counted.word is not None, event.name
        holder, place = holder[place], entry_place(event.by, counted.word)
    holder[place] += counted.amount
    check_int32(holder[place], counted.event)


def _check_places(board: Board, world: World) -> None:
    places = [place for body in bodies(world) if (place := where_is(body, world)) is not None]
    assert len(set(places)) == len(places), f"two on one cell: {world.position}, {world.movers}"
    assert all(place in board.kind_of for place in places), places
    assert all(
        where_is(body, world) is None or away_of(body, world) is None for body in bodies(world)
    )
