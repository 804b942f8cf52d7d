"""Help for a `show` or `hide` that names no field: what agents and cells have that can be shown."""

from collections.abc import Mapping

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics import errors, guesses
from sjdsl.compiler.diagnostics.problems import Poisoned, Problems
from sjdsl.compiler.elaborate.lookup import AGENT_ATTRIBUTES, CELL_ATTRIBUTES, no_field
from sjdsl.compiler.elaborate.scope import Static
from sjdsl.runtime.actions import HEADINGS

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
    candidates = [*static.fields, *OWNERS, *static.kinds]
    return problems.unknown(name, candidates, "the fields of the world, and what has fields,", {name.text: help_})


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


def no_agent_field(owner: str, name: ast.Name, static: Static, problems: Problems) -> Poisoned:
    """Reports `agent.f`, where f is no declared field: what every agent has of itself must be copied to be shown."""
    if name.text not in AGENT_ATTRIBUTES:
        return no_field(name, "an agent", static.agent_fields, guesses.AGENT_FIELDS | guesses.PLACES, problems)
    help_ = "an agent that is away sees nothing, and is not seen" if name.text == "away" else _copy(owner, name.text, static)
    return problems.fail(
        errors.WrongSort(
            name.span,
            name=f"{owner}.{name.text}",
            what="what every agent has of itself",
            wanted="a field that the game declares",
            help=help_,
        )
    )


def _copy(owner: str, attribute: str, static: Static) -> str:
    """Returns how to keep, in a field that can be shown, what agents have of themselves."""
    value = f"agent.{attribute}"
    match attribute:
        case "row" | "col":
            far = (static.map_rows if attribute == "row" else static.map_cols) - 1
            size, type_ = f"`size far : cells = {far}`, ", "0 .. far = 0"
        case "index":
            size, type_ = "", f"0 .. {static.num_agents - 1} = 0"
        case "heading":
            size, type_ = "", f"{{ {', '.join(HEADINGS)} }} = north"
        case _:
            size, type_, value = "", "{ rested, went } = rested", f"case {value} {{ yes: went, no: rested }}"
    field = f"my_{attribute}"
    steps = f"{size}`field {field} : {type_}` in `agents`, `each agent {{ set agent.{field} = {value} }}`, `show {owner}.{field}`"
    return f"copy it in a last phase into a field of your own: {steps}"


def of_group(observable: ast.Show | ast.Hide, name: ast.Name, static: Static, problems: Problems) -> Poisoned:
    """Reports `show GROUP.f`: each kind is shown by itself."""
    verb, group = "show" if isinstance(observable, ast.Show) else "hide", observable.what.name
    kinds = [k for k in static.groups[group.text] if name.text in static.kinds[k]]
    if not kinds:
        return no_field(name, f"the group `{group.text}`", _fields_of(group.text, static), guesses.PLACES, problems)
    paths = [f"{kind}.{name.text}" for kind in kinds]
    more = dict.fromkeys(paths, " as { … }" if isinstance(observable, ast.Show) and observable.labels else "")
    if verb == "show" and not any(more.values()):
        more = {path: labels(path, static.kinds[kinds[0]][name.text].type.kind) for path in paths}
    help_ = "write it for each kind: " + ", ".join(f"`{verb} {path}{more[path]}`" for path in paths)
    return problems.fail(errors.WrongSort(group.span, name=group.text, what="a group of kinds", wanted="one kind", help=help_))


def labels(path: str, kind: str) -> str:
    """Returns labels, as an example, for a field of agents or numbers; nothing for words, which are shown as they are."""
    examples = {"agent": f"mine where {path} is agent, theirs", "agents": f"ours where agent in {path}, theirs"}
    if kind == "word":
        return ""
    return f" as {{ {examples.get(kind, f'some where {path} > 0, none_left')} }}"


def _fields_of(group: str, static: Static) -> list[str]:
    return [field for kind in static.groups[group] for field in static.kinds[kind]]


def no_cell_field(kind: str, name: ast.Name, fields: Mapping[str, ir.VarField], problems: Problems) -> Poisoned:
    """Reports `KIND.f`, where f is no declared field."""
    instead = guesses.PLACES
    if name.text in CELL_ATTRIBUTES:
        instead = {name.text: "where a cell is, an agent sees by its place in the window; fields of cells are shown"}
    return no_field(name, f"the kind `{kind}`", fields, instead, problems)
