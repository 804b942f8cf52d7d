"""Which names fit a place: fields after a dot, actions after `chose`, kinds after `each`, phases after `->`, words after `is`."""

from collections.abc import Iterable, Iterator, Mapping, Sequence

from lark import Token

from sjdsl.compiler import ast
from sjdsl.compiler.ast.names import Names, Owners, Space, Symbol
from sjdsl.compiler.elaborate.constants import UNITS
from sjdsl.compiler.elaborate.lookup import AGENT_ATTRIBUTES, CELL_ATTRIBUTES, MOVER_ATTRIBUTES, NOWHERE
from sjdsl.compiler.elaborate.shapes import BUILT_IN as FORMS
from sjdsl.compiler.ir.operations import FUNCTIONS
from sjdsl.editor.local_names import BEFORE_DOMAIN
from sjdsl.editor.place import Place, head
from sjdsl.runtime.actions import BUILT_IN, HEADINGS

Locals = Mapping[str, Owners]
Found = tuple[str, str, int]  # the word, its sort, its rank

POLICIES = ("random", "never", "stay")
SIDES = ("ahead", "behind", "left", "right")
HEADS = frozenset((
    "GROUP", "ACTS", "FORBID", "BLOCKS", "SCHEDULE", "MOVES", "WINDOW", "LOOK", "SHOW", "HIDE", "MONOTONE", "SYMMETRIC", "EXPECT", "SLOTS",
    "DROP", "SET", "ADD", "GIVE", "TALLY", "SEND", "REMOVE", "MARK", "PARAM", "SIZE", "FIELD", "PICK", "EACH", "FIRST", "MATCH", "WHEN",
    "CHANCE", "LET", "DRAW", "MOVE", "ALWAYS", "ONCE", "REQUIRE", "CONSERVED", "MEAN", "FINAL", "DEFINE", "EPISODE", "EVENT", "KIND",
    "AGENTS", "PHASE", "GLYPH", "AIM", "SEEK", "SHAPE", "TIMER", "VARIANT", "POLICY", "SCENARIO", "METRICS", "CHECKS", "OBSERVE", "MOVERS",
))  # fmt: skip


def fitting(place: Place, names: Names, around: Locals) -> Iterator[Found]:
    """Yields the names that may stand at a place where the grammar has a name."""
    beginning = head(place.tokens, HEADS)
    first = beginning.type if beginning is not None else ""
    special = _after(place, first, names, around)
    if special is not None:
        yield from special
    elif "INT" in place.following:
        yield from _values(place, names, around, first)


def _after(place: Place, first: str, names: Names, around: Locals) -> list[Found] | None:
    """Returns the names behind a word or sign that asks for one sort of them; None where values stand."""
    last, before = place.last(), place.last(2)
    if last == "DOT":
        return list(_members(place.tokens, names, around))
    if last in ("CHOSE", "CHOOSE") or (first == "FORBID" and last in ("FORBID", "COMMA")):
        return [*_of("action", names, 0), *((name, "local", 2) for name, owners in around.items() if owners is None)]
    if first == "SCHEDULE" and last in ("SCHEDULE", "ARROW"):
        return [(n, s, r) for n, s, r in _of("phase", names, 0) if n != "start"] + [("tick", "phase", 1)]
    if last == "TALLY":
        return [(n, s, 0) for n, s, _ in _of("metric", names, 0) if not isinstance(names.nodes[Symbol("metric", n)], ast.Measure)]
    if _begins_domain(place, first):
        return _who(names)
    if last == "OF":
        return _kinds(names) if place.text(2) == "cell" else _local(around, 0)
    if last == "IN":
        forms: list[Found] = [(form, "form", 2) for form in FORMS]
        return [*_of("shape", names, 0), *forms, *_local(around, 1), *_values(place, names, around, first)]
    if last == "COLON" and first in ("PARAM", "SIZE"):
        return [(unit, "unit", 0) for unit in UNITS]
    if last == "COLON" and first == "FIELD":
        return [("agent", "value", 0), ("cell", "value", 0), ("reward", "unit", 1), *((u, "unit", 3) for u in ("fraction", "probability"))]
    if last == "FACING":
        return [*((h, "value", 0) for h in HEADINGS), ("same", "value", 1), *_local(around, 2)]
    if before == "MONOTONE":
        return [("falling", "value", 0), ("rising", "value", 0)]
    return _declared_after(place, first, names, around)


def _declared_after(place: Place, first: str, names: Names, around: Locals) -> list[Found] | None:
    """Returns the names of one sort that a declaration lists."""
    last = place.last()
    in_slots = last == "POLICY" and head(place.tokens[:-1], frozenset({"SLOTS"})) is not None
    lists: dict[tuple[str, str], list[Found]] = {}
    lists["GROUP", "GROUP"] = lists["GROUP", "EQUAL"] = lists["GROUP", "COMMA"] = _kinds(names)
    lists["ACTS", "ACTS"] = lists["ACTS", "COMMA"] = [(name, "action", 0) for name in BUILT_IN]
    lists["BLOCKS", "BLOCKS"] = lists["BLOCKS", "COMMA"] = [*_of("shape", names, 0), *((m, "sort of movers", 1) for m in names.movers)]
    lists["WINDOW", "WINDOW"] = lists["WINDOW", "COMMA"] = [(side, "value", 0) for side in SIDES]
    lists["EXPECT", "WITH"] = lists["EXPECT", "COMMA"] = [*_of("policy", names, 0), *((name, "policy", 1) for name in POLICIES)]
    lists["MARK", "MARK"] = lists["AIM", "AIM"] = [*_of("shape", names, 0), *((form, "form", 2) for form in FORMS)]
    lists["MOVES", "MOVES"] = [("relative", "value", 0), ("compass", "value", 0)]
    lists["LOOK", "LOOK"] = _who(names)
    lists["MONOTONE", "MONOTONE"] = lists["MONOTONE", "IN"] = [(n, s, 0) for n, s in names.sorts.items() if s == "define"]
    lists["POLICY", "POLICY"] = [*_of("policy", names, 0), ("random", "policy", 1), ("stay", "policy", 1)] if in_slots else []
    lists["DROP", "DROP"] = [*_shared(names, ()), *_of("phase", names), *_of("metric", names), *_of("shape", names), *_of("policy", names),
                             *_of("scenario", names), *_of("checks", names), *_of("variant", names)]  # fmt: skip
    lists["SEND", "SEND"] = lists["REMOVE", "REMOVE"] = _local(around, 0)
    covered = [(word, "value", 2) for word in ("marks", "content")]
    lists["SHOW", "SHOW"] = lists["HIDE", "HIDE"] = [
        ("agent", "value", 0),
        *_kinds(names),
        *_shared(names, ("field of the world",)),
        *covered,
    ]
    if (first, last) == ("SET", "SET"):
        inside = head_of_block(place.tokens) in ("PHASE", "START")
        return [*_local(around, 0), *_shared(names, ("field of the world",))] if inside else list(_shared(names, ("parameter", "size")))
    return lists.get((first, last))


def head_of_block(tokens: Sequence[Token]) -> str:
    """Returns the kind of declaration whose braces a place is in, the outermost that holds statements; empty outside of all."""
    opened: list[str] = []
    last = ""
    for token in tokens:
        if token.type in ("PHASE", "VARIANT", "AGENTS", "KIND", "METRICS", "CHECKS", "OBSERVE", "POLICY", "SCENARIO", "MOVERS"):
            last = token.type
        elif token.type == "LBRACE":
            opened.append(last)
        elif token.type == "RBRACE" and opened:
            opened.pop()
            last = opened[-1] if opened else ""
    return "PHASE" if "PHASE" in opened else opened[-1] if opened else ""


def _begins_domain(place: Place, first: str) -> bool:
    last, before = place.last(), place.last(2)
    opens = {"LPAR": before in ("COUNT", "ANY", "ALL"), "INT": before == "PICK", "NAME": before == "PICK"}
    opens |= {"TO": first == "SEND", "WITH": first == "MATCH", "FROM": before == "AWAY"}
    return opens.get(last, last in BEFORE_DOMAIN)


def _of(space: Space, names: Names, rank: int = 3) -> list[Found]:
    return [(symbol.name, space, rank) for symbol in names.nodes if symbol.space == space]


def _local(around: Locals, rank: int) -> list[Found]:
    return [(name, "local", rank) for name in around]


def _kinds(names: Names) -> list[Found]:
    return [(name, sort, 0) for name, sort in names.sorts.items() if sort in ("kind", "group")]


def _who(names: Names) -> list[Found]:
    return [("agent", "value", 0), *_kinds(names), *((name, "sort of movers", 0) for name in sorted(names.movers))]


def _shared(names: Names, sorts: Sequence[str]) -> list[Found]:
    return [(name, sort, 2) for name, sort in names.sorts.items() if not sorts or sort in sorts]


def _values(place: Place, names: Names, around: Locals, first: str) -> Iterator[Found]:
    """Yields what a value can begin with; words of the field it is compared with first."""
    compared = compared_field(place.tokens, names, around)
    for words in compared:
        yield from ((word, "word", 0) for word in words)
    yield from _local(around, 1)
    yield from _shared(names, ("parameter", "size", "define", "field of the world"))
    if not compared:
        yield from ((word, "word", 4) for word in names.words)
    yield from ((row.name, "function", 4) for row in FUNCTIONS.values() if not (row.word or row.checks))
    yield from ((name, "value", 4) for name in ("step", NOWHERE, *(HEADINGS if place.last() in ("IS", "NOT", "EQUAL") else ())))
    if first in ("REQUIRE", "ALWAYS", "ONCE", "EXPECT", "CONSERVED"):
        yield from _of("metric", names, 3)
    yield from ((row.name, "function", 3) for row in FUNCTIONS.values() if first.lower() in row.checks)


def _members(tokens: Sequence[Token], names: Names, around: Locals) -> Iterator[Found]:
    """Yields what may stand after a dot."""
    _, owners, action = _path(tokens[:-1], names, around)
    if action:
        yield from ((s.name, "argument", 0) for s in names.nodes if s.space == "argument" and s.owner == action)
        return
    for owner in sorted(owners) if owners is not None else sorted(o for o in names.fields if o):
        yield from ((name, "field", 0) for name in names.fields.get(owner, {}))
    attributes: Iterable[str] = AGENT_ATTRIBUTES if owners is None or "agent" in owners else CELL_ATTRIBUTES
    if owners and owners & names.movers:
        attributes = ("heading", *MOVER_ATTRIBUTES)
    yield from ((name, "attribute", 1) for name in attributes)
    if owners is None or "agent" in owners:
        with_arguments = [s.name for s, node in names.nodes.items() if isinstance(node, ast.Action) and node.arguments]
        yield from ((name, "action", 1) for name in with_arguments)


def compared_field(tokens: Sequence[Token], names: Names, around: Locals) -> list[list[str]]:
    """Returns the words of the field before `is`, `is not`, `in {`, `=`, `[` or `case`; nothing where there is none."""
    end = len(tokens)
    while end and tokens[end - 1].type in ("IS", "NOT", "EQUAL", "LSQB", "IN"):
        end -= 1
    if end == len(tokens) or not end:
        return []
    fields, _, _ = _path(tokens[:end], names, around)
    found = []
    for field in fields:
        if isinstance(field, ast.Field):
            of = field.by if tokens[end].type == "LSQB" else field.type
            found += [[name.text for name in of.names]] if isinstance(of, ast.Words) else []
    return found


def _without_index(tokens: Sequence[Token]) -> Sequence[Token]:
    """Returns tokens without the brackets at their end."""
    while tokens and tokens[-1].type == "RSQB":
        depth, at = 0, len(tokens)
        while at:
            at -= 1
            depth += (tokens[at].type == "RSQB") - (tokens[at].type == "LSQB")
            if depth == 0:
                break
        tokens = tokens[:at]
    return tokens


def _path(tokens: Sequence[Token], names: Names, around: Locals) -> tuple[list[ast.Field | ast.Timer], Owners, str]:
    """Returns the fields that the path at the end of tokens can be, what it can be, and the action, if it is one that has arguments."""
    tokens = _without_index(tokens)
    if not tokens or tokens[-1].type != "NAME":
        return [], None, ""
    name = str(tokens[-1])
    if len(tokens) > 1 and tokens[-2].type == "DOT":
        _, owners, _ = _path(tokens[:-2], names, around)
        fields = [names.fields[s.owner][s.name] for s in names.with_field(name, owners)]
        if not fields and isinstance(names.nodes.get(Symbol("action", name)), ast.Action):
            return [], frozenset(), name
        held = [h for h in map(names.type_of, fields) if h]
        return fields, (frozenset().union(*held) if fields else None), ""
    declared = names.fields.get("", {}).get(name)
    if declared is not None:
        return [declared], around[name] if name in around else names.type_of(declared), ""
    # in a declaration: `glyph "t" with fruit = `, `field fruit : { none, ripe } = `
    fields = [fields[name] for owner, fields in names.fields.items() if owner and name in fields]
    return fields, around[name] if name in around else names.owners(name), ""
