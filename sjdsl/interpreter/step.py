"""Interprets one reset and one step: forbidden actions, the turns of the schedule, rewards, events,
metrics, the end."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, assert_never

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import action_named, beginning_phases, event_named
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
from sjdsl.interpreter.state import HEADINGS, Outcome, Value, World, copied, default_params
from sjdsl.interpreter.stored import held_values
from sjdsl.interpreter.tasks import fix_parts, key_of_task
from sjdsl.interpreter.threefry import Draws, Threefry
from sjdsl.interpreter.writes import Counted, Writes, write_fields

# (event, its enum value or None) -> its count so far, over all agents
Totals = Mapping[tuple[str, str | None], int]


def reset(
    game: ir.Game,
    params: Mapping[str, Value],
    draws: Draws,
    tell: Tell | None = None,
    sends: bool = True,
) -> World:
    """Returns the state that an episode starts from.

    Args:
      tell: called with the account of each phase that is played.
      sends: whether the `send` statements of `start` are performed; without them nobody has a
        place, and no other phase is played: that is for `play_starting`.
    """
    board = board_of(game)
    laid = declared_world(board, dict(params))
    if game.task is not None:
        laid = _with_task(board, laid, draws, tell)
    if not sends:
        return _phase(
            game.start, _starting(board, laid, draws), _empty_outcome(board), tell, sends=False
        )
    world = laid
    for phase in beginning_phases(game):
        world = _begun(phase, board, world, draws, tell)
    return world


def task_of_key(game: ir.Game, key: tuple[int, int]) -> dict[str, Value]:
    """Returns the values of the task's fields, those of a row as a tuple, that a key gives."""
    board = board_of(game)
    assert game.task is not None, game.name
    laid = declared_world(board, default_params(game))
    fields = _with_task(board, laid, Threefry(*key), None).fields
    return {name: fields[name] for name in game.task.fields}


def _with_task(board: Board, laid: World, draws: Draws, tell: Tell | None) -> World:
    """Returns the state before `start` with the task of an episode."""
    task = board.game.task
    assert task is not None
    chosen = task.draw.model_copy(update={"label": f"{task.draw.label}, the tasks that are played"})

    def drawn(key: Draws, tell: Tell | None = None) -> World:
        any_task = _phase(task.draw, _starting(board, laid, key), _empty_outcome(board), tell)
        world = copied(any_task)
        fix_parts(world, board, key)
        if tell is not None:
            tell(Account(chosen, any_task, world))
        return world

    return drawn(key_of_task(board, draws, drawn), tell)


def play_starting(game: ir.Game, world: World, draws: Draws) -> World:
    """Returns the state after the phases that follow `start`, of a state in which somebody else
    has placed everybody, and does so again: no `send` to a random cell is performed."""
    board = board_of(game)
    for phase in game.starting:
        instance = _starting(board, world, draws)
        world = _phase(phase, instance, _empty_outcome(board), None, sends=False)
    return world


def _begun(phase: ir.Phase, board: Board, before: World, draws: Draws, tell: Tell | None) -> World:
    """Returns the state after a phase with which an episode or a trial begins."""
    world = _phase(phase, _starting(board, before, draws), _empty_outcome(board), tell)
    for body in bodies(world):
        has_place = where_is(body, world) is not None or away_of(body, world) is not None
        assert has_place, f"{body} has no place"
    return world


def _starting(board: Board, world: World, draws: Draws) -> Instance:
    """Returns an instance of a phase that comes before the first step, when everybody stays."""
    stay = board.game.agents.actions.index("stay")
    return Instance(board, world, (stay,) * board.agents, draws)


def _next_trial(board: Board, ended: World, draws: Draws, tell: Tell | None) -> World:
    """Returns the first state of the trial after that which ended: as after a reset, but for the
    fields that are kept. What the phases of its beginning write to those is lost."""
    world = declared_world(board, ended.params)
    _keep(ended, world, board)
    world.fields["trial"] += 1
    for phase in beginning_phases(board.game):
        begun = _begun(phase, board, world, draws, tell)
        _keep(world, begun, board)
        world = begun
    return world


def _keep(before: World, after: World, board: Board) -> None:
    """Gives the kept fields in `after` the values that they have in `before`."""
    assert board.game.trials is not None
    of_task = () if board.game.task is None else board.game.task.fields
    for name in ("trial", *of_task):
        after.fields[name] = before.fields[name]
    for kept in board.game.trials.kept:
        if kept.held_by.what == "world":
            after.fields[kept.name] = before.fields[kept.name]
        else:
            declared = board.fields[kept.held_by.name, kept.name]
            held_values(declared, after)[:] = held_values(declared, before)


def step(
    game: ir.Game,
    world: World,
    actions: Sequence[int],
    params: Mapping[str, Value],
    draws: Draws,
    tell: Tell | None = None,
) -> tuple[World, Outcome]:
    """Returns the next state and the other results of the step. `world` isn't changed.

    After the last step of a trial that isn't the last, the state is the first of the next trial.
    `tell` is called with an account of every turn. Raises LeavesFloat32.
    """
    board = board_of(game)
    world = copied(world)
    world.params = dict(params)
    allowed = _allowed(board, world, actions)
    world.marks = []
    outcome = _empty_outcome(board)
    for turn in game.schedule:
        instance = Instance(board, world, allowed, draws)
        match turn:
            case ir.Phase():
                world = _phase(turn, instance, outcome, tell)
            case ir.Tick():
                world = _tick(instance)
                if tell is not None:
                    tell(Account(turn, instance.world, world, actions=allowed))
            case _:
                assert_never(turn)
    for event in game.events:
        if event.shown:
            _show_counts(event, outcome, world)
    for measure in game.measures:
        outcome.measures[measure.name] = _measured(measure, Instance(board, world, allowed))
    world.step += 1
    outcome.truncated = world.step >= evaluate(game.episode, Instance(board, world))
    is_over = outcome.truncated or outcome.terminated
    if is_over and game.trials is not None and world.fields["trial"] + 1 < game.trials.number:
        outcome.truncated = outcome.terminated = False
        outcome.last_of_trial = world
        world = _next_trial(board, world, draws, tell)
    return world, outcome


def action_mask(game: ir.Game, world: World) -> list[list[bool]]:
    """Returns which actions of each agent aren't forbidden in a state."""
    board = board_of(game)
    mask = []
    for agent in range(board.agents):
        forbidden = _forbidden(board, world, agent)
        mask.append([number not in forbidden for number in range(len(game.agents.actions))])
    return mask


def read(
    game: ir.Game,
    world: World,
    e: ir.Expr,
    totals: Totals | None = None,
    before: tuple[World, Totals] | None = None,
) -> Value:
    """Returns the value of an expression of `checks`.

    `before` is the state before the step, and the totals then; by default the current ones.
    """
    board = board_of(game)
    instance = Instance(board, world, totals=totals or {})
    earlier = instance
    if before is not None:
        world_before, totals_before = before
        earlier = Instance(board, world_before, totals=totals_before)
    with watched(lambda: e, world.step):
        return evaluate(e, replace(instance, earlier=earlier))


def _measured(measure: ir.Measure, instance: Instance) -> Value:
    with watched(lambda: measure, instance.world.step):
        return evaluate(measure.value, instance)


def _forbidden(board: Board, world: World, agent: int) -> set[int]:
    """Returns the actions that an agent may not take now; `stay` is never one."""
    instance = Instance(board, world, names={"agent": agent})
    forbidden: set[int] = set()
    for forbid in board.game.agents.forbids:
        forbidden.update(_forbidden_by(forbid, instance))
    return forbidden - {board.game.agents.actions.index("stay")}


def _forbidden_by(forbid: ir.Forbid, instance: Instance) -> Iterator[int]:
    """Yields the actions that one `forbid` forbids; it may name the arguments of an action."""
    if not forbid.names:
        if evaluate(forbid.condition, instance):
            yield from forbid.actions
        return
    for action in forbid.actions:
        values = arguments_of(action_named(instance.board.game, forbid.action), action)
        assert values is not None, (forbid, action)
        arguments = {name: value for name, value in zip(forbid.names, values, strict=True) if name}
        if evaluate(forbid.condition, instance.binding(arguments)):
            yield action


def _allowed(board: Board, world: World, actions: Sequence[int]) -> tuple[int, ...]:
    """Returns the actions with `stay` in place of unknown and forbidden ones."""
    names = board.game.agents.actions
    stay = names.index("stay")
    allowed = []
    for agent, action in enumerate(actions):
        is_allowed = 0 <= action < len(names) and action not in _forbidden(board, world, agent)
        allowed.append(int(action) if is_allowed else stay)
    return tuple(allowed)


def _phase(
    phase: ir.Phase, instance: Instance, outcome: Outcome, tell: Tell | None, sends: bool = True
) -> World:
    """Returns the state after a phase: all reads are of the state before it, all writes appear
    together."""
    writes = Writes() if tell is None else Writes(done=[], drawn=[])
    with watched(lambda: phase, instance.world.step):
        perform(phase.body, instance, writes)
    world = copied(instance.world)
    with watched(lambda: _adding(phase, ir.Add), instance.world.step):
        write_fields(writes, instance.board, world)
    if id(phase) in instance.board.moving:
        assert not writes.sends, f"`{phase.label}` moves and sends"
        move(writes.entity_type, writes.movers or {}, writes.courses, instance, world)
    headings: dict[int, str] = {}
    for turned, heading in writes.turns:
        assert headings.setdefault(turned, heading) == heading, f"agent {turned} turns two ways"
        world.heading[turned] = HEADINGS.index(heading)
    send(phase.name, writes.sends if sends else [], instance, world)
    for agent in writes.removes:
        assert agent not in {s.agent for s in writes.sends}, f"agent {agent} is sent and removed"
        remove(agent, world)
    shift(writes.shifts, instance, world)
    world.marks += [(phase.name, *cell) for cell in sorted(writes.marks)]
    with watched(lambda: _adding(phase, ir.Give), instance.world.step):
        rewards: dict[int, list[np.float32]] = {}
        for agent, value in writes.gives:
            rewards.setdefault(agent, []).append(value)
        for agent, values in rewards.items():
            outcome.reward[agent] = added_up([outcome.reward[agent], *values])
    for counted in writes.tallies:
        _count(counted, instance.board, outcome)
    outcome.terminated = outcome.terminated or writes.end
    _check_places(instance.board, world)
    if tell is not None:
        done = tuple(writes.done or ())
        drawn = tuple(writes.drawn or ())
        tell(Account(phase, instance.world, world, done, drawn, instance.actions))
    return world


def _adding(phase: ir.Phase, class_: type[ir.Add | ir.Give]) -> ir.Node:
    """Returns the last statement of a class that adds reals; the phase if there is none."""
    statements = [
        node
        for node in ir.walk(phase)
        if isinstance(node, class_) and node.value.type.kind == "real"
    ]
    return statements[-1] if statements else phase


def _tick(instance: Instance) -> World:
    """Returns the state after `tick`: timers first, then the agents that come back see the new
    ones.
    """
    world = copied(instance.world)
    board = instance.board
    for declared in board.fields.values():
        if declared.timer and declared.held_by.what == "world":
            world.fields[declared.name] = _counted_down(world.fields[declared.name])
        elif declared.timer:
            values = held_values(declared, world)
            values[:] = map(_counted_down, values)
    bring_back(Instance(board, copied(world), instance.actions, instance.draws), world)
    _check_places(board, world)
    return world


def _counted_down(timer: Value) -> Value:
    if isinstance(timer, tuple):
        return tuple(_counted_down(entry) for entry in timer)
    return max(0, timer - 1)


def _empty_outcome(board: Board) -> Outcome:
    """Returns an outcome in which nothing has happened."""
    events: dict[str, Any] = {}
    for event in board.game.events:
        counts = [[0] * len(event.by) if event.by else 0 for _ in range(board.agents)]
        events[event.name] = counts if event.per_agent else counts[0]
    return Outcome(reward=[np.float32(0)] * board.agents, events=events)


def _count(counted: Counted, board: Board, outcome: Outcome) -> None:
    """Adds one tally to the counts of its event."""
    event = event_named(board.game, counted.event)
    counts: Any = outcome.events
    index: Any = event.name
    if event.per_agent:
        assert counted.agent is not None, event.name
        counts = counts[index]
        index = counted.agent
    if event.by:
        assert counted.word is not None, event.name
        counts = counts[index]
        index = entry_place(event.by, counted.word)
    counts[index] += counted.amount
    check_int32(counts[index], counted.event)


def _show_counts(event: ir.Event, outcome: Outcome, world: World) -> None:
    """Writes the counts of an event to the field that agents see."""
    counts: Any = outcome.events[event.name]
    if event.per_agent:
        world.agents[event.name] = [_shown(count) for count in counts]
    else:
        world.fields[event.name] = _shown(counts)


def _shown(counts: Any) -> Value:
    """Returns a count, or counts by word, as a plane can show them."""
    return tuple(map(_shown, counts)) if isinstance(counts, list) else min(counts, 255)


def _check_places(board: Board, world: World) -> None:
    """Asserts that nobody shares a cell or stands outside the map."""
    places = [place for body in bodies(world) if (place := where_is(body, world)) is not None]
    assert len(set(places)) == len(places), f"two on one cell: {world.position}, {world.movers}"
    assert all(place in board.kind_of for place in places), places
    assert all(
        where_is(body, world) is None or away_of(body, world) is None for body in bodies(world)
    )
