"""The legend of a game: each appearance of cells, agents and movers, with its text."""

from collections.abc import Iterator
from itertools import islice, product

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.implications import conjuncts
from sjdsl.compiler.ir.printer import expression
from sjdsl.render.appearance import BAR_STEPS, Drawing, Figure, draw_cell, ruled
from sjdsl.render.colours import agent_colour, mixed
from sjdsl.render.look import FieldLook, KindLook, Look, Rule

MOST = 4096  # combinations of words that are tried
SHOWN = 5  # eighths of the bar in a legend
MARKED = 0.6  # how much of a marked cell has the colour of its mark


def legend_entries(look: Look) -> Iterator[tuple[Drawing | Figure, str]]:
    """Yields what can be seen: cells, marks, then agents and movers."""
    yield from cell_entries(look)
    for label, colour in look.marks:
        yield Drawing(mixed(look.kinds[0].ground, colour, MARKED)), label
    yield from figure_entries(look)


def cell_entries(look: Look) -> Iterator[tuple[Drawing, str]]:
    """Yields the kinds, what their looks say, and the words, owners and numbers that are drawn without one."""
    for kind in look.kinds:
        found = list(dict.fromkeys(_kind_entries(kind)))
        if not any(text.split(":")[0] == kind.name for _, text in found):  # no cell of it is ever without one of its words
            found[:1] = [(drawing, f"{kind.name}: {text}") for drawing, text in found[:1]]
        yield from found


def _kind_entries(kind: KindLook) -> Iterator[tuple[Drawing, str]]:
    nothing, always = (0,) * len(kind.fields), tuple(int(rule.condition is None) for rule in kind.rules)
    real = frozenset(_word_drawings(kind))
    plain = draw_cell(kind, nothing + always)
    if plain in real:
        same = [text for field in kind.fields for value, text in _values(field, kind.rules) if value == 0]
        yield plain, f"{kind.name}: {', '.join(same)}" if same else kind.name
    for place, rule in enumerate(kind.rules):
        if rule.condition is not None:
            applied = tuple(max(a, int(p == place or _implies(rule, other))) for p, (a, other) in enumerate(zip(always, kind.rules)))
            yield draw_cell(kind, nothing + applied), rule.label
    for place, field in enumerate(kind.fields):
        for value, text in _values(field, kind.rules):
            drawn = draw_cell(kind, (*nothing[:place], value, *nothing[place + 1 :], *always))
            if drawn != plain and (drawn in real or field.holds != "word"):
                yield drawn, text


def _word_drawings(kind: KindLook) -> Iterator[Drawing]:
    """Yields what can be drawn where all numbers are 0 and nobody owns anything, for all words together; of very many, the first.

    A look that reads more than words applies nowhere.
    """
    words = [range(len(field.words)) if field.holds == "word" else (0,) for field in kind.fields]
    states = np.array(list(islice(product(*words), MOST)), int)
    values = {field.attribute: column - (field.holds == "agent") for field, column in zip(kind.fields, states.T, strict=True)}
    known = {field.name for field in kind.fields if field.holds == "word"}
    applies = [rule.applies(kind.name, values, len(states)) if rule.reads <= known else np.zeros(len(states)) for rule in kind.rules]
    for place, state in enumerate(states.tolist()):
        yield draw_cell(kind, (*state, *(int(where[place]) for where in applies)))


def _implies(rule: Rule, other: Rule) -> bool:
    """Returns whether another look applies wherever one does: each part of the other's condition is a part of its own."""
    first, second = (frozenset(map(expression, conjuncts(r.condition))) if r.condition else frozenset() for r in (rule, other))
    return second <= first


def figure_entries(look: Look) -> Iterator[tuple[Figure, str]]:
    """Yields the roles of the agents, their looks, what they can carry, the pale one, and then the movers."""
    if look.colour_field is not None:
        attribute, colours = look.colour_field
        for number, role in enumerate(look.roles):
            if not _is_said(attribute.removeprefix("agent_"), role, look.rules):
                yield Figure(number, colours[number]), role
    agent = Figure(0, agent_colour(0))
    yield from _body_entries(agent, look.rules, look.carried)
    if look.can_be_held:
        yield Figure(0, agent_colour(0), held=True), "pale: can only stay"
    for herd in look.herds:
        plain = Figure(None, herd.colour, herd.sprite)
        for rule in herd.rules:
            if rule.condition is None:
                plain = ruled(plain, rule)
        yield plain, herd.name
        for figure, text in _body_entries(plain, herd.rules, herd.carried):
            yield figure, f"{herd.name}: {text}"


def _body_entries(plain: Figure, rules: tuple[Rule, ...], carried: tuple[FieldLook, ...]) -> Iterator[tuple[Figure, str]]:
    """Yields what the looks of agents, or of a sort of movers, do to their body, and the badges of what it carries."""
    yield from ((ruled(plain, rule), rule.label) for rule in rules if rule.condition is not None)
    for field in carried:
        for number, picture in enumerate(field.pictures):
            word = field.words[number] if field.words else ""
            is_start = field.holds == "word" and number == field.start
            if not is_start and not _is_said(field.name, word, rules):
                figure = Figure(plain.number, plain.colour, plain.sprite, badges=(*plain.badges, picture))
                yield figure, f"{field.name}: {word}" if word else field.name


def _values(field: FieldLook, rules: tuple[Rule, ...]) -> Iterator[tuple[int, str]]:
    """Yields the values of a field that a legend names: words, some owner, a bar."""
    if field.sort in ("bar", "edge"):
        if not _is_said(field.name, "", rules):
            yield (SHOWN * BAR_STEPS // 8 if field.sort == "bar" else 1), field.name
        return
    for number, word in enumerate(field.words):
        if field.is_drawn(number) and not _is_said(field.name, word, rules):
            yield number, word


def _is_said(name: str, word: str, rules: tuple[Rule, ...]) -> bool:
    """Returns whether a look says alone how a word of a field is drawn, or, without a word, a field that has none."""
    for rule in rules:
        parts = () if rule.condition is None else tuple(conjuncts(rule.condition))
        if len(parts) == 1 and name in rule.reads and (not word or word in _words(parts[0])):
            return True
    return False


def _words(part: ir.Expr) -> frozenset[str]:
    """Returns the words with which a condition holds, or the entries of a row that it reads."""
    match part:
        case ir.InWords():
            return frozenset(part.words)
        case ir.Same():
            return frozenset(side.value for side in (part.left, part.right) if isinstance(side, ir.Word))
        case _:
            return frozenset(node.value for node in ir.walk(part) if isinstance(node, ir.Word))
