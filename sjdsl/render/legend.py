"""The legend of a game: each appearance of cells, agents and movers, with its text."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import islice, product

import numpy as np

from sjdsl.compiler.ir.implications import conjuncts
from sjdsl.compiler.ir.printer import expression
from sjdsl.render.appearance import (
    BAR_STEPS,
    Beam,
    Drawing,
    Figure,
    Key,
    cell_keys,
    draw_cell,
    draw_figures,
    marked_cells,
    ruled,
)
from sjdsl.render.colours import PALE, WORDS, agent_colour
from sjdsl.render.look import FieldLook, KindLook, Look, Rule
from sjdsl.render.moment import Snapshot

MOST = 4096  # combinations of words that are tried
FEW = 8  # of one kind that a legend lists; the words of more stand there one by one
SHOWN = 5  # eighths of the bar in a legend
ALL = (True, True, True, True)  # sides of the beam in a legend

Entry = tuple[Drawing | Figure | Beam, str]


def legend_entries(look: Look, shown: Sequence[Snapshot] | None = None) -> list[Entry]:
    """Returns what can be seen, each thing once: cells, marks, agents and movers, then what stands beside the returns.

    shown: the moments whose pictures the legend is for, which then leaves out what is in none of them.
    """
    found: dict[str, Entry] = {}
    for kind in look.kinds:
        for drawing, text in _entries_of(kind, shown):
            if not any(
                drawing == other for other, _ in found.values()
            ):  # what looks like grass is grass
                unique = f"{kind.name}: {text}" if text in found else text
                found.setdefault(unique, (drawing, unique))
    for label, colour in look.marks:
        if shown is None or any(marked_cells(shot, label) for shot in shown):
            text = " or ".join(look.actions[number] for number in look.acting[label]) or label
            found.setdefault(text, (Beam(PALE, colour, ALL), text))
    pictured = {
        picture: drawing
        for drawing, _ in found.values()
        if isinstance(drawing, Drawing)
        for picture in drawing.objects
    }
    for figure, text in figure_entries(look, shown):
        word = text.rpartition(": ")[2]
        if not (
            word in found and figure.badges and figure.badges[-1] in pictured
        ):  # what lies on the ground and is carried
            found.setdefault(text, (figure, text))
    for figure, text in _held(look):
        if not any(figure == other for other, _ in found.values()):
            found.setdefault(text, (figure, text))
    return list(found.values())


def _held(look: Look) -> Iterator[tuple[Figure, str]]:
    """Yields the pictures of what agents have beside their returns."""
    for row in look.held:
        for word, picture in zip(row.words, row.pictures, strict=True):
            yield Figure(None, picture.colour, picture.sprite), f"has {word}"


def cell_entries(
    look: Look, shown: Sequence[Snapshot] | None = None
) -> Iterator[tuple[Drawing, str]]:
    """Yields the kinds, what their looks say, and the words, owners and numbers that are drawn without one."""
    for kind in look.kinds:
        yield from _entries_of(kind, shown)


def _entries_of(kind: KindLook, shown: Sequence[Snapshot] | None) -> list[tuple[Drawing, str]]:
    states: set[tuple[Key, bool]] | None = None
    if shown is not None:
        states = {(key, shot.step > 0) for shot in shown for key in cell_keys(kind, shot.values)[0]}
    found = [
        (drawing, text)
        for drawing, text, occurs in _kind_entries(kind)
        if states is None or any(occurs(*state) for state in states)
    ]
    found = list(dict.fromkeys(found))
    if not any(
        text.split(":")[0] == kind.name for _, text in found
    ):  # no cell of it is ever without one of its words
        found[:1] = [(drawing, f"{kind.name}: {text}") for drawing, text in found[:1]]
    return found


def _kind_entries(kind: KindLook) -> Iterator[tuple[Drawing, str, Callable[[Key, bool], bool]]]:
    """Yields drawings and texts, each with whether cells in a state, after the first step or at it, show it."""
    nothing, always = (
        tuple(field.plain for field in kind.fields),
        tuple(int(rule.condition is None) for rule in kind.rules),
    )
    states = list(_word_states(kind))
    real = {draw_cell(kind, state) for state in states}
    plain = draw_cell(kind, nothing + always)
    if plain in real:
        same = [
            text
            for field in kind.fields
            for value, text in _values(field, kind.fields)
            if value == field.plain
        ]
        text = f"{kind.name}: {', '.join(same)}" if same else kind.name
        yield plain, text, lambda key, begun: draw_cell(kind, key, begun) == plain
    for place, rule in enumerate(kind.rules):
        if rule.condition is not None:
            applied = tuple(
                max(a, int(p == place or _implies(rule, other)))
                for p, (a, other) in enumerate(zip(always, kind.rules))
            )
            at = len(nothing) + place
            yield (
                draw_cell(kind, nothing + applied),
                rule.label or kind.name,
                lambda key, _, at=at: bool(key[at]),
            )  # type: ignore[misc]
    for place, field in enumerate(kind.fields):
        for value, text in _values(field, kind.fields):
            drawn = draw_cell(kind, (*nothing[:place], value, *nothing[place + 1 :], *always))
            if drawn != plain and (drawn in real or field.holds != "word"):
                is_word = field.holds == "word"
                yield (
                    drawn,
                    text,
                    lambda key, _, at=place, v=value, w=is_word: key[at] == v if w else key[at] > 0,
                )  # type: ignore[misc]
    together = [
        (state, text)
        for state in states
        if state[len(nothing) :] == always and (text := _words_together(kind, state))
    ]
    for state, text in together if len(together) <= FEW else ():
        yield draw_cell(kind, state), text, lambda key, _, state=state: key == state  # type: ignore[misc]


def _words_together(kind: KindLook, state: Key) -> str:
    """Returns the words of a state that are drawn beside each other; nothing if one alone is."""
    drawn = [
        text
        for field, number in zip(kind.fields, state, strict=False)
        for value, text in _values(field, kind.fields)
        if field.holds == "word" and value == number != field.plain
    ]
    return ", ".join(drawn) if len(drawn) > 1 else ""


def _word_states(kind: KindLook) -> Iterator[Key]:
    """Yields the states in which all numbers are 0 and nobody owns anything, for all words together; of very many, the first.

    A look that reads more than words applies nowhere.
    """
    words = [range(len(field.words)) if field.holds == "word" else (0,) for field in kind.fields]
    states = np.array(list(islice(product(*words), MOST)), int)
    values = {
        field.attribute: column - (field.holds == "agent")
        for field, column in zip(kind.fields, states.T, strict=True)
    }
    known = {field.name for field in kind.fields if field.holds == "word"}
    applies = [
        rule.applies(kind.name, values, len(states))
        if rule.reads <= known
        else np.zeros(len(states))
        for rule in kind.rules
    ]
    for place, state in enumerate(states.tolist()):
        yield (*state, *(int(where[place]) for where in applies))


def _implies(rule: Rule, other: Rule) -> bool:
    """Returns whether another look applies wherever one does: each part of the other's condition is a part of its own."""
    first, second = (
        frozenset(map(expression, conjuncts(r.condition))) if r.condition else frozenset()
        for r in (rule, other)
    )
    return second <= first


def figure_entries(
    look: Look, shown: Sequence[Snapshot] | None = None
) -> Iterator[tuple[Figure, str]]:
    """Yields the roles of the agents, their looks, what they can carry, the pale one, and then the movers."""
    drawn = None if shown is None else [draw_figures(look, shot) for shot in shown]

    def occur(sort: str, is_like: Callable[[Figure], bool]) -> bool:
        return drawn is None or any(
            is_like(figure) for figures in drawn for figure in figures[sort]
        )

    if look.colour_field is not None:
        attribute, colours = look.colour_field
        for number, role in enumerate(look.roles):
            figure = Figure(number, colours[number])
            if role not in look.roles_in_looks and occur(
                "agent", lambda f, c=figure.colour: f.colour == c
            ):  # type: ignore[misc]
                yield (
                    figure,
                    f"{attribute.removeprefix('agent_')}: {role}" if role in WORDS else role,
                )
    agent = Figure(0, agent_colour(0))
    yield from _body_entries(
        agent, look.rules, look.carried, lambda is_like: occur("agent", is_like)
    )
    if look.can_be_held and occur("agent", lambda figure: figure.held):
        yield Figure(0, agent_colour(0), held=True), "pale: can only stay"
    for herd in look.herds:
        plain = Figure(None, herd.colour, herd.sprite)
        for rule in herd.rules:
            if rule.condition is None:
                plain = ruled(plain, rule)
        yield plain, herd.name
        for figure, text in _body_entries(
            plain, herd.rules, herd.carried, lambda is_like, n=herd.name: occur(n, is_like)
        ):  # type: ignore[misc]
            yield figure, f"{herd.name}: {text}"


def _body_entries(
    plain: Figure,
    rules: tuple[Rule, ...],
    carried: tuple[FieldLook, ...],
    occur: Callable[[Callable[[Figure], bool]], bool],
) -> Iterator[tuple[Figure, str]]:
    """Yields what the looks of agents, or of a sort of movers, do to their body, and the badges of what it carries."""
    for rule in rules:
        if rule.condition is not None and occur(lambda f, rule=rule: _shows(f, rule)):  # type: ignore[misc]
            yield ruled(plain, rule), rule.label
    for field in carried:
        for number, (word, picture) in enumerate(zip(field.words, field.pictures, strict=True)):
            if field.is_carried(number) and occur(lambda f, picture=picture: picture in f.badges):  # type: ignore[misc]
                yield replace(plain, badges=(*plain.badges, picture)), f"{field.name}: {word}"


def _shows(figure: Figure, rule: Rule) -> bool:
    """Returns whether a figure looks as a look says."""
    return (
        rule.sprite in (None, figure.sprite)
        and rule.colour in (None, figure.colour)
        and rule.badge in (None, *figure.badges)
    )


def _values(field: FieldLook, fields: Sequence[FieldLook]) -> Iterator[tuple[int, str]]:
    """Yields the values of a field that a legend names: words, some owner, a bar. A word of several of the `fields` stands behind its field."""
    if field.sort in ("bar", "edge"):
        yield (SHOWN * BAR_STEPS // 8 if field.sort == "bar" else 1), field.name
        return
    elsewhere = {word for other in fields if other is not field for word in other.words}
    for number, word in enumerate(field.words):
        if field.is_drawn(number):
            yield number, f"{field.name} {word}" if word in elsewhere else word
