"""Random `set` and `add`: mostly writes that surely agree, sometimes others, for the compiler to judge."""

from dataclasses import dataclass, field, replace
from math import inf

from sjdsl.compiler import ir
from sjdsl.runtime.actions import HEADINGS
from tests.fuzz.conditions import agent_value, somebody, word
from tests.fuzz.declared import Field, Lines
from tests.fuzz.quantities import integer, key_for, real
from tests.fuzz.reading import Scope, Typed, Variable
from tests.fuzz.typed_numbers import fitted

HEADING = Field(
    "heading", ir.Type(kind="word", words=HEADINGS), ""
)  # of movers: a field as others are
BOLD = 0.06  # how often a write is made that may well be refused


@dataclass
class Written:
    """What the statements of one phase have written so far: (place, kind, field) -> sorts of writes; where agents were sent."""

    fields: dict[tuple[str, str, str], list[str]] = field(default_factory=dict)
    places: int = 0
    pools: dict[str, tuple[str, ...]] = field(default_factory=dict)

    def allows(self, keys: list[tuple[str, str, str]], sort: str) -> bool:
        """Returns whether a write of this sort (set, add, bound, lot, lot of an entry) agrees with those before."""
        before = [s for k in keys for s in self.fields.get(k, ())]
        return not before or (sort in ("add", "lot", "lot of an entry") and set(before) == {sort})

    def note(self, keys: list[tuple[str, str, str]], sort: str) -> None:
        for key in keys:
            self.fields.setdefault(key, []).append(sort)


def is_own(v: Variable, scope: Scope) -> bool:
    """Returns whether each instance has this variable for itself."""
    if v.frame < 0:
        return False
    many = [i for i, f in enumerate(scope.frames) if not f.single]
    if not many:
        return not scope.frames[v.frame].placed or scope.frames[v.frame].single
    return many == [v.frame] and not scope.frames[v.frame].placed


def write(scope: Scope, written: Written, depth: int) -> Lines:
    """Returns a `set` or `add`, with a guard around it where the range needs one; nothing if there is nothing to write."""
    w = scope.world
    options: list[tuple[Variable | None, Field, str]] = [(None, f, f.name) for f in w.fields]
    for v in scope.variables:
        fields = w.cell_fields(v.kinds) if v.kinds else w.fields_of(v.sort)
        may_turn = not v.kinds and scope.sort != "start" and not written.places
        turns = bool(v.sort) or (may_turn and w.is_now(0.3))
        fields = [*fields, HEADING] if turns else fields
        options += [(v, f, f"{v.name}.{f.name}") for f in fields]
    held = [Variable(text) for text in scope.sure] if w.is_now(0.3) else []
    options += [(v, f, f"{v.name}.{f.name}") for v in held for f in w.agent_fields]
    w.random.shuffle(options)
    for owner, f, text in options[:6]:
        made = _write_one(scope, written, owner, f, text, depth)
        if made:
            return made
    return []


def _write_one(
    scope: Scope, written: Written, owner: Variable | None, f: Field, text: str, depth: int
) -> Lines:
    w = scope.world
    keys = _keys(owner, f)
    entry = _own_entry(scope, owner, f) if w.is_now(0.8) else ""
    own = bool(entry) or (
        all(x.single for x in scope.frames) if owner is None else is_own(owner, scope)
    )
    text += f"[{entry}]" if entry else ""
    f = replace(f, type=f.type.model_copy(update={"indexed_by": ()})) if entry else f
    bold = w.is_now(BOLD)
    sums = f.type.kind in ("int", "real", "agents") and not f.timer
    if sums and w.is_now(0.55 if own else 0.8):
        return _add(scope, written, keys, own, bold, f, text, depth)
    lot = "lot of an entry" if entry else "lot"
    is_agent_heading = f is HEADING and owner is not None and owner.is_agent
    if (
        scope.sort == "phase"
        and not is_agent_heading
        and (bold or written.allows(keys, lot))
        and w.is_now(0.5 if keys and written.fields.get(keys[0]) else 0.15)
    ):
        by_lot = value(scope, f, depth)
        if by_lot is not None:
            written.note(keys, lot)
            return [f"set {text} = {by_lot[0]} by lot"]
    if not bold and not written.allows(keys, "set"):
        return []
    inner = scope if own or bold else of_target_alone(scope, owner)
    made = value(inner, f, depth)
    if made is None:
        return []
    written.note(keys, "set")
    target = _target(inner, f, text, made)
    return [f"set {target} = {made[0]}"]


def _own_entry(scope: Scope, owner: Variable | None, f: Field) -> str:
    """Returns the agent whose entry of a row by agent each instance has for itself; empty if there is none."""
    if (
        not f.type.indexed_by
        or f.type.indexed_by[0].kind != "agent"
        or (owner is not None and owner.frame < 0)
    ):
        return ""
    left = {i for i, frame in enumerate(scope.frames) if not frame.single} - (
        {owner.frame} if owner is not None else set()
    )
    fitting = [v.name for v in scope.agents() if v.frame >= 0 and left <= {v.frame}]
    return scope.world.random.choice(fitting) if fitting else ""


def _keys(owner: Variable | None, f: Field) -> list[tuple[str, str, str]]:
    if owner is None:
        return [("world", "", f.name)]
    if owner.sort:
        return [("mover", owner.sort, f.name)]
    return [("agent", "", f.name)] if owner.is_agent else [("cell", k, f.name) for k in owner.kinds]


def of_target_alone(scope: Scope, owner: Variable | None) -> Scope:
    """Returns a scope in which only the target is known: what it gives is the same for all who reach it."""
    held = owner is not None and owner.name in scope.sure  # an agent that a field holds
    variables = () if owner is None or held else (owner,)
    return replace(
        scope,
        variables=variables,
        locals=(),
        sure=frozenset({owner.name} if held and owner else ()),
        filled=frozenset(),
    )


def _target(scope: Scope, f: Field, text: str, made: Typed) -> str:
    """Returns the field, an entry of it, or the whole row."""
    if not f.type.indexed_by or made[1].indexed_by:
        return text
    if scope.world.is_now(0.3):
        return text
    key = key_for(scope, f.type.indexed_by[0], 1)
    return f"{text}[{key}]" if key else text


def value(scope: Scope, f: Field, depth: int) -> Typed | None:
    """Returns what a field of this type can be set to."""
    w, type_ = scope.world, f.type
    rows = [
        v
        for v in scope.values
        if v[1].indexed_by == type_.indexed_by
        and v[1].kind == type_.kind
        and v[1].unit == type_.unit
    ]
    rows = [
        v
        for v in rows
        if type_.low <= v[1].low and v[1].high <= type_.high and set(v[1].words) <= set(type_.words)
    ]
    if type_.indexed_by and rows and w.is_now(0.25):
        return w.random.choice(rows)
    one = type_.model_copy(update={"indexed_by": ()})
    if type_.indexed_by and rows and type_.indexed_by[0].kind != "agent" and w.is_now(0.4):
        filler = value(scope, replace(f, type=one), depth)
        if filler is not None:
            return (
                f"shift({w.random.choice(rows)[0]}, {w.random.choice((-2, -1, 0, 1, 1, 3))}, {filler[0]})",
                type_,
            )
    match type_.kind:
        case "word":
            found = word(scope, type_.words, 2)
            return None if found is None else (found[0], one)
        case "int" if f.timer:
            return fitted(integer(scope, "steps", depth), 0, w.random.choice((2, 4))), one
        case "int":
            return fitted(integer(scope, type_.unit, depth), type_.low, type_.high), one
        case "real" if type_.high < inf:
            return f"min(max({_number(scope, type_, depth)}, {type_.low}), {type_.high})", one
        case "real":
            return real(scope, "reward", depth)[0], one
        case "agent":
            return agent_value(scope), one
        case "cell":
            cells = [v.name for v in scope.cells() if set(v.kinds) <= set(type_.kinds)] * 3
            cells += [
                text for text, t in scope.single_values("cell") if set(t.kinds) <= set(type_.kinds)
            ]
            return w.random.choice([*cells, "nowhere"]), one
        case _:
            sets = [text for text, _ in scope.single_values("agents")]
            return w.random.choice([*sets, "nobody"]), one


def _add(
    scope: Scope,
    written: Written,
    keys: list[tuple[str, str, str]],
    own: bool,
    bold: bool,
    f: Field,
    text: str,
    depth: int,
) -> Lines:
    w, type_ = scope.world, f.type
    if type_.kind == "real" and type_.high < inf and not f.capped:
        return []
    guarded = type_.kind == "int" and not f.capped
    sort = "bound" if guarded else "add"
    if not bold and (not written.allows(keys, sort) or (guarded and not own)):
        return []
    if type_.kind == "agents":
        written.note(keys, sort)
        who = w.random.choice(somebody(scope) or ["nobody"])
        target = _entry(scope, f, text)
        return [f"add {who} to {target}"] if who != "nobody" and target else []
    rows = [
        v
        for v in scope.values
        if v[1].indexed_by == type_.indexed_by
        and v[1].kind == type_.kind
        and v[1].unit in (type_.unit, "number")
    ]
    if type_.indexed_by and not guarded:
        whole = w.is_now(0.4)
        if whole and not rows:
            return []
        written.note(keys, sort)
        if whole:
            a, b = w.random.choice(rows)[0], w.random.choice(rows)[0]
            return [f"add {w.random.choice((a, f'{a} + {b}', f'{a} - {b}'))} to {text}"]
    written.note(keys, sort)
    target = _entry(scope, f, text)
    if not target:
        return []
    if not guarded:
        return [f"add {_number(scope, type_, depth)} to {target}"]
    step = w.random.choice((1, 1, 2, -1))
    test = (
        f"{target} <= {int(type_.high) - step}"
        if step > 0
        else f"{target} >= {int(type_.low) - step}"
    )
    if step > 0 and w.is_now(0.5):
        test = f"{target} < {int(type_.high) - step + 1}"
    return [f"when {test} {{", f"  add {step} to {target}", "}"]


def _entry(scope: Scope, f: Field, text: str) -> str:
    if not f.type.indexed_by:
        return text
    key = key_for(scope, f.type.indexed_by[0], 1) or (
        f.type.indexed_by[0].names[0] if f.type.indexed_by[0].kind == "word" else ""
    )
    return f"{text}[{key}]" if key else ""


def _number(scope: Scope, type_: ir.Type, depth: int) -> str:
    if type_.kind == "real" and type_.high < inf:  # a reward may leave float32, a whole number not
        return f"{fitted(integer(scope, 'number', depth), -5, 9)} * 0.3"
    if type_.kind == "real":
        return real(scope, "reward", depth)[0]
    return fitted(integer(scope, type_.unit, depth), -5, 9)
