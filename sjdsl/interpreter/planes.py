"""The planes of an observation: their order, and what their values stand for."""

from dataclasses import dataclass
from typing import Literal

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import marking_phases

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
    """One value for each cell of a window.

    encoding: `word`: an index into `labels`; `bits`: bit k stands for label k; `number`.
    what: `content`, `agent`, `marks`, or what the observable is of. observable: what is shown, for planes of one field. agent: of whom, for
    planes of every agent.
    """

    name: str
    encoding: Literal["word", "bits", "number"]
    labels: tuple[str, ...]
    what: Literal["content", "agent", "marks", "other", "mover", "everyone", "own", "world"]
    observable: ir.Observable | None = None
    agent: int | None = None


def planes(game: ir.Game) -> tuple[Plane, ...]:
    """Returns the planes of a game in the order of the last axis of an observation."""
    result = [
        Plane("content", "word", content_labels(game), "content"),
        Plane("agent", "word", AGENT_WORDS, "agent"),
    ]
    if marking_phases(game) and not any(
        hidden.what == "marks" and hidden.on == "map" for hidden in game.hidden
    ):
        result.append(
            Plane("marks", "bits", tuple(phase.label for phase in marking_phases(game)), "marks")
        )
    for what in ("other", "mover", "everyone", "own", "world"):
        agents = range(game.agents.number) if what == "everyone" else (None,)
        result += [
            _field_plane(observable, agent)
            for observable in game.observables
            if observable.what == what
            for agent in agents
        ]
    return tuple(result)


def observable_words(observable: ir.Observable) -> tuple[str, ...]:
    """Returns the words an observable can show: its labels if it has some, else the field's; none for a number."""
    words = tuple(dict.fromkeys(label.name for label in observable.labels)) or observable.type.words
    return (*words, HIDDEN) if words and observable.shown_when is not None else words


def content_observables(game: ir.Game, kind: str) -> tuple[ir.Observable, ...]:
    """Returns the word fields that are seen of a kind's cells."""
    return tuple(s for s in game.observables if s.what == "cell" and s.kind == kind)


def content_words(observable: ir.Observable) -> tuple[str, ...]:
    """Returns the words of a cell's field as they are seen: one more if it can be hidden."""
    return (
        (*observable_words(observable), HIDDEN)
        if observable.hidden_when is not None
        else observable_words(observable)
    )


def content_labels(game: ir.Game) -> tuple[str, ...]:
    """Returns the labels of the content plane.

    Outside the map, then every visible state of every kind, first field slowest; then what kinds that are shown as a whole look like beside,
    and how a cell looks that an agent covers.
    """
    labels = [OUTSIDE]
    others: list[str] = []
    for kind in game.kinds:
        whole = look_of(game, kind.name)
        if whole is not None:
            others += observable_words(whole)
            continue
        states = [kind.name]
        for observable in content_observables(game, kind.name):
            states = [
                f"{state} {field_name(observable)}={word}"
                for state in states
                for word in content_words(observable)
            ]
        labels += states
    if any(hidden.what == "content" for hidden in game.hidden):
        others.append(COVERED)
    return tuple(
        labels + [label for n, label in enumerate(others) if label not in labels + others[:n]]
    )


def look_of(game: ir.Game, kind: str) -> ir.Observable | None:
    """Returns the observable that says how a kind looks as a whole, if there is one."""
    wholes = [observable for observable in content_observables(game, kind) if not observable.field]
    return wholes[0] if wholes else None


def field_name(observable: ir.Observable) -> str:
    """Returns the field as an author writes it after its owner."""
    return (
        observable.field
        if observable.word is None
        else f"{observable.field}[{observable.word.key}]"
    )


def _field_plane(observable: ir.Observable, agent: int | None) -> Plane:
    assert observable.what != "cell"
    assert observable.what != "heading"
    words = observable_words(observable)
    if observable.what == "mover":
        name = (
            f"{observable.kind}.{field_name(observable)}" if observable.field else observable.kind
        )
        words = ("none", *words) if words else ()
        return Plane(name, "word" if words else "number", words, "mover", observable)
    owner = {"other": "other.", "everyone": f"everyone[{agent}].", "own": "agent.", "world": ""}[
        observable.what
    ]
    if observable.what == "other" and words:
        words = ("nobody", *words)
    return Plane(
        owner + field_name(observable),
        "word" if words else "number",
        words,
        observable.what,
        observable,
        agent,
    )
