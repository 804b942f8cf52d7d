"""Elaborates `window`: how far agents see, perhaps each sort of agents its own way."""

from sjdsl.compiler import ast, ir
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors, guesses, limits
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.scope import Scope

SIDES = {"ahead": 9, "behind": 1, "left": 5, "right": 5}  # how far an agent sees unless the game says otherwise


def window(game: Composition, scope: Scope) -> ir.Window:
    """Returns what an observation covers: as far to each side as anyone sees."""
    plain = next((w for w in game.windows if w.condition is None), None)
    usual = SIDES if plain is None else _sides(plain, SIDES, scope)
    origin = game.windows[0].span if game.windows else None
    observer = Scope(scope.static, scope.problems, part="observe").bind("agent", ir.Member(name="agent", sort=ir.Sort("agent")))
    views = []
    for tree in game.windows:
        if tree.condition is not None:
            with scope.problems.survive():
                sides = _sides(tree, usual, scope)
                views.append(_view(sides, observer.condition(tree.condition), tree.span))
    if not views:
        return _covering([], usual, origin)
    views.append(_view(usual, None, plain.span if plain is not None else origin))
    return _covering(views, {side: max(getattr(view, side) for view in views) for side in SIDES}, origin)


def _view(sides: dict[str, int], condition: ir.Expr | None, origin: Span | None) -> ir.View:
    ahead, behind, left, right = (sides[side] for side in SIDES)
    return ir.View(ahead=ahead, behind=behind, left=left, right=right, condition=condition, origin=origin)


def _covering(views: list[ir.View], sides: dict[str, int], origin: Span | None) -> ir.Window:
    ahead, behind, left, right = (sides[side] for side in SIDES)
    return ir.Window(ahead=ahead, behind=behind, left=left, right=right, views=tuple(views), origin=origin)


def _sides(tree: ast.Window, usual: dict[str, int], scope: Scope) -> dict[str, int]:
    """Returns how far a window goes to each side; to sides that are not named as far as usual."""
    sides = dict(usual)
    for i, (name, value_tree) in enumerate(tree.sides):
        if name.text in [n.text for n, _ in tree.sides[:i]]:
            scope.problems.add(errors.WrittenTwice(name.span, what=f"`{name.text}`"))
        if name.text not in SIDES:
            scope.problems.unknown(name, tuple(SIDES), "the sides of a window", guesses.SIDES)
            continue
        with scope.problems.survive():
            value = scope.fixed(value_tree, "the window")
            if value != int(value) or not 0 <= value <= limits.MAX_WINDOW:
                wrong = errors.OutOfLimits(value_tree.span, name=f"the window {name.text}", value=value, low=0, high=limits.MAX_WINDOW)
                raise scope.problems.fail(wrong)
            sides[name.text] = int(value)
    return sides
