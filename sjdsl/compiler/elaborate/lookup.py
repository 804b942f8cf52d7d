"""Looks names up: kinds, words and defines; refuses names that are taken or unknown."""

import re
from collections.abc import Container, Iterable, Iterator, Sequence
from itertools import chain
from math import inf
from typing import Literal, TypeGuard

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol, local_symbol
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.diagnostic import Fix, Near, near
from sjdsl.compiler.diagnostics.problems import Poisoned, Problems
from sjdsl.compiler.diagnostics.slips import slip
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.scope import Scope, Static, wrong_type
from sjdsl.compiler.ir.implications import is_known
from sjdsl.compiler.ir.printer import expression_text as text
from sjdsl.near_names import nearest

AGENT_ATTRIBUTES = ("index", "heading", "moved", "away", "row", "col")
MOVER_ATTRIBUTES = ("index", "moved", "away", "row", "col")
CELL_ATTRIBUTES = ("row", "col")
NOWHERE = "nowhere"  # no cell; where a field has a word `nowhere`, that word


def is_member(e: ir.Expr, what: Literal["agent", "mover", "cell"]) -> TypeGuard[ir.Member]:
    """Returns whether an expression is a variable of a domain of agents, movers or cells."""
    return isinstance(e, ir.Member) and e.entity_type.what == what


def is_agent(e: ir.Expr) -> bool:
    """Returns whether an expression stands for one agent: a variable, or a value of type agent."""
    return is_member(e, "agent") or e.type.kind == "agent"


def check_agent(value: ir.Expr, e: ast.Expr, wanted: str, scope: Scope, help_: str = "") -> None:
    """Reports what isn't one agent, or can be nobody. wanted: what the message asks for."""
    if isinstance(value, ir.Nobody):
        raise scope.expected(e.span, wanted, "nobody")
    if not is_agent(value):
        raise wrong_type(scope, e, wanted, value.type, help_)
    check_somebody(value, e.span, scope)


def named_agent(value: ir.Expr, e: ast.Expr, scope: Scope) -> ir.Member:
    """Returns an agent that a statement has named; reports anything else."""
    if is_member(value, "agent"):
        return value
    raise not_named(value, e, scope)


def not_named(value: ir.Expr, e: ast.Expr, scope: Scope) -> Poisoned:
    """Reports something that isn't an agent that a statement has named."""
    wanted = "an agent that a statement around has named"
    if is_agent(value) and not isinstance(value, ir.Member):
        help_ = f"name it: `each agent as x in {text(value)}`"
        return wrong_type(scope, e, wanted, value.type, help_, "an agent that a field holds")
    return wrong_type(scope, e, wanted, value.type)


def kinds_of_cell(e: ir.Expr) -> tuple[str, ...] | None:
    """Returns the kinds that a cell can be of, an empty tuple for `nowhere`.

    None: it isn't one cell, but something else or a row of cells.
    """
    if is_member(e, "cell"):
        return e.kinds
    return e.type.kinds if e.type.is_single("cell") else None


def or_nowhere(e: ir.Expr) -> ir.Expr:
    """Returns no cell for the word `nowhere` of some field, where a cell is wanted."""
    if isinstance(e, ir.Word) and e.value == NOWHERE:
        return ir.Nowhere(origin=e.origin)
    return e


def check_somewhere(cell: ir.Expr, span: Span, scope: Scope) -> None:
    """Reports a cell that a field holds, unless a guard says that it isn't `nowhere`."""
    if isinstance(cell, ir.Member):
        return
    is_somewhere = ir.Not(value=ir.Same(left=cell, right=ir.Nowhere()))
    if not is_known(is_somewhere, scope.facts):
        raise scope.fail(errors.CanBeNowhere(span, path=text(cell)))


def check_somebody(agent: ir.Expr, span: Span, scope: Scope) -> None:
    """Reports an agent that a field holds, unless a guard says that it isn't `nobody`."""
    if isinstance(agent, ir.Member | ir.ArgumentOf):
        return
    is_somebody = ir.Not(value=ir.Same(left=agent, right=ir.Nobody()))
    if not is_known(is_somebody, scope.facts):
        raise scope.fail(errors.CanBeNobody(span, path=text(agent)))


def check_placed(agent: ir.Expr, span: Span, expression: str, scope: Scope) -> None:
    """Reports an expression about the place or choice of an agent that has none.

    That is so in `phase start`, when the agent comes back, and before the step.
    """
    if scope.part == "start":
        raise scope.fail(errors.NoPlaceYet(span, expression=expression))
    if not isinstance(agent, ir.Member):
        return
    if agent.name == scope.returning:
        raise scope.fail(errors.NoPlaceWhenBack(span, expression=expression, name=agent.name))
    if agent.name in scope.elsewhere:
        raise scope.fail(errors.NoPlaceBefore(span, expression=expression, name=agent.name))


def repeated(names: Iterable[ast.Name]) -> Iterator[ast.Name]:
    """Yields each name that has occurred before."""
    seen: set[str] = set()
    for name in names:
        if name.text in seen:
            yield name
        seen.add(name.text)


def table_words(table: ast.Table, scope: Scope) -> tuple[str, ...]:
    """Returns the words of a table's entries; reports one that is there twice."""
    keys = [entry.key for entry in table.entries]
    for key in repeated(keys):
        raise scope.fail(errors.TableRepeats(key.span, name=key.text))
    for key in keys:
        if scope.static.is_word(key.text):
            scope.static.refer(key, Symbol("word", key.text))
    return tuple(key.text for key in keys)


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


def variable(name: ast.Name, scope: Scope) -> ir.Expr | str:
    """Returns what the name of a variable stands for; a text if that is an action."""
    scope.refer(name)
    bound = scope.variables[name.text]
    if bound is None:
        raise Poisoned
    return bound if isinstance(bound, str) else bound.changed(origin=name.span)


def bound_cell(name: ast.Name, scope: Scope) -> ir.Member | None:
    """Returns the cell that a statement around has bound by this name; None if it is no variable.

    A variable hides a kind of the same name.
    """
    if name.text not in scope.variables:
        return None
    cell = variable(name, scope)
    if isinstance(cell, str) or not is_member(cell, "cell"):
        wanted = "a kind, a group, or a cell of a statement around"
        raise scope.misused(name, "not a cell", wanted)
    return cell


def check_free(name: ast.Name, scope: Scope, chosen: bool) -> None:
    """Reports a variable's name that is in use already.

    chosen: whether the author wrote it after `as`, `let` or `draw`.
    """
    taken_by = ""
    if name.text in scope.variables:
        taken_by = "a variable around this statement"
    elif chosen:
        taken_by = _declared_as(name.text, scope.static)
    if taken_by:
        raise scope.fail(errors.NameTaken(name.span, name=name.text, taken_by=taken_by))


def _declared_as(name: str, static: Static) -> str:
    """Returns what a name stands for in the whole game, empty for a free name."""
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
    return next((meaning for meaning, table in tables.items() if name in table), "")


def check_known_word(
    tree: ast.Expr | ast.Table, owner: ir.Expr | str, words: Iterable[str], scope: Scope
) -> None:
    """Reports a name that means nothing here in the place of a word, with the words there are."""
    static = scope.static
    if not isinstance(tree, ast.Path) or tree.steps:
        return
    name = tree.name.text
    if name in scope.variables or static.is_word(name) or name in static.names():
        return
    if Symbol("name", name) not in static.broken and name not in static.events:
        raise not_a_word(tree.span, name, owner, words, scope.reporting_all())


def read_beside(tree: ast.Expr, scope: Scope) -> None:
    """Reports the mistakes in the other operand of something that could not be read.

    A name alone may be a word of what could not be read. It is a mistake only if it is unknown
    everywhere, and all declarations could be read.
    """
    if not isinstance(tree, ast.Path) or tree.steps:
        with scope.problems.skip_if_broken():
            scope.after_unreadable_guard().expression(tree)
    elif not scope.static.broken:
        tried = Problems()
        with tried.skip_if_broken():
            scope.but(problems=tried).expression(tree)
        for problem in tried.diagnostics:
            if isinstance(problem, errors.UnknownName):
                scope.problems.add(problem)


def not_a_word(
    span: Span, word: str, owner: ir.Expr | str, words: Iterable[str], scope: Scope
) -> Poisoned:
    """Reports a word that is none of those of `owner`.

    owner: a value, or the name of a field or event.
    """
    if isinstance(owner, str):
        name = declared = owner
    else:
        name = text(owner)
        declared = declared_name(owner)
    return scope.fail(
        errors.WordOutside(
            span, word=word, owner=f"`{name}`", declared=declared, words=tuple(words)
        )
    )


def not_among(word: ast.Name, words: tuple[str, ...], construct: str, scope: Scope) -> Poisoned:
    """Reports a key that is none of those of a construct, such as `this table`."""
    return scope.fail(errors.WordOutside(word.span, word=word.text, owner=construct, words=words))


def no_word(name: ast.Name, names: Iterable[str], construct: str, scope: Scope) -> Poisoned:
    """Reports a word that no field, row or event declares.

    names: of all words beside it. construct: what they are the words of.
    """
    meant = near(name.text, list(chain.from_iterable(scope.static.word_sets)))
    help_ = ""
    if not meant.nearest:
        listed = ", ".join(dict.fromkeys(names))
        first, _, _ = listed.partition(",")
        help_ = (
            f"the words of a {construct} are those of a field, a row (`by`) or an event: "
            f"declare one, `field NAME : {{ {listed} }} = {first}`"
        )
    return scope.fail(errors.UnknownName(name.span, name=name.text, near=meant, help=help_))


def check_words(
    words: Iterable[str], known: Sequence[str], span: Span, owner: ir.Expr | str, scope: Scope
) -> None:
    """Reports the first of some words that is none of those of `owner`."""
    for word in words:
        if word not in known:
            raise not_a_word(span, word, owner, known, scope)


def declared_name(e: ir.Expr) -> str:
    """Returns the name of the field or event that declares a value's words or numbers.

    Empty if neither does.
    """
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
        return scope.misused(
            name,
            "a variable of the statements around",
            "the agent that is sent, or something of the world",
            scope.withheld[name.text],
        )
    if static.kinds_of(name.text) or name.text == "agent" or name.text in static.movers:
        return _no_variable(name, scope)
    others = (
        (
            static.events,
            "an event",
            "events are read in `checks`; what a rule reads is kept in a field",
        ),
        (
            static.action_names,
            "an action",
            f"`agent chose {name.text}` asks whether an agent chose it",
        ),
        (
            static.shapes,
            "a shape",
            f"`count(KIND in {name.text} of agent)` counts what is in it",
        ),
    )
    for table, actual, help_ in others:
        if name.text in table:
            return scope.misused(name, actual, "a value", help_)
    return _unknown_anywhere(name, scope)


def _no_variable(name: ast.Name, scope: Scope) -> Poisoned:
    """Reports the name of agents, movers or kinds of cells where one of them is wanted."""
    static = scope.static
    if name.text in static.movers:
        actual = "a sort of movers"
    elif name.text == "agent":
        actual = "the agents"
    elif name.text in static.kinds:
        actual = "a kind of cell"
    else:
        actual = "a group of kinds"
    wanted = f"a variable of a statement around (`each {name.text} …`)"
    help_ = ""
    if scope.defining:
        wanted = "a parameter"
        define = scope.defining[-1]
        body = static.written(static.defines[define].value.span)
        rewritten = re.sub(rf"\b{name.text}\b", "who", body)
        help_ = (
            f"a define sees only its parameters: write `define {define}(who) = {rewritten}`, "
            f"and use it as `{define}({name.text})`"
        )
    elif scope.part in ("metrics", "checks"):
        help_ = f"`count({name.text} where …)` and `sum(… over {name.text})` are about all of them"
    elif name.text != "agent" and "agent" in scope.variables:
        help_ = f"`each agent on {name.text}` binds the cell under each agent as well"
    return scope.misused(name, actual, wanted, help_)


def _unknown_anywhere(name: ast.Name, scope: Scope) -> Poisoned:
    """Reports the name of nothing, with those that the author may have meant."""
    static = scope.static
    meant = nearest(name.text, static.names() | set(scope.variables))
    values = sorted(
        {*scope.variables, *static.sizes, *static.params, *static.fields, *static.defines, "step"}
    )
    listed = ""
    if len(values) > 1:
        listed = near(name.text, values, "the values known here").listed
    help_, word = slip(name.text, values)
    fix = Fix(name.span, word) if word else None
    owners = _owners_of_field(name.text, static)
    if owners and not meant and not help_:
        paths = " or ".join(f"`{owner}.{name.text}`" for owner in owners[:3])
        help_ = f"a field is written with its owner: {paths}"
    return scope.fail(
        errors.UnknownName(name.span, name=name.text, near=Near(meant, listed), help=help_, fix=fix)
    )


def _owners_of_field(name: str, static: Static) -> list[str]:
    """Returns what has a field of this name: `agent`, kinds and movers."""
    owners = []
    if name in static.agent_fields or name in AGENT_ATTRIBUTES:
        owners.append("agent")
    owners += [kind for kind, fields in static.kinds.items() if name in fields]
    for movers in static.movers.values():
        if name in static.fields_of(movers.entity_type):
            owners.append(movers.name)
    return owners


def no_field(
    name: ast.Name, owner: str, fields: Iterable[str], problems: Problems, help_: str = ""
) -> Poisoned:
    """Reports a field that `owner` does not have."""
    known = list(fields)
    hint, word = slip(name.text, known)
    fix = Fix(name.span, word) if word else None
    meant = near(name.text, known, "the fields")
    return problems.fail(
        errors.NoField(
            name.span, owner=owner, name=name.text, help=help_ or hint, fix=fix, near=meant
        )
    )


def interval_text(low: float, high: float) -> str:
    """Returns what numbers a value can reach, for messages."""
    lowest = "any number" if low == -inf else f"{low:g}"
    if low == high:
        return lowest
    highest = "any number" if high == inf else f"{high:g}"
    return f"{lowest} .. {highest}"


def check_arguments(name: str, span: Span, number: int, wanted: int, scope: Scope) -> None:
    """Reports another number of arguments than is wanted."""
    if number != wanted:
        described = {0: "no arguments", 1: "1 argument"}.get(wanted, f"{wanted} arguments")
        raise scope.fail(errors.WrongArguments(span, name=name, wanted=described, actual=number))


def use_define(name: ast.Name, arguments: tuple[ast.Expr, ...], scope: Scope) -> ir.Expr:
    """Writes a `define` out where it is used; it sees its parameters, no variables around."""
    define = scope.static.defines[name.text]
    scope.static.use(name, Symbol("name", name.text))
    if name.text in scope.defining:
        raise scope.fail(errors.DefineCycle(name.span, name=name.text))
    check_arguments(name.text, name.span, len(arguments), len(define.parameters), scope)
    scope.static.expansions += 1
    _check_expansions(name, scope)
    values = scope.expressions(arguments)
    variables: dict[str, ir.Expr | str | None] = {
        parameter.text: value for parameter, value in zip(define.parameters, values, strict=True)
    }
    inner = scope.but(
        variables=variables,
        locals={p.text: local_symbol(p) for p in define.parameters},
        defining=(*scope.defining, name.text),
        withheld={},
        never=None if scope.part == "checks" else scope.static.never_in(f"define {name.text}"),
    )
    value = inner.expression(define.value)
    return ir.Named(type=value.type, name=name.text, value=value, origin=name.span)


def _check_expansions(name: ast.Name, scope: Scope) -> None:
    """Reports, once, defines that are nested too deeply or written out too often."""
    if scope.static.expansions > limits.MAX_EXPANSIONS:
        problem = "too many uses of defines, once those inside them are written out"
        limit = limits.MAX_EXPANSIONS
    elif len(scope.defining) >= limits.MAX_DEFINES_DEEP:
        problem = "too many defines that use one another"
        limit = limits.MAX_DEFINES_DEEP
    else:
        return
    if not any(isinstance(d, errors.TooMuch) for d in scope.problems.diagnostics):
        help_ = "name parts of it with `let` in the phase"
        scope.problems.add(limits.too_much(problem, limit, name.span, help_))
    raise Poisoned
