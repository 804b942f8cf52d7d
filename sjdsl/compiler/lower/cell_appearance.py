"""Numbers for the appearance of cells, as they are painted and as an observer sees them."""

from dataclasses import replace
from itertools import product
from math import inf, prod

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.ir.queries import (
    kinds_by_glyph,
    marking_phases,
    seen_heading,
    sets,
    shown_field,
    shows_attribute,
)
from sjdsl.compiler.lower.scope import NotSupported
from sjdsl.compiler.lower.state_reads import timer_bound
from sjdsl.compiler.program.expressions import Expression, Literal
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
    """How cells of one kind look.

    A cell is painted as a number for its kind and the values of the kind's painted fields. An
    observer sees a number for its kind and what is shown of it (`observables`), which may differ.

    painted: the fields that are painted, each with how many values it has.
    raw, final: the kind's first number, as painted and as seen; its others follow.
    present: whether it is painted as itself: it is on the map, and doesn't always look like
      something else.
    labels: of a kind that is shown as a whole, the final number of each of its labels.
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
        """Whether an observer is shown the painted values, in the same order."""
        for observable in self.observables:
            if observable.labels or observable.hidden_when is not None:
                return False
        painted = [field.name for field, _ in self.painted]
        return painted == [observable.field for observable in self.observables]


def observable_words(observable: ir.Observable) -> tuple[str, ...]:
    """Returns the words or labels of a cell observable, `hidden` last if it can be hidden."""
    words = _labels_or_words(observable)
    return (*words, HIDDEN) if observable.hidden_when is not None else words


def _labels_or_words(observable: ir.Observable) -> tuple[str, ...]:
    if observable.labels:
        return tuple(dict.fromkeys(label.name for label in observable.labels))
    return observable.type.words


def looks(game: ir.Game) -> tuple[Look, ...]:
    """Returns the looks of all kinds in declaration order.

    If they are too many for a byte, fields that only labels read are not painted.
    """
    by_kind, num_painted = _numbered_looks(game, True)
    if num_painted > 256:
        by_kind, num_painted = _numbered_looks(game, False)
    number = max(num_painted, len(content_labels(game)))
    if number > 256:
        instead = "`hide` fields of cells that need not be seen, or show them with fewer labels"
        feature = f"{number} different looks of cells (at most 256)"
        raise NotSupported(feature, game.kinds[-1].origin, instead)
    result = []
    for look in by_kind.values():
        other = _as_another(look, game)
        if other is not None:
            raw = 0 if other == OUTSIDE else by_kind[other].raw
            look = replace(look, raw=raw, present=False)
        result.append(look)
    return tuple(result)


def _numbered_looks(game: ir.Game, paints_read: bool) -> tuple[dict[str, Look], int]:
    """Returns the looks of all kinds, and how many numbers are painted.

    paints_read: whether fields are painted that only labels and `hide` read.
    """
    raw = 1
    labels = content_labels(game)
    on_map = _kinds_on_map(game)
    by_kind: dict[str, Look] = {}
    for kind in game.kinds:
        observables = _observables_of(kind, game)
        whole = _shown_as(kind, game)
        numbers: tuple[int, ...] = ()
        if whole is None:
            final = labels.index(_states(kind, game)[0])
        else:
            numbers = tuple(labels.index(word) for word in observable_words(whole))
            final = numbers[0]
        fields = _painted(kind, observables, game, paints_read)
        painted = tuple((f, _values(f, game)) for f in fields)
        look = Look(kind, painted, observables, raw, final, kind.name in on_map, numbers)
        by_kind[kind.name] = look
        if _as_another(look, game) is None:
            raw += look.raw_values
    return by_kind, raw


def _as_another(look: Look, game: ir.Game) -> str | None:
    """Returns what else a kind always looks like: another kind on the map, or what is outside.

    None if it looks like nothing else, or that can't be painted in its place.
    """
    if len(look.labels) != 1:
        return None
    name = look.observables[0].labels[-1].name
    hidden_kinds = {kind for hidden in game.hidden for kind in hidden.kinds}
    if look.kind.name in hidden_kinds or name in hidden_kinds:
        return None
    shown_kinds = {observable.kind for observable in game.observables}
    is_plain_kind = name in _kinds_on_map(game) - shown_kinds
    return name if name == OUTSIDE or is_plain_kind else None


def _kinds_on_map(game: ir.Game) -> set[str]:
    return {kinds_by_glyph(game)[glyph] for glyph in set().union(*game.rows)}


def _observables_of(kind: ir.Kind, game: ir.Game) -> tuple[ir.Observable, ...]:
    return tuple(s for s in game.observables if s.what == "cell" and s.kind == kind.name)


def _shown_as(kind: ir.Kind, game: ir.Game) -> ir.Observable | None:
    """Returns the observable that says how cells of a kind look as a whole, if there is one."""
    return next((s for s in _observables_of(kind, game) if not s.field), None)


def _painted(
    kind: ir.Kind, observables: tuple[ir.Observable, ...], game: ir.Game, paints_read: bool
) -> list[ir.VarField]:
    """Returns the fields that are painted, of those that have few values.

    They are the fields shown as they are, and those that labels and `hide` read. All others are
    looked up for each cell of each window.
    """
    wanted = {s.field for s in observables if not s.labels}
    if paints_read:
        conditions = [label.condition for s in observables for label in s.labels]
        conditions += [s.hidden_when for s in observables]
        conditions += [hidden.when for hidden in game.hidden if kind.name in hidden.kinds]
        for condition in conditions:
            if condition is not None:
                wanted |= _fields_read(condition, kind)
    return [f for f in kind.fields if f.name in wanted and _values(f, game)]


def _values(field: ir.VarField, game: ir.Game) -> int:
    """Returns how many values a field has that can be painted; 0 if it cannot."""
    if field.type.indexed_by:
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


def _fields_read(condition: ir.Expr, kind: ir.Kind) -> set[str]:
    """Returns the fields of a cell of a kind that a condition reads."""
    names = set()
    for node in ir.walk(condition):
        if isinstance(node, ir.FieldRead) and isinstance(node.owner, ir.Member):
            if kind.name in node.held_by.names:
                names.add(node.name)
    return names


def content_labels(game: ir.Game) -> tuple[str, ...]:
    """Returns the labels of the content plane in the order of its values."""
    states: list[str] = []
    labels: list[str] = []
    for kind in game.kinds:
        whole = _shown_as(kind, game)
        if whole is None:
            states += _states(kind, game)
        else:
            labels += observable_words(whole)
    all_labels = [OUTSIDE, *states, *labels]
    if any(hidden.what == "content" for hidden in game.hidden):
        all_labels.append(COVERED)
    return tuple(dict.fromkeys(all_labels))


def _states(kind: ir.Kind, game: ir.Game) -> list[str]:
    """Returns the labels of all states that are seen of a kind, the first field slowest."""
    shown = []
    for observable in _observables_of(kind, game):
        shown.append([f"{observable.field}={word}" for word in observable_words(observable)])
    return [" ".join((kind.name, *values)) for values in product(*shown)]


def seen_marks(game: ir.Game) -> tuple[ir.Phase, ...]:
    """Returns the phases whose marks are seen: all, or none if marks are hidden everywhere."""
    if any(hidden.what == "marks" and hidden.on == "map" for hidden in game.hidden):
        return ()
    return marking_phases(game)


def agent_labels(game: ir.Game) -> tuple[str, ...]:
    """Returns the labels of the plane of agents; `other` is one whose heading is hidden."""
    heading = seen_heading(game)
    if heading is None:
        return (*AGENT_LABELS[:OTHER_FACING], "other")
    return AGENT_LABELS if heading.hidden_when is None else (*AGENT_LABELS, "other")


def token_planes(game: ir.Game) -> tuple[TokenPlane, ...]:
    """Returns what each plane of a `tokens` observation means, in order."""
    content = content_labels(game)
    agents = agent_labels(game)
    planes = [
        TokenPlane("content", "word", content, len(content) - 1),
        TokenPlane("agent", "word", agents, len(agents) - 1),
    ]
    marking = seen_marks(game)
    if marking:
        labels = tuple(phase.label for phase in marking)
        planes.append(TokenPlane("marks", "bits", labels, 2 ** len(marking) - 1))
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
    """Returns the plane of a field. prefix: its owner, as the name of the plane begins."""
    if observable.what == "mover":
        prefix = f"{observable.kind}." if observable.field else observable.kind
    name = f"{prefix}{observable.field}"
    if observable.word:
        name = f"{name}[{observable.word.key}]"
    uniform = observable.what in UNIFORM
    words = shown_words(observable)
    if words:
        if observable.what == "other":
            words = ("nobody", *words)
        elif observable.what == "mover":
            words = ("none", *words)
        return TokenPlane(name, "word", words, len(words) - 1, uniform)
    high = number_bound(observable, game)
    if high == inf:
        feature = (
            f"showing `{name}`, which has no bound: "
            "give the numbers it is set to limits within 0 .. 255"
        )
        raise NotSupported(feature, observable.origin)
    if high > 255:
        example = f"`show {name} as {{ much where {name} > 99, little }}`"
        instead = f"show it with labels, such as {example}"
        if observable.value is not None:
            smaller = f"`quotient({name}, {high // 256 + 1:g})`"
            instead = f"{instead}, or a define of less, such as {smaller}"
        feature = f"showing `{name}`, which can reach {high:g} (at most 255)"
        raise NotSupported(feature, observable.origin, instead)
    return TokenPlane(name, "number", (), int(high), uniform)


def shown_words(observable: ir.Observable) -> tuple[str, ...]:
    """Returns the words that a plane of a field shows, none for a number.

    The last is `hidden`, if the field is shown under a condition.
    """
    words = _labels_or_words(observable)
    return (*words, HIDDEN) if words and observable.shown_when is not None else words


def number_bound(observable: ir.Observable, game: ir.Game) -> float:
    """Returns the largest value of a shown number; for a timer, of the numbers it is set to."""
    if shows_attribute(observable) or observable.value is not None:
        return observable.type.high
    field = shown_field(game, observable)
    if not field.timer:
        return field.type.high
    bound = 0.0
    for node in ir.walk(game):
        if isinstance(node, ir.Set) and sets(node, field):
            bound = max(bound, largest(node.value, game))
    return bound


def largest(e: ir.Expr, game: ir.Game) -> float:
    """Returns an upper bound of a number, whatever the parameters are set to."""
    if not isinstance(e, ir.Local) or e.type.high != inf:
        return e.type.high
    bounds = []
    for node in ir.walk(game):
        if isinstance(node, ir.Draw) and node.name == e.name and node.high is not None:
            bounds.append(largest(node.high, game))
    return max(bounds, default=inf)


def relative_heading(difference: Expression, same: int) -> Expression:
    """Returns the number for another's heading in the plane of agents.

    Args:
      difference: the other's heading minus the observer's.
      same: the number for the same heading; those to its right follow.
    """
    return Literal(same) + (difference & 3)
