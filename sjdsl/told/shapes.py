"""The shapes of a game: pictures of their cells, and what ends a lane."""

from sjdsl.compiler import ir
from sjdsl.doc.wording import counted, joined
from sjdsl.told.phrases import English

TALLEST = 12  # rows of a picture; longer shapes are said lane by lane
Cell = tuple[int, int]


def shape_lines(shapes: tuple[ir.Shape, ...], laned: frozenset[str], english: English) -> list[str]:
    """Returns the paragraphs about shapes. laned: those whose lanes rules speak of."""
    if not shapes:
        return []
    lines = []
    for shape in shapes:
        cells = {cell for lane in shape.lanes for cell in lane}
        text = f"{shape.name}, {counted(len(cells), 'cell')}{_direction(shape, cells)}"
        blocking = _blocking(shape, shape.name in laned, english)
        lines.append(f"- {text}. {blocking}".rstrip())
        lines += [f"    {row}" for row in _drawn(shape, cells)]
    return lines


def _direction(shape: ir.Shape, cells: set[Cell]) -> str:
    has_middle = (0, 0) in cells
    if shape.directed:
        if has_middle:
            return " (x, and @, the agent's own, looking up); the shape turns with it"
        return " (x); ^ is the agent, looking up, and the shape turns with it"
    if has_middle:
        return " (x, and the middle @, which belongs to it); up is always north"
    return " (x) around the middle o, which does not belong to it; up is always north"


def _drawn(shape: ir.Shape, cells: set[Cell]) -> list[str]:
    steps = [ahead for ahead, _ in cells]
    if cells and _is_in_columns(shape) and max(steps) - min(steps) < TALLEST:
        return picture(shape)
    return [f"lane {number}: {_lane(lane)}" for number, lane in enumerate(shape.lanes, 1)]


def picture(shape: ir.Shape) -> list[str]:
    """Returns rows of `x` and `.`; the agent is `^`, a middle `o`, `@` if it belongs to it."""
    cells = {cell for lane in shape.lanes for cell in lane}
    middle = "^" if shape.directed else "o"
    signs = dict.fromkeys(cells, "x")
    signs[(0, 0)] = "@" if (0, 0) in cells else middle
    rows = [row for row, _ in signs]
    cols = [col for _, col in signs]
    across = range(min(cols), max(cols) + 1)
    return [
        "".join(signs.get((row, col), ".") for col in across)
        for row in range(max(rows), min(rows) - 1, -1)
    ]


def _is_in_columns(shape: ir.Shape) -> bool:
    """Returns whether each column ahead and beside is a lane, and what lies behind another."""
    if not shape.directed:
        return len(shape.lanes) == 1
    wanted: dict[tuple[int, bool], list[Cell]] = {}
    cells = sorted((c for lane in shape.lanes for c in lane), key=lambda cell: abs(cell[0]))
    for ahead, right in cells:
        wanted.setdefault((right, ahead < 0), []).append((ahead, right))
    return sorted(map(list, shape.lanes)) == sorted(wanted.values())


def _lane(lane: tuple[Cell, ...]) -> str:
    return "; ".join(f"{ahead} ahead {_aside(right)}" for ahead, right in lane)


def _aside(right: int) -> str:
    if right == 0:
        return "straight"
    return f"{abs(right)} to the {'right' if right > 0 else 'left'}"


def _blocking(shape: ir.Shape, is_laned: bool, english: English) -> str:
    if shape.see_through or not shape.directed:
        return ""
    game = english.naming.game
    ends = []
    for kind in game.kinds:
        for block in kind.blocks if kind.name in english.naming.all_kinds else ():
            if block.what == shape.name:
                when = "" if block.condition is None else f" (if {english.text(block.condition)})"
                ends.append(f"a {kind.name} cell{when}")
    for block in game.agents.blocks:
        if block.what == shape.name:
            when = "" if block.condition is None else f" (if {english.text(block.condition)})"
            ends.append(f"an agent{when}")
    lanes = "Each column is a lane, from the agent's row outward"
    is_one = len(shape.lanes) == 1
    if not ends:
        return f"{lanes}; nothing stops it." if is_laned and not is_one else "Nothing stops it."
    end = f"ends at {joined(ends, 'or')}; what it ends at still belongs to it."
    return f"It {end}" if is_one else f"{lanes}; a lane {end}"
