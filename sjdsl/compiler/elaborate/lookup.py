"""Name lookup: kinds, words and defines by name, the names a variable may have, and errors for unknown names."""

import re
from collections.abc import Container, Iterable, Sequence
from math import inf

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol, local_symbol
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.diagnostic import Fix, Near, near
from sjdsl.compiler.diagnostics.problems import Poisoned, Problems
from sjdsl.compiler.diagnostics.slips import slip
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.ir.implications import is_known
from sjdsl.compiler.ir.printer import expression as text
from sjdsl.near_names import nearest

AGENT_ATTRIBUTES = ("index", "heading", "moved", "away", "row", "col")
MOVER_ATTRIBUTES = ("index", "moved", "away", "row", "col")
CELL_ATTRIBUTES = ("row", "col")
NOWHERE = "nowhere"  # the value of a field that holds no cell; a word where a field has such a word


def as_agent(e: ir.Expr) -> bool:
    """Returns whether an expression stands for one agent: a variable, or a value of type agent."""
    return (isinstance(e, ir.Member) and e.sort.what == "agent") or e.type.kind == "agent"


def not_named(given: ir.Expr, e: ast.Expr, scope: Scope) -> Poisoned:
    """Reports something that isn't an agent with a name of its own; if a field holds it, with how to name it."""
    held = as_agent(given) and not isinstance(given, ir.Member)
    help_, described = (
        (f"name it: `each agent as x in {text(given)}`", "an agent that a field holds")
        if held
        else ("", "")
    )
    return wrong_type(
        scope, e, "an agent that a statement around has named", given.type, help_, described
    )


def kinds_of_cell(e: ir.Expr) -> tuple[str, ...] | None:
    """Returns the kinds that a cell can be of, be it a variable or a value; none for `nowhere`. None: it isn't a cell."""
    if isinstance(e, ir.Member) and e.sort.what == "cell":
        return e.kinds
    return e.type.kinds if e.type.kind == "cell" and not e.type.by else None


def or_nowhere(e: ir.Expr) -> ir.Expr:
    """Returns no cell for the word `nowhere` of some field, where a cell is wanted."""
    return ir.Nowhere(origin=e.origin) if isinstance(e, ir.Word) and e.value == NOWHERE else e


def check_somewhere(cell: ir.Expr, span: Span, scope: Scope) -> None:
    """Reports a cell that a field holds, if it can be nowhere, as far as the guards around tell."""
    if not isinstance(cell, ir.Member) and not is_known(
        ir.Not(value=ir.Same(left=cell, right=ir.Nowhere())), scope.facts
    ):
        raise scope.fail(errors.CanBeNowhere(span, path=text(cell)))


def check_somebody(agent: ir.Expr, span: Span, scope: Scope) -> None:
    """Reports an agent that a field holds, if it can be nobody, as far as the guards around tell."""
    if not isinstance(agent, ir.Member | ir.ArgumentOf) and not is_known(
        ir.Not(value=ir.Same(left=agent, right=ir.Nobody())), scope.facts
    ):
        raise scope.fail(errors.CanBeNobody(span, path=text(agent)))


def check_placed(agent: ir.Expr, span: Span, what: str, scope: Scope) -> None:
    """Reports `what`, if it asks for the place or choice of an agent that has none: in `phase start`, on its return, before the step."""
    if scope.part == "start":
        raise scope.fail(errors.NoPlaceYet(span, expression=what))
    if isinstance(agent, ir.Member) and agent.name == scope.returning:
        raise scope.fail(errors.NoPlaceWhenBack(span, expression=what, name=agent.name))
    if isinstance(agent, ir.Member) and agent.name in scope.elsewhere:
        raise scope.fail(errors.NoPlaceBefore(span, expression=what, name=agent.name))


def table_words(table: ast.Table, scope: Scope) -> tuple[str, ...]:
    """Returns the words of a table's entries; reports one that stands there twice."""
    names = tuple(entry.key.text for entry in table.entries)
    for i, entry in enumerate(table.entries):
        if entry.key.text in names[:i]:
            raise scope.fail(errors.TableRepeats(entry.key.span, name=entry.key.text))
        if scope.static.is_word(entry.key.text):
            scope.static.refer(entry.key, Symbol("word", entry.key.text))
    return names


def kinds_named(name: ast.Name, scope: Scope) -> tuple[str, ...]:
    """Returns the kinds a kind or group name stands for."""
    kinds = scope.static.kinds_of(name.text)
    if kinds is not None:
        scope.static.refer(name, Symbol("name", name.text))
        return kinds
    if Symbol("name", name.text) in scope.static.broken:
        raise Poisoned
    known = ["agent", *scope.static.movers, *scope.static.kinds, *scope.static.groups]
    raise scope.problems.unknown(name, known, "the agents and kinds of this game")


def bound_cell(name: ast.Name, scope: Scope) -> ir.Member | None:
    """Returns the cell that a statement around has bound by this name, which comes before a kind; None if it is no variable."""
    if name.text not in scope.variables:
        return None
    scope.refer(name)
    bound = scope.variables[name.text]
    if bound is None:
        raise Poisoned
    if not (isinstance(bound, ir.Member) and bound.sort.what == "cell"):
        wanted = "a kind, a group, or a cell of a statement around"
        raise scope.fail(
            errors.WrongSort(name.span, name=name.text, actual="not a cell", wanted=wanted)
        )
    return bound.model_copy(update={"origin": name.span})


def check_free(name: ast.Name, scope: Scope, chosen: bool) -> None:
    """Reports a variable's name that is in use already (`chosen`: written after `as`, `let` or `draw`)."""
    static, what = scope.static, ""
    if name.text in scope.variables:
        what = "a variable around this statement"
    elif chosen:
        tables: dict[str, Container[str]] = {
            "a size": static.sizes,
            "a parameter": static.params,
            "a define": static.defines,
            "a field of the world": static.fields,
            "a kind": static.kinds,
            "a group": static.groups,
            "a sort of movers": static.movers,
            "a word": {word for words in static.word_sets for word in words},
            "the agents' own name": ("agent",),
            "a number of the language": ("step",),
        }
        what = next((w for w, table in tables.items() if name.text in table), "")
    if what:
        raise scope.fail(errors.NameTaken(name.span, name=name.text, taken_by=what))


def check_known_word(
    tree: ast.Expr | ast.Table, owner: ir.Expr | str, words: Iterable[str], scope: Scope
) -> None:
    """Reports a name that means nothing here in the place of a word, with the words there are."""
    static = scope.static
    if (
        not isinstance(tree, ast.Path)
        or tree.steps
        or tree.name.text in scope.variables
        or static.is_word(tree.name.text)
    ):
        return
    name = tree.name.text
    if (
        name not in static.names()
        and Symbol("name", name) not in static.broken
        and name not in static.events
    ):
        raise not_a_word(tree.span, name, owner, words, scope.sure())


def read_beside(tree: ast.Expr, scope: Scope) -> None:
    """Reports the mistakes of what is compared with, or put into, something that could not be read.

    A name alone may be a word of that. It is a mistake if it is nothing in the whole game, and all of that could be read.
    """
    if not isinstance(tree, ast.Path) or tree.steps:
        with scope.problems.survive():
            scope.unsure().expression(tree)
    elif not scope.static.broken:
        tried = Problems()
        with tried.survive():
            scope.but(problems=tried).expression(tree)
        for problem in tried.found:
            if isinstance(problem, errors.UnknownName):
                scope.problems.add(problem)


def not_a_word(
    span: Span, word: str, owner: ir.Expr | str, words: Iterable[str], scope: Scope
) -> Poisoned:
    """Reports a word that is none of those of `owner`: of a value, or of a field or event given by its name."""
    name, declared = (
        (owner, owner) if isinstance(owner, str) else (text(owner), declared_name(owner))
    )
    return scope.fail(
        errors.WordOutside(
            span, word=word, owner=f"`{name}`", declared=declared, words=tuple(words)
        )
    )


def check_words(
    words: Iterable[str], known: Sequence[str], span: Span, owner: ir.Expr | str, scope: Scope
) -> None:
    """Reports the first of some words that is none of those of `owner`."""
    for word in words:
        if word not in known:
            raise not_a_word(span, word, owner, known, scope)


def declared_name(e: ir.Expr) -> str:
    """Returns the name of the field or event whose words or numbers a value has, empty if neither declares them."""
    match e:
        case ir.FieldRead() | ir.EventTotal():
            return e.name
        case ir.At():
            return declared_name(e.row)
        case _:
            return ""


def unknown(name: ast.Name, scope: Scope) -> Poisoned:
    """Reports a name that isn't a value: the name of something else, or of nothing."""
    static = scope.static
    if Symbol("name", name.text) in static.broken:
        return Poisoned()
    if name.text in scope.withheld:
        what, wanted = (
            "a variable of the statements around",
            "the agent that is sent, or something of the world",
        )
        return scope.fail(
            errors.WrongSort(
                name.span,
                name=name.text,
                actual=what,
                wanted=wanted,
                help=scope.withheld[name.text],
            )
        )
    if static.kinds_of(name.text) or name.text == "agent" or name.text in static.movers:
        what = (
            "the agents"
            if name.text == "agent"
            else "a kind of cell"
            if name.text in static.kinds
            else "a group of kinds"
        )
        what = "a sort of movers" if name.text in static.movers else what
        wanted, help_ = f"a variable of a statement around (`each {name.text} …`)", ""
        if scope.defining:
            wanted = "a parameter"
            define, value = scope.defining[-1], static.defines[scope.defining[-1]].value.span
            body = re.sub(
                rf"\b{name.text}\b", "who", static.sources[value.file].text[value.start : value.end]
            )
            rewritten = f"`define {define}(who) = {' '.join(body.split())}`"
            help_ = f"a define sees its parameters alone: write {rewritten}, and use it as `{define}({name.text})`"
        elif scope.part in ("metrics", "checks"):
            help_ = f"of all there are `count({name.text} where …)` and `sum(… over {name.text})`"
        elif name.text != "agent" and "agent" in scope.variables:
            help_ = f"`each agent on {name.text}` binds the cell under each agent as well"
        return scope.fail(
            errors.WrongSort(name.span, name=name.text, actual=what, wanted=wanted, help=help_)
        )
    for what, table, help_ in (
        (
            "an event",
            static.events,
            "events are read in `checks`; what a rule reads is kept in a field",
        ),
        (
            "an action",
            static.action_names,
            f"`agent chose {name.text}` asks whether an agent chose it",
        ),
        ("a shape", static.shapes, f"`count(KIND in {name.text} of agent)` counts what is in it"),
    ):
        if name.text in table:
            return scope.fail(
                errors.WrongSort(
                    name.span, name=name.text, actual=what, wanted="a value", help=help_
                )
            )
    meant = nearest(name.text, static.names() | set(scope.variables))
    values = sorted(
        {*scope.variables, *static.sizes, *static.params, *static.fields, *static.defines, "step"}
    )
    listed = near(name.text, values if len(values) > 1 else (), "the values known here").listed
    help_, word = slip(name.text, values)
    fix = Fix(name.span, word) if word else None
    owners = ["agent"] * (name.text in static.agent_fields or name.text in AGENT_ATTRIBUTES)
    owners += [kind for kind, fields in static.kinds.items() if name.text in fields]
    owners += [sort for sort in static.movers if name.text in static.mover_fields(sort)]
    if owners and not meant:
        help_ = (
            help_
            or f"a field is written with its owner: {' or '.join(f'`{owner}.{name.text}`' for owner in owners[:3])}"
        )
    return scope.fail(
        errors.UnknownName(name.span, name=name.text, near=Near(meant, listed), help=help_, fix=fix)
    )


def no_field(
    name: ast.Name, owner: str, fields: Iterable[str], problems: Problems, help_: str = ""
) -> Poisoned:
    """Reports a field that `owner` does not have."""
    known = list(fields)
    hint, word = slip(name.text, known)
    fix, meant = Fix(name.span, word) if word else None, near(name.text, known, "the fields")
    return problems.fail(
        errors.NoField(
            name.span, owner=owner, name=name.text, help=help_ or hint, fix=fix, near=meant
        )
    )


def interval_text(low: float, high: float) -> str:
    """Returns what numbers a value can reach, for messages."""
    lowest = "any number" if low == -inf else f"{low:g}"
    return lowest if low == high else f"{lowest} .. {'any number' if high == inf else f'{high:g}'}"


def check_arguments(name: str, span: Span, given: int, wanted: int, scope: Scope) -> None:
    """Reports arguments that are not as many as wanted."""
    if given != wanted:
        raise scope.fail(
            errors.WrongArguments(
                span, name=name, wanted=f"{wanted} argument{'s' * (wanted != 1)}", actual=given
            )
        )


def use_define(name: ast.Name, arguments: tuple[ast.Expr, ...], scope: Scope) -> ir.Expr:
    """Writes a `define` out where it is used: its own names and its arguments, none of the variables around."""
    define = scope.static.defines[name.text]
    scope.static.use(name, Symbol("name", name.text))
    if name.text in scope.defining:
        raise scope.fail(errors.DefineCycle(name.span, name=name.text))
    check_arguments(name.text, name.span, len(arguments), len(define.parameters), scope)
    scope.static.expansions += 1
    too_many = scope.static.expansions > limits.MAX_EXPANSIONS
    if too_many or len(scope.defining) >= limits.MAX_DEFINES_DEEP:
        what, limit = "defines that use one another", limits.MAX_DEFINES_DEEP
        if too_many:
            what, limit = (
                "uses of defines, once those inside them are written out",
                limits.MAX_EXPANSIONS,
            )
        if not any(isinstance(d, errors.TooMuch) for d in scope.problems.found):
            scope.problems.add(
                limits.too_much(
                    f"too many {what}", limit, name.span, "name parts of it with `let` in the phase"
                )
            )
        raise Poisoned
    variables: dict[str, ir.Expr | str | None] = dict(
        zip((p.text for p in define.parameters), scope.expressions(arguments), strict=True)
    )
    named = {p.text: local_symbol(p) for p in define.parameters}
    never = None if scope.part == "checks" else scope.static.never_in(f"define {name.text}")
    inner = scope.but(
        variables=variables,
        locals=named,
        defining=(*scope.defining, name.text),
        withheld={},
        never=never,
    )
    value = inner.expression(define.value)
    return ir.Named(type=value.type, name=name.text, value=value, origin=name.span)
