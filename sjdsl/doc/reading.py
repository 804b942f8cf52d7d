"""Notes on how to read a rule sheet: rules of the language that one game relies on."""

from collections.abc import Iterator

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import can_be_away
from sjdsl.doc.vocabulary import Vocabulary
from sjdsl.doc.wording import Line, bullets

ALWAYS = (
    Line("names `like this` are those of the game's file; a number in brackets behind a name is its default value"),
    Line("names *like this* are given by a sentence to an agent, a cell or a value, for this sentence and those inside it"),
    Line('without such a name, "the agent" or "the … cell" is the one that the sentence around is about'),
    Line("a sentence about each member of a set holds for all of them at once"),
    Line("a phase reads everything as it was when the phase began, and all that it changes shows when it is over"),
    Line("there is at most one agent on a cell"),
)
MOVEMENT = Line(
    "Movement: all who move act at the same time",
    (
        Line("turning is done at once; a turn never changes the cell, a step never the heading"),
        Line("who would leave the map, or enter a cell that no agent can enter, stays"),
        Line("two agents cannot change places: both stay"),
        Line("of several agents that would enter one cell, one has it, chosen at random, all equally likely; the others stay"),
        Line("nobody enters the cell of an agent that stays; the cell of an agent that leaves at the same time can be entered"),
        Line("agents that the sentence does not name stay, whatever they chose"),
    ),
)
NOTES: tuple[tuple[tuple[type, ...], Line], ...] = (
    ((ir.Step,), Line("the number of finished steps is 0 in the first step")),
    (
        (ir.Near,),
        Line("a cell of a shape that is off the map does not exist, and a shape without its middle does not hold whom it goes around"),
    ),
    (
        (ir.Add,),
        Line("all that is added to one field in one phase is summed first and then added at once, and only then kept within its range"),
    ),
    ((ir.Give,), Line("the rewards that an agent receives in a step are summed")),
    ((ir.Chance, ir.Draw), Line("every draw is made anew in each step and for each member that a sentence is about, independent of all others")),
    (
        (ir.Chance,),
        Line('"otherwise, with probability p" is the probability if nothing above it happened; one draw decides between all of them'),
    ),
    (
        (ir.Pick,),
        Line("who is chosen at random: different ones, every choice equally likely; inside another sentence each of its members has a choice of its own"),
    ),
    (
        (ir.First,),
        Line("a lane is looked along from its nearest cell; what is not meant is passed over, and the cell that ends a lane is its last"),
    ),
    (
        (ir.Match,),
        Line("random pairs: all possible pairs of two different ones are put in a random order, all orders equally likely; a pair is made if both are still free"),
    ),
    ((ir.Mix,), Line("the mean of a table weighted by a row: each entry times the row's number for its word, divided by the row's sum, all summed; of a table with two words per entry, the first word is meant, and what remains is a row")),
    ((ir.Case,), Line("of several values with conditions, exactly one condition holds")),
    ((ir.Arithmetic,), Line("a quotient of whole numbers is a real number")),
    ((ir.Mark,), Line("marks are seen in the next observation and change nothing else")),
    ((ir.Tally,), Line("counts change nothing in the game")),
)  # fmt: skip


def how_to_read(v: Vocabulary) -> list[str]:
    """Returns the notes that a game needs."""
    return [*bullets(_notes(v)), ""]


def _notes(v: Vocabulary) -> Iterator[Line]:
    yield from ALWAYS
    yield from (line for sorts, line in NOTES if v.has(*sorts))
    sends = [node for node in v.nodes if isinstance(node, ir.Send)]
    if sends:
        yield _sending(sends)
    if can_be_away(v.game):
        yield _away(sends)
    if v.has(ir.Move):
        yield MOVEMENT


def _sending(sends: list[ir.Send]) -> Line:
    found = [
        Line(
            "a cell is free if nobody stood on it when the phase began; the cells of agents that are sent there in the same phase count as free"
        ),
        Line("who is sent to the same cells by several sentences is sent once"),
        Line("agents that are sent to the same cells in one phase come to different ones; which, is random, all equally likely"),
    ]
    if any(s.stay for s in sends):
        found.append(Line("if some of those sent may have to stay, their cells do not count as free; cells go to the lowest numbers first"))
    if any(s.facing is None for s in sends):
        found.append(Line("a random direction is one of four, equally likely"))
    return Line("who is sent somewhere", tuple(found))


def _away(sends: list[ir.Send]) -> Line:
    found = [
        Line("it stands on no cell, no sentence is about it, it chooses nothing and sees nothing"),
        Line("its fields stay as they are and its timers fall; rewards and counts reach it"),
    ]
    if any(s.after is not None for s in sends):
        found.append(
            Line(
                "it leaves at once, and comes back at the last of the ticks it waits for, to a cell that is free then; a wait of 0 ticks is none"
            )
        )
    return Line("an agent that is away", tuple(found))
