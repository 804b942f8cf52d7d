"""Declarations: numbers, kinds, fields, agents and shapes become the static tables every scope sees."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf

from sjdsl.compiler import ast, ir
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors, guesses, limits
from sjdsl.compiler.diagnostics.diagnostic import near_or_all
from sjdsl.compiler.diagnostics.problems import Poisoned, Problems
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate import shapes
from sjdsl.compiler.elaborate.constants import constant
from sjdsl.compiler.elaborate.expressions import expression
from sjdsl.compiler.elaborate.lookup import AGENT_ATTRIBUTES, CELL_ATTRIBUTES, check_known_word, interval_text
from sjdsl.compiler.elaborate.scope import Scope, Static, wrong_type
from sjdsl.compiler.ir.printer import expression as text
from sjdsl.compiler.ir.types import describe, join_units, words

BUILT_IN_ACTIONS = ("turn_left", "turn_right", "step_left", "step_right", "forward", "backward", "stay")
FIELD_TYPES = ("{ a, b }", "0 .. 9", "agent", "set of agent", "reward")
SEEN = {"outside": "what an agent sees off the map", "everyone": "all agents, in `observe`"}  # no names of kinds
RESERVED_VARIABLES = ("agent", "other", "step", "nobody", "all", "yes", "no", "cell")


@dataclass
class Declarations:
    """The static tables, with what only the finished game needs."""

    static: Static
    glyphs: list[tuple[Span, ir.GlyphMeaning]] = field(default_factory=list)
    agents: ir.Agents | None = None


def declare_numbers(game: Composition, problems: Problems, overrides: Mapping[str, object], num_agents: int | None) -> Static:
    """Returns the static tables with word sets, sizes and parameters; sizes take their values from `overrides`."""
    static = Static(game.sources, expression, defines=dict(game.defines))
    _collect_words(game, static, problems)
    _check_names(game, static, problems)
    static.events = {n: m for n, m in game.metrics.items() if isinstance(m, ast.Event)}
    overrides = dict(overrides)
    if num_agents is not None:
        _override_agents(game, overrides, num_agents, problems)
    scope = Scope(static, problems)
    for declared in game.constants.values():
        with problems.survive(static.broken, declared.name.text):
            constant(declared, scope, overrides.get(declared.name.text))
    return static


def _override_agents(game: Composition, overrides: dict[str, object], num_agents: int, problems: Problems) -> None:
    number = game.number
    if isinstance(number, ast.Path) and not number.steps and number.name.text in game.constants:
        overrides.setdefault(number.name.text, num_agents)
    elif number is not None:
        what = "another number of agents: `agents` does not name a `size` that says how many"
        problems.add(errors.NOT_SUPPORTED, number.span, what=what)


def _collect_words(game: Composition, static: Static, problems: Problems) -> None:
    """Finds every set of words: of fields, rows, events and labels."""

    def add(names: tuple[ast.Name, ...]) -> None:
        if len(names) > limits.MAX_WORDS:
            problems.add(errors.NOT_SUPPORTED, names[0].span, what=f"a set of more than {limits.MAX_WORDS} words")
        spelt = [n.text for n in names]
        for i, name in enumerate(names):
            if name.text in spelt[:i]:
                problems.add(errors.TWICE, name.span, what=f"the word `{name.text}`")
        static.word_sets.append(tuple(dict.fromkeys(spelt)))

    attributes = [a for k in game.kinds.values() for a in k.attributes] + list(game.agent_fields.values())
    for item in [*attributes, *game.fields.values()]:
        if isinstance(item, ast.Field):
            if isinstance(item.type, ast.Words):
                add(item.type.names)
            if item.by is not None:
                add(item.by.names)
    for metric in game.metrics.values():
        if isinstance(metric, ast.Event) and metric.by is not None:
            add(metric.by.names)
    static.word_sets.append(("north", "east", "south", "west"))


def _check_names(game: Composition, static: Static, problems: Problems) -> None:
    """One name space: sizes, params, defines, world fields, kinds, groups, words."""
    taken: dict[str, str] = {}
    tables = (
        ("a number", game.constants),
        ("a define", game.defines),
        ("a field of the world", game.fields),
        ("a kind", game.kinds),
        ("a group", game.groups),
    )
    for what, table in tables:
        for name, node in table.items():
            if name in RESERVED_VARIABLES:
                problems.add(errors.NAME_TAKEN, node.name.span, name=name, what="something of the language")
            elif name in SEEN and what in ("a kind", "a group"):
                problems.add(errors.NAME_TAKEN, node.name.span, name=name, what=SEEN[name])
            elif name in taken:
                problems.add(errors.NAME_TAKEN, node.name.span, name=name, what=taken[name])
            elif static.is_word(name):
                problems.add(errors.WORD_CLASH, node.name.span, name=name, what=what)
            taken.setdefault(name, what)


def declare_world(game: Composition, static: Static, problems: Problems) -> Declarations:
    """Adds shapes, kinds, groups, agents and fields to the tables."""
    _check_counts(game, problems)
    made = Declarations(static)
    scope = Scope(static, problems)
    for shape in game.shapes.values():
        with problems.survive(static.broken, f"shape {shape.name.text}"):
            static.shapes[shape.name.text] = shapes.declared(shape, scope)
    with problems.survive():
        _number_of_agents(game, scope)
    for kind in game.kinds.values():
        with problems.survive(static.broken, kind.name.text):
            fields = fields_of(kind.attributes, scope, "cell", kind.name.text)
            static.kinds[kind.name.text] = ir.Kind(name=kind.name.text, glyph=kind.glyph.text, fields=fields, origin=kind.span)
            _glyphs(kind, made, scope)
    for group in game.groups.values():
        with problems.survive(static.broken, group.name.text):
            static.groups[group.name.text] = tuple(_kind(name, scope) for name in group.kinds)
    for declared in game.fields.values():
        with problems.survive(static.broken, declared.name.text):
            made_field = one_field(declared, scope, "world", "")
            static.fields[made_field.name] = made_field
    with problems.survive():
        made.agents = _agents(game, scope)
    return made


def _check_counts(game: Composition, problems: Problems) -> None:
    fields = [a for k in game.kinds.values() for a in k.attributes if isinstance(a, ast.Field | ast.Timer)]
    counts = (
        ("kinds", len(game.kinds), limits.MAX_KINDS),
        ("fields", len(fields) + len(game.fields) + len(game.agent_fields), limits.MAX_FIELDS),
        ("phases", len(game.phases), limits.MAX_PHASES),
    )
    problems.found += [limits.too_much(f"the game has {given} {what}", limit, game.span) for what, given, limit in counts if given > limit]


def _kind(name: ast.Name, scope: Scope) -> str:
    if name.text not in scope.static.kinds:
        raise scope.problems.unknown(name, scope.static.kinds, "the kinds")
    return name.text


def _number_of_agents(game: Composition, scope: Scope) -> None:
    if game.number is None:
        return
    value = scope.fixed(game.number, "the number of agents")
    if value != int(value) or not 1 <= value <= limits.MAX_AGENTS:
        raise scope.problems.fail(
            errors.OUT_OF_LIMITS,
            game.number.span,
            name="the number of agents",
            value=value,
            low=1,
            high=limits.MAX_AGENTS,
            reason="",
        )
    scope.static.num_agents = int(value)


def _agents(game: Composition, scope: Scope) -> ir.Agents:
    """Returns the agents; their actions and fields are known even where something else about them is missing."""
    static, problems = scope.static, scope.problems
    span = game.agents_span or game.span
    static.actions = _actions(game, problems)
    frame = "relative"
    if game.moves is not None:
        frame = game.moves.frame.text
        if frame not in ("relative", "compass"):
            problems.unknown(game.moves.frame, ("relative", "compass"), "the ways of moving", guesses.MOVES)
    made = []
    for declared in game.agent_fields.values():
        with problems.survive(static.broken, f"agent.{declared.name.text}"):
            made.append(one_field(declared, scope, "agent", ""))
            static.agent_fields[made[-1].name] = made[-1]
    if game.agents_span is None or game.number is None:
        raise problems.fail(errors.MISSING_PART, span, what="number of agents", help="`agents 2 { acts ... moves relative }`")
    if game.acts is None:
        static.broken.add("actions")
        raise problems.fail(errors.MISSING_PART, span, what="actions", help="`acts turn_left, ..., stay` in `agents`")
    return ir.Agents(number=static.num_agents, actions=static.actions, relative=frame == "relative", fields=tuple(made), origin=span)


def _actions(game: Composition, problems: Problems) -> tuple[str, ...]:
    """Returns the names of the actions, as far as the game says."""
    if game.acts is None:
        return ()
    actions = tuple(a.text for a in game.acts.actions)
    for i, action in enumerate(game.acts.actions):
        if action.text in actions[:i]:
            problems.add(errors.TWICE, action.span, what=f"the action `{action.text}`")
    if "stay" not in actions:
        problems.add(errors.MISSING_PART, game.acts.span, what="action `stay`", help="`stay` among the `acts`")
    if len(actions) > limits.MAX_ACTIONS:
        problems.add(errors.NOT_SUPPORTED, game.acts.span, what=f"more than {limits.MAX_ACTIONS} actions")
    return actions


def fields_of(attributes: tuple[object, ...], scope: Scope, place: str, kind: str) -> tuple[ir.VarField, ...]:
    """Returns the fields and timers among the attributes of a kind."""
    made: list[ir.VarField] = []
    for attribute in attributes:
        if isinstance(attribute, ast.Field | ast.Timer):
            if attribute.name.text in {f.name for f in made}:
                scope.problems.add(errors.TWICE, attribute.name.span, what=f"the field `{attribute.name.text}`")
                continue
            with scope.problems.survive(scope.static.broken, f"{kind}.{attribute.name.text}"):
                made.append(one_field(attribute, scope, place, kind))
    return tuple(made)


def one_field(declared: ast.Field | ast.Timer, scope: Scope, place: str, kind: str) -> ir.VarField:
    """Returns one field with its type and starting value."""
    taken = AGENT_ATTRIBUTES if place == "agent" else CELL_ATTRIBUTES if place == "cell" else ()
    if declared.name.text in taken:
        what = "a field of the agents" if place == "agent" else "a field of a kind"
        problem = "every agent has it already" if place == "agent" else "every cell has it already"
        scope.problems.add(errors.BAD_NAME, declared.name.span, name=declared.name.text, what=what, problem=problem)
    common = {"name": declared.name.text, "place": place, "kind": kind, "origin": declared.span}
    if isinstance(declared, ast.Timer):
        type_ = ir.Type(kind="int", unit="steps", low=0, high=inf)
        return ir.VarField(type=type_, timer=True, start=0, **common)
    type_ = field_type(declared.type, declared.name.text, scope)
    start = start_value(declared, type_, scope)
    if declared.by is not None:
        type_ = type_.model_copy(update={"by": (tuple(dict.fromkeys(n.text for n in declared.by.names)),)})
    capped = isinstance(declared.type, ast.Range) and declared.type.capped
    return ir.VarField(type=type_, capped=capped, start=start, **common)


def field_type(declared: ast.Type, field: str, scope: Scope) -> ir.Type:
    match declared:
        case ast.Words():
            return words(tuple(dict.fromkeys(n.text for n in declared.names)))
        case ast.Range():
            return _range_type(declared, scope)
        case ast.NamedType():
            if declared.name.text == "agent":
                return ir.AGENTS if declared.set_of else ir.AGENT
            if declared.name.text == "reward" and not declared.set_of:
                return ir.Type(kind="real", unit="reward")
            instead = {guess: help_.format(name=field) for guess, help_ in guesses.TYPES.items()}
            raise scope.problems.unknown(declared.name, FIELD_TYPES, "the types of fields", instead)


def _range_type(declared: ast.Range, scope: Scope) -> ir.Type:
    low, high = scope.expression(declared.low), scope.expression(declared.high)
    values = [scope.fixed(e, "the range of a field") for e in (declared.low, declared.high)]
    if any(v != int(v) for v in values) or values[0] > values[1] or max(map(abs, values)) > 2**30:
        raise scope.problems.fail(
            errors.WRONG_TYPE,
            declared.span,
            wanted="a range of whole numbers, the smaller first",
            given="another one",
            help="",
        )
    unit = join_units(low.type.unit, high.type.unit)
    return ir.Type(kind="int", unit="count" if unit in (None, "number") else unit, low=values[0], high=values[1])


def start_value(declared: ast.Field, type_: ir.Type, scope: Scope) -> int | float | str | None:
    """Returns the starting value: written, or 0 for rewards, nobody for agents."""
    if declared.start is None:
        if type_.kind in ("agent", "agents"):
            return None
        if type_.unit == "reward":
            return 0.0
        raise scope.problems.fail(
            errors.MISSING_PART,
            declared.span,
            what=f"starting value for `{declared.name.text}`",
            help="`= value` after its type",
        )
    return starting(declared.start, declared.name.text, type_, scope)


def starting(tree: ast.Expr, name: str, type_: ir.Type, scope: Scope) -> int | float | str | None:
    if type_.kind == "word":
        check_known_word(tree, name, type_.words, scope)
    value = scope.expression(tree)
    match value:
        case ir.Nobody() if type_.kind in ("agent", "agents"):
            return None
        case ir.Word() if type_.kind == "word":
            if value.value not in type_.words:
                raise scope.problems.not_a_word(tree.span, value.value, name, type_.words)
            return value.value
        case ir.Number() if type_.kind in ("int", "real"):
            if type_.kind == "int" and (value.value != int(value.value) or not type_.low <= value.value <= type_.high):
                raise scope.problems.fail(
                    errors.FIELD_RANGE,
                    tree.span,
                    name=name,
                    low=f"{type_.low:g}",
                    high=f"{type_.high:g}",
                    reached=interval_text(value.type),
                )
            return int(value.value) if type_.kind == "int" else float(value.value)
        case _:
            raise wrong_type(scope, tree, f"a starting value ({describe(type_)})", value.type)


def _glyphs(kind: ast.Kind, made: Declarations, scope: Scope) -> None:
    """Adds the kind's own glyph and its `glyph … with` glyphs to the legend."""
    name = kind.name.text
    made.glyphs.append((kind.glyph.span, ir.GlyphMeaning(glyph=kind.glyph.text, kind=name, origin=kind.span)))
    fields = {f.name: f for f in made.static.kinds[name].fields}
    for attribute in kind.attributes:
        if not isinstance(attribute, ast.Glyph):
            continue
        starts = []
        for field_name, tree in attribute.starts:
            if f"{name}.{field_name.text}" in scope.static.broken:
                continue
            if field_name.text not in fields:
                choices = near_or_all(field_name.text, fields, "its fields")
                scope.problems.add(errors.NO_FIELD, field_name.span, owner=f"the kind `{name}`", name=field_name.text, **choices)
                continue
            with scope.problems.survive():
                value = starting(tree, field_name.text, fields[field_name.text].type, scope)
                starts.append((field_name.text, value))
        meaning = ir.GlyphMeaning(glyph=attribute.glyph.text, kind=name, starts=tuple(starts), origin=attribute.span)
        made.glyphs.append((attribute.glyph.span, meaning))


def blocks(game: Composition, static: Static, problems: Problems) -> None:
    """Adds to each kind what it blocks; conditions read the cell's fields and `agent`."""
    for kind in game.kinds.values():
        built = static.kinds.get(kind.name.text)
        if built is None:
            continue
        found: list[ir.Block] = []
        for attribute in kind.attributes:
            if not isinstance(attribute, ast.Blocks):
                continue
            with problems.survive():
                found += _one_blocks(attribute, kind.name.text, Scope(static, problems, place="`blocks`"))
        static.kinds[kind.name.text] = built.model_copy(update={"blocks": tuple(found)})


def _one_blocks(attribute: ast.Blocks, kind: str, scope: Scope) -> list[ir.Block]:
    test = None
    if attribute.condition is not None:
        inner = scope.bind(kind, ir.Member(name=kind, who="cell", kinds=(kind,)))
        test = inner.bind("agent", ir.Member(name="agent", who="agent")).condition(attribute.condition)
    found = []
    for what in attribute.what:
        if f"shape {what.text}" in scope.static.broken:
            continue
        if what.text != "agents" and what.text not in scope.static.shapes:
            scope.problems.unknown(what, ["agents", *scope.static.shapes], "what a cell can block")
            continue
        if what.text != "agents" and scope.static.shapes[what.text].see_through:
            problem = f"the shape `{what.text}` sees through everything"
            scope.problems.add(errors.NEVER_HAPPENS, what.span, problem=problem)
        found.append(ir.Block(what=what.text, condition=test, origin=attribute.span))
    return found


def forbids(game: Composition, agents: ir.Agents, static: Static, problems: Problems) -> ir.Agents:
    """Returns the agents with their `forbid` lines, which may read the agent's own fields and the world's."""
    found = []
    scope = Scope(static, problems, place="`forbid`").bind("agent", ir.Member(name="agent", who="agent"))
    for forbid in game.forbids.values():
        with problems.survive():
            test = scope.condition(forbid.condition)
            for node in ir.walk(test):
                where = isinstance(node, ir.Attribute) and node.name in ("row", "col")
                if (
                    where
                    or isinstance(node, ir.Count | ir.Sum | ir.StandsOn | ir.Chose)
                    or (isinstance(node, ir.FieldRead) and node.place == "agent" and not isinstance(node.owner, ir.Member))
                ):
                    raise problems.fail(errors.FORBID_READS, node.origin or forbid.span, what=f"`{text(node)}`")  # type: ignore[arg-type]
            numbers = tuple(_forbidden(a, static, problems) for a in forbid.actions) or tuple(range(len(agents.actions)))
            found.append(ir.Forbid(actions=numbers, condition=test, origin=forbid.span))
    return agents.model_copy(update={"forbids": tuple(found)})


def _forbidden(name: ast.Name, static: Static, problems: Problems) -> int:
    if name.text == "stay":
        what, wanted = "what forbidden actions become", "an action that can be forbidden"
        raise problems.fail(errors.NOT_A, name.span, name=name.text, what=what, wanted=wanted)
    return _action(name, static, problems)


def _action(name: ast.Name, static: Static, problems: Problems) -> int:
    if "actions" in static.broken:
        raise Poisoned
    if name.text not in static.actions:
        raise problems.fail(errors.NO_ACTION, name.span, name=name.text, **near_or_all(name.text, static.actions, "the actions"))
    return static.actions.index(name.text)
