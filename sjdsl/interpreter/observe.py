"""Interprets `observe`.

The egocentric window of each agent, rotated so that its heading points up.
"""

from typing import assert_never

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import seen_heading, shown_field, shows_attribute
from sjdsl.interpreter import planes
from sjdsl.interpreter.board import Board, board_of
from sjdsl.interpreter.bodies import heading_of
from sjdsl.interpreter.evaluate import evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.members import agent_on, is_on_map
from sjdsl.interpreter.shapes import place_at
from sjdsl.interpreter.state import Cell, Mover, World


def observe(game: ir.Game, world: World) -> np.ndarray:
    """Returns uint8 `[agents, planes, rows, columns]`, zeros for an agent that is away."""
    board = board_of(game)
    window = game.window
    rows = window.ahead + 1 + window.behind
    cols = window.left + 1 + window.right
    observation = np.zeros((board.agents, len(board.planes), rows, cols), np.uint8)
    for agent, place in enumerate(world.position):
        if place is None:
            continue
        instance = Instance(board, world, names={"agent": agent})
        visible = visible_cells(window, agent, place, instance)
        for index, plane in enumerate(board.planes):
            if plane.what in ("everyone", "own", "world"):  # the same in the whole window
                inner = instance
                if plane.agent is not None:
                    inner = instance.binding({"everyone": plane.agent})
                observation[agent, index] = _token(_observable_of(plane), inner, 0)
                continue
            for row, col, cell in visible:
                observation[agent, index, row, col] = _token_at(plane, cell, agent, instance)
    return observation


def visible_cells(
    window: ir.Window, agent: int, place: Cell, instance: Instance
) -> list[tuple[int, int, Cell]]:
    """Returns row and column in the window of each cell that an observer sees, and the cell."""
    views = (
        view
        for view in window.views
        if view.condition is None or evaluate(view.condition, instance)
    )
    view = next(views, window)
    heading = instance.world.heading[agent]
    visible = []
    for ahead in range(view.ahead, -view.behind - 1, -1):
        for right in range(-view.left, view.right + 1):
            cell = instance.board.at(*place_at(place, heading, ahead, right))
            if cell is not None:
                visible.append((window.ahead - ahead, window.left + right, cell))
    return visible


def _token_at(plane: planes.Plane, cell: Cell, agent: int, instance: Instance) -> int:
    """Returns the token of one plane at one cell of the map."""
    match plane.what:
        case "content":
            return _content_token(cell, instance)
        case "agent":
            return _agent_token(cell, agent, instance)
        case "marks":
            if _hides_marks(cell, instance):
                return 0
            return sum(
                1 << bit
                for bit, phase in enumerate(instance.board.marking)
                if (phase.name, *cell) in instance.world.marks
            )
        case "other":
            other = _visible_agent(cell, instance)
            if other in (None, agent):
                return 0
            inner = instance.binding({"other": other})
            return _token(_observable_of(plane), inner, first=1 if plane.labels else 0)
        case "mover":
            return _mover_token(_observable_of(plane), cell, agent, instance)
        case "everyone" | "own" | "world":
            raise AssertionError(plane)
        case _:
            assert_never(plane.what)


def _content_token(cell: Cell, instance: Instance) -> int:
    """Returns the token of what a cell is: its kind and visible fields, or its look."""
    game = instance.board.game
    kind = instance.board.kind_of[cell]
    covers_content = any(hidden.what == "content" for hidden in game.hidden)
    if covers_content and _visible_agent(cell, instance) is not None:
        return instance.board.content_codes[planes.COVERED]
    inner = instance.binding({kind: cell})
    look = planes.look_of(game, kind)
    if look is not None:
        return instance.board.content_codes[_label(look, inner)]
    content = kind
    for observable in planes.content_observables(game, kind):
        is_hidden = _is_hidden(observable, inner)
        label = planes.HIDDEN if is_hidden else _label(observable, inner)
        content += f" {planes.field_name(observable)}={label}"
    return instance.board.content_codes[content]


def _visible_agent(cell: Cell, instance: Instance) -> int | None:
    """Returns the agent that is seen on a cell."""
    agent = agent_on(cell, instance.world)
    return agent if agent is not None and is_on_map(agent, instance.world) else None


def _hides_marks(cell: Cell, instance: Instance) -> bool:
    """Returns whether marks on a cell are invisible."""
    for hidden in instance.board.game.hidden:
        if hidden.what == "marks" and hidden.on == "agents":
            if _visible_agent(cell, instance) is not None:
                return True
        if hidden.on == "cells" and instance.board.kind_of.get(cell) in hidden.kinds:
            if hidden.when is None or evaluate(hidden.when, instance.binding({hidden.name: cell})):
                return True
    return False


def _agent_token(cell: Cell, agent: int, instance: Instance) -> int:
    """Returns the token of who stands on a cell and how it faces: an index into AGENT_WORDS."""
    other = _visible_agent(cell, instance)
    if other is None:
        return 0
    if other == agent:
        return 1
    words = planes.agent_words(instance.board.game)
    heading = seen_heading(instance.board.game)
    if heading is None or _is_hidden(heading, instance.binding({"other": other})):
        return words.index("other")
    return 2 + (instance.world.heading[other] - instance.world.heading[agent]) % 4


def _mover_token(observable: ir.Observable, cell: Cell, agent: int, instance: Instance) -> int:
    """Returns the token of a mover on a cell, 0 where there is none."""
    entity_type = observable.kind
    places = instance.world.movers[entity_type].position
    if cell not in places:
        return 0
    mover = Mover(entity_type, places.index(cell))
    inner = instance.binding({entity_type: mover})
    is_hidden = _is_hidden(observable, inner)
    if not observable.field:
        return int(not is_hidden)
    if observable.field == "heading" and not observable.labels and not is_hidden:
        return 1 + (heading_of(mover, instance.world) - instance.world.heading[agent]) % 4
    has_labels = bool(planes.observable_words(observable))
    return _token(observable, inner, first=1 if has_labels else 0)


def _token(observable: ir.Observable, instance: Instance, first: int) -> int:
    """Returns the index of the observable's label, counted from `first`, or its number.

    It is 0 if the observable is hidden and has no label for that, or if its owner is off the map.
    """
    labels = planes.observable_words(observable)
    if _is_hidden(observable, instance):
        has_label = labels and observable.shown_when is not None
        return first + labels.index(planes.HIDDEN) if has_label else 0
    if labels:
        return first + labels.index(_label(observable, instance))
    is_place = observable.what == "everyone" and observable.field in ("row", "col")
    if is_place and not is_on_map(instance.names["everyone"], instance.world):
        return 0
    return min(max(int(evaluate(_expression_of(observable, instance.board), instance)), 0), 255)


def _label(observable: ir.Observable, instance: Instance) -> str:
    """Returns the first label whose condition holds, or the value as text without one."""
    for label in observable.labels:
        if label.condition is None or evaluate(label.condition, instance):
            return label.name
    value = evaluate(_expression_of(observable, instance.board), instance)
    if isinstance(value, bool):
        return "yes" if value else "no"
    return str(value)


def _is_hidden(observable: ir.Observable, instance: Instance) -> bool:
    """Returns whether an observer may not see an observable."""
    if observable.shown_when is not None and not evaluate(observable.shown_when, instance):
        return True
    return observable.hidden_when is not None and evaluate(observable.hidden_when, instance)


def _expression_of(observable: ir.Observable, board: Board) -> ir.Expr:
    """Returns the expression that an observable shows.

    The board caches it: to build an expression takes longer than to evaluate it.
    """
    if id(observable) not in board.read:
        board.read[id(observable)] = (observable, _build_expression(observable, board))
    _, expression = board.read[id(observable)]
    return expression


def _build_expression(observable: ir.Observable, board: Board) -> ir.Expr:
    """Returns the expression that an observable shows, built anew."""
    if observable.value is not None:
        return observable.value
    owner = observable.owner
    if owner is not None and shows_attribute(observable):
        type_ = ir.CONDITION if observable.field in ("moved", "away") else observable.type
        return ir.Attribute(type=type_, owner=owner, name=observable.field)  # type: ignore[arg-type]
    declared = shown_field(board.game, observable)
    field = ir.FieldRead(
        type=declared.type, owner=owner, held_by=declared.held_by, name=observable.field
    )
    if observable.word is None:
        return field
    inner = declared.type.model_copy(update={"indexed_by": declared.type.indexed_by[1:]})
    key = ir.Word(
        type=ir.Type(kind="word", words=observable.word.index_set.names), value=observable.word.name
    )
    return ir.At(type=inner, row=field, key=key)


def _observable_of(plane: planes.Plane) -> ir.Observable:
    """Returns the observable of a plane that has one."""
    assert plane.observable is not None, plane
    return plane.observable
