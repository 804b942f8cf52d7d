"""The legend of a game: each appearance of cells, agents and movers, with its text."""

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import chain, islice, product

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.implications import conjuncts
from sjdsl.compiler.ir.printer import expression_text
from sjdsl.render.appearance import (
    BAR_STEPS,
    Beam,
    Drawing,
    Figure,
    Key,
    apply_rule,
    cell_keys,
    draw_cell,
    draw_figures,
    marked_cells,
)
from sjdsl.render.colours import PALE, WORDS, agent_colour
from sjdsl.render.look import FieldLook, KindLook, Look, Rule
from sjdsl.render.moment import Snapshot
from sjdsl.render.usual import Picture

MAX_STATES = 4096  # combinations of enum values that are tried
MAX_COMBINED = 8  # combinations of one kind in a legend; if there are more, each value stands alone
LEGEND_BAR = 5 * BAR_STEPS // 8  # length of a bar in a legend
ALL_SIDES = (True, True, True, True)

Entry = tuple[Drawing | Figure | Beam, str]
# Whether a cell with a key looks so; the bool: after the first step.
Occurs = Callable[[Key, bool], bool]


def legend_entries(look: Look, shown: Sequence[Snapshot] | None = None) -> list[Entry]:
    """Returns what can be seen, each thing once, with its text.

    In this order: cells, marks, agents and movers, then the things that stand beside the returns.

    Args:
      shown: the moments that will be drawn; the legend leaves out what is in none of them.
    """
    entries: dict[str, Entry] = {}
    for kind in look.kinds:
        for drawing, text in _entries_of(kind, shown):
            # What looks like grass is called grass.
            if all(drawing != other for other, _ in entries.values()):
                unique = f"{kind.name}: {text}" if text in entries else text
                entries.setdefault(unique, (drawing, unique))
    for label, colour in look.marks:
        if shown is None or any(marked_cells(snapshot, label) for snapshot in shown):
            actions = [look.actions[number] for number in look.marking_actions[label]]
            text = " or ".join(actions) or label
            entries.setdefault(text, (Beam(PALE, colour, ALL_SIDES), text))
    on_ground: set[Picture] = set()
    for symbol, _ in entries.values():
        if isinstance(symbol, Drawing):
            on_ground |= {*symbol.objects}
    for figure, text in figure_entries(look, shown):
        value = text.rpartition(": ")[2]
        is_explained = value in entries and figure.badges and figure.badges[-1] in on_ground
        if not is_explained:
            entries.setdefault(text, (figure, text))
    for row in look.possessions:
        for word, picture in zip(row.words, row.pictures, strict=True):
            figure = Figure(None, picture.colour, picture.sprite)
            if all(figure != other for other, _ in entries.values()):
                entries.setdefault(f"has {word}", (figure, f"has {word}"))
    return list(entries.values())


def _entries_of(kind: KindLook, shown: Sequence[Snapshot] | None) -> list[tuple[Drawing, str]]:
    """Returns the drawings of a kind that occur in the moments shown; one text names the kind."""
    states: set[tuple[Key, bool]] = set()
    for snapshot in shown or ():
        keys, _ = cell_keys(kind, snapshot.values)
        states |= {(key, snapshot.step > 0) for key in keys}
    entries: list[tuple[Drawing, str]] = []
    for drawing, text, occurs in _kind_entries(kind):
        is_shown = shown is None or any(occurs(*state) for state in states)
        if is_shown and (drawing, text) not in entries:
            entries.append((drawing, text))
    if not entries or any(text.split(":")[0] == kind.name for _, text in entries):
        return entries
    (drawing, text), *others = entries
    return [(drawing, f"{kind.name}: {text}"), *others]


def _kind_entries(kind: KindLook) -> Iterator[tuple[Drawing, str, Occurs]]:
    """Yields the drawings of a kind, each with its text and the test of which cells show it.

    In this order: the plain cell, each look, each field's values, then combinations of values.
    """
    plain_values = tuple(field.plain for field in kind.fields)
    always = tuple(int(rule.condition is None) for rule in kind.rules)
    plain = draw_cell(kind, plain_values + always)
    states = list(_word_states(kind))
    drawings = {draw_cell(kind, state) for state in states}
    if plain in drawings:
        yield plain, _plain_text(kind), lambda key, begun: draw_cell(kind, key, begun) == plain
    for index, rule in enumerate(kind.rules, len(plain_values)):
        if rule.condition is not None:
            applied = tuple(int(_implies(rule, other)) for other in kind.rules)
            drawing = draw_cell(kind, plain_values + applied)
            yield drawing, rule.label or kind.name, _is_positive(index)
    for index, field in enumerate(kind.fields):
        for value, text in _values(field, kind.fields):
            values = (*plain_values[:index], value, *plain_values[index + 1 :])
            drawing = draw_cell(kind, values + always)
            if drawing == plain:
                continue
            if field.holds != "word":
                yield drawing, text, _is_positive(index)
            elif drawing in drawings:
                yield drawing, text, _is_value(index, value)
    combined: list[tuple[Key, str]] = []
    for state in states:
        text = _combined_text(kind, state)
        if text and state[len(plain_values) :] == always:
            combined.append((state, text))
    if len(combined) <= MAX_COMBINED:
        for state, text in combined:
            yield draw_cell(kind, state), text, _is_state(state)


def _is_positive(index: int) -> Occurs:
    return lambda key, _: key[index] > 0


def _is_value(index: int, value: int) -> Occurs:
    return lambda key, _: key[index] == value


def _is_state(state: Key) -> Occurs:
    return lambda key, _: key == state


def _plain_text(kind: KindLook) -> str:
    """Returns the text of a cell in which each field has its plain value."""
    texts: list[str] = []
    for field in kind.fields:
        texts += [text for value, text in _values(field, kind.fields) if value == field.plain]
    return f"{kind.name}: {', '.join(texts)}" if texts else kind.name


def _combined_text(kind: KindLook, state: Key) -> str:
    """Returns the enum values of a state that are drawn beside each other; "" if fewer than two."""
    texts: list[str] = []
    # After the fields, a state has a number for each look.
    for field, number in zip(kind.fields, state, strict=False):
        if field.holds == "word" and number != field.plain:
            texts += [text for value, text in _values(field, kind.fields) if value == number]
    return ", ".join(texts) if len(texts) > 1 else ""


def _word_states(kind: KindLook) -> Iterator[Key]:
    """Yields the keys of cells with all combinations of their fields' enum values.

    Of very many combinations it yields the first. All numbers are 0 and nobody owns anything. A
    look that reads more than enum values applies to none of them.
    """
    word_fields = [field for field in kind.fields if field.holds == "word"]
    choices = [range(len(field.words)) if field in word_fields else (0,) for field in kind.fields]
    combinations = list(islice(product(*choices), MAX_STATES))
    values = {}
    for field, column in zip(kind.fields, np.array(combinations, int).T, strict=True):
        values[field.attribute] = column - 1 if field.holds == "agent" else column
    known = {field.name for field in word_fields}
    columns = []
    for rule in kind.rules:
        applies = [False] * len(combinations)
        if rule.reads <= known:
            applies = rule.applies(kind.name, values, len(combinations)).tolist()
        columns.append(applies)
    # A key: the number of each field's value, and whether each rule applies.
    for combination, *applied in zip(combinations, *columns, strict=True):
        yield (*combination, *map(int, applied))


def _implies(rule: Rule, other: Rule) -> bool:
    """Returns whether `other` surely applies wherever `rule` does."""
    return _parts(other.condition) <= _parts(rule.condition)


def _parts(condition: ir.Expr | None) -> set[str]:
    """Returns the conditions that `and` joins, as texts."""
    return set() if condition is None else set(map(expression_text, conjuncts(condition)))


def figure_entries(
    look: Look, shown: Sequence[Snapshot] | None = None
) -> Iterator[tuple[Figure, str]]:
    """Yields the agents by role, their looks, what they carry, the pale one, then the movers."""
    drawn: defaultdict[str, list[Figure]] | None = None
    if shown is not None:
        drawn = defaultdict(list)
        for snapshot in shown:
            for name, figures in draw_figures(look, snapshot).items():
                drawn[name] += figures
    agents = None if drawn is None else drawn["agent"]
    if look.colour_field is not None:
        attribute, colours = look.colour_field
        for number, (role, colour) in enumerate(zip(look.roles, colours, strict=True)):
            occurs = agents is None or any(figure.colour == colour for figure in agents)
            if occurs and role not in look.roles_in_looks:
                field_name = attribute.removeprefix("agent_")
                yield Figure(number, colour), f"{field_name}: {role}" if role in WORDS else role
    agent = Figure(0, agent_colour(0))
    yield from _body_entries(agent, look.rules, look.carried, agents)
    if look.can_be_held and (agents is None or any(figure.held for figure in agents)):
        yield replace(agent, held=True), "pale: can only stay"
    for herd in look.herds:
        plain = Figure(None, herd.colour, herd.sprite)
        for rule in herd.rules:
            if rule.condition is None:
                plain = apply_rule(plain, rule)
        yield plain, herd.name
        movers = None if drawn is None else drawn[herd.name]
        for figure, text in _body_entries(plain, herd.rules, herd.carried, movers):
            yield figure, f"{herd.name}: {text}"


def _body_entries(
    plain: Figure,
    rules: tuple[Rule, ...],
    carried: tuple[FieldLook, ...],
    drawn: Sequence[Figure] | None,
) -> Iterator[tuple[Figure, str]]:
    """Yields the looks of agents, or of one type of movers, and the badges of what they carry.

    Args:
      drawn: the figures that will be drawn, None if they aren't known.
    """
    for rule in rules:
        occurs = drawn is None or any(_shows(figure, rule) for figure in drawn)
        if rule.condition is not None and occurs:
            yield apply_rule(plain, rule), rule.label
    for field in carried:
        for number, (word, picture) in enumerate(zip(field.words, field.pictures, strict=True)):
            occurs = drawn is None or any(picture in figure.badges for figure in drawn)
            if field.is_carried(number) and occurs:
                yield replace(plain, badges=(*plain.badges, picture)), f"{field.name}: {word}"


def _shows(figure: Figure, rule: Rule) -> bool:
    """Returns whether a figure is drawn as a look says."""
    return (
        rule.sprite in (None, figure.sprite)
        and rule.colour in (None, figure.colour)
        and rule.badge in (None, *figure.badges)
    )


def _values(field: FieldLook, fields: Sequence[FieldLook]) -> Iterator[tuple[int, str]]:
    """Yields the values of a field that a legend names, with their texts.

    The text of an enum value that another of the `fields` has too begins with the field's name.
    """
    match field.drawn_as:
        case "bar":
            yield LEGEND_BAR, field.name
        case "edge":
            yield 1, field.name
        case _:
            others = (other.words for other in fields if other is not field)
            elsewhere = set(chain.from_iterable(others))
            for number, word in enumerate(field.words):
                if field.is_drawn(number):
                    yield number, f"{field.name} {word}" if word in elsewhere else word
