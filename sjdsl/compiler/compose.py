"""Composes a game.

Inherits its base (`extends`), then adds its own sections and the chosen variants, by one rule.

    Source + variants -> Composition

A repeated name replaces, inside `agents` and `observe` entry by entry; a new name is added; `set`
changes a number or one table entry; `drop` removes.
"""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path
from typing import ClassVar, NamedTuple

from sjdsl.compiler import ast
from sjdsl.compiler.ast.names import Space, Symbol
from sjdsl.compiler.ast.node import Node
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic, near
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.syntax.parse import parse
from sjdsl.compiler.syntax.read import inside_folder, read_source

Sections = tuple[ast.Section | ast.Override | ast.Drop, ...]
# The table of a composition that each declaration with a name goes into, and what stands before its
# name in messages about changes:
# shapes, phases and so on have name spaces of their own.
TABLE_OF: dict[type[Node], tuple[str, str]] = {
    ast.Constant: ("constants", ""), ast.Kind: ("kinds", ""), ast.Group: ("groups", ""), ast.Field: ("fields", ""),
    ast.Timer: ("fields", ""), ast.Define: ("defines", ""), ast.Movers: ("movers", ""), ast.Shape: ("shapes", "shape "),
    ast.Phase: ("phases", "phase "), ast.Variant: ("variants", "variant "), ast.Scenario: ("scenarios", "scenario "),
    ast.ScriptedPolicy: ("policies", "policy "), ast.Task: ("tasks", "task "),
    ast.HoldOut: ("held_out", "hold out "),
}  # fmt: skip
Observable = ast.Show | ast.ShowEvent | ast.Hide


@dataclass
class Composition:
    """The declarations of one game in one variant, by name, in order of first appearance.

    `file`: the name of the game's own file among the `sources`, which hold its bases too; `chosen`:
    the variants applied.
    """

    name: str
    title: str
    span: Span
    cites: list[str] = field(default_factory=list)
    about: dict[str, str] = field(default_factory=dict)
    constants: dict[str, ast.Constant] = field(default_factory=dict)
    episode: ast.Episode | None = None
    tasks: dict[str, ast.Task] = field(default_factory=dict)
    train_on: ast.TrainOn | None = None
    held_out: dict[str, ast.HoldOut] = field(default_factory=dict)
    kinds: dict[str, ast.Kind] = field(default_factory=dict)
    groups: dict[str, ast.Group] = field(default_factory=dict)
    fields: dict[str, ast.Field | ast.Timer] = field(default_factory=dict)
    map: ast.Map | None = None
    agents_span: Span | None = None
    number: ast.Expr | None = None
    acts: ast.Acts | None = None
    moves: ast.Moves | None = None
    agent_fields: dict[str, ast.Field | ast.Timer] = field(default_factory=dict)
    forbids: dict[str, ast.Forbid] = field(default_factory=dict)
    agent_blocks: dict[str, ast.Blocks] = field(default_factory=dict)
    movers: dict[str, ast.Movers] = field(default_factory=dict)
    shapes: dict[str, ast.Shape] = field(default_factory=dict)
    defines: dict[str, ast.Define] = field(default_factory=dict)
    schedule: ast.Schedule | None = None
    phases: dict[str, ast.Phase] = field(default_factory=dict)
    windows: tuple[ast.Window, ...] = ()
    observables: dict[str, Observable] = field(default_factory=dict)
    looks: dict[str, tuple[ast.Look, ...]] = field(default_factory=dict)  # by what they are of
    metrics: dict[str, ast.Event | ast.Measure] = field(default_factory=dict)
    checks: dict[str, tuple[ast.Check, ...]] = field(
        default_factory=dict
    )  # by the name of their block, "" without one
    policies: dict[str, ast.ScriptedPolicy] = field(default_factory=dict)
    scenarios: dict[str, ast.Scenario] = field(default_factory=dict)
    variants: dict[str, ast.Variant] = field(default_factory=dict)
    references: list[tuple[Span, Symbol]] = field(
        default_factory=list
    )  # the names that were resolved, and what each stands for
    sources: dict[str, Source] = field(default_factory=dict)
    file: str = ""
    chosen: tuple[str, ...] = ()
    problems: list[Diagnostic] = field(default_factory=list)

    TABLES: ClassVar[dict[str, Space]] = {
        "constants": "name", "kinds": "name", "groups": "name", "fields": "name", "movers": "name", "shapes": "shape", "defines": "name",
        "phases": "phase", "metrics": "metric", "checks": "checks", "policies": "policy", "scenarios": "scenario",
        "held_out": "split",
    }  # fmt: skip

    def names(self) -> list[str]:
        """Returns every name a variant may change."""
        return [name for table in self.TABLES for name in getattr(self, table) if name] + [
            *self.agent_fields,
            *self.about,
            *self.variants,
        ]

    def declared_fields(self) -> list[ast.Field | ast.Timer]:
        """Returns the fields and timers of cells, movers, agents and the world."""
        owners: list[ast.Kind | ast.Movers] = [*self.kinds.values(), *self.movers.values()]
        attributes = [attribute for owner in owners for attribute in owner.attributes]
        fields = [a for a in attributes if isinstance(a, ast.Field | ast.Timer)]
        return [*fields, *self.agent_fields.values(), *self.fields.values()]

    def task_fields(self) -> dict[str, ast.TaskField]:
        """Returns the fields of tasks by name."""
        return {field.name.text: field for task in self.tasks.values() for field in task.fields}

    def number_names(self) -> tuple[list[str], list[str]]:
        """Returns the names of the sizes and of the parameters."""
        return [n for n, c in self.constants.items() if c.is_size], [
            n for n, c in self.constants.items() if not c.is_size
        ]


def compose(source: Source, variants: Sequence[str] = ()) -> Composition:
    """Returns the game of a file with its bases, and variants applied left to right.

    Raises CompileError: a text that cannot be parsed, a base that cannot be read, a circle of
    `extends`, an unknown variant, a change to what is not there, two variants that disagree.
    """
    game = _inherited(tuple(bases(source)))
    game.file = source.name
    game.chosen = tuple(variants)
    touched: dict[str, tuple[str, str]] = {}
    for name in variants:
        variant = game.variants.get(name)
        if variant is None:
            raise CompileError(
                [
                    errors.NoVariant(
                        game.span, name=name, near=near(name, game.variants, "its variants")
                    )
                ]
            )
        _check_duplicates(game, variant.changes)
        _check_clashes(game, name, variant, touched)
        _apply(game, variant.changes)
    if game.problems:
        raise CompileError(game.problems)
    return game


def bases(source: Source) -> Iterator[tuple[Source, ast.File]]:
    """Yields a text with its tree, then the game that it extends, and so on.

    Raises CompileError: a text that cannot be parsed, a base that cannot be read, a circle of
    `extends`.
    """
    seen: list[Source] = []
    while True:
        file = parse(source)
        yield source, file
        if file.game.extends is None:
            return
        seen.append(source)
        source = _base_of(file.game.extends, source)
        if any(_is_same(source, other) for other in seen):
            raise CompileError([errors.ExtendsCycle(file.game.extends.span, name=source.name)])


def _is_same(a: Source, b: Source) -> bool:
    """Returns whether two texts are of one file, by whatever path."""
    if a.file is None or b.file is None:
        return a.name == b.name
    with suppress(OSError):
        return a.file.samefile(b.file)
    return a.file == b.file  # of an editor, not on the disk


def _inherited(files: Sequence[tuple[Source, ast.File]]) -> Composition:
    """Returns the composition of a file and its bases: the outermost base is the last."""
    outermost = files[-1][1].game
    game = Composition(outermost.name.text, "", outermost.name.span)
    for source, file in reversed(files):
        game.name = file.game.name.text
        game.span = file.game.name.span
        if file.game.title is not None:
            game.title = file.game.title.text or game.title
        game.sources[source.name] = source
        _check_duplicates(game, file.game.sections)
        _apply(game, file.game.sections)
    return game


def _base_of(name: ast.String, source: Source) -> Source:
    """Returns the text that a file `extends`, from the file's own folder.

    Raises CompileError if there is none, or it cannot be read.
    """
    problems = Problems()
    path = inside_folder(name.text, name.span, source, problems)
    if path is None:
        raise CompileError(problems.diagnostics)
    name_here = (Path(source.name).parent / name.text).as_posix()
    over = source.instead_of(path)
    if over is not None:
        return Source(name_here, over, path.parent, source.over, path.resolve())
    if not path.exists():
        beside = [p.name for p in path.parent.glob("*.sj")] if path.parent.is_dir() else []
        how = f"`extends` takes a file beside this one: copy a bundled game with its maps, `sjdsl new --from {name.text}`"
        how = f'{how}, and write `extends "{name.text}.sj"`' if name.text.isidentifier() else ""
        raise CompileError(
            [errors.NoFile(name.span, name=name.text, near=near(path.name, beside), help=how)]
        )
    return replace(read_source(path), name=name_here, over=source.over)


class Entry(NamedTuple):
    """Something that a section declares.

    table: the field of a composition that it goes into; name: in that table, if it is one.
    label: what messages about changes call it.
    """

    table: str
    name: str
    label: str
    span: Span
    node: Node


def _entries(section: ast.Section) -> list[Entry]:
    """Returns what a section declares under a name that a variant can replace."""
    match section:
        case ast.Cite():
            return []
        case ast.About(name=name):
            return [Entry("about", name.text, f"about {name.text}", name.span, section)]
        case ast.Checks():
            block = section.name
            if block is None:
                return []
            return [Entry("checks", block.text, f"checks {block.text}", block.span, section)]
        case ast.Map() | ast.Episode() | ast.Schedule():
            table = type(section).__name__.lower()
            return [Entry(table, "", table, section.span, section)]
        case ast.TrainOn():
            return [Entry("train_on", "", "train on", section.span, section)]
        case ast.Agents():
            return list(map(_entry_of_agents, section.attributes))
        case ast.Observe():
            return _entries_observed(section)
        case ast.Look(what=what):
            return [Entry("looks", what.text, f"look {what.text}", section.span, section)]
        case ast.Metrics():
            return [
                Entry("metrics", m.name.text, f"metric {m.name.text}", m.name.span, m)
                for m in section.metrics
            ]
        case _:
            table, prefix = TABLE_OF[type(section)]
            name = section.name
            return [Entry(table, name.text, prefix + name.text, name.span, section)]


def _entry_of_agents(
    attribute: ast.Acts | ast.Moves | ast.Field | ast.Timer | ast.Forbid | ast.Blocks,
) -> Entry:
    """Returns an attribute of agents, with the name under which a variant replaces it."""
    match attribute:
        case ast.Acts() | ast.Moves():
            table = name = type(attribute).__name__.lower()
        case ast.Forbid():
            table = "forbids"
            name = "forbid " + (", ".join(map(_chosen_text, attribute.actions)) or "all")
        case ast.Blocks():
            table = "agent_blocks"
            name = f"blocks {', '.join(what.text for what in attribute.what)}"
        case ast.Field() | ast.Timer():
            table = "agent_fields"
            name = attribute.name.text
    return Entry(table, name, f"agents {name}", attribute.span, attribute)


def _changed(section: ast.Section | ast.Override | ast.Drop) -> list[tuple[str, Span, Node]]:
    """Returns what a section declares or changes: (label, span, node)."""
    match section:
        case ast.Override():
            return [(path_text(section.path), section.path.span, section)]
        case ast.Drop():
            return [(section.name.text, section.name.span, section)]
        case _:
            return [(entry.label, entry.span, entry.node) for entry in _entries(section)]


def _check_duplicates(game: Composition, sections: Sections) -> None:
    """Reports what one text declares twice."""
    seen: dict[str, Span] = {}
    for label, span, node in chain.from_iterable(map(_changed, sections)):
        if isinstance(node, ast.Look):  # one kind looks this way or that
            continue
        is_changed = isinstance(node, ast.Override) and any(_touches(label, k) for k in seen)
        is_alone = isinstance(node, ast.Map | ast.Episode | ast.Schedule)
        if is_changed or (label in seen and (is_alone or " " in label)):
            game.problems.append(errors.WrittenTwice(span, part=f"`{label}`"))
        elif label in seen:
            taken_by = f"something declared in line {seen[label].line}"
            game.problems.append(errors.NameTaken(span, name=label, taken_by=taken_by))
        seen.setdefault(label, span)


def _check_clashes(
    game: Composition, name: str, variant: ast.Variant, touched: dict[str, tuple[str, str]]
) -> None:
    """Reports what a variant and one before it change differently.

    touched: label -> (variant, text of its change).
    """
    for label, span, node in chain.from_iterable(map(_changed, variant.changes)):
        text = _content(game, node)
        for other, (first, before) in touched.items():
            if first != name and _touches(other, label) and (other, before) != (label, text):
                game.problems.append(errors.ChangeClash(span, first=first, second=name, name=label))
                break
        touched.setdefault(label, (name, text))


def _touches(a: str, b: str) -> bool:
    """Returns whether two keys name the same thing, or one an entry of the other.

    `pay` and `pay[red]`.
    """
    return a == b or a.startswith(f"{b}[") or b.startswith(f"{a}[")


def _content(game: Composition, node: Node) -> str:
    """Returns the text of a node without layout, to compare two changes."""
    return " ".join(game.sources[node.span.file].text[node.span.start : node.span.end].split())


def _apply(game: Composition, sections: Sections) -> None:
    """Adds the sections of a text to a game; what a base has under the same names is replaced."""
    looks: dict[str, tuple[ast.Look, ...]] = {}
    for section in sections:
        match section:
            case ast.Cite():
                game.cites.append(section.text.text)
            case ast.About():
                game.about[section.name.text] = " ".join(text.text for text in section.texts)
            case ast.Look(what=what):
                looks[what.text] = (*looks.get(what.text, ()), section)
            case ast.Checks(name=None):
                game.checks[""] = game.checks.get("", ()) + section.checks
            case ast.Checks(name=ast.Name() as name):
                game.checks[name.text] = section.checks
            case ast.Override():
                _override_constant(game, section)
            case ast.Drop():
                _drop(game, section.name)
            case _:
                _add(game, section)
    game.looks |= looks


def _add(game: Composition, section: ast.Section) -> None:
    """Adds what a section declares to the tables of a game."""
    if isinstance(section, ast.Agents):
        game.agents_span = game.agents_span or section.span
        game.number = section.number or game.number
    if isinstance(section, ast.Observe):
        windows = (node for node in section.observables if isinstance(node, ast.Window))
        game.windows = tuple(windows) or game.windows
    for entry in _entries(section):
        table = getattr(game, entry.table)
        if isinstance(table, dict):
            table[entry.name] = entry.node
        elif not isinstance(entry.node, ast.Window):
            setattr(game, entry.table, entry.node)


def _chosen_text(action: ast.Chosen) -> str:
    """Returns an action as it is spoken of, without layout.

    Arguments other than names and numbers show as `..`.
    """
    if action.arguments is None:
        return action.name.text
    texts = []
    for argument in action.arguments:
        match argument:
            case ast.Path():
                texts.append(path_text(argument))
            case ast.Int():
                texts.append(str(argument.value))
            case _:
                texts.append("..")
    return f"{action.name.text}({', '.join(texts)})"


def _entries_observed(observe: ast.Observe) -> list[Entry]:
    """Returns what a block says. The windows are one entry together, replaced together."""
    entries: list[Entry] = []
    windows = [node for node in observe.observables if isinstance(node, ast.Window)]
    plain = [window for window in windows if window.condition is None] or windows[:1]
    for number, window in enumerate(plain):
        if number == 0 and len(windows) > len(plain):
            end = windows[-1].span.end
            span = replace(window.span, start=windows[0].span.start, end=end)
            window = replace(window, span=span)
        entries.append(Entry("windows", "", "observe window", window.span, window))
    for node in observe.observables:
        if not isinstance(node, ast.Window):
            name = _observable_name(node)
            entries.append(Entry("observables", name, f"observe {name}", node.span, node))
    return entries


def _observable_name(observable: Observable) -> str:
    """Returns the name under which a variant replaces a `show` or `hide`."""
    if isinstance(observable, ast.ShowEvent):
        return f"event {observable.name.text}"
    name = path_text(observable.what)
    if isinstance(observable, ast.Hide) and observable.on is not None:
        return f"{name} on {observable.on.text}"
    return name


def _override_constant(game: Composition, change: ast.Override) -> None:
    """Gives a constant of the game another value, or entries of its table others."""
    name = change.path.name.text
    constant = game.constants.get(name)
    if constant is None:
        _unknown(game, change.path.name)
        return
    game.references.append((change.path.name.span, Symbol("name", name)))
    value = _replace_entry(game, constant.value, change.path.steps, change, constant.by)
    game.constants[name] = replace(constant, value=value)


def _replace_entry(
    game: Composition,
    value: ast.Expr | ast.Table,
    steps: tuple[ast.Member | ast.Index, ...],
    change: ast.Override,
    by: ast.By | None = None,
) -> ast.Expr | ast.Table:
    """Returns a constant's value with the entry replaced to which the steps lead."""
    if not steps:
        return change.value
    key: ast.Name | None = None  # the entry that is changed: a word, or a number
    match steps[0]:
        case ast.Index(key=ast.Path(name=name)):
            key = name
        case ast.Index(key=ast.Int(value=number) as written):
            key = ast.Name(written.span, str(number))
    if key is not None and by is not None:
        value = _with_entry(value, key, by)
    if (
        key is None
        or not isinstance(value, ast.Table)
        or key.text not in {e.key.text for e in value.entries}
    ):
        _unknown(game, ast.Name(change.path.span, path_text(change.path)))
        return value
    game.references.append((key.span, Symbol("word", key.text)))
    changed = (
        replace(e, value=_replace_entry(game, e.value, steps[1:], change))
        if e.key.text == key.text
        else e
        for e in value.entries
    )
    return replace(value, entries=tuple(changed))


def _drop(game: Composition, name: ast.Name) -> None:
    """Removes what a variant drops by name."""
    others: dict[str, Space | None] = {
        "agent_fields": "field",
        "observables": None,
        "about": None,
        "variants": "variant",
    }
    for table, space in (*Composition.TABLES.items(), *others.items()):
        entries: dict[str, object] = getattr(game, table)
        if name.text in entries:
            del entries[name.text]
            if space is not None:
                game.references.append(
                    (name.span, Symbol(space, name.text, "agent" if space == "field" else ""))
                )
            return
    _unknown(game, name)


def _unknown(game: Composition, name: ast.Name) -> None:
    game.problems.append(
        errors.ChangeUnknown(name.span, name=name.text, near=near(name.text, game.names()))
    )


def path_text(path: ast.Path) -> str:
    """Returns a path as written, without layout; keys other than names show as `..`."""
    text = path.name.text
    for step in path.steps:
        match step:
            case ast.Member():
                text += f".{step.name.text}"
            case ast.Index(key=ast.Path(name=name)):
                text += f"[{name.text}]"
            case ast.Index(key=ast.Int(value=number)):
                text += f"[{number}]"
            case ast.Index():
                text += "[..]"
    return text


def _with_entry(value: ast.Expr | ast.Table, key: ast.Name, by: ast.By) -> ast.Expr | ast.Table:
    """Returns a table in which an entry stands by itself.

    One that `otherwise` or a single number for all stood for gets a line of its own.
    """
    if isinstance(by, ast.Words):
        is_entry = key.text in {name.text for name in by.names}
    else:
        is_entry = key.text.isdigit()
    if not is_entry:
        return value
    rest = ast.Name(value.span, "otherwise")
    entries = (
        value.entries if isinstance(value, ast.Table) else (ast.Entry(value.span, rest, value),)
    )
    others = next((entry for entry in entries if entry.key.text == "otherwise"), None)
    if others is None or key.text in {entry.key.text for entry in entries}:
        return value
    return ast.Table(value.span, (ast.Entry(value.span, key, others.value), *entries))
