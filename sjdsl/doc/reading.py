"""Notes on how to read a rule sheet: rules of the language that one game relies on."""

from collections.abc import Iterator

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import body_sorts, can_be_away
from sjdsl.doc.vocabulary import Vocabulary
from sjdsl.doc.wording import Line, bullets

ALWAYS = (
    Line("names `like this` are those of the game's file; a number in brackets behind a name is its default value"),
    Line("names *like this* are given by a statement to an agent, a cell or a value, for this statement and those inside it"),
    Line('without such a name, "the agent" or "the … cell" is that of the enclosing statement'),
    Line("a statement about each member of a set holds for all of them at once"),
    Line("a phase reads the state as it was when the phase began, and its changes appear when it is over"),
    Line("there is at most one agent on a cell"),
)
MOVEMENT = Line(
    "Movement: all agents move at the same time",
    (
        Line("a turn changes only the heading, a step only the cell"),
        Line("an agent that would leave the map, or enter a cell that no agent can enter, stays"),
        Line("two agents cannot change places: both stay"),
        Line("if several agents would enter one cell, one of them does, chosen at random with equal chances; the others stay"),
        Line("no agent enters the cell of an agent that stays; a cell that its agent leaves at the same time can be entered"),
        Line("agents that the statement does not name stay, whatever they chose"),
    ),
)
BODIES = Line(
    "movers occupy cells as agents do: no two of them all stand on one cell, and what is said of agents that move or are sent is true of them",
    (
        Line("a mover that would leave the map, or enter a cell that its sort cannot enter, stays; those that do not move in a phase stay"),
        Line("a cell is nearer if fewer steps along rows and columns lead from it to the nearest one, whatever stands between"),
        Line("a cell beside a mover is free if it can enter it and nobody stood on it when the phase began"),
    ),
)
NOTES: dict[tuple[type[ir.Node], ...], str] = {
    (ir.Step,): "the number of finished steps is 0 in the first step",
    (ir.Near,): "cells of a shape that are off the map do not exist; "
    "a shape without its middle does not contain the agent or cell that it goes around",
    (ir.Add,): "additions to one field in one phase are summed first, then added once, and only then kept within its range",
    (ir.Give,): "the rewards that an agent receives in a step are summed",
    (ir.Chance, ir.Draw): "every step, and each member that a statement is about, has a random draw of its own, independent of all others",
    (ir.Chance,): '"otherwise, with probability p" is the probability if nothing above it happened; one draw decides between all of them',
    (ir.Pick,): "members chosen at random are different ones, every choice equally likely; "
    "inside another statement each of its members has a choice of its own",
    (ir.First,): "a lane is searched from its nearest cell; what does not match is passed over, and the cell that ends a lane is its last",
    (ir.Match,): "random pairs: all possible pairs of two different ones are put in a random order, all orders equally likely; "
    "a pair is made if both are still free",
    (
        ir.Shift,
    ): "agents that are sent some cells away, or to one cell, go at once: the cells on the way must be on the map, open to the agent "
    "and empty; the last one may also be left in the same phase by an agent that is sent; "
    "of several that are sent to one cell, one is drawn at random",
    (
        ir.Mix,
    ): "the mean of a table weighted by a row: each entry times the row's number for its word, divided by the row's sum, all summed; "
    "of a table with two words per entry, the first word is meant, and what remains is a row",
    (ir.Case,): "of several values with conditions, exactly one condition holds",
    (ir.Arithmetic,): "a quotient of whole numbers is a real number",
    (ir.Mark,): "marks are seen in the next observation and change nothing else",
    (ir.Tally,): "counts change nothing in the game",
}


def how_to_read(v: Vocabulary) -> list[str]:
    """Returns the notes that a game needs."""
    return [*bullets(_notes(v)), ""]


def _notes(v: Vocabulary) -> Iterator[Line]:
    yield from ALWAYS
    if v.game.movers:
        yield BODIES
    yield from (Line(text) for sorts, text in NOTES.items() if v.has(*sorts))
    sends = [node for node in v.nodes if isinstance(node, ir.Send)]
    if sends:
        yield _sending(sends)
    if any(can_be_away(v.game, sort) for sort in body_sorts(v.game)):
        yield _away(sends)
    if v.has(ir.Move):
        yield MOVEMENT


def _sending(sends: list[ir.Send]) -> Line:
    found = [
        "a cell is free if nobody stood on it when the phase began; the cells of agents that are sent there in the same phase count as free",
        "an agent that several statements send to the same cells is sent once",
        "agents that are sent to the same cells in one phase get different ones, at random with equal chances",
    ]
    if any(s.stay for s in sends):
        found.append("if some of the agents sent may have to stay, their cells do not count as free; cells go to the lowest numbers first")
    if any(s.facing is None for s in sends):
        found.append("a random direction is one of four, equally likely")
    return Line("an agent that is sent somewhere", tuple(map(Line, found)))


def _away(sends: list[ir.Send]) -> Line:
    found = [
        "it stands on no cell, no statement is about it, it chooses nothing and sees nothing",
        "its fields stay as they are and its timers fall; rewards and counts reach it",
    ]
    if any(s.after is not None for s in sends):
        back = "it leaves at once, and comes back at the last of the ticks it waits for, to a cell that is free then"
        found.append(f"{back}; with a wait of 0 ticks it is never away")
    return Line("an agent that is away", tuple(map(Line, found)))
