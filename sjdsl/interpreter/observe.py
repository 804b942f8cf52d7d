"""Interprets `observe`: the egocentric window of each agent, rotated so that its heading points up."""

from typing import assert_never

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import shown_field, shows_attribute
from sjdsl.interpreter import planes
from sjdsl.interpreter.board import Board, board_of
from sjdsl.interpreter.bodies import heading_of
from sjdsl.interpreter.evaluate import evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.members import agent_on, is_here
from sjdsl.interpreter.shapes import place_at
from sjdsl.interpreter.state import Cell, Mover, World


def observe(game: ir.Game, world: World) -> np.ndarray:
    """Returns uint8 `[agents, planes, rows, columns]`; who is away sees zeros."""
    board, window = board_of(game), game.window
    all_planes = board.planes
    rows, columns = window.ahead + 1 + window.behind, window.left + 1 + window.right
    picture = np.zeros((board.agents, len(all_planes), rows, columns), np.uint8)
    for agent, place in enumerate(world.position):
        if place is None:
            continue
        here = Instance(board, world, names={"agent": agent})
        seen = _seen_cells(window, agent, place, here)
        for number, plane in enumerate(all_planes):
            if plane.what in ("everyone", "own", "world"):  # the same in the whole window
                inside = here if plane.agent is None else here.binding({"everyone": plane.agent})
                picture[agent, number] = _shown(_observable(plane), inside, 0)
                continue
            for row, column, cell in seen:
                picture[agent, number, row, column] = _value(plane, cell, agent, here)
    return picture


def _seen_cells(
    window: ir.Window, agent: int, place: Cell, here: Instance
) -> list[tuple[int, int, Cell]]:
    """Returns the rows and columns of the window in which an observer sees a cell of the map, with these cells; the others show zeros."""
    views = (
        view for view in window.views if view.condition is None or evaluate(view.condition, here)
    )
    view, heading = next(views, window), here.world.heading[agent]
    found = []
    for row in range(window.ahead + 1 + window.behind):
        for column in range(window.left + 1 + window.right):
            ahead, right = window.ahead - row, column - window.left
            if -view.behind <= ahead <= view.ahead and -view.left <= right <= view.right:
                cell = here.board.at(*place_at(place, heading, ahead, right))
                found += [] if cell is None else [(row, column, cell)]
    return found


def _value(plane: planes.Plane, cell: Cell, agent: int, here: Instance) -> int:
    """Returns what one plane shows at one cell of the map."""
    match plane.what:
        case "content":
            return _content(cell, here)
        case "agent":
            return _agent(cell, agent, here)
        case "marks":
            if _hides_marks(cell, here):
                return 0
            return sum(
                1 << bit
                for bit, phase in enumerate(here.board.marking)
                if (phase.name, *cell) in here.world.marks
            )
        case "other":
            other = _somebody(cell, here)
            return (
                0
                if other in (None, agent)
                else _shown(_observable(plane), here.binding({"other": other}), bool(plane.labels))
            )
        case "mover":
            return _mover(_observable(plane), cell, agent, here)
        case "everyone" | "own" | "world":
            raise AssertionError(plane)
        case _:
            assert_never(plane.what)


def _content(cell: Cell, here: Instance) -> int:
    kind = here.board.kind_of[cell]
    if _somebody(cell, here) is not None and any(
        hidden.what == "content" for hidden in here.board.game.hidden
    ):
        return here.board.content_codes[planes.COVERED]
    whole = planes.look_of(here.board.game, kind)
    if whole is not None:
        return here.board.content_codes[_word(whole, here.binding({kind: cell}))]
    label = kind
    for observable in planes.content_observables(here.board.game, kind):
        inside = here.binding({kind: cell})
        word = planes.HIDDEN if _is_hidden(observable, inside) else _word(observable, inside)
        label += f" {planes.field_name(observable)}={word}"
    return here.board.content_codes[label]


def _somebody(cell: Cell, here: Instance) -> int | None:
    """Returns the agent that is seen on a cell."""
    agent = agent_on(cell, here.world)
    return agent if agent is not None and is_here(agent, here.world) else None


def _hides_marks(cell: Cell, here: Instance) -> bool:
    """Returns whether no marks are seen of a cell."""
    for hidden in here.board.game.hidden:
        if hidden.what == "marks" and hidden.on == "agents" and _somebody(cell, here) is not None:
            return True
        if hidden.on == "cells" and here.board.kind_of.get(cell) in hidden.kinds:
            if hidden.when is None or evaluate(hidden.when, here.binding({hidden.name: cell})):
                return True
    return False


def _agent(cell: Cell, agent: int, here: Instance) -> int:
    other = _somebody(cell, here)
    if other is None:
        return 0
    if other == agent:
        return 1
    return 2 + (here.world.heading[other] - here.world.heading[agent]) % 4


def _mover(observable: ir.Observable, cell: Cell, agent: int, here: Instance) -> int:
    """Returns what is seen of a mover on a cell, 0 where none is."""
    sort = observable.kind
    places = here.world.movers[sort].position
    if cell not in places:
        return 0
    mover = Mover(sort, places.index(cell))
    inside = here.binding({sort: mover})
    hidden = _is_hidden(observable, inside)
    if not observable.field:
        return int(not hidden)
    if observable.field == "heading" and not observable.labels and not hidden:
        return 1 + (heading_of(mover, here.world) - here.world.heading[agent]) % 4
    return _shown(observable, inside, bool(planes.observable_words(observable)))


def _shown(observable: ir.Observable, here: Instance, first: int) -> int:
    """Returns the index of the observable's word, counted from `first`, or its number; 0 if it is hidden, or not there."""
    words = planes.observable_words(observable)
    if _is_hidden(observable, here):
        return (
            first + words.index(planes.HIDDEN) if words and observable.shown_when is not None else 0
        )
    if words:
        return first + words.index(_word(observable, here))
    if (
        observable.what == "everyone"
        and observable.field in ("row", "col")
        and not is_here(here.names["everyone"], here.world)
    ):
        return 0
    return min(max(int(evaluate(_expression_of(observable, here.board), here)), 0), 255)


def _word(observable: ir.Observable, here: Instance) -> str:
    for label in observable.labels:
        if label.condition is None or evaluate(label.condition, here):
            return label.name
    value = evaluate(_expression_of(observable, here.board), here)
    if isinstance(value, bool):
        return "yes" if value else "no"
    return str(value)


def _is_hidden(observable: ir.Observable, here: Instance) -> bool:
    if observable.shown_when is not None and not evaluate(observable.shown_when, here):
        return True
    return observable.hidden_when is not None and evaluate(observable.hidden_when, here)


def _expression_of(observable: ir.Observable, board: Board) -> ir.Expr:
    """Returns the expression an observable shows. The board keeps it: making one takes longer than reading a cell."""
    if id(observable) not in board.read:
        board.read[id(observable)] = (observable, _make_read(observable, board))
    return board.read[id(observable)][1]


def _make_read(observable: ir.Observable, board: Board) -> ir.Expr:
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
    inner = declared.type.model_copy(update={"by": declared.type.by[1:]})
    key = ir.Word(
        type=ir.Type(kind="word", words=observable.word.level.names), value=observable.word.name
    )
    return ir.At(type=inner, row=field, key=key)


def _observable(plane: planes.Plane) -> ir.Observable:
    assert plane.observable is not None, plane
    return plane.observable
