"""All the rules of a game on a page, in the order of the ODD protocol (Grimm et al. 2020, JASSS 23(2) 7): tables, and each rule as written."""

from itertools import groupby

from sjdsl.compiler import ast, ir
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.ir.queries import event_named, kind_named, phases_of, starts_of
from sjdsl.compiler.lower import NotSupported, token_planes
from sjdsl.doc.actions import action_rows
from sjdsl.doc.numbers import parameters
from sjdsl.doc.quoted import comment_behind, quoted
from sjdsl.doc.wording import code, counted, fenced, joined, number, plain, table
from sjdsl.doc.written import Written
from sjdsl.runtime.planes import TokenPlane

READING = "They are quoted as written, with their comments; the manual of the language says what each word means."


def rule_sheet(w: Written) -> str:
    """Returns the whole sheet as Markdown."""
    c = w.composition
    sections = (
        ("Purpose", purpose(w)),
        ("Entities, state and scales", entities(w)),
        ("Parameters", parameters(w)),
        ("Process overview: one step", overview(w)),
        ("Observation", observation(w)),
        ("Initialisation", initialisation(w)),
        ("Names", quoted(c, names(w))),
        ("Phases", quoted(c, phases(c).values())),
        ("Metrics", metrics(w)),
        ("Checks", quoted(c, (check for block in c.checks.values() for check in block), "checks")),
        ("Policies", quoted(c, c.policies.values())),
        ("Scenarios", scenarios(w)),
        ("Pictures", quoted(c, (look for looks in c.looks.values() for look in looks))),
        ("Variants", variants(w)),
    )
    name = f"{code(w.game.name)}, from {code(w.file)}" + (
        f", variant {code('+'.join(w.chosen))}" if w.chosen else ""
    )
    found = [
        f"# {plain(w.game.title or w.game.name)}",
        "",
        f"The rules of the game {name}. {READING}",
        "",
    ]
    for title, lines in sections:
        found += [f"## {title}", "", *lines] if lines else []
    return "\n".join(found).rstrip("\n") + "\n"


def purpose(w: Written) -> list[str]:
    """Returns what the file says the game is about."""
    about = dict(w.game.about)
    summary = about.pop("summary", "")
    found = [plain(summary), ""] if summary else []
    found += [f"- {plain(key.replace('_', ' '))}: {plain(text)}" for key, text in about.items()]
    found += [f"- source: {plain(cite)}" for cite in w.game.cites]
    return [*found, ""] if found else []


def entities(w: Written) -> list[str]:
    """Returns the agents, movers, kinds of cell and the map, their fields and the world's, and the shapes."""
    c, game = w.composition, w.game
    own = [*c.agent_fields.values(), *c.agent_blocks.values(), *c.forbids.values()]
    text = "".join(game.rows)
    glyphs = [
        (code(g.glyph), g.kind, str(text.count(g.glyph)), starts(g, game)) for g in game.glyphs
    ]
    kinds = [
        kind for kind in c.kinds.values() if kind.attributes or comment_behind(c, kind)
    ]  # of the others the table says all
    size = f"{counted(len(game.rows), 'row')} of {counted(len(game.rows[0]), 'cell')}; the first row is north."
    edges = (
        " Its edges are joined: what leaves it on one side comes in at the opposite side."
        if game.wraps
        else ""
    )
    sections = (
        ("Agents", [f"{counted(game.agents.number, 'agent')}.", ""]),
        (
            "",
            [
                *table(("number", "action", "what it does"), action_rows(game)),
                "",
                *quoted(c, own, "agents"),
            ],
        ),
        ("Movers", quoted(c, c.movers.values())),
        (
            "Kinds of cell",
            [*table(("glyph", "kind", "cells on the map", "their state at the start"), glyphs), ""],
        ),
        ("", quoted(c, [*kinds, *c.groups.values()])),
        ("Map", [size + edges, "", *fenced(game.rows), ""]),
        ("State of the world", quoted(c, c.fields.values())),
        ("Shapes", quoted(c, c.shapes.values())),
    )
    found = []
    for title, lines in sections:
        found += [*([f"### {title}", ""] if title else []), *lines] if lines else []
    return found


def starts(glyph: ir.GlyphMeaning, game: ir.Game) -> str:
    """Returns the fields that a glyph of the map stands for, each with its value at the start."""
    own = starts_of(game, glyph)
    return ", ".join(
        f"{code(f.name)} = {_start(own[f.name], f)}" for f in kind_named(game, glyph.kind).fields
    )


def _start(start: int | float | str | None, field: ir.VarField) -> str:
    if start is None:
        return {"agents": "empty", "cell": "nowhere"}.get(field.type.kind, "nobody")
    return code(start) if isinstance(start, str) else number(start)


def overview(w: Written) -> list[str]:
    """Returns the schedule and the length of an episode, and which phases draw at random."""
    c = w.composition
    drawing = {
        p.label.partition("(")[0]: None
        for p in phases_of(w.game)
        if any(map(is_random, ir.walk(p)))
    }
    drawn = (
        f"Random draws are made in {joined(map(code, drawing))}."
        if drawing
        else "Nothing is drawn at random."
    )
    return [*quoted(c, (c.schedule, c.episode)), drawn, ""]


def is_random(node: ir.Node) -> bool:
    return isinstance(
        node, ir.Chance | ir.Draw | ir.Match | ir.Move | ir.Pick | ir.Send | ir.Shift
    ) or (isinstance(node, ir.Set) and node.lot is not None)


def names(w: Written) -> list[ast.Define]:
    """Returns the defines of the game's own file, and those of its bases that are read."""
    read = {node.name for node in ir.walk(w.game) if isinstance(node, ir.Named)}
    c = w.composition
    return [
        define for name, define in c.defines.items() if name in read or define.span.file == c.file
    ]


def phases(c: Composition) -> dict[str, ast.Phase]:
    """Returns the phases of the schedule, each once, in the order of their first turns."""
    turns = () if c.schedule is None else c.schedule.turns
    return {
        turn.name.text: c.phases[turn.name.text] for turn in turns if turn.name.text in c.phases
    }


def observation(w: Written) -> list[str]:
    """Returns the window, what is shown and hidden as it is written, and what each plane of an observation says."""
    c = w.composition
    found = quoted(c, [*c.windows, *c.observables.values()], "observe")
    try:
        rows = [
            (str(i), code(plane.name), _values(plane))
            for i, plane in enumerate(token_planes(w.game))
        ]
    except NotSupported as refused:
        return [*found, f"The compiler cannot make observations: {refused.feature}.", ""]
    return [*found, *table(("plane", "name", "values"), rows), ""]


def _values(plane: TokenPlane) -> str:
    match plane.encoding:
        case "number":
            return f"0 to {plane.high}"
        case "bits":
            return ", ".join(f"bit {bit} {code(label)}" for bit, label in enumerate(plane.labels))
        case "word":
            alike = groupby(
                enumerate(plane.labels),
                lambda entry: entry[1].partition(" ")[0] if "=" in entry[1] else entry,
            )
            return ", ".join(_labels(list(entries)) for _, entries in alike)


def _labels(entries: list[tuple[int, str]]) -> str:
    """Returns a value of a plane and what it means; for all states of a kind, the first and last value, and each field once."""
    (first, label), (last, _) = entries[0], entries[-1]
    if first == last:
        return f"{first} {plain(label)}"
    states = [[word.split("=") for word in state.split()[1:]] for _, state in entries]
    fields = [
        f"{field[0][0]} {'/'.join(dict.fromkeys(value for _, value in field))}"
        for field in zip(*states, strict=True)
    ]
    order = " (the last fastest)" if len(fields) > 1 else ""
    return f"{first} to {last} {label.partition(' ')[0]}: {plain(' × '.join(fields))}{order}"


def initialisation(w: Written) -> list[str]:
    """Returns how an episode begins."""
    first = "At first, fields have the values behind their `=`, and cells the state that their glyph stands for. Then comes the phase `start`:"
    return [first, "", *quoted(w.composition, [w.composition.phases["start"]])]


def metrics(w: Written) -> list[str]:
    """Returns what is counted and measured."""
    found = table(
        ("metric", "what it is", "of", "source"),
        (_metric(m, w) for m in w.composition.metrics.values()),
    )
    return [*found, ""] if found else []


def _metric(metric: ast.Event | ast.Measure, w: Written) -> tuple[str, ...]:
    name, text = metric.name, w.composition.sources[metric.span.file].text
    after = text[name.span.end : metric.span.end].strip(" =\n")
    if isinstance(metric, ast.Measure):
        what = (
            "mean over the steps of an episode"
            if metric.is_mean
            else "at the last step of an episode"
        )
    else:
        what = f"counted for {'each agent' if event_named(w.game, name.text).per_agent else 'the whole game'}"
    source = comment_behind(w.composition, metric).lstrip("# ")
    return code(name.text), what, code(" ".join(after.split())) if after else "", plain(source)


def scenarios(w: Written) -> list[str]:
    """Returns the line-ups of a game."""
    rows = [(code(s.name), plain(s.title), joined(map(_slots, s.slots))) for s in w.game.scenarios]
    return [*table(("scenario", "what it is", "who plays"), rows), ""] if rows else []


def _slots(part: ir.Slots) -> str:
    return f"{part.number} {code(part.policy) if part.policy else 'focal'}"


def variants(w: Written) -> list[str]:
    """Returns the variants of the game; their differences are another report."""
    if not w.variants:
        return []
    rows = [(code(name), plain(title)) for name, title in w.variants]
    hint = (
        f"`sjdsl diff {w.file} --variants default {w.variants[0][0]}` says what a variant changes."
    )
    return [*table(("variant", "what it is"), rows), "", hint, ""]
