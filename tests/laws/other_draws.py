"""The random draws of a step under a symmetry: each instance draws the same number, and one chosen of several is the same one.

Which number that takes depends on the order in which there was to choose: cells in reading order, agents by number.
"""

from dataclasses import dataclass

from sjdsl.compiler import ir
from sjdsl.compiler.ir.free_variables import variables_around
from sjdsl.interpreter.threefry import Chosen, Recorded, return_stream
from tests.laws.streams import Stream, other_digit, renumbered, streams
from tests.laws.symmetry import Symmetry


class RunsOut(Exception):
    """There were fewer free cells than agents sent: lower numbers come first, by the manual, so that new numbers change who stays."""


class NeverDrawn(Exception):
    """The other game draws where the first one did not."""


@dataclass(frozen=True)
class Table:
    """Words by stream and number. Raises NeverDrawn for others."""

    words: dict[tuple[int, int], int]

    def bits(self, stream: int, number: int) -> int:
        if (stream, number) not in self.words:
            raise NeverDrawn(stream, number)
        return self.words[stream, number]


def other_draws(game: ir.Game, changed: ir.Game, drawn: Recorded, s: Symmetry) -> Table:
    """Returns the words for the game under the symmetry. Raises RunsOut where the manual lets the number of an agent decide."""
    known = streams(game)
    words: dict[tuple[int, int], int] = {}
    for stream, number, word in drawn.used:
        about = known[stream]
        if about.sort == "heading":
            word = s.heading(word >> 30) << 30 | word & 0x3FFFFFFF
        words[stream, renumbered(number, about.digits, game, changed, s)] = word
    sends: dict[int, list[Chosen]] = {}
    for chosen in drawn.chosen:
        about = known[chosen.stream]
        if about.sort == "order":
            sends.setdefault(chosen.stream, []).append(chosen)
        elif about.sort == "way":
            ways = sorted(s.heading(way) for way in chosen.left)
            place = renumbered(chosen.number, about.digits, game, changed, s)
            words[chosen.stream, place] = choosing(
                ways.index(s.heading(chosen.left[chosen.taken])), len(ways)
            )
        else:
            index, size = _picked(chosen, about, game, changed, s)
            words[chosen.stream, renumbered(chosen.number, about.digits, game, changed, s)] = (
                choosing(index, size)
            )
    for stream, turns in sends.items():
        if known[stream].digits[0].what == "fixed":  # movers: each has its turn as before
            words |= {(stream, mover): word for mover, word in _in_turn(turns, s)}
            continue
        if s.order != tuple(sorted(s.order)) and (
            _is_own(game, stream) or (len(turns[-1].left) == 1 and _may_stay(game, stream))
        ):
            raise RunsOut
        words |= {(stream, agent): word for agent, word in _sent(turns, s)}
    return Table(words)


def tied(game: ir.Game, drawn: Recorded) -> bool:
    """Returns whether two have drawn the same rank, so that their numbers may decide."""
    known = streams(game)
    ranks = [(stream, word >> 8) for stream, _, word in drawn.used if known[stream].sort == "rank"]
    return len(set(ranks)) < len(ranks)


def choosing(index: int, size: int) -> int:
    """Returns a word that chooses the one of that index out of so many: floor(word * size / 2^32) == index."""
    return (2 * index + 1) * 2**31 // size


def _picked(
    chosen: Chosen, about: Stream, game: ir.Game, changed: ir.Game, s: Symmetry
) -> tuple[int, int]:
    assert about.options is not None
    numbers = [other_digit(found.number, about.options, game, changed, s) for found in chosen.left]
    return sorted(numbers).index(numbers[chosen.taken]), len(numbers)


def _sent(turns: list[Chosen], s: Symmetry) -> list[tuple[int, int]]:
    """Returns the word of each agent, by its new number, with which all of them get the cells they got."""
    if list(s.order) == sorted(
        s.order
    ):  # each agent has its turn as before, with cells of its own perhaps
        return _in_turn(turns, s)
    free = sorted(s.cell(cell) for cell in turns[0].left)
    goes = {s.order[turn.number]: s.cell(turn.left[turn.taken]) for turn in turns}
    words = []
    for agent in sorted(goes):
        index = free.index(goes[agent])
        words.append((agent, choosing(index, len(free))))
        free.pop(index)
    return words


def _in_turn(turns: list[Chosen], s: Symmetry) -> list[tuple[int, int]]:
    """Returns the word of each that is sent, in the same turns, with which it gets the cell that it got."""
    found = [(turn, sorted(s.cell(cell) for cell in turn.left)) for turn in turns]
    return [
        (turn.number, choosing(free.index(s.cell(turn.left[turn.taken])), len(free)))
        for turn, free in found
    ]


def _may_stay(game: ir.Game, stream: int) -> bool:
    sends = [n for n in ir.walk(game) if isinstance(n, ir.Send)]
    return any(n.stay for n in sends if stream in (n.cell_stream, return_stream(n.cell_stream)))


def _is_own(game: ir.Game, stream: int) -> bool:
    """Returns whether the cells that fit differ from one agent to another: then who comes first decides what is left for the rest."""
    sends = [n for n in ir.walk(game) if isinstance(n, ir.Send)]
    return any(
        variables_around(n.domain)
        for n in sends
        if stream in (n.cell_stream, return_stream(n.cell_stream))
    )
