"""What the number of each word of a stream is made of: one digit for each member around the draw."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import body_type, movers_named
from sjdsl.interpreter import members
from sjdsl.interpreter.board import Board, board_of, cells_of
from sjdsl.interpreter.threefry import return_stream
from tests.laws.symmetry import Symmetry


@dataclass(frozen=True)
class Digit:
    """One place of a number. `agent`: an id; `cell`: a number among the cells of the kinds; `fixed`: the same under every symmetry."""

    what: Literal["agent", "cell", "fixed"]
    radix: int
    kinds: tuple[str, ...] = ()


@dataclass(frozen=True)
class Stream:
    """`digits`: outermost first. `options`: what a `pick` chooses from. `sort`: what its words are used for.

    `rank`: who of several comes first, by number if the upper 24 bits are the same. `way`: which of the directions that are open to a mover.
    """

    digits: tuple[Digit, ...]
    sort: Literal["plain", "pick", "order", "heading", "rank", "way"] = "plain"
    options: Digit | None = None


def streams(game: ir.Game) -> dict[int, Stream]:
    """Returns every stream that a step or a reset can draw from."""
    found: dict[int, Stream] = {}
    of_task = () if game.task is None else (game.task.draw,)
    for turn in (*of_task, game.start, *game.starting, *game.schedule):
        if isinstance(turn, ir.Phase):
            _block(turn.body, (), board_of(game), found)
    return found


def _block(
    body: Iterable[ir.Stmt], around: tuple[Digit, ...], board: Board, found: dict[int, Stream]
) -> None:
    for statement in body:
        inside = around
        match statement:
            case ir.Draw(by=ir.IndexSet() as by):
                entry = Digit("agent" if by.kind == "agent" else "fixed", len(by))
                found[statement.stream] = Stream((*around, entry))
            case ir.Chance() | ir.Draw():
                found[statement.stream] = Stream(around)
            case ir.Set(lot=int(stream)):
                found[stream] = Stream(around, "rank")
            case ir.Each():
                inside = (*around, _digit(statement.domain, board))
            case ir.First():
                assert isinstance(statement.domain.restriction, ir.Near)
                lanes = board.shapes[statement.domain.restriction.shape].lanes
                inside = (*around, Digit("fixed", len(lanes)))
            case ir.Pick():
                own = _digit(statement.domain, board)
                inside = (*around, own)
                found[statement.stream] = Stream(
                    (*around, Digit("fixed", min(statement.most, own.radix))), "pick", own
                )
            case ir.Match():
                inside = (*around, _digit(statement.left, board))
                found[statement.stream] = Stream(
                    (
                        *around,
                        _everybody(statement.left, board),
                        _everybody(statement.right, board),
                    ),
                    "rank",
                )
            case ir.Move():
                found[statement.stream] = Stream(
                    (*around, _everybody(statement.domain, board)), "rank"
                )
                if isinstance(statement.course, ir.Wander):
                    found[statement.course.stream] = Stream(
                        (_everybody(statement.domain, board),), "way"
                    )
            case ir.Shift():
                sent = _body(statement.who, board)
                found[statement.stream] = Stream((sent,), "rank")
                if statement.heading_stream is not None:
                    found[statement.heading_stream] = Stream((sent,), "heading")
            case ir.Send():
                sent = _body(statement.who, board)
                for change in (lambda stream: stream, return_stream):
                    found[change(statement.cell_stream)] = Stream((sent,), "order")
                    found[change(statement.heading_stream)] = Stream((sent,), "heading")
            case _:
                pass
        for name in ("body", "otherwise"):
            _block(
                getattr(statement, name, ()),
                around if name == "otherwise" else inside,
                board,
                found,
            )
        for branch in getattr(statement, "branches", ()):
            _block(branch.body, inside, board, found)


def _digit(domain: ir.Domain, board: Board) -> Digit:
    if domain.var.entity_type.what == "cell" and isinstance(domain.restriction, ir.Near):
        return Digit("fixed", members.radix(domain, board))  # a shape's cells keep their numbers
    return _everybody(domain, board)


def _body(who: ir.Expr, board: Board) -> Digit:
    """Returns the place of the number of an agent or a mover."""
    sort = body_type(who)
    return (
        Digit("fixed", movers_named(board.game, sort.name).number)
        if sort.what == "mover"
        else Digit("agent", board.agents)
    )


def _everybody(domain: ir.Domain, board: Board) -> Digit:
    if domain.var.entity_type.what != "cell":
        return _body(domain.var, board)
    return Digit("cell", members.population(domain, board), domain.var.kinds)


def renumbered(
    number: int, digits: tuple[Digit, ...], game: ir.Game, changed: ir.Game, s: Symmetry
) -> int:
    """Returns the number that the same instance has under a symmetry."""
    values = []
    for digit in reversed(digits):
        number, value = divmod(number, digit.radix)
        values.append(other_digit(value, digit, game, changed, s))
    assert number == 0, "a number with more digits than its stream has"
    for digit, value in zip(digits, reversed(values), strict=True):
        number = number * digit.radix + value
    return number


def other_digit(value: int, digit: Digit, game: ir.Game, changed: ir.Game, s: Symmetry) -> int:
    match digit.what:
        case "agent":
            return s.order[value]
        case "cell":
            cell = cells_of(board_of(game), digit.kinds)[value]
            return cells_of(board_of(changed), digit.kinds).index(s.cell(cell))
        case "fixed":
            return value
