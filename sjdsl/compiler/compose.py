"""Composes a game: inherits its base (`extends`), then adds its own sections and the chosen variants, by one rule.

    Source + variants -> Composition

A repeated name replaces, inside `agents` and `observe` entry by entry; a new name is added; `set` changes a number or one
table entry; `drop` removes.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar

from sjdsl.compiler import ast
from sjdsl.compiler.ast.names import Space, Symbol
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic, Label, near
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.syntax.parse import parse
from sjdsl.compiler.syntax.read import inside_folder, read_source


class Change(Record):
    """What a file says of one name, outside of variants: its text without layout. is_drop: it takes the name away, whatever it is of."""

    span: Span
    text: str
    is_drop: bool


def undone(files: Iterable[str], file_changes: Mapping[str, Change], variant: str, changes: Mapping[str, Change]) -> Iterator[Diagnostic]:
    """Yields a warning for each change of an extending game that a change of a variant of its base replaces.

    `files`: those of the game, the outermost base first. `file_changes`: what they say of each name.
    """
    order = {file: place for place, file in enumerate(files)}
    for key, change in changes.items():
        for other, before in file_changes.items():
            both = (key, other)
            if change.is_drop or before.is_drop:
                both = (key.rpartition(" ")[2], other.rpartition(" ")[2])
            if order[before.span.file] > order[change.span.file] and before.text != change.text and touches(*both):
                label = Label(change.span, f"`{variant}` changes it here")
                yield errors.UndoneByVariant(before.span, labels=(label,), name=other, variant=variant)


def touches(a: str, b: str) -> bool:
    """Returns whether two keys name the same thing, or one an entry of the other: `pay` and `pay[red]`."""
    return a == b or a.startswith(f"{b}[") or b.startswith(f"{a}[")


@dataclass
class Composition:
    """The declarations of one game in one variant, by name, in order of first appearance.

    `file`: the name of the game's own file among the `sources`, which hold its bases too; `chosen`: the variants applied.
    """

    name: str
    title: str
    span: Span
    cites: list[str] = field(default_factory=list)
    about: dict[str, str] = field(default_factory=dict)
    constants: dict[str, ast.Constant] = field(default_factory=dict)
    episode: ast.Episode | None = None
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
    observables: dict[str, ast.Show | ast.Hide] = field(default_factory=dict)
    looks: dict[str, tuple[ast.Look, ...]] = field(default_factory=dict)  # by what they are of
    metrics: dict[str, ast.Event | ast.Measure] = field(default_factory=dict)
    checks: dict[str, tuple[ast.Check, ...]] = field(default_factory=dict)  # by the name of their block, "" without one
    policies: dict[str, ast.ScriptedPolicy] = field(default_factory=dict)
    scenarios: dict[str, ast.Scenario] = field(default_factory=dict)
    variants: dict[str, ast.Variant] = field(default_factory=dict)
    references: list[tuple[Span, Symbol]] = field(default_factory=list)  # the names that were resolved, and what each stands for
    sources: dict[str, Source] = field(default_factory=dict)
    file: str = ""
    chosen: tuple[str, ...] = ()
    problems: list[Diagnostic] = field(default_factory=list)
    file_changes: dict[str, Change] = field(default_factory=dict)  # by the files of the game, outside of variants
    warnings: list[Diagnostic] = field(default_factory=list)

    NAMED: ClassVar[dict[type[Any], str]] = {  # sections with a name, and the table each of them is kept in
        ast.Constant: "constants", ast.Kind: "kinds", ast.Group: "groups", ast.Field: "fields", ast.Timer: "fields", ast.Movers: "movers",
        ast.Shape: "shapes", ast.Define: "defines", ast.Phase: "phases", ast.ScriptedPolicy: "policies", ast.Scenario: "scenarios",
        ast.Variant: "variants",
    }  # fmt: skip
    TABLES: ClassVar[dict[str, Space]] = {
        "constants": "name", "kinds": "name", "groups": "name", "fields": "name", "movers": "name", "shapes": "shape", "defines": "name",
        "phases": "phase", "metrics": "metric", "checks": "checks", "policies": "policy", "scenarios": "scenario",
    }  # fmt: skip

    def names(self) -> list[str]:
        """Returns every name a variant may change."""
        return [name for table in self.TABLES for name in getattr(self, table) if name] + [*self.agent_fields, *self.about, *self.variants]

    def number_names(self) -> tuple[list[str], list[str]]:
        """Returns the names of the sizes and of the parameters."""
        return [n for n, c in self.constants.items() if c.is_size], [n for n, c in self.constants.items() if not c.is_size]


def compose(source: Source, variants: Sequence[str] = ()) -> Composition:
    """Returns the game of a file with its bases, and variants applied left to right.

    Raises CompileError: a text that cannot be parsed, a base that cannot be read, a circle of `extends`, an unknown variant, a change to
    what is not there, two variants that disagree.
    """
    game = _chain(source, parse(source), ())
    game.file, game.chosen = source.name, tuple(variants)
    touched: dict[str, tuple[str, object]] = {}
    for name in variants:
        variant = game.variants.get(name)
        if variant is None:
            raise CompileError([errors.NoVariant(game.span, name=name, near=near(name, game.variants, "its variants"))])
        _check_duplicates(game, variant.changes)
        _check_clashes(game, name, variant, touched)
        game.warnings += undone(game.sources, game.file_changes, name, _changes(game, variant.changes))
        _apply(game, variant.changes)
    if game.problems:
        raise CompileError(game.problems)
    return game


def _chain(source: Source, file: ast.File, seen: tuple[str, ...]) -> Composition:
    """Returns the composition of a file on its bases, outermost base first."""
    title = file.game.title.text if file.game.title else ""
    if file.game.extends is None:
        game = Composition(file.game.name.text, title, file.game.name.span)
    else:
        base = base_of(file.game.extends, source)
        tree = parse(base)
        if base.name in (*seen, source.name):
            raise CompileError([errors.ExtendsCycle(file.game.extends.span, name=base.name)])
        game = _chain(base, tree, (*seen, source.name))
        game.name, game.span = file.game.name.text, file.game.name.span
        game.title = title or game.title
    game.sources[source.name] = source
    _check_duplicates(game, file.game.sections)
    game.file_changes |= _changes(game, file.game.sections)
    _apply(game, file.game.sections)
    return game


def base_of(name: ast.String, source: Source) -> Source:
    """Returns the text that a file `extends`, from the file's own folder. Raises CompileError if there is none, or it cannot be read."""
    problems = Problems()
    path = inside_folder(name.text, name.span, source, problems)
    if path is None:
        raise CompileError(problems.found)
    name_here = (Path(source.name).parent / name.text).as_posix()
    over = source.instead_of(path)
    if over is not None:
        return Source(name_here, over, path.parent, source.over)
    if not path.is_file():
        beside = [p.name for p in path.parent.glob("*.sj")] if path.parent.is_dir() else []
        how = f"`extends` takes a file beside this one: copy a bundled game with its maps, `sjdsl new --from {name.text}`"
        how = f'{how}, and write `extends "{name.text}.sj"`' if name.text.isidentifier() else ""
        raise CompileError([errors.NoFile(name.span, name=name.text, near=near(path.name, beside), help=how)])
    return Source(name_here, read_source(path).text, path.parent, source.over)


def section_names(section: ast.Section | ast.Override | ast.Drop) -> list[tuple[str, Span, object]]:
    """Returns what a section declares or changes: (key, span, node)."""
    match section:
        case ast.Constant() | ast.Kind() | ast.Group() | ast.Field() | ast.Timer() | ast.Define() | ast.Movers() | ast.Drop():
            return [(section.name.text, section.name.span, section)]
        case ast.Shape() | ast.Phase() | ast.Variant() | ast.Scenario() | ast.ScriptedPolicy() | ast.About():  # each has its own name space
            space = "policy" if isinstance(section, ast.ScriptedPolicy) else type(section).__name__.lower()
            return [(f"{space} {section.name.text}", section.name.span, section)]
        case ast.Checks():
            return [] if section.name is None else [(f"checks {section.name.text}", section.name.span, section)]
        case ast.Map() | ast.Episode() | ast.Schedule():
            return [(type(section).__name__.lower(), section.span, section)]
        case ast.Agents():
            return [(f"agents {key}", node.span, node) for key, node in _agent_entries(section)]
        case ast.Observe():
            return [(f"observe {key}", node.span, node) for key, node in _observable_entries(section)]
        case ast.Look():
            return [(f"look {section.what.text}", section.span, section)]
        case ast.Metrics():
            return [(f"metric {m.name.text}", m.name.span, m) for m in section.metrics]
        case ast.Override():
            return [(path_text(section.path), section.path.span, section)]
        case _:
            return []


def _check_duplicates(game: Composition, sections: tuple[ast.Section | ast.Override | ast.Drop, ...]) -> None:
    seen: dict[str, Span] = {}
    for section in sections:
        for key, span, node in section_names(section):
            if isinstance(node, ast.Look):  # one kind looks this way or that
                continue
            over = isinstance(node, ast.Override) and any(touches(key, k) for k in seen)
            if key in seen or over:
                if over or isinstance(node, ast.Map | ast.Episode | ast.Schedule) or " " in key:
                    game.problems.append(errors.WrittenTwice(span, what=f"`{key}`"))
                else:
                    what = f"something declared in line {seen[key].line}"
                    game.problems.append(errors.NameTaken(span, name=key, what=what))
            seen.setdefault(key, span)


def _check_clashes(game: Composition, name: str, variant: ast.Variant, touched: dict[str, tuple[str, object]]) -> None:
    for section in variant.changes:
        for key, span, node in section_names(section):
            for other, before in touched.items():
                same = other == key and before[1] == _content(game, node)
                if before[0] != name and touches(other, key) and not same:
                    game.problems.append(errors.ChangeClash(span, first=before[0], second=name, name=key))
                    break
            touched.setdefault(key, (name, _content(game, node)))


def _changes(game: Composition, sections: tuple[ast.Section | ast.Override | ast.Drop, ...]) -> dict[str, Change]:
    """Returns what sections say of rules, by the names they have in `section_names`."""
    values = ast.Override | ast.Constant | ast.Map | ast.Episode | ast.About
    named = (entry for section in sections if not isinstance(section, values) for entry in section_names(section))
    return {key: Change(span, _content(game, node), isinstance(node, ast.Drop)) for key, span, node in named}


def _content(game: Composition, node: object) -> str:
    """Returns the text of a node without layout, to compare two changes."""
    span: Span = node.span  # type: ignore[attr-defined]
    return " ".join(game.sources[span.file].text[span.start : span.end].split())


def _apply(game: Composition, sections: tuple[ast.Section | ast.Override | ast.Drop, ...]) -> None:
    looks = [section for section in sections if isinstance(section, ast.Look)]
    for name in dict.fromkeys(look.what.text for look in looks):
        game.looks[name] = tuple(look for look in looks if look.what.text == name)
    for section in sections:
        named: Any = section
        if type(section) in Composition.NAMED:
            getattr(game, Composition.NAMED[type(section)])[named.name.text] = section
        match section:
            case ast.Episode() | ast.Map() | ast.Schedule():
                setattr(game, type(section).__name__.lower(), section)
            case ast.Cite():
                game.cites.append(section.text.text)
            case ast.About():
                game.about[section.name.text] = " ".join(text.text for text in section.texts)
            case ast.Agents():
                _apply_agents(game, section)
            case ast.Observe():
                game.windows = tuple(s for s in section.observables if isinstance(s, ast.Window)) or game.windows
                game.observables |= {_observable_key(s): s for s in section.observables if not isinstance(s, ast.Window)}
            case ast.Metrics():
                game.metrics |= {m.name.text: m for m in section.metrics}
            case ast.Checks():
                name = "" if section.name is None else section.name.text
                game.checks[name] = section.checks if name else game.checks.get(name, ()) + section.checks
            case ast.Override():
                _override(game, section)
            case ast.Drop():
                _drop(game, section.name)


AgentAttribute = ast.Acts | ast.Moves | ast.Field | ast.Timer | ast.Forbid | ast.Blocks


def _agent_entries(agents: ast.Agents) -> list[tuple[str, AgentAttribute]]:
    """Returns the attributes of the agents by their keys."""

    def key(attribute: AgentAttribute) -> str:
        match attribute:
            case ast.Acts() | ast.Moves():
                return type(attribute).__name__.lower()
            case ast.Forbid():
                return forbid_key(attribute)
            case ast.Blocks():
                return f"blocks {', '.join(what.text for what in attribute.what)}"
            case _:
                return attribute.name.text

    return [(key(attribute), attribute) for attribute in agents.attributes]


def forbid_key(forbid: ast.Forbid) -> str:
    return f"forbid {', '.join(map(chosen_text, forbid.actions)) or 'all'}"


def chosen_text(action: ast.Chosen) -> str:
    """Returns an action as it is spoken of, without layout; arguments other than names and numbers show as `..`."""
    if action.arguments is None:
        return action.name.text
    values = (path_text(a) if isinstance(a, ast.Path) else str(a.value) if isinstance(a, ast.Int) else ".." for a in action.arguments)
    return f"{action.name.text}({', '.join(values)})"


def _apply_agents(game: Composition, agents: ast.Agents) -> None:
    game.agents_span = game.agents_span or agents.span
    if agents.number is not None:
        game.number = agents.number
    tables: dict[type[Any], dict[str, Any]] = {ast.Forbid: game.forbids, ast.Blocks: game.agent_blocks}
    for key, attribute in _agent_entries(agents):
        if isinstance(attribute, ast.Acts | ast.Moves):
            setattr(game, key, attribute)
        else:
            tables.get(type(attribute), game.agent_fields)[key] = attribute


def _observable_entries(observe: ast.Observe) -> list[tuple[str, ast.Window | ast.Show | ast.Hide]]:
    """Returns what a block says, by its key. The windows are one entry together, so that they are replaced together."""
    windows = [s for s in observe.observables if isinstance(s, ast.Window)]
    plain = [w for w in windows if w.condition is None] or windows[:1]
    if len(windows) > len(plain):
        span = replace(plain[0].span, start=windows[0].span.start, end=windows[-1].span.end)
        plain[0] = replace(plain[0], span=span)
    return [("window", window) for window in plain] + [
        (_observable_key(s), s) for s in observe.observables if not isinstance(s, ast.Window)
    ]


def _observable_key(observable: ast.Show | ast.Hide) -> str:
    on = f" on {observable.on.text}" if isinstance(observable, ast.Hide) and isinstance(observable.on, ast.Name) else ""
    return path_text(observable.what) + on


def _override(game: Composition, change: ast.Override) -> None:
    name = change.path.name
    constant = game.constants.get(name.text)
    if constant is None:
        _unknown(game, name)
        return
    game.references.append((name.span, Symbol("name", name.text)))
    game.constants[name.text] = replace(constant, value=_replace_entry(game, constant.value, change.path.steps, change, constant.by))


def _replace_entry(
    game: Composition,
    value: ast.Expr | ast.Table,
    steps: tuple[ast.Member | ast.Index, ...],
    change: ast.Override,
    by: ast.By | None = None,
) -> ast.Expr | ast.Table:
    if not steps:
        return change.value
    key = entry_key(steps[0])
    if key is not None and by is not None:
        value = with_entry(value, key, by)
    if key is None or not isinstance(value, ast.Table) or key.text not in {e.key.text for e in value.entries}:
        _unknown(game, ast.Name(change.path.span, path_text(change.path)))
        return value
    game.references.append((key.span, Symbol("word", key.text)))
    entries = tuple(
        replace(e, value=_replace_entry(game, e.value, steps[1:], change)) if e.key.text == key.text else e for e in value.entries
    )
    return replace(value, entries=entries)


def _drop(game: Composition, name: ast.Name) -> None:
    others: dict[str, Space | None] = {"agent_fields": "field", "observables": None, "about": None, "variants": "variant"}
    for table, space in {**Composition.TABLES, **others}.items():
        entries: dict[str, object] = getattr(game, table)
        if name.text in entries:
            del entries[name.text]
            if space is not None:
                game.references.append((name.span, Symbol(space, name.text, "agent" if space == "field" else "")))
            return
    _unknown(game, name)


def _unknown(game: Composition, name: ast.Name) -> None:
    game.problems.append(errors.ChangeUnknown(name.span, name=name.text, near=near(name.text, game.names())))


def path_text(path: ast.Path) -> str:
    """Returns a path as written, without layout; keys other than names show as `..`."""
    steps = []
    for step in path.steps:
        if isinstance(step, ast.Member):
            steps.append("." + step.name.text)
        else:
            key = step.key
            steps.append(f"[{key.name.text}]" if isinstance(key, ast.Path) else f"[{key.value}]" if isinstance(key, ast.Int) else "[..]")
    return path.name.text + "".join(steps)


def entry_key(step: ast.Member | ast.Index) -> ast.Name | None:
    """Returns the entry that a change names: a word, or a number."""
    match step:
        case ast.Index(key=ast.Path(name=name)):
            return name
        case ast.Index(key=ast.Int(value=number) as written):
            return ast.Name(written.span, str(number))
    return None


def with_entry(value: ast.Expr | ast.Table, key: ast.Name, by: ast.By) -> ast.Expr | ast.Table:
    """Returns a table in which an entry stands by itself: one that `otherwise` or a single number for all stood for gets a line of its own."""
    known = isinstance(by, ast.Words) and key.text in {name.text for name in by.names}
    if not known and not (not isinstance(by, ast.Words) and key.text.isdigit()):
        return value
    rest = ast.Name(value.span, "otherwise")
    entries = value.entries if isinstance(value, ast.Table) else (ast.Entry(value.span, rest, value),)
    others = next((entry for entry in entries if entry.key.text == "otherwise"), None)
    if others is None or key.text in {entry.key.text for entry in entries}:
        return value
    return ast.Table(value.span, (ast.Entry(value.span, key, others.value), *entries))
