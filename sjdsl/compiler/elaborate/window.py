"""Elaborates `window`: how far an agent sees to each side, and under which condition."""

from sjdsl.compiler import ast, ir
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.elaborate.possible import possible_condition
from sjdsl.compiler.elaborate.scope import Scope

SIDES = {"ahead": 9, "behind": 1, "left": 5, "right": 5}  # of a window, where the game says nothing


def window(game: Composition, scope: Scope) -> ir.Window:
    """Returns the window of observations, which reaches as far to each side as any of its views.

    A view is a `window ... when CONDITION` of the game; the last one is that without a condition.
    """
    plain = next((tree for tree in game.windows if tree.condition is None), None)
    usual = SIDES if plain is None else _sides(plain, SIDES, scope)
    origin = game.windows[0].span if game.windows else None
    observer = scope.with_agent("observe")

    def view(tree: ast.Window) -> ir.View:
        assert tree.condition is not None
        sides = _sides(tree, usual, scope)
        test = possible_condition(tree.condition, observer)
        return ir.View(**sides, condition=test, origin=tree.span)

    conditional = (tree for tree in game.windows if tree.condition is not None)
    views = scope.problems.each(conditional, view)
    if views:
        last_origin = origin if plain is None else plain.span
        views.append(ir.View(**usual, condition=None, origin=last_origin))
    farthest = {}
    for side in SIDES:
        farthest[side] = max([0, usual[side], *(getattr(view, side) for view in views)])
    return ir.Window(**farthest, views=tuple(views), origin=origin)


def _sides(tree: ast.Window, usual: dict[str, int], scope: Scope) -> dict[str, int]:
    """Returns how far a window goes to each side: as written, else as usual."""
    sides = dict(usual)
    seen: set[str] = set()
    for name, value in tree.sides:
        if name.text in seen:
            scope.problems.add(errors.WrittenTwice(name.span, part=f"`{name.text}`"))
        seen.add(name.text)
        if name.text not in SIDES:
            scope.problems.unknown(name, tuple(SIDES), "the sides of a window")
            continue
        with scope.problems.skip_if_broken():
            sides[name.text] = scope.whole(
                value, "the window", f"the window {name.text}", 0, limits.MAX_WINDOW
            )
    return sides
