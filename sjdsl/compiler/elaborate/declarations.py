"""Elaborates declarations: numbers, kinds, fields, agents and shapes become the symbol table that every scope sees."""

from collections.abc import Mapping

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
from sjdsl.compiler.elaborate.keys import level_of
from sjdsl.compiler.elaborate.movers import declare_movers
from sjdsl.compiler.elaborate.possible import check_possible
from sjdsl.compiler.elaborate.scope import Scope, Static
from sjdsl.compiler.ir.sorts import AGENTS
from sjdsl.runtime.actions import HEADINGS

SEEN = {
    "outside": "what an agent sees off the map",
    "everyone": "all agents, in `observe`",
}  # no names of kinds
Tables = Mapping[
    str,
    Mapping[
        str, ast.Constant | ast.Define | ast.Field | ast.Timer | ast.Kind | ast.Group | ast.Movers
    ],
]
RESERVED_VARIABLES = ("agent", "other", "step", "nobody", "all", "yes", "no", "cell")


def declare_numbers(
    game: Composition, problems: Problems, overrides: Mapping[str, object], num_agents: int | None
) -> Static:
    """Returns the static tables with word sets, sizes and parameters; sizes take their values from `overrides`."""
    static = Static(
        game.sources, expression, references=game.references, defines=dict(game.defines)
    )
    _check_names(game, _collect_words(game, static, problems), problems)
    static.events = {n: m for n, m in game.metrics.items() if isinstance(m, ast.Event)}
    static.number_from_file = num_agents is None and not overrides
    overrides = dict(overrides)
    if num_agents is not None:
        override_number(game, overrides, num_agents, problems)
    scope = Scope(static, problems)
    by_agent = [
        c for c in game.constants.values() if isinstance(c.by, ast.Name)
    ]  # these need the number of agents, which sizes may say
    for declared in (*(c for c in game.constants.values() if c not in by_agent), *by_agent):
        if by_agent and declared is by_agent[0]:
            declare_number(game, scope)
        with problems.survive(static.broken, Symbol("name", declared.name.text)):
            constant(declared, scope, overrides.get(declared.name.text))
    static.params = {name: static.params[name] for name in game.constants if name in static.params}
    if not by_agent:
        declare_number(game, scope)
    return static


def _collect_words(game: Composition, static: Static, problems: Problems) -> dict[str, Span]:
    """Finds every set of words: of fields, rows, events, labels and arguments of actions. Returns where each word is declared first."""
    first: dict[str, Span] = {}

    def add(names: tuple[ast.Name, ...]) -> None:
        if len(names) > limits.MAX_WORDS:
            problems.add(
                errors.Unsupported(
                    names[0].span, feature=f"a set of more than {limits.MAX_WORDS} words"
                )
            )
        spelt = [n.text for n in names]
        for i, name in enumerate(names):
            if name.text in spelt[:i]:
                problems.add(errors.WrittenTwice(name.span, part=f"the word `{name.text}`"))
            first.setdefault(name.text, name.span)
        static.word_sets.append(tuple(dict.fromkeys(spelt)))

    owners: tuple[ast.Kind | ast.Movers, ...] = (*game.kinds.values(), *game.movers.values())
    attributes = [a for owner in owners for a in owner.attributes] + list(
        game.agent_fields.values()
    )
    fields = [a for a in [*attributes, *game.fields.values()] if isinstance(a, ast.Field)]
    arguments = [
        argument
        for action in (() if game.acts is None else game.acts.actions)
        for argument in action.arguments
    ]
    events = [metric for metric in game.metrics.values() if isinstance(metric, ast.Event)]
    sets = [each for field in fields for each in (field.type, field.by)]
    for each in (
        *sets,
        *(e.by for e in events),
        *(number.by for number in game.constants.values()),
        *(a.type for a in arguments),
    ):
        if isinstance(each, ast.Words):
            add(each.names)
    static.word_sets.append(HEADINGS)
    return first


def _check_names(game: Composition, words: Mapping[str, Span], problems: Problems) -> None:
    """One name space: sizes, params, defines, world fields, kinds, groups, words. `words`: where each is declared; headings nowhere."""
    taken: dict[str, tuple[str, Span]] = {}
    cells: Tables = {"a kind": game.kinds, "a group": game.groups, "a sort of movers": game.movers}
    tables: Tables = {
        "a number": game.constants,
        "a define": game.defines,
        "a field of the world": game.fields,
        **cells,
    }
    for what, table in tables.items():
        for name, node in table.items():
            if name in RESERVED_VARIABLES:
                problems.add(
                    errors.NameTaken(
                        node.name.span, name=name, taken_by="something of the language"
                    )
                )
            elif name in SEEN and what in cells:
                problems.add(errors.NameTaken(node.name.span, name=name, taken_by=SEEN[name]))
            elif name in taken:
                other, span = taken[name]
                problems.add(
                    errors.NameTaken(
                        node.name.span,
                        name=name,
                        taken_by=other,
                        labels=(Label(span, "declared here"),),
                    )
                )
            elif name in words or name in HEADINGS:
                labels = (Label(words[name], "the word is declared here"),) if name in words else ()
                problems.add(
                    errors.WordClash(node.name.span, name=name, taken_by=what, labels=labels)
                )
            taken.setdefault(name, (what, node.name.span))


def declare_world(game: Composition, static: Static, problems: Problems) -> None:
    """Adds shapes, kinds, groups, fields and what there is to know of the agents to the tables."""
    _check_counts(game, problems)
    scope = Scope(static, problems)
    for shape in game.shapes.values():
        with problems.survive(static.broken, Symbol("shape", shape.name.text)):
            static.shapes[shape.name.text] = shapes.declared(shape, scope)
    static.mover_sorts = tuple(game.movers)
    static.cell_types = {kind: (kind,) for kind in game.kinds}
    static.cell_types |= {
        name: tuple(kind.text for kind in group.kinds) for name, group in game.groups.items()
    }
    for name, event in static.events.items():
        if event.by is not None:
            with problems.survive():
                static.event_levels[name] = level_of(event.by, scope)
    for kind in game.kinds.values():
        with problems.survive(static.broken, Symbol("name", kind.name.text)):
            static.kinds[kind.name.text] = fields_of(
                kind.attributes, scope, ir.Sort("cell", (kind.name.text,))
            )
            _glyphs(kind, scope)
    for group in game.groups.values():
        with problems.survive(static.broken, Symbol("name", group.name.text)):
            for kind_name in group.kinds:
                if kind_name.text not in static.kinds:
                    raise problems.unknown(kind_name, static.kinds, "the kinds")
                static.refer(kind_name, Symbol("name", kind_name.text))
            static.groups[group.name.text] = tuple(kind_name.text for kind_name in group.kinds)
    for declared in game.fields.values():
        with problems.survive(static.broken, Symbol("name", declared.name.text)):
            static.fields[declared.name.text] = one_field(declared, scope, ir.Sort("world"))
    declare_agents(game, scope)
    declare_movers(game, scope)


def _check_counts(game: Composition, problems: Problems) -> None:
    owners: tuple[ast.Kind | ast.Movers, ...] = (*game.kinds.values(), *game.movers.values())
    fields = [
        a for owner in owners for a in owner.attributes if isinstance(a, ast.Field | ast.Timer)
    ]
    counts = (
        ("kinds", len(game.kinds), limits.MAX_KINDS),
        ("fields", len(fields) + len(game.fields) + len(game.agent_fields), limits.MAX_FIELDS),
        ("phases", len(game.phases), limits.MAX_PHASES),
    )
    for what, given, limit in counts:
        if given > limit:
            problems.add(limits.too_much(f"the game has {given} {what}", limit, game.span))


def _glyphs(kind: ast.Kind, scope: Scope) -> None:
    """Adds the kind's own glyph and its `glyph … with` glyphs to the legend."""
    name = kind.name.text
    scope.static.glyphs.append(
        (kind.glyph.span, ir.GlyphMeaning(glyph=kind.glyph.text, kind=name, origin=kind.span))
    )
    fields = scope.static.kinds[name]
    for attribute in kind.attributes:
        if not isinstance(attribute, ast.Glyph):
            continue
        starts = []
        for field_name, tree in attribute.starts:
            if Symbol("field", field_name.text, name) in scope.static.broken:
                continue
            if field_name.text not in fields:
                meant = near(field_name.text, fields, "its fields")
                scope.problems.add(
                    errors.NoField(
                        field_name.span,
                        owner=f"the kind `{name}`",
                        name=field_name.text,
                        near=meant,
                    )
                )
                continue
            scope.static.refer(field_name, Symbol("field", field_name.text, name))
            with scope.problems.survive():
                value = starting(tree, field_name.text, fields[field_name.text].type, scope)
                starts.append((field_name.text, value))
        meaning = ir.GlyphMeaning(
            glyph=attribute.glyph.text, kind=name, starts=tuple(starts), origin=attribute.span
        )
        scope.static.glyphs.append((attribute.glyph.span, meaning))


def build_kinds(game: Composition, static: Static, problems: Problems) -> tuple[ir.Kind, ...]:
    """Returns the kinds with their fields and what they block; conditions read the cell's fields and `agent`."""
    made = []
    for name, fields in static.kinds.items():
        kind, scope = game.kinds[name], Scope(static, problems, part="blocks")
        found: list[ir.Block] = []
        for blocks in (a for a in kind.attributes if isinstance(a, ast.Blocks)):
            with problems.survive():
                sorts = dict.fromkeys(
                    ir.Sort("mover", (what.text,)) if what.text in static.movers else AGENTS
                    for what in blocks.what
                )
                found += blocked(
                    blocks, {sort: _blocks_when(blocks, name, sort, scope) for sort in sorts}, scope
                )
        made.append(
            ir.Kind(
                name=name,
                glyph=kind.glyph.text,
                fields=tuple(fields.values()),
                blocks=tuple(found),
                origin=kind.span,
            )
        )
    return tuple(made)


def _blocks_when(blocks: ast.Blocks, kind: str, sort: ir.Sort, scope: Scope) -> ir.Expr | None:
    """Returns the condition of `blocks`, about the cell and about who moves: an agent (or the anchor of a shape), or a mover of a sort."""
    if blocks.condition is None:
        return None
    cell, who = (
        ir.Member(name=kind, sort=ir.Sort("cell", (kind,))),
        ir.Member(name=sort.name, sort=sort),
    )
    inner = scope.bind(kind, cell).bind(who.name, who)
    test = inner.condition(blocks.condition)
    check_possible(test, inner)
    return test
