"""Elaborates declarations into the symbol table: numbers, kinds, fields, agents, shapes."""

from collections.abc import Iterator, Mapping

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.diagnostic import Label, near
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate import shapes
from sjdsl.compiler.elaborate.agents import blocked, declare_agents, declare_number, override_number
from sjdsl.compiler.elaborate.constants import constant
from sjdsl.compiler.elaborate.expressions import expression
from sjdsl.compiler.elaborate.fields import fields_of, one_field, starting
from sjdsl.compiler.elaborate.keys import index_set_of
from sjdsl.compiler.elaborate.lookup import repeated
from sjdsl.compiler.elaborate.movers import declare_movers
from sjdsl.compiler.elaborate.possible import possible_condition
from sjdsl.compiler.elaborate.scope import Scope, Static
from sjdsl.compiler.elaborate.tasks import declare_task
from sjdsl.compiler.elaborate.trials import TRIAL, declare_trial
from sjdsl.compiler.ir.entity_types import AGENTS
from sjdsl.runtime.actions import HEADINGS

Declared = (
    ast.Constant
    | ast.Define
    | ast.Field
    | ast.TaskField
    | ast.Timer
    | ast.Kind
    | ast.Group
    | ast.Movers
)
Tables = Mapping[str, Mapping[str, Declared]]
RESERVED_VARIABLES = ("agent", "other", "step", "nobody", "all", "yes", "no", "cell")
OBSERVED_NAMES = {  # what `observe` has names for, so that no kind can
    "outside": "what an agent sees off the map",
    "everyone": "all agents, in `observe`",
}


def declare_numbers(
    game: Composition, problems: Problems, overrides: Mapping[str, object], num_agents: int | None
) -> Static:
    """Returns the static tables with sets of words, sizes and parameters.

    overrides: the values that a caller gives sizes.
    """
    static = Static(
        game.sources, expression, references=game.references, defines=dict(game.defines)
    )
    _check_names(game, _collect_words(game, static, problems), problems)
    for name, metric in game.metrics.items():
        if isinstance(metric, ast.Event):
            static.events[name] = metric
    static.number_from_file = num_agents is None and not overrides
    overrides = dict(overrides)
    if num_agents is not None:
        override_number(game, overrides, num_agents, problems)
    scope = Scope(static, problems)
    constants = list(game.constants.values())
    by_agent = [declared for declared in constants if isinstance(declared.by, ast.Name)]
    others = [declared for declared in constants if declared not in by_agent]

    def declare(constants: list[ast.Constant]) -> None:
        for declared in constants:
            name = declared.name.text
            with problems.skip_if_broken(static.broken, Symbol("name", name)):
                constant(declared, scope, overrides.get(name))

    declare(others)
    declare_number(game, scope)  # which sizes may say
    declare(by_agent)
    static.params = {name: static.params[name] for name in game.constants if name in static.params}
    return static


def _collect_words(game: Composition, static: Static, problems: Problems) -> dict[str, Span]:
    """Adds every set of words to the tables; returns where each word is declared first."""
    first: dict[str, Span] = {}
    for words in _word_sets(game):
        names = [name.text for name in words.names]
        if len(names) > limits.MAX_WORDS:
            feature = f"a set of more than {limits.MAX_WORDS} words"
            problems.add(errors.Unsupported(words.names[0].span, feature=feature))
        for name in repeated(words.names):
            problems.add(errors.WrittenTwice(name.span, part=f"the word `{name.text}`"))
        for name in words.names:
            first.setdefault(name.text, name.span)
        static.word_sets.append(tuple(dict.fromkeys(names)))
    static.word_sets.append(HEADINGS)
    return first


def _word_sets(game: Composition) -> Iterator[ast.Words]:
    """Yields the sets of words of fields, rows, events, numbers and arguments of actions."""
    places: list[object] = []
    for field in game.declared_fields():
        if isinstance(field, ast.Field):
            places.append(field.type)
        places.append(field.by)
    places += [metric.by for metric in game.metrics.values() if isinstance(metric, ast.Event)]
    places += [number.by for number in game.constants.values()]
    for declared in game.task_fields().values():
        places += [declared.type, declared.by]
    if game.acts is not None:
        places += [argument.type for action in game.acts.actions for argument in action.arguments]
    yield from (place for place in places if isinstance(place, ast.Words))


def _check_names(game: Composition, words: Mapping[str, Span], problems: Problems) -> None:
    """Reports a name with two meanings: numbers, defines, fields of the world, kinds, words.

    words: where each is declared; the headings are words without a place.
    """
    taken: dict[str, tuple[str, Span]] = {}
    cells: Tables = {"a kind": game.kinds, "a group": game.groups, "a sort of movers": game.movers}
    tables: Tables = {
        "a number": game.constants,
        "a define": game.defines,
        "a field of the world": game.fields,
        "a field of the task": game.task_fields(),
        **cells,
    }
    has_trials = game.episode is not None and game.episode.trials is not None
    reserved = (*RESERVED_VARIABLES, TRIAL) if has_trials else RESERVED_VARIABLES
    for meaning, table in tables.items():
        for name, node in table.items():
            span = node.name.span
            if name in reserved:
                taken_by = "something of the language"
                problems.add(errors.NameTaken(span, name=name, taken_by=taken_by))
            elif name in OBSERVED_NAMES and meaning in cells:
                taken_by = OBSERVED_NAMES[name]
                problems.add(errors.NameTaken(span, name=name, taken_by=taken_by))
            elif name in taken:
                taken_by, first = taken[name]
                labels = (Label(first, "declared here"),)
                problems.add(errors.NameTaken(span, name=name, taken_by=taken_by, labels=labels))
            elif name in words:
                labels = (Label(words[name], "the word is declared here"),)
                problems.add(errors.WordClash(span, name=name, taken_by=meaning, labels=labels))
            elif name in HEADINGS:
                problems.add(errors.WordClash(span, name=name, taken_by=meaning))
            taken.setdefault(name, (meaning, span))


def declare_world(game: Composition, static: Static, problems: Problems) -> None:
    """Adds shapes, kinds, groups, fields and the agents' actions and fields to the tables."""
    _check_counts(game, problems)
    scope = Scope(static, problems)
    for name, shape in game.shapes.items():
        with problems.skip_if_broken(static.broken, Symbol("shape", name)):
            static.shapes[name] = shapes.declared(shape, scope)
    static.mover_types = tuple(game.movers)
    static.cell_types = {kind: (kind,) for kind in game.kinds}
    for name, group in game.groups.items():
        static.cell_types[name] = tuple(kind.text for kind in group.kinds)
    for name, event in static.events.items():
        if event.by is not None:
            with problems.skip_if_broken():
                static.event_index_sets[name] = index_set_of(event.by, scope)
    for name, kind in game.kinds.items():
        with problems.skip_if_broken(static.broken, Symbol("name", name)):
            static.kinds[name] = fields_of(kind.attributes, scope, ir.EntityType("cell", (name,)))
            _glyphs(kind, scope)
    for name, group in game.groups.items():
        with problems.skip_if_broken(static.broken, Symbol("name", name)):
            for kind_name in group.kinds:
                if kind_name.text not in static.kinds:
                    raise problems.unknown(kind_name, static.kinds, "the kinds")
                static.refer(kind_name, Symbol("name", kind_name.text))
            static.groups[name] = static.cell_types[name]
    for name, field in game.fields.items():
        with problems.skip_if_broken(static.broken, Symbol("name", name)):
            static.fields[name] = one_field(field, scope, ir.EntityType("world"))
    declare_trial(game, scope)
    declare_task(game, scope)
    declare_agents(game, scope)
    declare_movers(game, scope)


def _check_counts(game: Composition, problems: Problems) -> None:
    """Reports more kinds, fields or phases than a game may have."""
    counts = (
        ("kinds", len(game.kinds), limits.MAX_KINDS),
        ("fields", len(game.declared_fields()) + len(game.task_fields()), limits.MAX_FIELDS),
        ("phases", len(game.phases), limits.MAX_PHASES),
    )
    for noun, number, limit in counts:
        if number > limit:
            problems.add(limits.too_much(f"the game has {number} {noun}", limit, game.span))


def _glyphs(kind: ast.Kind, scope: Scope) -> None:
    """Adds the kind's own glyph and its `glyph … with` glyphs to the legend."""
    name = kind.name.text
    glyphs = scope.static.glyphs
    plain = ir.GlyphMeaning(glyph=kind.glyph.text, kind=name, origin=kind.span)
    glyphs.append((kind.glyph.span, plain))
    for attribute in kind.attributes:
        if isinstance(attribute, ast.Glyph):
            meaning = ir.GlyphMeaning(
                glyph=attribute.glyph.text,
                kind=name,
                starts=_starts(attribute, name, scope),
                origin=attribute.span,
            )
            glyphs.append((attribute.glyph.span, meaning))


def _starts(
    glyph: ast.Glyph, kind: str, scope: Scope
) -> tuple[tuple[str, int | float | str | None], ...]:
    """Returns the fields of a kind that a glyph gives another starting value, with the values."""
    fields = scope.static.kinds[kind]
    starts = []
    for name, tree in glyph.starts:
        symbol = Symbol("field", name.text, kind)
        if symbol in scope.static.broken:
            continue
        if name.text not in fields:
            owner = f"the kind `{kind}`"
            meant = near(name.text, fields, "its fields")
            scope.problems.add(errors.NoField(name.span, owner=owner, name=name.text, near=meant))
            continue
        scope.static.refer(name, symbol)
        with scope.problems.skip_if_broken():
            start = starting(tree, name.text, fields[name.text].type, scope)
            starts.append((name.text, start))
    return tuple(starts)


def build_kinds(game: Composition, static: Static, problems: Problems) -> tuple[ir.Kind, ...]:
    """Returns the kinds with their fields and what they block.

    The conditions read the cell's fields and `agent`.
    """
    kinds = []
    for name, fields in static.kinds.items():
        kind = game.kinds[name]
        scope = Scope(static, problems, part="blocks")
        blocks: list[ir.Block] = []
        for attribute in kind.attributes:
            if isinstance(attribute, ast.Blocks):
                with problems.skip_if_broken():
                    blocks += _blocks(attribute, name, scope)
        kinds.append(
            ir.Kind(
                name=name,
                glyph=kind.glyph.text,
                fields=tuple(fields.values()),
                blocks=tuple(blocks),
                origin=kind.span,
            )
        )
    return tuple(kinds)


def _blocks(blocks: ast.Blocks, kind: str, scope: Scope) -> list[ir.Block]:
    """Returns one line of `blocks`, its condition read for agents and each of the movers."""
    tests: dict[ir.EntityType, ir.Expr | None] = {}
    for blocked_name in blocks.what:
        is_mover = blocked_name.text in scope.static.movers
        entity_type = ir.EntityType("mover", (blocked_name.text,)) if is_mover else AGENTS
        if entity_type not in tests:
            tests[entity_type] = _blocks_when(blocks, kind, entity_type, scope)
    return blocked(blocks, tests, scope)


def _blocks_when(
    blocks: ast.Blocks, kind: str, entity_type: ir.EntityType, scope: Scope
) -> ir.Expr | None:
    """Returns the condition of `blocks`, about the cell and who moves.

    Who moves is an agent, which may be the anchor of a shape, or a mover.
    """
    if blocks.condition is None:
        return None
    inner = scope.bind_member(kind, ir.EntityType("cell", (kind,))).bind_member(
        entity_type.name, entity_type
    )
    return possible_condition(blocks.condition, inner)
