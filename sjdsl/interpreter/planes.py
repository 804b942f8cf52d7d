"""The planes of an observation: their order, and what their values stand for."""

from dataclasses import dataclass
from typing import Literal

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import marking_phases, seen_heading

HIDDEN = "hidden"
OUTSIDE = "outside"
COVERED = "covered"
AGENT_WORDS = (
    "none",
    "self",
    "other same heading",
    "other turned right",
    "other opposite",
    "other turned left",
)


@dataclass(frozen=True)
class Plane:
    """One value for each cell of a window."""

    name: str
    # `word`: an index into `labels`; `bits`: bit k stands for label k; `number`.
    encoding: Literal["word", "bits", "number"]
    labels: tuple[str, ...]
    what: Literal["content", "agent", "marks", "other", "mover", "everyone", "own", "world"]
    observable: ir.Observable | None = None  # for planes of one field
    agent: int | None = None  # for planes of every agent: whose field it is


def planes(game: ir.Game) -> tuple[Plane, ...]:
    """Returns the planes of a game in the order of the last axis of an observation."""
    result = [
        Plane("content", "word", content_labels(game), "content"),
        Plane("agent", "word", agent_words(game), "agent"),
    ]
    marking = marking_phases(game)
    are_hidden = any(hidden.what == "marks" and hidden.on == "map" for hidden in game.hidden)
    if marking and not are_hidden:
        labels = tuple(phase.label for phase in marking)
        result.append(Plane("marks", "bits", labels, "marks"))
    for what in ("other", "mover", "everyone", "own", "world"):
        agents = range(game.agents.number) if what == "everyone" else (None,)
        for observable in game.observables:
            if observable.what == what:
                result += [_field_plane(observable, agent) for agent in agents]
    return tuple(result)


def agent_words(game: ir.Game) -> tuple[str, ...]:
    """Returns the labels of the plane of agents; `other` is one whose heading is hidden."""
    heading = seen_heading(game)
    if heading is None:
        return ("none", "self", "other")
    return AGENT_WORDS if heading.hidden_when is None else (*AGENT_WORDS, "other")


def observable_words(observable: ir.Observable) -> tuple[str, ...]:
    """Returns the labels of an observable, or the enum values of its field; none for a number."""
    labels = dict.fromkeys(label.name for label in observable.labels)
    words = tuple(labels) or observable.type.words
    return (*words, HIDDEN) if words and observable.shown_when is not None else words


def content_observables(game: ir.Game, kind: str) -> tuple[ir.Observable, ...]:
    """Returns the observables that are part of the content of a kind's cells."""
    return tuple(s for s in game.observables if s.what == "cell" and s.kind == kind)


def content_words(observable: ir.Observable) -> tuple[str, ...]:
    """Returns the labels of an observable of cells, with `hidden` if it can be hidden."""
    words = observable_words(observable)
    return words if observable.hidden_when is None else (*words, HIDDEN)


def content_labels(game: ir.Game) -> tuple[str, ...]:
    """Returns the labels of the content plane, each once.

    First `outside`, then every visible state of every kind, first field slowest; then the labels of
    kinds that have one look, and `covered`, for a cell that an agent covers.
    """
    labels = [OUTSIDE]
    look_labels: list[str] = []
    for kind in game.kinds:
        look = look_of(game, kind.name)
        if look is not None:
            look_labels += observable_words(look)
            continue
        states = [kind.name]
        for observable in content_observables(game, kind.name):
            name = field_name(observable)
            words = content_words(observable)
            states = [f"{state} {name}={word}" for state in states for word in words]
        labels += states
    if any(hidden.what == "content" for hidden in game.hidden):
        look_labels.append(COVERED)
    return (*labels, *(label for label in dict.fromkeys(look_labels) if label not in labels))


def look_of(game: ir.Game, kind: str) -> ir.Observable | None:
    """Returns the observable with the look of a kind, which shows no field, if there is one."""
    looks = [observable for observable in content_observables(game, kind) if not observable.field]
    return looks[0] if looks else None


def field_name(observable: ir.Observable) -> str:
    """Returns the field as an author writes it after its owner."""
    if observable.word is None:
        return observable.field
    return f"{observable.field}[{observable.word.key}]"


def _field_plane(observable: ir.Observable, agent: int | None) -> Plane:
    """Returns the plane of an observable. `agent`: whose field it is, in planes of every agent."""
    what = observable.what
    assert what != "cell"
    assert what != "heading"
    labels = observable_words(observable)
    if what == "mover":
        name = observable.kind
        if observable.field:
            name += f".{field_name(observable)}"
        labels = ("none", *labels) if labels else ()
        return Plane(name, "word" if labels else "number", labels, "mover", observable)
    prefixes = {"other": "other.", "everyone": f"everyone[{agent}].", "own": "agent.", "world": ""}
    name = prefixes[what] + field_name(observable)
    if what == "other" and labels:
        labels = ("nobody", *labels)
    return Plane(name, "word" if labels else "number", labels, what, observable, agent)
