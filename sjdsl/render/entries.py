"""What a legend names: each thing that cells and agents can show, with its text."""

from collections.abc import Iterator

from sjdsl.compiler import ir
from sjdsl.compiler.facts import conjuncts
from sjdsl.render.colours import agent_colour
from sjdsl.render.drawings import BAR_STEPS, Drawing, Figure, draw_cell
from sjdsl.render.look import FieldLook, Look, Rule

SHOWN = 5  # eighths of the bar in a legend


def cell_entries(look: Look) -> Iterator[tuple[Drawing, str]]:
    """Yields the kinds, what their looks say, and the words, owners and numbers that are drawn without one."""
    for kind in look.kinds:
        always = tuple(int(rule.condition is None) for rule in kind.rules)
        plain = draw_cell(kind, (0,) * len(kind.fields) + always)
        same = [text for place, field in enumerate(kind.fields) for value, text in _values(field, kind.rules) if value == 0]
        yield plain, f"{kind.name}: {', '.join(same)}" if same else kind.name
        for place, rule in enumerate(kind.rules):
            if rule.condition is not None:
                applied = tuple(max(a, int(p == place)) for p, a in enumerate(always))
                yield draw_cell(kind, (0,) * len(kind.fields) + applied), rule.label
        for place, field in enumerate(kind.fields):
            for value, text in _values(field, kind.rules):
                values = [0] * len(kind.fields)
                values[place] = value
                drawn = draw_cell(kind, (*values, *always))
                if drawn != plain:
                    yield drawn, text


def figure_entries(look: Look) -> Iterator[tuple[Figure, str]]:
    """Yields the roles of the agents, their looks, what they can carry, and the pale one."""
    for number, role in enumerate(look.roles):
        assert look.colour_field is not None
        yield Figure(number, look.colour_field[1][number]), role
    for rule in look.rules:
        if rule.condition is not None:
            badges = () if rule.badge is None else (rule.badge,)
            yield Figure(0, rule.colour or agent_colour(0), rule.sprite or "agent", badges=badges), rule.label
    for field in look.carried:
        words = field.words or (field.name,)
        for word, picture in zip(words, field.pictures, strict=True):
            is_start = field.holds == "word" and words.index(word) == field.start
            if not is_start and not _is_said(field.name, word if field.words else "", look.rules):
                yield Figure(0, agent_colour(0), badges=(picture,)), f"{field.name}: {word}" if field.words else field.name
    if look.can_be_held:
        yield Figure(0, agent_colour(0), held=True), "pale: can only stay"


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
