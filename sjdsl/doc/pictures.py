"""The English of `look`: how the cells and agents of a game are drawn."""

from sjdsl.compiler import ir
from sjdsl.doc.phrases import condition
from sjdsl.doc.vocabulary import Vocabulary
from sjdsl.doc.wording import Line, bullets, code, joined


def pictures(v: Vocabulary) -> list[str]:
    """Returns the section on pictures."""
    intro = "No rule depends on this. What is not said is drawn as the game's rules suggest."
    return [intro, "", *bullets(picture_lines(v)), ""]


def picture_lines(v: Vocabulary) -> list[Line]:
    """Returns a sentence for each `look`."""
    found = []
    for look in v.game.looks:
        noun = {"agent": "agent", "mover": look.name}.get(look.what) or f"{v.kinds(look.kinds)} cell"
        shown = [] if look.body is None else [f"as {_sprite(look.body)}" if look.body.sprite else f"in {look.body.colour}"]
        shown += [] if look.badge is None else [f"with {_sprite(look.badge)} in its corner"]
        when = "" if look.condition is None else f" where {condition(look.condition, v)}"
        found.append(Line(f"the {noun} is drawn {joined(shown)}{when}"))
    return found


def _sprite(paint: ir.Paint) -> str:
    return f"{paint.colour} {code(paint.sprite)}".strip() if paint.sprite else f"a {paint.colour} mark"
