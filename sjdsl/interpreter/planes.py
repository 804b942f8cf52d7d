"""The planes of an observation: their order, and what their values stand for."""

from dataclasses import dataclass
from typing import Literal

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import marking_phases, sight_of_headings

HIDDEN = "hidden"
OUTSIDE = "outside"
COVERED = "covered"
AGENT_WORDS = ("none", "self", "other same heading", "other turned right", "other opposite", "other turned left")


@dataclass(frozen=True)
class Plane:
    """One value for each cell of a window.

    encoding: `word`: an index into `labels`; `bits`: bit k stands for label k; `number`.
    what: `content`, `agent`, `marks`, or what the sight is of. sight: what is shown, for planes of one field. agent: of whom, for
    planes of every agent.
    """

    name: str
    encoding: Literal["word", "bits", "number"]
    labels: tuple[str, ...]
    what: Literal["content", "agent", "marks", "other", "everyone", "own", "world"]
    sight: ir.Sight | None = None
    agent: int | None = None


def planes(game: ir.Game) -> tuple[Plane, ...]:
    """Returns the planes of a game in the order of the last axis of an observation."""
    result = [
        Plane("content", "word", content_labels(game), "content"),
        Plane("agent", "word", _agent_labels(game), "agent"),
    ]
    if marking_phases(game) and not any(hidden.what == "marks" and hidden.on == "map" for hidden in game.hidden):
        result.append(Plane("marks", "bits", tuple(phase.label for phase in marking_phases(game)), "marks"))
    for what in ("other", "everyone", "own", "world"):
        agents = range(game.agents.number) if what == "everyone" else (None,)
        result += [_field_plane(sight, agent) for sight in game.sights if sight.what == what for agent in agents]
    return tuple(result)


def sight_words(sight: ir.Sight) -> tuple[str, ...]:
    """Returns the words a sight can show: its labels if it has some, else the field's; none for a number."""
    return tuple(dict.fromkeys(label.name for label in sight.labels)) or sight.type.words


def content_sights(game: ir.Game, kind: str) -> tuple[ir.Sight, ...]:
    """Returns the word fields that are seen of a kind's cells."""
    return tuple(s for s in game.sights if s.what == "cell" and s.kind == kind)


def content_words(sight: ir.Sight) -> tuple[str, ...]:
    """Returns the words of a cell's field as they are seen: one more if it can be hidden."""
    return (*sight_words(sight), HIDDEN) if sight.hidden_when is not None else sight_words(sight)


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
            others += sight_words(whole)
            continue
        states = [kind.name]
        for sight in content_sights(game, kind.name):
            states = [f"{state} {field_name(sight)}={word}" for state in states for word in content_words(sight)]
        labels += states
    if any(hidden.what == "content" for hidden in game.hidden):
        others.append(COVERED)
    return tuple(labels + [label for n, label in enumerate(others) if label not in labels + others[:n]])


def look_of(game: ir.Game, kind: str) -> ir.Sight | None:
    """Returns the sight that says how a kind looks as a whole, if there is one."""
    wholes = [sight for sight in content_sights(game, kind) if not sight.field]
    return wholes[0] if wholes else None


def field_name(sight: ir.Sight) -> str:
    """Returns the field as an author writes it after its owner."""
    return sight.field if sight.word is None else f"{sight.field}[{sight.word}]"


def _agent_labels(game: ir.Game) -> tuple[str, ...]:
    headings = sight_of_headings(game)
    if headings is None:
        return ("none", "self", "other")
    return AGENT_WORDS if headings.hidden_when is None else (*AGENT_WORDS, "other")


def _field_plane(sight: ir.Sight, agent: int | None) -> Plane:
    assert sight.what != "cell"
    assert sight.what != "heading"
    owner = {"other": "other.", "everyone": f"everyone[{agent}].", "own": "agent.", "world": ""}[sight.what]
    words = sight_words(sight)
    if sight.what == "other" and words:
        words = ("nobody", *words)
    return Plane(owner + field_name(sight), "word" if words else "number", words, sight.what, sight, agent)
