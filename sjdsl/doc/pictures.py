"""The English of `look`: how the cells and agents of a game are drawn."""

from sjdsl.compiler import ir
from sjdsl.doc.conditions import condition
from sjdsl.doc.vocabulary import Vocabulary
from sjdsl.doc.wording import Line, bullets, code, joined


def pictures(v: Vocabulary) -> list[str]:
    """Returns the section on pictures."""
    intro = "No rule depends on this. What is not said is drawn as the game's rules suggest."
    return [intro, "", *bullets(picture_lines(v)), ""]


def picture_lines(v: Vocabulary) -> list[Line]:
    """Returns a sentence for each `look`."""
    return [_look(look, v) for look in v.game.looks]


def _look(look: ir.Look, v: Vocabulary) -> Line:
    noun = "the agent" if look.what == "agent" else f"the {look.name}" if look.what == "mover" else f"the {v.kinds(look.kinds)} cell"
    shown = [] if look.body is None else [_paint(look.body, "drawn")]
    shown += [] if look.badge is None else [f"{'' if shown else 'drawn '}with {_sprite(look.badge)} in its corner"]
    when = "" if look.condition is None else f" where {condition(look.condition, v)}"
    return Line(f"{noun} is {joined(shown)}{when}")


def _paint(paint: ir.Paint, verb: str) -> str:
    return f"{verb} as {_sprite(paint)}" if paint.sprite else f"{verb} in {paint.colour}"


def _sprite(paint: ir.Paint) -> str:
    return f"{paint.colour} {code(paint.sprite)}".strip() if paint.sprite else f"a {paint.colour} mark"
