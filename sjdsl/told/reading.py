"""How to read a window: what it covers, what is shown in it and how, and what isn't."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import all_fields
from sjdsl.compiler.lower.cell_appearance import COVERED
from sjdsl.doc.actions import has_built_in_moves
from sjdsl.doc.wording import joined, number
from sjdsl.told.codes import HEADING_UNSEEN, UNSEEN
from sjdsl.told.legal import looks_north
from sjdsl.told.phrases import English
from sjdsl.told.relevance import FieldName, Relevant, fields_read
from sjdsl.told.window import Window

NOBODY = "nobody"  # the label of `other.` planes where no agent is
OTHERS_LOOK = (
    "A^ A> Av A< are other agents: ^ looks the way you do, > to your right, v toward you, "
    "< to your left."
)
MOST_CODES = 40  # of a game whose text lists them; otherwise they stand in each message alone


def reading(relevant: Relevant, window: Window, english: English) -> list[str]:
    """Returns the lines on how to read the window."""
    game = relevant.game
    seen = game.window
    lines = [
        f"You see the cells from {seen.ahead} ahead of you to {seen.behind} behind, and from "
        f"{seen.left} to your left to {seen.right} to your right.",
        *_views(seen, english),
        f"{_top(game, window)} ME is you. ## is outside the grid.",
    ]
    if game.agents.number > 1:
        lines += _others(window, game)
    if COVERED in window.codes and any(hidden.what == "content" for hidden in game.hidden):
        lines.append(f"{UNSEEN} is hidden from you.")
    codes = window.codes
    whole = {o.kind for o in game.observables if o.what == "cell" and not o.field}
    absent = {kind.name for kind in game.kinds} - english.naming.all_kinds - whole
    if len(codes) <= MOST_CODES:
        named = [
            f"{code} {label}"
            for label, code in codes.items()
            if code not in ("##", UNSEEN) and label.split()[0] not in absent
        ]
        lines.append(f"Other codes: {'; '.join(named)}.")
    else:
        lines.append("Below each window is the meaning of its codes.")
    lines += _planes(window, game)
    conditions = _conditions(game, english)
    if conditions:
        lines.append('How what is shown depends on the state ("the agent" is you):')
    lines += [f"- {text}." for text in conditions]
    unseen = not_shown(relevant)
    if unseen:
        lines.append(f"You are not shown: {joined(unseen)}.")
    return lines


def _top(game: ir.Game, window: Window) -> str:
    """Returns which way the top of the window is."""
    if looks_north(game):
        return "You always look north, so the top of the window is north."
    top = "The window turns with you: its top is the way you look"
    if game.agents.relative or not has_built_in_moves(game):
        return f"{top}."
    if any(plane.name == "agent.heading" for plane in window.planes):
        return f"{top}, which agent.heading says. Steps go by the compass."
    return f"{top}, which you are not told. Steps go by the compass."


def _others(window: Window, game: ir.Game) -> list[str]:
    """Returns what the codes of other agents mean."""
    labels = window.planes[1].labels
    lines = []
    if "other same heading" in labels:
        lines.append("A^ are other agents." if looks_north(game) else OTHERS_LOOK)
    if "other" in labels:
        lines.append(f"{HEADING_UNSEEN} is an agent whose direction you can't see.")
    return lines


def _views(window: ir.Window, english: English) -> list[str]:
    lines = []
    for view in window.views:
        who = "Otherwise it sees"
        if view.condition is not None:
            who = f"If {english.text(view.condition)}, an agent sees"
        lines.append(
            f"- {who} from {view.ahead} ahead to {view.behind} behind, and from {view.left} to the "
            f"left to {view.right} to the right; cells beyond look like ##."
        )
    return lines


def _planes(window: Window, game: ir.Game) -> list[str]:
    """Returns what is said below a window, with the values that it can have."""
    lines = []
    timers = {f"agent.{field.name}" for field in game.agents.fields if field.timer}
    lowest = {
        observable.field: observable.type.low
        for observable in game.observables
        if observable.what in ("own", "other") and observable.type.kind == "int"
        if observable.hidden_when is None and observable.shown_when is None
    }
    timers |= {name.replace("agent.", "other.") for name in timers}
    for plane in window.planes[2:]:
        if plane.encoding == "number":
            low = number(lowest.get(plane.name.partition(".")[2], 0))
            is_timer = plane.name.partition("[")[0] in timers
            values = "a timer" if is_timer else f"{low} to {plane.high}"
            lines.append(f"- {plane.name}: {values}")
        elif plane.name != "marks":
            labels = list(plane.labels)
            if plane.name.startswith("other.") and labels[0] == NOBODY:
                labels = labels[1:]  # it is said of agents alone
            lines.append(f"- {plane.name}: {', '.join(labels)}")
    if lines:
        head = "Below the window are (`agent.` is your own, `other.` of others in view):"
        lines.insert(0, head)
    marks = next((plane for plane in window.planes if plane.name == "marks"), None)
    if marks is not None:
        stages = joined(marks.labels)
        lines.insert(
            0,
            f"Below the window are the cells that the last step marked, by stage ({stages}).",
        )
    return lines


def _conditions(game: ir.Game, english: English) -> list[str]:
    """Returns how what is shown depends on the state, where a label or a condition says so."""
    texts = []
    for observable in game.observables:
        name = _name(observable)
        if observable.value is not None and not observable.labels:
            value = english.text(observable.value)
            if value != name:
                texts.append(f"{name} is {value}")
        labels = observable.labels
        if labels and labels[0].condition is not None:
            looks = ", ".join(_look(label, english) for label in labels)
            texts.append(f"{name} is shown as {looks}")
        elif labels and labels[0].name != name:
            texts.append(f"{name} always looks like {labels[0].name}")
        if observable.hidden_when is not None:
            texts.append(f"{name} is hidden if {english.text(observable.hidden_when)}")
        if observable.shown_when is not None:
            shown = f"{name} is shown only if {english.text(observable.shown_when)}"
            texts.append(
                f"{shown}; else it is {'0' if observable.type.kind == 'int' else 'hidden'}"
            )
    for hidden in game.hidden:
        what = "marks are" if hidden.what == "marks" else "what a cell is, is"
        match hidden.on:
            case "map":
                texts.append(f"{what} never seen")
            case "agents":
                texts.append(f"{what} not seen where an agent stands")
            case "cells":
                when = "" if hidden.when is None else f" if {english.text(hidden.when)}"
                texts.append(f"{what} not seen on {joined(hidden.kinds, 'or')} cells{when}")
    return texts


def _look(label: ir.Label, english: English) -> str:
    if label.condition is None:
        return f"{label.name} otherwise"
    return f"{label.name} if {english.text(label.condition)}"


def _name(observable: ir.Observable) -> str:
    match observable.what:
        case "cell" | "mover":
            owner = observable.kind
        case "own":
            owner = "agent"
        case "other" | "everyone":
            owner = observable.what
        case "world":
            owner = ""
        case "heading":
            return "other.heading"
    entry = "" if observable.word is None else f"[{observable.word.key}]"
    name = f"{observable.field}{entry}"
    return ".".join(filter(None, (owner, name)))


def not_shown(relevant: Relevant) -> list[str]:
    """Returns the fields that the rules speak of and no observation shows or tells of.

    Those of the player's own agent are `agent.NAME`, those of the others `other.NAME`.
    """
    game = relevant.game
    shown: set[FieldName] = set()
    shown_of_others: set[FieldName] = set()
    for observable in game.observables:
        held_by = observable.entity_type
        fields = fields_read(observable) | {(held_by.what, held_by.name, observable.field)}
        if observable.what in ("other", "everyone"):
            shown_of_others |= fields
        if observable.what != "other":
            shown |= fields
    names = []
    for field in all_fields(game):
        held_by = field.held_by
        key = (held_by.what, held_by.name, field.name)
        if not relevant.has(field) or field.name == "heading":
            continue
        if key not in shown:
            names.append(field.name if held_by.what == "world" else f"{held_by.name}.{field.name}")
        if held_by.what == "agent" and game.agents.number > 1 and key not in shown_of_others:
            names.append(f"other.{field.name}")
    return names
