"""Help for a `show` or `hide` that names no field: what agents and cells have that can be shown."""

from collections.abc import Mapping

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics import errors, guesses
from sjdsl.compiler.diagnostics.problems import Poisoned, Problems
from sjdsl.compiler.elaborate.lookup import AGENT_ATTRIBUTES, CELL_ATTRIBUTES, no_field
from sjdsl.compiler.elaborate.scope import Static

OWNERS = {"agent": "the observer itself", "other": "the other agents", "everyone": "all agents"}


def without_field(observable: ast.Show | ast.Hide, static: Static, problems: Problems) -> Poisoned:
    """Reports `show NAME`, where the name is no field of the world."""
    name, verb = observable.what.name, "show" if isinstance(observable, ast.Show) else "hide"
    if name.text in OWNERS:
        return _not_a_field(name, OWNERS[name.text], _of_agents(name.text, verb, static), problems)
    if name.text in static.groups:
        return _not_a_field(name, "a group of kinds", of_a_kind(static.groups[name.text][0], verb, static), problems)
    owners = ["agent", "other"] * (name.text in static.agent_fields)
    owners += [kind for kind, fields in static.kinds.items() if name.text in fields]
    help_ = f"a field is written with its owner: {' or '.join(f'`{verb} {o}.{name.text}`' for o in owners)}" if owners else ""
    values = ["step", *static.defines] if isinstance(observable, ast.Show) else []
    candidates = [*static.fields, *values, *OWNERS, *static.kinds]
    known = "the fields of the world, the defines, and what has fields," if values else "the fields of the world, and what has fields,"
    return problems.unknown(name, candidates, known, {name.text: help_})


def of_a_kind(kind: str, verb: str, static: Static) -> str:
    """Returns what can be shown or hidden of cells of a kind."""
    fields = {kind: [f.name for f in own.values() if f.type.kind == "word"] for kind, own in static.kinds.items()}
    plain = next((name for name, words in fields.items() if name != kind and not words), "outside")
    one = f"write which field, `{verb} {kind}.{fields[kind][0]}`; " if fields[kind] else ""
    return f"{one}`show {kind} as {{ {plain} }}` makes its cells look like `{plain}`"


def _of_agents(owner: str, verb: str, static: Static) -> str:
    """Returns what can be shown or hidden of agents."""
    if owner == "other" and verb == "hide":
        return "agents are always seen; `hide other.heading` hides which way they face, `hide other.heading when c` while c holds"
    fields = [f"`{verb} {owner}.{field}`" for field in static.agent_fields]
    return (
        f"say which field: {' or '.join(fields[:3])}"
        if fields
        else "agents are always seen; fields of theirs can be shown, if the game declares some"
    )


def _not_a_field(name: ast.Name, what: str, help_: str, problems: Problems) -> Poisoned:
    return problems.fail(errors.WrongSort(name.span, name=name.text, what=what, wanted="a field", help=help_))


def no_agent_field(name: ast.Name, static: Static, problems: Problems) -> Poisoned:
    """Reports `agent.f`, where f is no declared field."""
    return no_field(name, "an agent", [*static.agent_fields, *AGENT_ATTRIBUTES], guesses.AGENT_FIELDS | guesses.PLACES, problems)


def attribute_unseen(owner: str, name: ast.Name, problems: Problems) -> Poisoned:
    """Reports `agent.away` and `other.away`: an agent that is away sees nothing, and is not seen."""
    help_ = "an agent that is away sees nothing, and is not seen; `show everyone.away` tells all who is away"
    what, wanted = "the same whenever it is seen", "something that can change"
    return problems.fail(errors.WrongSort(name.span, name=f"{owner}.{name.text}", what=what, wanted=wanted, help=help_))


def labels(path: str, kind: str) -> str:
    """Returns labels, as an example, for a field of agents or numbers; nothing for words, which are shown as they are."""
    examples = {"agent": f"mine where {path} is agent, theirs", "agents": f"ours where agent in {path}, theirs"}
    examples |= {"cell": f"somewhere where {path} is not nowhere, unset"}
    if kind == "word":
        return ""
    return f" as {{ {examples.get(kind, f'some where {path} > 0, none_left')} }}"


def no_cell_field(kind: str, name: ast.Name, fields: Mapping[str, ir.VarField], problems: Problems) -> Poisoned:
    """Reports `KIND.f`, where f is no declared field."""
    instead = guesses.PLACES
    if name.text in CELL_ATTRIBUTES:
        instead = {name.text: "where a cell is, an agent sees by its place in the window; fields of cells are shown"}
    return no_field(name, f"the kind `{kind}`", fields, instead, problems)
