"""Elaborates shapes such as beams: pictures and built-in forms become lanes of (ahead, right) offsets."""

from collections.abc import Callable

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.elaborate.scope import Scope

Offset = tuple[int, int]
BUILT_IN = {
    "line": ("n",),
    "fan": ("length", "radius"),
    "disc": ("r",),
    "diamond": ("r",),
    "square": ("r",),
}
SEE_THROUGH: dict[
    str, Callable[[int, int, int], bool]
] = {  # whether a cell so far ahead and to the right is within r
    "disc": lambda ahead, right, r: ahead * ahead + right * right <= r * r,
    "diamond": lambda ahead, right, r: abs(ahead) + abs(right) <= r,
    "square": lambda *_: True,
}


def declared(shape: ast.Shape, scope: Scope) -> ir.Shape:
    """Returns a named shape."""
    if shape.call is not None:
        built = built_in(
            ast.ShapeRef(shape.call.span, shape.call.name, shape.call.arguments), scope
        )
        return built.model_copy(update={"name": shape.name.text, "origin": shape.span})
    rows = [row.text for row in shape.rows]
    problem = _picture_problem(rows)
    if problem:
        raise scope.fail(errors.BadPicture(shape.span, problem=problem))
    anchor_row = next(r for r, row in enumerate(rows) if "^" in row)
    anchor_col = rows[anchor_row].index("^")
    cells = {
        (anchor_row - r, c - anchor_col)
        for r, row in enumerate(rows)
        for c, glyph in enumerate(row)
        if glyph == "x"
    }
    lanes = []
    for right in sorted({c for _, c in cells}):  # a column is a lane, ahead and behind
        ahead = sorted(a for a, c in cells if c == right and a >= 0)
        behind = sorted((a for a, c in cells if c == right and a < 0), reverse=True)
        lanes += [tuple((a, right) for a in lane) for lane in (ahead, behind) if lane]
    return ir.Shape(
        name=shape.name.text,
        lanes=tuple(lanes),
        see_through=False,
        directed=True,
        origin=shape.span,
    )


def used(ref: ast.ShapeRef, scope: Scope) -> ir.Shape:
    """Returns the shape of `in SHAPE of x`: a named one, or a built-in form, kept under its text."""
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


def _picture_problem(rows: list[str]) -> str:
    """Returns what is wrong with a picture, in which `^` is the agent facing up and `x` its cells; empty if nothing is."""
    agents, cells = ("".join(rows).count(sign) for sign in "^x")
    if agents != 1:
        return f"this picture has {agents} `^`, and needs one"
    if set("".join(rows)) - set("^x."):
        return "a picture is made of `^`, `x` and `.`"
    if len({len(row) for row in rows}) != 1:
        return "the rows of this picture have different lengths"
    if not cells:
        return "this picture has no cell `x`"
    return (
        f"this picture has more than {limits.MAX_SHAPE_CELLS} cells"
        if cells > limits.MAX_SHAPE_CELLS
        else ""
    )


def built_in(ref: ast.ShapeRef, scope: Scope) -> ir.Shape:
    """Returns `line(n)`, `fan(length, radius)`, `disc(r)`, `diamond(r)`, `square(r)` (these three also `(r, centre)`)."""
    name, arguments = ref.name.text, ref.arguments or ()
    if name not in BUILT_IN:
        raise scope.problems.unknown(ref.name, [*BUILT_IN, *scope.static.shapes], "the shapes")
    centre = False
    if (
        name in SEE_THROUGH
        and len(arguments) == 2
        and isinstance(arguments[1], ast.Path)
        and arguments[1].name.text == "centre"
    ):
        arguments, centre = arguments[:1], True
    if len(arguments) != len(BUILT_IN[name]):
        wanted = f"{len(BUILT_IN[name])} number{'s' * (len(BUILT_IN[name]) > 1)} ({', '.join(BUILT_IN[name])})"
        help_ = f"`{name}(r, centre)` includes the middle" if name in SEE_THROUGH else ""
        raise scope.fail(
            errors.WrongArguments(
                ref.span, name=name, wanted=wanted, actual=len(arguments), help=help_
            )
        )
    numbers = [scope.whole(a, "a shape", "the reach of a shape", 1, 64) for a in arguments]
    label = f"{name}({', '.join(map(str, numbers))}{', centre' if centre else ''})"
    see_through, r = name in SEE_THROUGH, numbers[0]
    if see_through:
        around = (
            (a, c)
            for a in range(r, -r - 1, -1)
            for c in range(-r, r + 1)
            if centre or (a, c) != (0, 0)
        )
        lanes: tuple[tuple[Offset, ...], ...] = (
            tuple(cell for cell in around if SEE_THROUGH[name](*cell, r)),
        )
    else:
        lanes = _directed(name, numbers)
    if sum(map(len, lanes)) > limits.MAX_SHAPE_CELLS:
        raise scope.fail(
            errors.Unsupported(
                ref.span, feature=f"a shape of more than {limits.MAX_SHAPE_CELLS} cells"
            )
        )
    return ir.Shape(
        name=label, lanes=lanes, see_through=see_through, directed=not see_through, origin=ref.span
    )


def _directed(name: str, numbers: list[int]) -> tuple[tuple[Offset, ...], ...]:
    length = numbers[0]
    lanes = [tuple((a, 0) for a in range(1, length + 1))]
    if name == "fan":
        for side in range(1, numbers[1] + 1):
            lanes += [tuple((a, right) for a in range(length)) for right in (-side, side)]
    return tuple(lanes)
