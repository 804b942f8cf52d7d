"""Name lookup: kinds, actions and words by name, the names a variable may have, and errors for unknown names."""

import re
from collections.abc import Container, Iterable, Mapping
from math import inf

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.diagnostics import errors, guesses
from sjdsl.compiler.diagnostics.diagnostic import Near, near
from sjdsl.compiler.diagnostics.problems import Poisoned, Problems, named_first
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.scope import Scope, Static, wrong_type
from sjdsl.compiler.ir.implications import is_known
from sjdsl.compiler.ir.printer import expression as text

AGENT_ATTRIBUTES = ("index", "heading", "moved", "away", "row", "col")
MOVER_ATTRIBUTES = ("index", "moved", "away", "row", "col")
CELL_ATTRIBUTES = ("row", "col")
NOWHERE = "nowhere"  # the value of a field that holds no cell; a word where a field has such a word


def as_agent(e: ir.Expr) -> bool:
    """Returns whether an expression stands for one agent: a variable, or a value of type agent."""
    return (isinstance(e, ir.Member) and e.sort.what == "agent") or e.type.kind == "agent"


def not_named(given: ir.Expr, e: ast.Expr, scope: Scope) -> Poisoned:
    """Returns the failure that something is no agent with a name of its own; of one that a field holds, how to name it."""
    held = as_agent(given) and not isinstance(given, ir.Member)
    help_, told = (f"name it: `each agent as x in {text(given)}`", "an agent that a field holds") if held else ("", "")
    return wrong_type(scope, e, "an agent that a statement around has named", given.type, help_, told)


def kinds_of_cell(e: ir.Expr) -> tuple[str, ...] | None:
    """Returns the kinds that a cell can be of: of a variable, or of a value of type cell; none of `nowhere`. None: it is no cell."""
    if isinstance(e, ir.Member) and e.sort.what == "cell":
        return e.kinds
    return e.type.kinds if e.type.kind == "cell" and not e.type.by else None


def or_nowhere(e: ir.Expr) -> ir.Expr:
    """Returns no cell for the word `nowhere` of some field, where a cell is wanted."""
    return ir.Nowhere(origin=e.origin) if isinstance(e, ir.Word) and e.value == NOWHERE else e


def check_somewhere(cell: ir.Expr, span: Span, scope: Scope) -> None:
    """Says so if a cell that a field holds can be nowhere, as far as the guards around tell."""
    if not isinstance(cell, ir.Member) and not is_known(ir.Not(value=ir.Same(left=cell, right=ir.Nowhere())), scope.facts):
        raise scope.problems.fail(errors.CanBeNowhere(span, path=text(cell)))


def check_somebody(agent: ir.Expr, span: Span, scope: Scope) -> None:
    """Says so if an agent that a field holds can be nobody, as far as the guards around tell."""
    if not isinstance(agent, ir.Member | ir.ArgumentOf) and not is_known(ir.Not(value=ir.Same(left=agent, right=ir.Nobody())), scope.facts):
        raise scope.problems.fail(errors.CanBeNobody(span, path=text(agent)))


def check_placed(agent: ir.Expr, span: Span, what: str, scope: Scope) -> None:
    """Says so if `what` asks for the place or the choice of an agent that has none: in `phase start`, when it comes back, or before the step."""
    if scope.part == "start":
        raise scope.problems.fail(errors.NoPlaceYet(span, what=what))
    if isinstance(agent, ir.Member) and agent.name == scope.returning:
        raise scope.problems.fail(errors.NoPlaceWhenBack(span, what=what, name=agent.name))
    if isinstance(agent, ir.Member) and agent.name in scope.elsewhere:
        raise scope.problems.fail(errors.NoPlaceBefore(span, what=what, name=agent.name))


def table_words(table: ast.Table, scope: Scope) -> tuple[str, ...]:
    """Returns the words of a table's entries; says so if one stands there twice."""
    names = tuple(entry.key.text for entry in table.entries)
    for i, entry in enumerate(table.entries):
        if entry.key.text in names[:i]:
            raise scope.problems.fail(errors.TableRepeats(entry.key.span, name=entry.key.text))
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


def check_free(name: ast.Name, scope: Scope, chosen: bool) -> None:
    """Says so if a variable's name is in use already (`chosen`: written after `as`, `let` or `draw`)."""
    static = scope.static
    what = ""
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
        }
        what = next((w for w, table in tables.items() if name.text in table), "")
        what = what or ("a word" if static.is_word(name.text) else "")
        what = what or ("the agents' own name" if name.text == "agent" else "a number of the language" if name.text == "step" else "")
    if what:
        raise scope.problems.fail(errors.NameTaken(name.span, name=name.text, what=what))


def check_known_word(tree: ast.Expr | ast.Table, owner: ir.Expr | str, words: Iterable[str], scope: Scope) -> None:
    """Says which words there are, if a tree that should be one of them is a name that means nothing here."""
    static = scope.static
    if not isinstance(tree, ast.Path) or tree.steps or tree.name.text in scope.variables or static.is_word(tree.name.text):
        return
    name = tree.name.text
    if name not in static.names() and Symbol("name", name) not in static.broken and name not in static.events:
        raise not_a_word(tree.span, name, owner, words, scope)


def not_a_word(span: Span, word: str, owner: ir.Expr | str, words: Iterable[str], scope: Scope) -> Poisoned:
    """Reports a word that is none of those of `owner`: of a value, or of a field or event given by its name."""
    name, declared = (owner, owner) if isinstance(owner, str) else (text(owner), declared_name(owner))
    return scope.problems.fail(errors.WordOutside(span, word=word, owner=f"`{name}`", declared=declared, words=tuple(words)))


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
    """Reports a name that is no value: something else, or nothing at all."""
    static = scope.static
    if Symbol("name", name.text) in static.broken:
        return Poisoned()
    if name.text in scope.withheld:
        what, wanted = "a variable of the statements around", "the agent that is sent, or something of the world,"
        return scope.problems.fail(errors.WrongSort(name.span, name=name.text, what=what, wanted=wanted, help=scope.withheld[name.text]))
    if static.kinds_of(name.text) or name.text == "agent" or name.text in static.movers:
        what = "the agents" if name.text == "agent" else "a kind of cell" if name.text in static.kinds else "a group of kinds"
        what = "a sort of movers" if name.text in static.movers else what
        wanted, help_ = f"a variable of a statement around (`each {name.text} …`)", ""
        if scope.defining:
            wanted = "a parameter"
            help_ = _with_parameter(scope.defining[-1], name.text, static)
        elif scope.part in ("metrics", "checks"):
            help_ = f"of all there are `count({name.text} where …)` and `sum(… over {name.text})`"
        elif name.text != "agent" and "agent" in scope.variables:
            help_ = f"`each agent on {name.text}` binds the cell under each agent as well"
        return scope.problems.fail(errors.WrongSort(name.span, name=name.text, what=what, wanted=wanted, help=help_))
    for what, table, help_ in (
        ("an event", static.events, "events are read in `checks`; what a rule reads is kept in a field"),
        ("an action", static.action_names, f"`agent chose {name.text}` asks whether an agent chose it"),
        ("a shape", static.shapes, f"`count(KIND in {name.text} of agent)` counts what is in it"),
    ):
        if name.text in table:
            return scope.problems.fail(errors.WrongSort(name.span, name=name.text, what=what, wanted="a value", help=help_))
    meant = scope.near(name.text)
    values = sorted({*scope.variables, *static.sizes, *static.params, *static.fields, *static.defines, "step"})
    listed = near(name.text, values if len(values) > 1 else (), "the values known here").listed
    help_ = _owned(name.text, meant, static)
    return scope.problems.fail(errors.UnknownName(name.span, name=name.text, near=Near(meant, listed), help=help_))


def _with_parameter(define: str, variable: str, static: Static) -> str:
    """Returns how a define is written that speaks of a variable around its use."""
    value = static.defines[define].value.span
    written = re.sub(rf"\b{variable}\b", "who", static.sources[value.file].text[value.start : value.end])
    return f"a define sees its parameters alone: write `define {define}(who) = {' '.join(written.split())}`, and use it as `{define}({variable})`"


def _owned(name: str, near: str, static: Static) -> str:
    """Returns what to write for a name that something else has: a field without its owner, a condition compared with `true`."""
    if name in guesses.CONDITIONS:
        return "a condition is used as it is: `when c`, `when not c`"
    if name in guesses.VALUES:
        return guesses.VALUES[name]
    owners = ["agent"] * (name in static.agent_fields or name in AGENT_ATTRIBUTES)
    owners += [kind for kind, fields in static.kinds.items() if name in fields]
    owners += [sort for sort in static.movers if name in static.mover_fields(sort)]
    paths = " or ".join(f"`{owner}.{name}`" for owner in owners[:3])
    return f"a field is written with its owner: {paths}" if owners and not near else ""


def no_field(name: ast.Name, owner: str, fields: Iterable[str], instead: Mapping[str, str], problems: Problems) -> Poisoned:
    """Reports a field that `owner` does not have; `instead`: what to write for names that are often tried."""
    known = list(fields)
    help_, meant = instead.get(name.text, ""), near(name.text, known, "the fields")
    fix = named_first(help_, name.span, known)
    return problems.fail(errors.NoField(name.span, owner=owner, name=name.text, help=help_, fix=fix, near=meant))


def interval_text(type_: ir.Type) -> str:
    """Returns what numbers a value can reach, for messages."""
    low = "any number" if type_.low == -inf else f"{type_.low:g}"
    return low if type_.low == type_.high else f"{low} .. {'any number' if type_.high == inf else f'{type_.high:g}'}"
