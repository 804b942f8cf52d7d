"""The rules of a game under a symmetry: a map turned, shapes and windows mirrored, agents with other numbers.

    map { "ab" }   facing east   agent.col   agent.index   ->   map { "ba" }   facing west   1 - agent.col   case agent.index { ... }

What a rule reads of places, headings and numbers, it reads as it was before; so words and numbers kept in fields stay what they are.
An action keeps its number and does what it did: its name changes.
"""

from collections.abc import Callable
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.tree import rewrite
from sjdsl.compiler.ir.queries import body_type, shows_attribute
from sjdsl.compiler.ir.types import integer, words
from sjdsl.interpreter.state import HEADINGS
from tests.laws.symmetry import Symmetry
from tests.verify_ir import verify


def without_frame(game: ir.Game) -> ir.Game:
    """Returns the game without what is seen in the frame of the map itself: places, directions and numbers of agents."""
    kept = [
        s
        for s in game.observables
        if s.labels or not (s.type.words[:1] == ("nobody",) or _in_frame(s))
    ]
    return game.model_copy(update={"observables": tuple(kept)})


def _in_frame(observable: ir.Observable) -> bool:
    return shows_attribute(observable) and observable.field in ("row", "col", "heading", "index")


def other_game(game: ir.Game, s: Symmetry) -> ir.Game:
    """Returns the rules under a symmetry. Checks are left out: they are not played."""
    rule = _rule(s, game)
    agents = rewrite(game.agents, rule)
    window = game.window
    return verify(
        game.model_copy(
            update={
                "rows": s.rows(game.rows),
                "kinds": tuple(rewrite(kind, rule) for kind in game.kinds),
                "agents": agents.model_copy(
                    update={"actions": tuple(s.action(a, agents.relative) for a in agents.actions)}
                ),
                "movers": tuple(_movers(rewrite(movers, rule), s) for movers in game.movers),
                "shapes": tuple(_shape(shape, s) for shape in game.shapes),
                "start": _start(game.start, s, game),
                "starting": tuple(rewrite(phase, rule) for phase in game.starting),
                "schedule": tuple(rewrite(turn, rule) for turn in game.schedule),
                "window": _mirrored(rewrite(window, rule)) if s.mirror else rewrite(window, rule),
                "observables": tuple(rewrite(observable, rule) for observable in game.observables),
                "hidden": tuple(rewrite(hidden, rule) for hidden in game.hidden),
                "measures": tuple(rewrite(measure, rule) for measure in game.measures),
                "checks": (),
            }
        )
    )


def _mirrored(window: ir.Window) -> ir.Window:
    """Returns windows with left and right exchanged."""
    views = tuple(
        view.model_copy(update={"left": view.right, "right": view.left}) for view in window.views
    )
    return window.model_copy(update={"left": window.right, "right": window.left, "views": views})


def _rule(s: Symmetry, game: ir.Game, headings: bool = True) -> Callable[[Any], Any]:
    def rule(node: Any) -> Any:
        match node:
            case ir.Attribute(name="row" | "col"):
                return _coordinate(node, s)
            case ir.Attribute(name="heading") if headings and (s.mirror or s.quarters):
                return _heading_before(node, s)
            case ir.FieldRead(held_by=ir.EntityType("mover"), name="heading") if (
                s.mirror or s.quarters
            ):
                return _heading_before(node, s)
            case ir.Set(
                target=ir.Case(
                    subject=ir.FieldRead(held_by=ir.EntityType("mover"), name="heading") as heading
                )
            ):
                return node.model_copy(
                    update={"target": heading, "value": _changed_heading(node.value, s)}
                )
            case ir.Along() | ir.Face():
                return node.model_copy(update={"heading": _changed_heading(node.heading, s)})
            case ir.Attribute(name="index") if (
                list(s.order) != sorted(s.order) and body_type(node.owner).what == "agent"
            ):
                arms = [
                    ir.Arm(low=n, high=n, value=ir.Number(type=node.type, value=i))
                    for i, n in enumerate(s.order)
                ]
                return ir.Case(type=node.type, subject=node, arms=tuple(arms), origin=node.origin)
            case ir.Given(type=ir.Type(kind="agent"), value=ir.Number(value=int(number)) as value):
                new = s.order[number]
                return node.model_copy(
                    update={
                        "value": value.model_copy(
                            update={"value": new, "type": integer(new, new, "number")}
                        )
                    }
                )
            case ir.Forbid():
                return node.model_copy(
                    update={"actions": tuple(sorted(s.number(a, game) for a in node.actions))}
                )
            case ir.Send():
                way = None if node.way is None else _changed_heading(node.way, s)
                return node.model_copy(update={"facing": s.facing(node.facing), "way": way})
            case ir.Shift():
                heading = None if node.heading is None else _changed_heading(node.heading, s)
                way = None if node.way is None else _changed_heading(node.way, s)
                quarters = -node.quarters % 4 if s.mirror else node.quarters
                return node.model_copy(
                    update={
                        "facing": s.facing(node.facing),
                        "way": way,
                        "heading": heading,
                        "quarters": quarters,
                    }
                )
            case _:
                return node

    return rule


def _heading_before(e: ir.Attribute | ir.FieldRead, s: Symmetry) -> ir.Expr:
    """Returns which way an agent or a mover looked, from the way it looks now."""
    arms = [
        ir.Arm(words=(HEADINGS[s.heading(h)],), value=ir.Word(type=e.type, value=w))
        for h, w in enumerate(HEADINGS)
    ]
    return ir.Case(type=e.type, subject=e, arms=tuple(arms), origin=e.origin)


def _movers(movers: ir.Movers, s: Symmetry) -> ir.Movers:
    """Returns a sort of movers that look, before they are sent anywhere, the way that is north now."""
    heading, *others = movers.fields
    return movers.model_copy(
        update={"fields": (heading.model_copy(update={"start": s.facing(heading.start)}), *others)}
    )


def _changed_heading(e: ir.Expr, s: Symmetry) -> ir.Expr:
    """Returns the direction now, from the direction before."""
    arms = [
        ir.Arm(
            words=(w,),
            value=ir.Word(type=words(HEADINGS), value=HEADINGS[s.heading(HEADINGS.index(w))]),
        )
        for w in e.type.words
    ]
    return ir.Case(type=words(HEADINGS), subject=e, arms=tuple(arms), origin=e.origin)


def _start(phase: ir.Phase, s: Symmetry, game: ir.Game) -> ir.Phase:
    """Everybody faces north before it, under every look: `same` is a direction here, and what is read is no other one."""

    def rule(node: Any) -> Any:
        same = (
            isinstance(node, ir.Send)
            and node.facing == "same"
            and body_type(node.who).what == "agent"
        )
        return node.model_copy(update={"facing": "north"}) if same else node

    return rewrite(rewrite(phase, rule), _rule(s, game, headings=False))


def _coordinate(node: ir.Attribute, s: Symmetry) -> Any:
    """Returns the row or column that the owner's cell had before, from the one it has now."""
    if s.down or s.right:
        length, by = (s.height, s.down) if node.name == "row" else (s.width, s.right)
        back, whole = (
            ir.Number(type=ir.Type(kind="int", unit="cells", low=n, high=n), value=n)
            for n in (-by % length, length)
        )
        on = ir.Arithmetic(
            type=ir.Type(kind="int", unit="cells", low=0, high=2 * length),
            fn="+",
            args=(node, back),
        )
        return ir.Arithmetic(type=node.type, fn="%", args=(on, whole), origin=node.origin)
    before = [(r, c) for r in range(s.height) for c in range(s.width)]
    wanted = [cell[0 if node.name == "row" else 1] for cell in before]
    last = (s.height if node.name == "row" else s.width) - 1
    for name in ("row", "col"):
        now = [getattr(s.cell(cell), name) for cell in before]
        new = node.model_copy(update={"name": name})
        if now == wanted:
            return new
        if [last - n for n in now] == wanted:
            return ir.Arithmetic(
                type=node.type,
                fn="-",
                args=(ir.Number(type=node.type, value=last), new),
                origin=node.origin,
            )
    raise AssertionError(node)


def _shape(shape: ir.Shape, s: Symmetry) -> ir.Shape:
    """A shape before an agent turns with it; one that lies on the map is turned with the map. The cells keep their numbers."""

    def moved(ahead: int, right: int) -> tuple[int, int]:
        if shape.directed:
            return ahead, -right if s.mirror else right
        rows, cols = s.vector(-ahead, right)
        return -rows, cols

    return shape.model_copy(
        update={"lanes": tuple(tuple(moved(*cell) for cell in lane) for lane in shape.lanes)}
    )
