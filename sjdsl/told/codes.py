"""Codes of two characters for what can be in a window, the same in all frames of a game."""

from collections.abc import Iterable, Iterator
from string import ascii_letters, digits

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import blocks_always, num_cells
from sjdsl.compiler.lower.cell_appearance import COVERED, OUTSIDE

ME = "ME"
ARROWS = "^>v<"  # of others: the way they look, up being the way you look
OTHERS = tuple(f"A{arrow}" for arrow in ARROWS)
HEADING_UNSEEN = "A?"  # another whose heading is hidden
UNSEEN = "??"
SIGNS = ascii_letters + digits


def content_codes(labels: tuple[str, ...], game: ir.Game) -> dict[str, str]:
    """Returns the code of each label of the content plane, then of each sort of movers."""
    taken = {ME, UNSEEN, "##", "..", *OTHERS, HEADING_UNSEEN}
    codes = {OUTSIDE: "##", COVERED: UNSEEN}
    floor = _floor(game)
    if floor in labels:
        codes[floor] = ".."
    for label in (*labels, *(movers.name for movers in game.movers)):
        if label not in codes:
            codes[label] = next(code for code in _candidates(label) if code not in taken)
            taken.add(codes[label])
    return codes


def _floor(game: ir.Game) -> str:
    """Returns the kind without fields that most cells are of, of those that stop nobody."""
    plain = [kind.name for kind in game.kinds if not kind.fields and not blocks_always(kind)]
    return max(plain, key=lambda name: num_cells(game, (name,)), default="")


def _candidates(label: str) -> Iterator[str]:
    """Yields codes for a label such as `tree fruit=ripe`: `tr`, `ti`, …, `tA`, …"""
    kind, *states = label.split()
    words = [state.partition("=")[2] for state in states]
    if words:
        yield from (kind[0] + letter for word in words for letter in word)
    else:
        yield from (kind[0] + letter for letter in kind[1:])
    yield from _pairs(kind[0])
    yield from _pairs(SIGNS)


def _pairs(firsts: Iterable[str]) -> Iterator[str]:
    return (first + second for first in firsts for second in SIGNS)
