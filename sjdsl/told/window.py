"""What one agent sees, as text, from its own token planes."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.lower.cell_appearance import OTHER_FACING
from sjdsl.runtime.planes import TokenPlane
from sjdsl.told.codes import HEADING_UNSEEN, ME, OTHERS, UNSEEN, content_codes

if TYPE_CHECKING:  # the playground's NumPy has no `typing`
    from numpy.typing import NDArray

    Planes = NDArray[np.uint8]
else:
    Planes = np.ndarray
Place = tuple[int, int]  # row and column in the window
SELF = 1  # in the plane `agent`
FACING = ("as you do", "to your right", "toward you", "to your left")


@dataclass(frozen=True)
class Window:
    """Reads the windows of a game's agents.

    planes: what each plane means: `env.token_planes`.
    """

    game: ir.Game
    planes: tuple[TokenPlane, ...]

    @cached_property
    def codes(self) -> dict[str, str]:
        """The code of each label of the content plane, and of each sort of movers."""
        return content_codes(self.planes[0].labels, self.game)

    @cached_property
    def _numbers(self) -> dict[str, int]:
        return {plane.name: number for number, plane in enumerate(self.planes)}

    def text(self, seen: Planes) -> str:
        """Returns the window as text.

        Args:
          seen: `[P, rows, cols]` uint8, one agent's token planes.
        """
        me = self.own_place(seen)
        if me is None:
            return "You are away: you see nothing."
        lines = self._grid(seen)
        lines.append(f"Legend: {'; '.join(self._legend(seen))}.")
        content = self.content(seen, me)
        if content is not None and self.codes[content] != UNSEEN:
            lines.append(f"You stand on: {content}.")
        lines += self._uniform(seen)
        lines += self._others(seen)
        lines += self._movers(seen)
        lines += self._marks(seen)
        return "\n".join(lines)

    def own_place(self, seen: Planes) -> Place | None:
        """Returns where in its window the agent is; None if it is away."""
        places = _places(seen[1] == SELF)
        return places[0] if places else None

    def content(self, seen: Planes, place: Place) -> str | None:
        """Returns the label of a cell's content; None beyond the window."""
        row, col = place
        _, rows, cols = seen.shape
        if not (0 <= row < rows and 0 <= col < cols):
            return None
        return self.planes[0].labels[int(seen[0, row, col])]

    def mover(self, seen: Planes, place: Place) -> str | None:
        """Returns the sort of the mover that is seen on a cell."""
        for movers in self.game.movers:
            for plane in self._planes_of(movers):
                if seen[self._numbers[plane.name]][place] > 0:
                    return movers.name
        return None

    def uniform_value(self, seen: Planes, name: str) -> str | None:
        """Returns the value of a plane that is the same in the whole window; None without it."""
        if name not in self._numbers:
            return None
        number = self._numbers[name]
        return _value(self.planes[number], int(seen[number, 0, 0]))

    def _planes_of(self, movers: ir.Movers) -> list[TokenPlane]:
        """Returns the planes of a sort of movers that are above 0 where one is."""
        return [
            plane
            for plane in self.planes
            if plane.name == movers.name
            or (plane.name.startswith(f"{movers.name}.") and plane.encoding == "word")
        ]

    def _grid(self, seen: Planes) -> list[str]:
        window = self.game.window
        names = [f"{number}L" for number in range(window.left, 0, -1)]
        names += ["0"]
        names += [f"{number}R" for number in range(1, window.right + 1)]
        width = max(2, *map(len, names))
        rows = []
        for row in range(seen.shape[1]):
            cells = [self._cell(seen, (row, col)) for col in range(seen.shape[2])]
            rows.append((_row_name(window.ahead - row), cells))
        rows.insert(0, ("", names))
        margin = max(len(name) for name, _ in rows)
        return [
            f"{name:<{margin}}  {' '.join(cell.ljust(width) for cell in cells)}".rstrip()
            for name, cells in rows
        ]

    def _cell(self, seen: Planes, place: Place) -> str:
        who = int(seen[1][place])
        if who == SELF:
            return ME
        if who >= OTHER_FACING:
            return HEADING_UNSEEN if self._hides_heading(who) else OTHERS[who - OTHER_FACING]
        mover = self.mover(seen, place)
        content = self.content(seen, place)
        assert content is not None
        return self.codes[content if mover is None else mover]

    def _hides_heading(self, who: int) -> bool:
        """Returns whether a value of the plane of agents is another whose heading is hidden."""
        return self.planes[1].labels[who] == "other"

    def _legend(self, seen: Planes) -> list[str]:
        """Returns the codes that are in the window, in the order of the game's labels."""
        shown = {self._cell(seen, place) for place in _all_places(seen)}
        legend = [f"{code} {label}" for label, code in self.codes.items() if code in shown]
        if shown & set(OTHERS):
            legend.append("A^ A> Av A< other agents")
        if HEADING_UNSEEN in shown:
            legend.append(f"{HEADING_UNSEEN} an agent whose direction you can't see")
        return legend

    def _uniform(self, seen: Planes) -> list[str]:
        """Returns what is the same in the whole window: own fields, those of all, the world's."""
        own: list[str] = []
        rest: list[str] = []
        for number, plane in enumerate(self.planes):
            if plane.uniform:
                text = f"{plane.name} = {_value(plane, int(seen[number, 0, 0]))}"
                (own if plane.name.startswith("agent.") else rest).append(text)
        lines = [f"You: {'; '.join(own)}."] if own else []
        return [*lines, f"Known to all: {'; '.join(rest)}."] if rest else lines

    def _others(self, seen: Planes) -> list[str]:
        lines = []
        for place in _places(seen[1] >= OTHER_FACING):
            who = int(seen[1][place])
            parts = [] if self._hides_heading(who) else [f"looks {FACING[who - OTHER_FACING]}"]
            content = self.content(seen, place)
            if content is not None and self.codes[content] != UNSEEN:
                parts.append(f"on {content}")
            parts += self._fields("other.", seen, place)
            lines.append(self._said("Agent", place, parts))
        return lines

    def _movers(self, seen: Planes) -> list[str]:
        lines = []
        for place in _all_places(seen):
            name = self.mover(seen, place)
            if name is not None:
                lines.append(self._said(name, place, self._fields(f"{name}.", seen, place)))
        return lines

    def _fields(self, prefix: str, seen: Planes, place: Place) -> list[str]:
        """Returns the values of the planes whose names begin so, at a cell."""
        return [
            f"{plane.name.removeprefix(prefix)} = {_value(plane, int(seen[number][place]))}"
            for number, plane in enumerate(self.planes)
            if plane.name.startswith(prefix)
        ]

    def _said(self, who: str, place: Place, parts: list[str]) -> str:
        text = f": {'; '.join(parts)}" if parts else ""
        return f"{who} at {self._place(place)}{text}."

    def _marks(self, seen: Planes) -> list[str]:
        if "marks" not in self._numbers:
            return []
        number = self._numbers["marks"]
        marked = []
        for bit, label in enumerate(self.planes[number].labels):
            places = _places(seen[number] & (1 << bit))
            if places:
                marked.append(f"{label} at {', '.join(map(self._place, places))}")
        return [f"Marks of the last step: {'; '.join(marked)}."] if marked else []

    def _place(self, place: Place) -> str:
        row, col = place
        right = col - self.game.window.left
        ahead = _row_name(self.game.window.ahead - row)
        if right == 0:
            return f"({ahead}, 0)"
        return f"({ahead}, {abs(right)}{'R' if right > 0 else 'L'})"


def _row_name(ahead: int) -> str:
    if ahead == 0:
        return "beside you"
    return f"{ahead} ahead" if ahead > 0 else f"{-ahead} behind"


def _value(plane: TokenPlane, value: int) -> str:
    return plane.labels[value] if plane.encoding == "word" else str(value)


def _all_places(seen: Planes) -> Iterator[Place]:
    _, rows, cols = seen.shape
    return product(range(rows), range(cols))


def _places(mask: "NDArray[np.bool_] | NDArray[np.uint8]") -> list[Place]:
    rows, cols = np.nonzero(mask)
    return [(int(row), int(col)) for row, col in zip(rows, cols, strict=True)]
