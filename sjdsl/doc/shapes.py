"""The English of shapes: pictures, and what blocks their lanes."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import blocks_always
from sjdsl.doc.vocabulary import Vocabulary
from sjdsl.doc.wording import code, codes, counted, fenced

TALLEST = 12  # rows of a picture; longer shapes are said lane by lane
LANES = (
    "`x` is a cell of the shape. The cells of a column ahead of the agent (`^`) and beside it are one lane, nearest first; those behind it "
    "are another."
)
Cell = tuple[int, int]


def shapes(v: Vocabulary) -> list[str]:
    """Returns the paragraphs about all shapes of a game."""
    found = [line for shape in v.shapes.values() for line in _shape(shape, v)]
    return [LANES, "", *found] if any(shape.directed for shape in v.shapes.values()) else found


def _shape(shape: ir.Shape, v: Vocabulary) -> list[str]:
    cells = {cell for lane in shape.lanes for cell in lane}
    steps = [ahead for ahead, _ in cells]
    is_drawn = _columns(shape) and max(steps) - min(steps) < TALLEST
    drawn = fenced(picture(shape)) if is_drawn else [f"- {lane}" for lane in lanes(shape)]
    return [f"**{code(shape.name)}**, {counted(len(cells), 'cell')}. {_direction(shape)} {_blocking(shape, v)}".rstrip(), "", *drawn, ""]


def _direction(shape: ir.Shape) -> str:
    if shape.directed:
        return "It turns with the agent, which looks up in the picture."
    return "It has no direction: up in the picture is always north. All its cells are one lane, which nothing ends."


def _blocking(shape: ir.Shape, v: Vocabulary) -> str:
    if shape.see_through:
        return ""
    always = [k.name for k in v.game.kinds if blocks_always(k, shape.name)]
    sometimes = [k.name for k in v.game.kinds for b in k.blocks if b.what == shape.name and b.condition is not None]
    found = []
    if always:
        found.append(f"A lane ends at the first {' or '.join(always)} cell, which still belongs to it.")
    agents = [block for block in v.game.agents.blocks if block.what == shape.name]
    if agents:
        some = "some agents" if all(block.condition is not None for block in agents) else "the first agent"
        found.append(f"A lane ends at {some}, whose cell still belongs to it (see Agents).")
    if sometimes:
        found.append(f"{codes(sometimes)} cells can end a lane, too (see Kinds of cell).")
    return " ".join(found) or "Nothing on the map ends a lane."


def _columns(shape: ir.Shape) -> bool:
    """Returns whether the picture tells the lanes: a column ahead and beside is one, what lies behind it another."""
    if not shape.directed:
        return len(shape.lanes) == 1 and list(shape.lanes[0]) == sorted(shape.lanes[0], key=lambda cell: (-cell[0], cell[1]))
    wanted: dict[tuple[int, bool], list[Cell]] = {}
    for ahead, right in sorted((c for lane in shape.lanes for c in lane), key=lambda cell: abs(cell[0])):
        wanted.setdefault((right, ahead < 0), []).append((ahead, right))
    return sorted(map(list, shape.lanes)) == sorted(wanted.values())


def picture(shape: ir.Shape) -> list[str]:
    """Returns rows of `x` for cells and `.` for others; the agent is `^`, a middle without direction `o`, `@` if it belongs itself."""
    cells = {cell for lane in shape.lanes for cell in lane}
    rows, cols = zip(*cells, (0, 0))
    signs = dict.fromkeys(cells, "x") | {(0, 0): "@" if (0, 0) in cells else "^" if shape.directed else "o"}
    across = range(min(cols), max(cols) + 1)
    return ["".join(signs.get((a, c), ".") for c in across) for a in range(max(rows), min(rows) - 1, -1)]


def lanes(shape: ir.Shape) -> list[str]:
    """Returns the lanes of a shape in words, nearest cell first."""
    return [f"lane {number}: {_lane(lane)}" for number, lane in enumerate(shape.lanes, 1)]


def _lane(lane: tuple[Cell, ...]) -> str:
    steps = [a for a, _ in lane]
    if len({c for _, c in lane}) == 1 and steps == list(range(steps[0], steps[0] + len(steps))):
        return f"{steps[0]} to {steps[-1]} ahead, {_aside(lane[0][1])}"
    return "; ".join(f"{a} ahead and {_aside(c)}" for a, c in lane)


def _aside(right: int) -> str:
    return "straight" if right == 0 else f"{abs(right)} to the {'right' if right > 0 else 'left'}"
