"""The English of observations: what an agent observes, and which parts of the state are hidden from it."""

from collections.abc import Iterator

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import can_be_away, marking_phases
from sjdsl.compiler.lower.cell_appearance import shown_words
from sjdsl.doc.phrases import condition, value
from sjdsl.doc.vocabulary import Vocabulary
from sjdsl.doc.wording import Line, bullets, code, codes, counted, joined

AGENTS = (
    "whether no agent, it itself or another agent stands there, and which way another agent looks, as seen by the observer "
    "(same direction, right, opposite, left)"
)


def observation(v: Vocabulary) -> list[str]:
    """Returns the section on observation."""
    unseen = unseen_fields(v.game)
    hidden = f"Not seen: {joined(unseen)}." if unseen else "Nothing of the state is hidden but what lies outside the window."
    return [window(v), "", "It sees, for every cell of the window:", "", *bullets(seen(v)), "", hidden, ""]


def seen(v: Vocabulary) -> list[Line]:
    """Returns what is seen in each cell of the window."""
    covered = "; not of a cell on which an agent stands, the observer itself among them: it looks `covered`"
    is_covered = any(hidden.what == "content" for hidden in v.game.hidden)
    return [
        Line("the kind of every cell, or that it is outside the map" + (covered if is_covered else "")),
        *(_observable(s, v) if s.field else _look(s, v) for s in v.game.observables if s.what == "cell"),
        Line(AGENTS),
        *_marks(v),
        *(_observable(s, v) for s in v.game.observables if s.what not in ("cell", "heading")),
    ]


def window(v: Vocabulary) -> str:
    """Returns how far an agent sees."""
    view = v.game.window
    rows, columns = view.ahead + 1 + view.behind, view.left + 1 + view.right
    size = f"{counted(rows, 'row')} of {counted(columns, 'cell')}"
    away = " An agent that is away sees nothing." if can_be_away(v.game) else ""
    seen = f"After each step every agent sees a window of {size} around it ({_sides(view)}), turned so that the agent looks up.{away}"
    if not view.views:
        return seen
    own = "Of these cells it sees those of its own window, and all others as if they were outside the map."
    return f"{seen} {own} The window goes {'; '.join(views(v))}."


def views(v: Vocabulary) -> list[str]:
    """Returns how far the own windows of agents go, the first that applies first."""
    return [f"{_sides(x)} {'otherwise' if x.condition is None else f'if {condition(x.condition, v)}'}" for x in v.game.window.views]


def _sides(view: ir.View | ir.Window) -> str:
    return f"{view.ahead} ahead, {view.behind} behind, {view.left} to the left, {view.right} to the right"


def _look(s: ir.Observable, v: Vocabulary) -> Line:
    """Returns how cells of a kind look that are shown as a whole."""
    shown = code(s.labels[0].name) if len(s.labels) == 1 else f"the first of these that applies: {_labels(s.labels, v)}{_readers(s)}"
    return Line(f"{code(s.kind)} cells not as what they are, but as {shown}")


def _marks(v: Vocabulary) -> list[Line]:
    game = v.game
    phases = [phase.label for phase in marking_phases(game)]
    hidden = [h for h in game.hidden if h.what == "marks"]
    if not phases or any(h.on == "map" for h in hidden):
        return [Line(f"no marks{'' if not phases else f' of {codes(phases)}'}")] if hidden else []
    unseen = "; ".join(_not_marked(h, v) for h in hidden)
    return [Line(f"which of these phases marked it in this step, if any: {codes(phases)}" + (f"; but no marks {unseen}" if unseen else ""))]


def _not_marked(h: ir.Hidden, v: Vocabulary) -> str:
    if h.on == "agents":
        return "where an agent stands"
    test = "" if h.when is None else f' if {condition(h.when, v)} ("the agent" is the observer)'
    return f"on {joined(list(h.kinds), 'or')} cells" + (f" (each *{h.name}*)" if h.name not in h.kinds else "") + test


def _observable(s: ir.Observable, v: Vocabulary) -> Line:
    whose = {
        "cell": f"each {s.kind} cell",
        "own": "the observer itself",
        "other": "other agents, where they stand",
        "everyone": "every agent, wherever it is, in the order of their numbers",
        "world": "the world",
        "mover": f"each {s.kind}, where it stands",
    }[s.what]
    if s.what == "mover" and not s.field:
        unless = "" if s.hidden_when is None else f", unless {condition(s.hidden_when, v)}{_readers(s)}"
        return Line(f"whether a {s.kind} stands there{unless}")
    entry = "the"
    if s.word is not None:
        entry = f"the {f'{code(s.word.name)} entry' if s.word.level.sort == 'word' else f'entry for {s.word.name}'} of the"
    relative = " as seen by the observer" if s.what == "mover" and s.field == "heading" and not s.labels else ""
    whose = whose.replace(",", f"{relative},") if relative else whose
    named = f"{entry} {code(s.field)} of {whose}" if s.value is None else value(s.value, v)
    text = named + (", the same everywhere in the window" if s.what in ("everyone", "own", "world") else "")
    if s.labels:
        text += f", shown as the first of these that applies: {_labels(s.labels, v)}"
    if s.hidden_when is not None:
        text += f", unless {condition(s.hidden_when, v)}"
    if s.shown_when is not None:
        text += f", if {condition(s.shown_when, v)}; otherwise {code('hidden') if shown_words(s) else 0}"
    conditional = s.hidden_when is not None or s.shown_when is not None
    return Line(text + (_readers(s) if s.labels or conditional else ""))


def _readers(s: ir.Observable) -> str:
    """Returns what the variables in the conditions of an observable stand for."""
    name = "everyone" if s.what == "everyone" else "other"
    movers = f', "the {s.kind}" the one that is seen'
    other = {"cell": f', "the {s.kind} cell" the cell that is seen', "mover": movers, "own": "", "world": ""}.get(
        s.what, f", agent *{name}* the one that is seen"
    )
    return f' ("the agent" is the observer{other})'


def _labels(labels: tuple[ir.Label, ...], v: Vocabulary) -> str:
    return "; ".join(code(x.name) + (f" if {condition(x.condition, v)}" if x.condition is not None else " otherwise") for x in labels)


def unseen_fields(game: ir.Game) -> list[str]:
    """Returns the fields that no observable shows."""
    shown = {(s.what, s.kind, s.field) for s in game.observables}
    shown |= {("cell", s.kind, name) for s in game.observables if s.what == "cell" and not s.field for name in _read(s)}
    shown |= {(what, "", name) for sort, _, name in shown if sort == "everyone" for what in ("own", "other")}
    return [text for key, text in _fields(game) if key not in shown]


def _read(s: ir.Observable) -> set[str]:
    """Returns the fields of a kind that decide how its cells look."""
    nodes = (n for label in s.labels if label.condition is not None for n in ir.walk(label.condition))
    return {n.name for n in nodes if isinstance(n, ir.FieldRead) and n.held_by.what == "cell"}


def _fields(game: ir.Game) -> Iterator[tuple[tuple[str, str, str], str]]:
    for kind in game.kinds:
        yield from ((("cell", kind.name, f.name), f"the {code(f.name)} of {kind.name} cells") for f in kind.fields)
    for what, whose in (("own", "the observer itself"), ("other", "other agents")):
        yield from (((what, "", f.name), f"the {code(f.name)} of {whose}") for f in game.agents.fields)
    for sort in game.movers:
        yield from ((("mover", sort.name, f.name), f"the {code(f.name)} of {sort.name} movers") for f in sort.fields)
        yield ("mover", sort.name, ""), f"where {sort.name} movers stand"
    yield from ((("world", "", f.name), f"the {code(f.name)} of the world") for f in game.fields)
