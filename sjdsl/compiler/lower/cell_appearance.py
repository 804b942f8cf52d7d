"""Appearance of cells: numbers for the states of kinds, as painted and as an observer sees them."""

from dataclasses import replace
from math import prod

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.ir.queries import (
    can_be,
    kinds_by_glyph,
    marking_phases,
    shown_field,
    shows_attribute,
)
from sjdsl.compiler.lower.scope import NotSupported
from sjdsl.compiler.lower.state_reads import timer_bound
from sjdsl.compiler.program import expressions as array
from sjdsl.runtime.planes import TokenPlane

OTHER_FACING = 2  # number of the agent plane: the first heading of another
AGENT_LABELS = (
    "none",
    "self",
    "other same heading",
    "other turned right",
    "other opposite",
    "other turned left",
)


COVERED = "covered"  # how a cell looks on which an agent stands, if agents hide what they stand on
OUTSIDE = "outside"
UNIFORM = ("everyone", "own", "world")  # what is shown of these has one value for a whole window
HIDDEN = "hidden"


class Look(Record):
    """One kind: its painted fields with their numbers of values, and its observables in order.

    `raw` and `final` are the first numbers of the kind in the two numberings; a kind that is not on the map has no raw ones. `labels`: the
    final numbers of the labels of a kind that is shown as a whole. A kind that always looks like another is painted as that, and not
    `present` as itself.
    """

    kind: ir.Kind
    painted: tuple[tuple[ir.VarField, int], ...]
    observables: tuple[ir.Observable, ...]
    raw: int
    final: int
    present: bool
    labels: tuple[int, ...] = ()

    @property
    def raw_values(self) -> int:
        return int(self.present) * prod(values for _, values in self.painted)

    @property
    def final_words(self) -> tuple[tuple[str, ...], ...]:
        """The words each observable shows, in order."""
        return tuple(observable_words(s) for s in self.observables)

    @property
    def same(self) -> bool:
        """Whether an observer is shown exactly what is painted."""
        plain = all(not s.labels and s.hidden_when is None for s in self.observables)
        return plain and [f.name for f, _ in self.painted] == [s.field for s in self.observables]


def observable_words(observable: ir.Observable) -> tuple[str, ...]:
    """Returns the words or labels a cell observable shows; `hidden` is the last if it can be hidden."""
    words = (
        tuple(dict.fromkeys(label.name for label in observable.labels))
        if observable.labels
        else observable.type.words
    )
    return (*words, HIDDEN) if observable.hidden_when is not None else words


def looks(game: ir.Game) -> tuple[Look, ...]:
    """Returns the looks of all kinds in declaration order. If they are too many for a byte, what only labels read is not painted."""
    found, raw = _numbered_looks(game, True)
    if raw > 256:
        found, raw = _numbered_looks(game, False)
    if raw > 256 or len(content_labels(game)) > 256:
        what = f"{max(raw, len(content_labels(game)))} different looks of cells (at most 256)"
        raise NotSupported(
            what,
            game.kinds[-1].origin,
            "`hide` fields of cells that need not be seen, or show them with fewer labels",
        )
    painted_as = {name: _as_another(look, game) for name, look in found.items()}
    raws = {
        name: 0 if other == OUTSIDE else found[other].raw
        for name, other in painted_as.items()
        if other is not None
    }
    return tuple(
        replace(look, raw=raws[name], present=False) if name in raws else look
        for name, look in found.items()
    )


def _numbered_looks(game: ir.Game, read: bool) -> tuple[dict[str, Look], int]:
    """Returns the looks of all kinds, and how many numbers are painted. `read`: also the fields are painted that labels and `hide` read."""
    raw, labels, there = 1, content_labels(game), _kinds_on_map(game)
    found: dict[str, Look] = {}
    for kind in game.kinds:
        observables = _observables_of(kind, game)
        whole = _shown_as(kind, game)
        numbers = (
            tuple(labels.index(word) for word in observable_words(whole))
            if whole is not None
            else ()
        )
        final = numbers[0] if numbers else labels.index(_states(kind, game)[0])
        painted = tuple((f, _values(f, game)) for f in _painted(kind, observables, game, read))
        found[kind.name] = Look(kind, painted, observables, raw, final, kind.name in there, numbers)
        if _as_another(found[kind.name], game) is None:
            raw += found[kind.name].raw_values
    return found, raw


def _as_another(look: Look, game: ir.Game) -> str | None:
    """Returns what else, that can be painted, a kind always looks like: another kind on the map, or what is outside."""
    name = look.observables[0].labels[-1].name if len(look.labels) == 1 else ""
    if not name or any(
        kind in hidden.kinds for hidden in game.hidden for kind in (look.kind.name, name)
    ):
        return None
    there = name in _kinds_on_map(game) and all(s.kind != name for s in game.observables)
    return name if name == OUTSIDE or there else None


def _kinds_on_map(game: ir.Game) -> set[str]:
    return {kinds_by_glyph(game)[glyph] for glyph in set().union(*game.rows)}


def _observables_of(kind: ir.Kind, game: ir.Game) -> tuple[ir.Observable, ...]:
    return tuple(s for s in game.observables if s.what == "cell" and s.kind == kind.name)


def _shown_as(kind: ir.Kind, game: ir.Game) -> ir.Observable | None:
    """Returns the observable that says how cells of a kind look as a whole, if there is one."""
    return next((s for s in _observables_of(kind, game) if not s.field), None)


def _painted(
    kind: ir.Kind, observables: tuple[ir.Observable, ...], game: ir.Game, read: bool
) -> list[ir.VarField]:
    """Returns the fields that are painted: those shown as they are, and those that labels and `hide` read and that have few values.

    The others are looked up, for each cell of each window.
    """
    wanted = {s.field for s in observables if not s.labels}
    conditions = [
        c for s in observables for c in (*(label.condition for label in s.labels), s.hidden_when)
    ]
    conditions += [hidden.when for hidden in game.hidden if kind.name in hidden.kinds]
    for node in (n for c in conditions if c is not None and read for n in ir.walk(c)):
        if (
            isinstance(node, ir.FieldRead)
            and isinstance(node.owner, ir.Member)
            and kind.name in node.held_by.names
        ):
            wanted.add(node.name)
    return [f for f in kind.fields if f.name in wanted and _values(f, game)]


def _values(field: ir.VarField, game: ir.Game) -> int:
    """Returns how many values a field has that can be painted; 0 if it cannot."""
    if field.type.by:
        return 0
    match field.type.kind:
        case "word":
            return len(field.type.words)
        case "agent":
            return game.agents.number + 1
        case "int" if field.type.low >= 0:
            bound = timer_bound(field, ir.walk(game)) if field.timer else field.type.high
            return int(bound) + 1 if bound < 256 else 0
        case _:
            return 0


def content_labels(game: ir.Game) -> tuple[str, ...]:
    """Returns the labels of the content plane in the order of its values."""
    whole = [(kind, _shown_as(kind, game)) for kind in game.kinds]
    states = [
        state for kind, observable in whole if observable is None for state in _states(kind, game)
    ]
    looks = [
        word
        for _, observable in whole
        if observable is not None
        for word in observable_words(observable)
    ]
    covered = [COVERED] if any(hidden.what == "content" for hidden in game.hidden) else []
    return tuple(dict.fromkeys([OUTSIDE, *states, *looks, *covered]))


def _states(kind: ir.Kind, game: ir.Game) -> list[str]:
    """Returns the labels of all states that are seen of a kind, the first field slowest."""
    names = [kind.name]
    for observable in _observables_of(kind, game):
        names = [f"{n} {observable.field}={w}" for n in names for w in observable_words(observable)]
    return names


def seen_marks(game: ir.Game) -> tuple[ir.Phase, ...]:
    """Returns those whose marks are seen: all, or none if marks are hidden everywhere."""
    return (
        ()
        if any(hidden.what == "marks" and hidden.on == "map" for hidden in game.hidden)
        else marking_phases(game)
    )


def token_planes(game: ir.Game) -> tuple[TokenPlane, ...]:
    """Returns what each plane of a `tokens` observation means, in order."""
    planes = [TokenPlane("content", "word", content_labels(game), len(content_labels(game)) - 1)]
    planes.append(TokenPlane("agent", "word", AGENT_LABELS, len(AGENT_LABELS) - 1))
    marking = seen_marks(game)
    if marking:
        planes.append(
            TokenPlane("marks", "bits", tuple(p.label for p in marking), 2 ** len(marking) - 1)
        )
    everyone = tuple(f"everyone[{agent}]." for agent in range(game.agents.number))
    owners: dict[str, tuple[str, ...]] = {
        "other": ("other.",),
        "mover": ("",),
        "everyone": everyone,
        "own": ("agent.",),
        "world": ("",),
    }
    for what, prefixes in owners.items():
        for observable in game.observables:
            if observable.what == what:
                planes += [_field_plane(observable, prefix, game) for prefix in prefixes]
    return tuple(planes)


def _field_plane(observable: ir.Observable, prefix: str, game: ir.Game) -> TokenPlane:
    if observable.what == "mover":
        prefix = f"{observable.kind}." if observable.field else observable.kind
    name = f"{prefix}{observable.field}" + (f"[{observable.word.key}]" if observable.word else "")
    uniform = observable.what in UNIFORM
    if words := shown_words(observable):
        words = (*{"other": ("nobody",), "mover": ("none",)}.get(observable.what, ()), *words)
        return TokenPlane(name, "word", words, len(words) - 1, uniform)
    high = number_bound(observable, game)
    if high == float("inf"):
        raise NotSupported(
            f"showing `{name}`, which has no bound: give the numbers it is set to limits within 0 .. 255",
            observable.origin,
        )
    if high > 255:
        instead = (
            f"show it with labels, such as `show {name} as {{ much where {name} > 99, little }}`"
        )
        instead += (
            f", or a define of less, such as `quotient({name}, {high // 256 + 1:g})`"
            if observable.value is not None
            else ""
        )
        raise NotSupported(
            f"showing `{name}`, which can reach {high:g} (at most 255)", observable.origin, instead
        )
    return TokenPlane(name, "number", (), int(high), uniform)


def shown_words(observable: ir.Observable) -> tuple[str, ...]:
    """Returns the words that a plane of a field shows, none for a number; `hidden` is the last of what is shown under a condition."""
    words = (
        tuple(dict.fromkeys(x.name for x in observable.labels))
        if observable.labels
        else observable.type.words
    )
    return (*words, HIDDEN) if words and observable.shown_when is not None else words


def number_bound(observable: ir.Observable, game: ir.Game) -> float:
    """Returns the largest value of a shown number; for a timer what the limits of the numbers it is set to allow."""
    if shows_attribute(observable) or observable.value is not None:
        return observable.type.high
    field = shown_field(game, observable)
    if not field.timer:
        return field.type.high
    sets = (
        n
        for n in ir.walk(game)
        if isinstance(n, ir.Set) and isinstance(n.target, ir.FieldRead) and can_be(n.target, field)
    )
    return max((largest(s.value, game) for s in sets), default=0.0)


def largest(e: ir.Expr, game: ir.Game) -> float:
    """Returns an upper bound of a number, whatever the parameters are set to."""
    if isinstance(e, ir.Local) and e.type.high == float("inf"):
        drawn = [
            d
            for d in ir.walk(game)
            if isinstance(d, ir.Draw) and d.name == e.name and d.high is not None
        ]
        return max((largest(d.high, game) for d in drawn), default=e.type.high)  # type: ignore[arg-type]
    return e.type.high


def relative_heading(difference: array.Expression) -> array.Expression:
    """Returns the number of another's heading relative to the observer's."""
    return array.Binary(
        "+", array.Literal(OTHER_FACING), array.Binary("&", difference, array.Literal(3))
    )
