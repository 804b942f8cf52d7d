"""Random domains, and uses of defines: both bind or take variables."""

from dataclasses import replace

from sjdsl.compiler import ir
from tests.fuzz.conditions import condition, word
from tests.fuzz.declared import Define
from tests.fuzz.declaring import form
from tests.fuzz.quantities import integer, real
from tests.fuzz.reading import Frame, Scope, Variable

Made = tuple[str, Scope, int]  # text, the scope inside, the most members


def domain(
    scope: Scope,
    depth: int,
    kind: str = "",
    counted: bool = False,
    single: bool = False,
    shape: bool = False,
) -> Made:
    """Returns a domain. `kind`: whose; `counted`: in `count` or `sum`; `single`: one member at most; `shape`: `in SHAPE of` is needed."""
    w, r = scope.world, scope.world.random
    kind = kind or r.choice(("agent", "agent", *w.kinds, *w.groups, *w.movers))
    sort = kind if kind in w.movers else ""
    kinds = () if kind == "agent" or sort else w.kinds_of(kind)
    place, most = _place(scope, kinds, shape, counted, sort)
    name = kind if not scope.uses(kind) and r.random() < 0.5 else w.variable()
    text = kind if name == kind else f"{kind} as {name}"
    number = -1 if counted else len(scope.frames)
    frames = scope.frames if counted else (*scope.frames, Frame(single, placed=bool(place)))
    listed = not (single or counted or place.startswith(" in {") or most == 1)
    inner = replace(scope.having(Variable(name, kinds, number, listed, sort)), frames=frames)
    if not kinds and r.random() < 0.25 and scope.counts:
        under = r.choice([*w.kinds, *w.groups])
        if any(under == v.name for v in inner.cells()):  # that cell
            text += f" on {under}"
        else:
            bound = under if not inner.uses(under) and r.random() < 0.5 else w.variable()
            text += f" on {under}" if bound == under else f" on {under} as {bound}"
            inner = inner.having(Variable(bound, w.kinds_of(under), number))
    text += place
    if r.random() < 0.5:
        guard, inner = where(inner, depth)
        text += f" where {guard}"
    return text, inner, min(most, w.num_cells(kinds) if kinds else w.number_of(sort))


def where(scope: Scope, depth: int) -> tuple[str, Scope]:
    """Returns a condition, sometimes one that proves something, and the scope that knows it."""
    w = scope.world
    holders = scope.nobodies()
    if holders and w.is_now(0.15):
        text = w.random.choice(holders)
        return f"{text} is not nobody", replace(scope, sure=scope.sure | {text})
    rows = [v for v in scope.rows("int") if len(v[1].indexed_by) == 1 and v[1].low >= 0]
    if rows and w.is_now(0.15):
        text = w.random.choice(rows)[0]
        return f"sum({text}) > 0", replace(scope, filled=scope.filled | {text})
    return condition(scope, max(depth, 0)), scope


def _place(
    scope: Scope, kinds: tuple[str, ...], shape: bool, counted: bool, sort: str = ""
) -> tuple[str, int]:
    """Returns ` in …` or nothing, and the most members there."""
    r = scope.world.random
    anchors = scope.variables if scope.counts else ()
    if scope.sort == "start":  # nobody has a place yet
        anchors = tuple(a for a in anchors if not a.turns)
    if anchors and (shape or r.random() < 0.45):
        anchor = (
            r.choice([a for a in anchors if a.turns] or anchors) if shape else r.choice(anchors)
        )
        found = shape_for(scope, anchor.turns)
        return f" in {found[0]} of {anchor.name}", found[1]
    movers = [v.name for v in scope.movers() if v.sort == sort]
    if movers and not counted and r.random() < 0.1:
        named = r.sample(movers, r.randint(1, min(2, len(movers))))
        return f" in {{ {', '.join(named)} }}", len(named)
    if sort:
        return "", 10**6
    cells = [v.name for v in scope.cells()] if kinds else []
    if cells and r.random() < 0.1:
        named = r.sample(cells, r.randint(1, min(2, len(cells))))
        return f" in {{ {', '.join(named)} }}", len(named)
    if kinds:
        held = [
            text for text, type_ in scope.single_values("cell") if set(type_.kinds) & set(kinds)
        ]
        return (f" in {r.choice(held)}", 1) if held and r.random() < 0.4 else ("", 10**6)
    sets = [text for text, _ in scope.single_values("agents")]
    if sets and r.random() < 0.3:
        return f" in {r.choice(sets)}", 64
    holders = scope.nobodies()
    if holders and r.random() < 0.15:
        return f" in {r.choice(holders)}", 1
    agents = [v.name for v in scope.agents()]
    if agents and r.random() < 0.1 and not counted:
        named = r.sample(agents, r.randint(1, min(2, len(agents))))
        return f" in {{ {', '.join(named)} }}", len(named)
    return "", 10**6


def shape_for(scope: Scope, agent: bool) -> tuple[str, int]:
    """Returns a shape, with a name or without, that an agent (or a cell) can have around it."""
    w = scope.world
    fitting = [s for s in w.shapes if agent or not s.directed]
    if fitting and w.is_now(0.6):
        found = w.random.choice(fitting)
        return found.text, found.size
    made = form(w, directed=agent)
    return made.text, made.size


def use_of(scope: Scope, define: Define, depth: int) -> str:
    """Returns a use of a define with values for its parameters; empty if there are none that fit."""
    r = scope.world.random
    if not scope.counts:
        return ""
    given = []
    for wanted in define.parameters:
        if wanted == "agent":
            fitting = [v.name for v in scope.agents()]
        elif isinstance(wanted, ir.Type):
            fitting = [_argument(scope, wanted, depth)]
        else:
            fitting = [v.name for v in scope.cells() if v.kinds == wanted]
        if not fitting or not fitting[0]:
            return ""
        given.append(r.choice(fitting))
    return f"{define.name}({', '.join(given)})" if given else define.name


def _argument(scope: Scope, wanted: ir.Type, depth: int) -> str:
    if wanted.kind == "word":
        found = word(scope, wanted.words, 1)
        return found[0] if found and set(found[1]) <= set(wanted.words) else ""
    text, type_ = (integer if wanted.kind == "int" else real)(scope, wanted.unit, min(depth - 1, 1))
    from tests.fuzz.typed_numbers import fitted

    return fitted((text, type_), wanted.low, wanted.high)
