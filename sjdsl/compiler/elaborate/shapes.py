"""Elaborates shapes such as beams: pictures and built-in forms become lanes of offsets."""

from collections.abc import Callable
from itertools import product

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.elaborate.scope import Scope

Offset = tuple[int, int]  # ahead, right
BUILT_IN = {
    "line": ("n",),
    "fan": ("length", "radius"),
    "disc": ("r",),
    "diamond": ("r",),
    "square": ("r",),
}
SEE_THROUGH: dict[str, Callable[[int, int, int], bool]] = {
    # whether a cell so far ahead and to the right is within r
    "disc": lambda ahead, right, r: ahead * ahead + right * right <= r * r,
    "diamond": lambda ahead, right, r: abs(ahead) + abs(right) <= r,
    "square": lambda *_: True,
}


def declared(shape: ast.Shape, scope: Scope) -> ir.Shape:
    """Returns a named shape: a built-in form, or a picture."""
    if shape.call is not None:
        ref = ast.ShapeRef(shape.call.span, shape.call.name, shape.call.arguments)
        form = built_in(ref, scope)
        return form.changed(name=shape.name.text, origin=shape.span)
    rows = [row.text for row in shape.rows]
    problem = _picture_problem(rows)
    if problem:
        raise scope.fail(errors.BadPicture(shape.span, problem=problem))
    return ir.Shape(
        name=shape.name.text,
        lanes=_lanes(rows),
        see_through=False,
        directed=True,
        origin=shape.span,
    )


def used(ref: ast.ShapeRef, scope: Scope) -> ir.Shape:
    """Returns the shape of `in SHAPE of x`: a named one, or a built-in form, named by its text."""
    static = scope.static
    if ref.arguments is None:
        shape = static.shapes.get(ref.name.text)
        if shape is None:
            if Symbol("shape", ref.name.text) in static.broken:
                raise Poisoned
            raise scope.problems.unknown(ref.name, [*static.shapes, *BUILT_IN], "the shapes")
        static.use(ref.name, Symbol("shape", ref.name.text))
        return shape
    shape = built_in(ref, scope)
    return static.shapes.setdefault(shape.name, shape)


def _lanes(rows: list[str]) -> tuple[tuple[Offset, ...], ...]:
    """Returns the lanes of a picture: each column is two, one ahead and one behind."""
    anchor_row = next(r for r, row in enumerate(rows) if "^" in row)
    anchor_col = rows[anchor_row].index("^")
    columns: dict[int, list[int]] = {}  # how far ahead each cell is, by its place to the right
    for r, row in enumerate(rows):
        for c, glyph in enumerate(row):
            if glyph == "x":
                columns.setdefault(c - anchor_col, []).append(anchor_row - r)
    lanes = []
    for right, cells in sorted(columns.items()):
        ahead = sorted(cell for cell in cells if cell >= 0)
        behind = sorted((cell for cell in cells if cell < 0), reverse=True)
        for lane in (ahead, behind):
            if lane:
                lanes.append(tuple((cell, right) for cell in lane))
    return tuple(lanes)


def _picture_problem(rows: list[str]) -> str:
    """Returns why a picture is no shape, empty if it is one."""
    signs = "".join(rows)
    agents = signs.count("^")
    cells = signs.count("x")
    if agents != 1:
        return f"this picture has {agents} `^`, and needs one"
    if set(signs) - set("^x."):
        return "a picture is made of `^`, `x` and `.`"
    if len({len(row) for row in rows}) != 1:
        return "the rows of this picture have different lengths"
    if not cells:
        return "this picture has no cell `x`"
    if cells > limits.MAX_SHAPE_CELLS:
        return f"this picture has more than {limits.MAX_SHAPE_CELLS} cells"
    return ""


def built_in(ref: ast.ShapeRef, scope: Scope) -> ir.Shape:
    """Returns `line(n)`, `fan(length, radius)`, `disc(r)`, `diamond(r)` or `square(r)`.

    The last three may have a second argument, `centre`.
    """
    name = ref.name.text
    arguments = ref.arguments or ()
    if name not in BUILT_IN:
        raise scope.problems.unknown(ref.name, [*BUILT_IN, *scope.static.shapes], "the shapes")
    see_through = name in SEE_THROUGH
    has_centre = False
    if see_through and len(arguments) == 2:
        last = arguments[1]
        has_centre = isinstance(last, ast.Path) and last.name.text == "centre"
    if has_centre:
        arguments = arguments[:1]
    parameters = BUILT_IN[name]
    if len(arguments) != len(parameters):
        noun = "number" if len(parameters) == 1 else "numbers"
        raise scope.fail(
            errors.WrongArguments(
                ref.span,
                name=name,
                wanted=f"{len(parameters)} {noun} ({', '.join(parameters)})",
                actual=len(arguments),
                help=f"`{name}(r, centre)` includes the middle" if see_through else "",
            )
        )
    numbers = [scope.whole(a, "a shape", "the reach of a shape", 1, 64) for a in arguments]
    lanes = _around(name, numbers[0], has_centre) if see_through else _directed(name, numbers)
    if sum(map(len, lanes)) > limits.MAX_SHAPE_CELLS:
        feature = f"a shape of more than {limits.MAX_SHAPE_CELLS} cells"
        raise scope.fail(errors.Unsupported(ref.span, feature=feature))
    written = [str(number) for number in numbers]
    if has_centre:
        written.append("centre")
    return ir.Shape(
        name=f"{name}({', '.join(written)})",
        lanes=lanes,
        see_through=see_through,
        directed=not see_through,
        origin=ref.span,
    )


def _around(name: str, r: int, has_centre: bool) -> tuple[tuple[Offset, ...], ...]:
    """Returns the one lane of a form that is the same in all directions."""
    is_within = SEE_THROUGH[name]
    cells = [
        (ahead, right)
        for ahead, right in product(range(r, -r - 1, -1), range(-r, r + 1))
        if is_within(ahead, right, r)
    ]
    if not has_centre:
        cells.remove((0, 0))
    return (tuple(cells),)


def _directed(name: str, numbers: list[int]) -> tuple[tuple[Offset, ...], ...]:
    """Returns the lanes of a `beam` or `fan`, cells as (ahead, right)."""
    length = numbers[0]
    lanes = [tuple((ahead, 0) for ahead in range(1, length + 1))]
    if name == "fan":
        for side in range(1, numbers[1] + 1):
            lanes.append(tuple((ahead, -side) for ahead in range(length)))
            lanes.append(tuple((ahead, side) for ahead in range(length)))
    return tuple(lanes)
