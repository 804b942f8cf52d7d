"""All the rules of a game on a page, in tables and as written.

Source: the order of sections is that of the ODD protocol (Grimm et al. 2020, JASSS 23(2) 7).
"""

from itertools import chain, groupby

from sjdsl.compiler import ast, ir
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.ir.queries import event_named, kind_named, phases_of, starts_of, task_space
from sjdsl.compiler.ir.task_rows import rows_of_hold_out, rows_of_training, tasks_with
from sjdsl.compiler.lower import NotSupported, token_planes
from sjdsl.doc.actions import action_rows
from sjdsl.doc.numbers import parameters
from sjdsl.doc.quoted import comment_behind, quoted
from sjdsl.doc.wording import code, counted, fenced, joined, plain, table, value_at_start
from sjdsl.doc.written import Written
from sjdsl.runtime.planes import TokenPlane

READING = (
    "They are quoted as written, with their comments; the manual of the language says what each "
    "word means."
)


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
        ("Checks", quoted(c, chain.from_iterable(c.checks.values()), "checks")),
        ("Policies", quoted(c, c.policies.values())),
        ("Scenarios", scenarios(w)),
        ("Pictures", quoted(c, chain.from_iterable(c.looks.values()))),
        ("Variants", variants(w)),
    )
    name = f"{code(w.game.name)}, from {code(w.file)}"
    if w.chosen:
        name += f", variant {code('+'.join(w.chosen))}"
    sheet = [f"# {plain(w.game.title or w.game.name)}", ""]
    sheet += [f"The rules of the game {name}. {READING}", ""]
    for title, lines in sections:
        if lines:
            sheet += [f"## {title}", "", *lines]
    return "\n".join(sheet).rstrip("\n") + "\n"


def purpose(w: Written) -> list[str]:
    """Returns what the file says the game is about."""
    about = dict(w.game.about)
    summary = about.pop("summary", "")
    lines = [plain(summary), ""] if summary else []
    lines += [f"- {_topic(key)}: {plain(text)}" for key, text in about.items()]
    lines += [f"- source: {plain(cite)}" for cite in w.game.cites]
    return [*lines, ""] if lines else []


def _topic(key: str) -> str:
    """Returns the key of an `about` in words; `our_difficulty` is `difficulty (ours)`."""
    words = plain(key.removeprefix("our_").replace("_", " "))
    return f"{words} (ours)" if key.startswith("our_") else words


def entities(w: Written) -> list[str]:
    """Returns the agents, movers, kinds of cell, the map, the fields of the world and shapes."""
    c = w.composition
    sections = {
        "Agents": _agents(w),
        "Movers": quoted(c, c.movers.values()),
        "Kinds of cell": _kinds(w),
        "Map": _map(w.game),
        "State of the world": quoted(c, c.fields.values()),
        "Task": _task(w),
        "Shapes": quoted(c, c.shapes.values()),
    }
    text: list[str] = []
    for title, lines in sections.items():
        if lines:
            text += [f"### {title}", "", *lines]
    return text


def _task(w: Written) -> list[str]:
    """Returns what is drawn for each episode, how many tasks there are, and its splits."""
    task = w.game.task
    if task is None:
        return []
    c = w.composition
    space = counted(task_space(task), "task")
    sides = []
    for hold_out in task.hold_outs:
        held_out = counted(tasks_with(rows_of_hold_out(task, hold_out), task), "task")
        sides.append(f"`{hold_out.name}` holds out {held_out}.")
    if task.hold_outs:
        left = counted(tasks_with(rows_of_training(task), task), "task")
        sides.append(f"To train on: {left}.")
    written = (*c.tasks.values(), c.train_on, *c.held_out.values())
    return [" ".join([f"Drawn for each episode: {space}.", *sides]), "", *quoted(c, written)]


def _agents(w: Written) -> list[str]:
    """Returns the part on agents: their number, their actions, and their declarations."""
    c = w.composition
    actions = table(("number", "action", "what it does"), action_rows(w.game))
    declarations = [*c.agent_fields.values(), *c.agent_blocks.values(), *c.forbids.values()]
    number_of_agents = f"{counted(w.game.agents.number, 'agent')}."
    return [number_of_agents, "", *actions, "", *quoted(c, declarations, "agents")]


def _kinds(w: Written) -> list[str]:
    """Returns the table of glyphs, and the kinds and groups with more than it says."""
    c = w.composition
    cells = "".join(w.game.rows)
    glyphs = []
    for meaning in w.game.glyphs:
        number_of_cells = str(cells.count(meaning.glyph))
        row = (code(meaning.glyph), meaning.kind, number_of_cells, starts(meaning, w.game))
        glyphs.append(row)
    kinds = [kind for kind in c.kinds.values() if kind.attributes or comment_behind(c, kind)]
    return [
        *table(("glyph", "kind", "cells on the map", "their state at the start"), glyphs),
        "",
        *quoted(c, [*kinds, *c.groups.values()]),
    ]


def _map(game: ir.Game) -> list[str]:
    """Returns the part on the map: its size and its rows."""
    rows = counted(len(game.rows), "row")
    cells = counted(len(game.rows[0]), "cell")
    size = f"{rows} of {cells}; the first row is north."
    if game.wraps:
        size += " Its edges are joined: what leaves it on one side comes in at the opposite side."
    return [size, "", *fenced(game.rows), ""]


def starts(glyph: ir.GlyphMeaning, game: ir.Game) -> str:
    """Returns the fields of a glyph's kind, each with its value at the start."""
    values = starts_of(game, glyph)
    fields = kind_named(game, glyph.kind).fields
    return ", ".join(f"{code(f.name)} = {value_at_start(values[f.name], f)}" for f in fields)


def overview(w: Written) -> list[str]:
    """Returns the schedule and the length of an episode, and which phases draw at random."""
    c = w.composition
    random_phases = dict.fromkeys(
        phase.label.partition("(")[0]
        for phase in phases_of(w.game)
        if any(map(_is_random, ir.walk(phase)))
    )
    draws = "Nothing is drawn at random."
    if random_phases:
        draws = f"Random draws are made in {joined(map(code, random_phases))}."
    return [*quoted(c, (c.schedule, c.episode)), draws, ""]


def _is_random(node: ir.Node) -> bool:
    if isinstance(node, ir.Set):
        return node.lot is not None
    return isinstance(node, ir.Chance | ir.Draw | ir.Match | ir.Move | ir.Pick | ir.Send | ir.Shift)


def names(w: Written) -> list[ast.Define]:
    """Returns the defines of the game's file, and those of its bases that the game reads."""
    read = {node.name for node in ir.walk(w.game) if isinstance(node, ir.Named)}
    c = w.composition
    return [
        define for name, define in c.defines.items() if name in read or define.span.file == c.file
    ]


def phases(c: Composition) -> dict[str, ast.Phase]:
    """Returns the phases of the schedule, each once, in the order of their first turns."""
    turns = () if c.schedule is None else c.schedule.turns
    names_in_order = dict.fromkeys(turn.name.text for turn in turns)
    return {name: c.phases[name] for name in names_in_order if name in c.phases}


def observation(w: Written) -> list[str]:
    """Returns the window, what is shown and hidden, and the values of each plane."""
    c = w.composition
    lines = quoted(c, [*c.windows, *c.observables.values()], "observe")
    try:
        planes = token_planes(w.game)
    except NotSupported as refusal:
        return [*lines, f"The compiler cannot make observations: {refusal.feature}.", ""]
    rows = [(str(i), code(plane.name), _values(plane)) for i, plane in enumerate(planes)]
    return [*lines, *table(("plane", "name", "values"), rows), ""]


def _values(plane: TokenPlane) -> str:
    """Returns what the numbers of a plane mean."""
    match plane.encoding:
        case "number":
            return f"0 to {plane.high}"
        case "bits":
            return ", ".join(f"bit {bit} {code(label)}" for bit, label in enumerate(plane.labels))
        case "word":
            groups = groupby(enumerate(plane.labels), _state_of_kind)
            return ", ".join(_labels(list(entries)) for _, entries in groups)


def _state_of_kind(entry: tuple[int, str]) -> object:
    """Returns the kind if a label is a state, such as `tree fruit=ripe`; else the label itself."""
    _, label = entry
    return label.partition(" ")[0] if "=" in label else entry


def _labels(entries: list[tuple[int, str]]) -> str:
    """Returns a value of a plane with its label, or the range of the states of one kind.

    With a range stand the kind's fields, each with its values: `2 to 5 tree: fruit none/ripe`.
    """
    first, label = entries[0]
    last, _ = entries[-1]
    if first == last:
        return f"{first} {plain(label)}"
    values: dict[str, dict[str, None]] = {}
    for _, state in entries:
        for assignment in state.split()[1:]:
            name, value = assignment.split("=")
            values.setdefault(name, {})[value] = None
    fields = [f"{name} {'/'.join(values_of_field)}" for name, values_of_field in values.items()]
    order = " (the last fastest)" if len(fields) > 1 else ""
    return f"{first} to {last} {label.partition(' ')[0]}: {plain(' × '.join(fields))}{order}"


def initialisation(w: Written) -> list[str]:
    """Returns how an episode begins."""
    values = (
        "At first, fields have the values behind their `=`, and cells the state that their glyph "
        "stands for. Then comes the phase `start`:"
    )
    c = w.composition
    lines = [values, "", *quoted(c, [c.phases["start"]])]
    if w.game.starting:
        following = [c.phases[phase.label] for phase in w.game.starting]
        lines += ["Then, in this order:", "", *quoted(c, following)]
    return lines


def metrics(w: Written) -> list[str]:
    """Returns what is counted and measured."""
    rows = [_metric(metric, w) for metric in w.composition.metrics.values()]
    lines = table(("metric", "what it is", "of", "source"), rows)
    return [*lines, ""] if lines else []


def _metric(metric: ast.Event | ast.Measure, w: Written) -> tuple[str, ...]:
    """Returns the line of an event or measure in the table of metrics."""
    name = metric.name
    text = w.composition.sources[metric.span.file].text
    expression = " ".join(text[name.span.end : metric.span.end].strip(" =\n").split())
    if isinstance(metric, ast.Event):
        per_agent = event_named(w.game, name.text).per_agent
        meaning = "counted for each agent" if per_agent else "counted for the whole game"
    elif metric.is_mean:
        meaning = "mean over the steps of an episode"
    else:
        meaning = "at the last step of an episode"
    source = comment_behind(w.composition, metric).lstrip("# ")
    return code(name.text), meaning, code(expression) if expression else "", plain(source)


def scenarios(w: Written) -> list[str]:
    """Returns the scenarios of a game, with who plays in each."""
    rows = [(code(s.name), plain(s.title), joined(map(_slots, s.slots))) for s in w.game.scenarios]
    return [*table(("scenario", "what it is", "who plays"), rows), ""] if rows else []


def _slots(part: ir.Slots) -> str:
    return f"{part.number} {code(part.policy) if part.policy else 'focal'}"


def variants(w: Written) -> list[str]:
    """Returns the variants of the game; `sjdsl diff` reports their differences."""
    if not w.variants:
        return []
    rows = [(code(name), plain(title)) for name, title in w.variants]
    command = f"sjdsl diff {w.file} --variants default {w.variants[0][0]}"
    hint = f"`{command}` says what a variant changes."
    return [*table(("variant", "what it is"), rows), "", hint, ""]
