"""Random expressions that are numbers: text, and the unit and interval the compiler will find."""

from math import inf

from sjdsl.compiler import ir
from sjdsl.compiler.ir.entity_types import IndexSet
from sjdsl.compiler.ir.operations import CALCULATIONS
from sjdsl.compiler.ir.types import element, hull
from tests.fuzz.reading import Scope, Typed
from tests.fuzz.typed_numbers import combined, ends_of, fitted, interval, real_type, whole_type

LARGE = 1e6  # beyond this nothing is multiplied: whole numbers have 32 bits


def integer(scope: Scope, unit: str, depth: int) -> Typed:
    """Returns a whole number of this unit, or a bare one."""
    w = scope.world
    if depth <= 0 or w.is_now(0.35):
        return atom(scope, "int", unit)
    choices = [
        "sum",
        "sum",
        "difference",
        "product",
        "remainder",
        "quotient",
        "round",
        "plain",
        "case",
        "negation",
        "define",
    ]
    if scope.counts:
        choices += ["total", "total", "over"] + (["count"] * 3 if unit == "count" else [])
    if unit == "cells":
        choices += ["apart"] * 6
    if w.with_arguments:
        choices.append("asked")
    match w.random.choice(choices):
        case "sum" | "difference" as which:
            return combined(
                "+" if which == "sum" else "-",
                integer(scope, unit, depth - 1),
                integer(scope, unit, depth - 1),
            )
        case "product":
            left, right = (
                integer(scope, "count" if w.is_now(0.5) else "number", depth - 1),
                integer(scope, unit, depth - 1),
            )
            if unit != "count" and left[1].unit == "count" and right[1].unit == "number":
                left = atom(scope, "int", "number")
            if max(map(abs, (*ends_of(left), *ends_of(right)))) > LARGE:
                return right
            return combined("*", *(w.random.sample((left, right), 2)))
        case "remainder":
            divisor = str(w.random.randint(1, 4))
            left = integer(scope, unit, depth - 1)
            return f"({left[0]}) % {divisor}", whole_type(
                *interval("%", left[1], whole_type(int(divisor), int(divisor), "number")),
                left[1].unit,
            )
        case "quotient":
            left, divisor = integer(scope, unit, depth - 1), w.random.choice((2, 3, -2))
            below = whole_type(divisor, divisor, "number")
            return f"quotient({left[0]}, {divisor})", whole_type(
                *interval("quotient", left[1], below), left[1].unit
            )
        case "round":
            text = fitted(real(scope, "number", depth - 1), -9, 9)
            return f"round({text})", whole_type(-9, 9, "number")
        case "negation":
            inner = integer(scope, unit, depth - 1)
            return f"-({inner[0]})", whole_type(-inner[1].high, -inner[1].low, inner[1].unit)
        case "plain":
            return plain(
                scope,
                [integer(scope, unit, depth - 1) for _ in range(w.random.choice((2, 2, 3)))],
                "int",
            )
        case "case":
            return case(scope, lambda s: integer(s, unit, depth - 1), depth)
        case "count":
            return count(scope, depth)
        case "total":
            return total(scope, "int", unit, depth)
        case "over":
            return over(scope, "int", unit, depth)
        case "asked":
            from tests.fuzz.acting import number_chosen

            return number_chosen(scope, unit) or atom(scope, "int", unit)
        case "apart":
            return apart(scope) or atom(scope, "int", unit)
        case _:
            return used(scope, "int", unit, depth) or atom(scope, "int", unit)


def real(scope: Scope, unit: str, depth: int) -> Typed:
    """Returns a real number of this unit (reward, probability, fraction), or a bare one."""
    w = scope.world
    if depth <= 0 or w.is_now(0.3):
        return atom(scope, "real", unit)
    choices = [
        "sum",
        "difference",
        "product",
        "quotient",
        "plain",
        "case",
        "whole",
        "define",
        "ramp",
        "elementary",
    ]
    if scope.counts:
        choices += ["total", "share", "mix", "over"]
    match w.random.choice(choices):
        case "sum" | "difference" as which:
            return combined(
                "+" if which == "sum" else "-",
                real(scope, unit, depth - 1),
                real(scope, unit, depth - 1),
            )
        case "product":
            return product(scope, unit, depth)
        case "quotient":
            return quotient(scope, unit, depth)
        case "plain":
            return plain(scope, [real(scope, unit, depth - 1) for _ in range(2)], "real")
        case "case":
            return case(scope, lambda s: real(s, unit, depth - 1), depth)
        case "whole":
            return integer(scope, "number", depth - 1)
        case "ramp" if unit in ("fraction", "number"):
            return ramp(scope, depth)
        case "elementary":
            return elementary(scope, depth)
        case "share" if unit == "fraction":
            return share(scope, depth)
        case "mix":
            return expected(scope, unit) or atom(scope, "real", unit)
        case "total":
            return total(scope, "real", unit, depth)
        case "over":
            return over(scope, "real", unit, depth)
        case _:
            return used(scope, "real", unit, depth) or atom(scope, "real", unit)


def atom(scope: Scope, kind: str, unit: str) -> Typed:
    """Returns a value that can be named here, or a written number."""
    r = scope.world.random
    fitting = [v for v in scope.single_values(kind) if v[1].unit in (unit, "number")]
    rows = [v for v in scope.rows(kind) if v[1].unit in (unit, "number")]
    if rows and r.random() < 0.3:
        found = entry(scope, r.choice(rows), 1)
        if found is not None:
            return found
    if fitting and r.random() < 0.75:
        return r.choice(fitting)
    return written(scope, kind, unit)


def written(scope: Scope, kind: str, unit: str) -> Typed:
    r = scope.world.random
    if kind == "int":
        value = r.choice((0, 1, 1, 2, 3, 4, 7))
        return str(value), whole_type(value, value, "number")
    value = (
        r.choice((0.25, 0.5, 0.125, 0.3, 0.75))
        if unit in ("probability", "fraction")
        else r.choice((0.5, 1.5, 0.1, 2.25))
    )
    return str(value), real_type(value, value, "number")


def entry(scope: Scope, row: Typed, depth: int) -> Typed | None:
    """Returns one entry of a row or table."""
    text, type_ = row
    while type_.indexed_by:
        key = key_for(scope, type_.indexed_by[0], depth)
        if not key:
            return None
        text, type_ = f"{text}[{key}]", element(type_)
    return text, type_


def key_for(scope: Scope, level: IndexSet, depth: int) -> str:
    """Returns what an entry of a row can be asked for by here; empty if nothing can."""
    from tests.fuzz.conditions import somebody, word

    match level.kind:
        case "word":
            found = word(scope, level.names, depth)
            return found[0] if found else ""
        case "agent":
            known = somebody(scope) if scope.by_game else []
            return scope.world.random.choice(known) if known else ""
        case _:
            low, high = int(level.names[0]), int(level.names[-1])
            if depth <= 0 or scope.world.is_now(0.4):
                return str(scope.world.random.randint(low, high))
            return fitted(integer(scope, "count", depth - 1), low, high)


def product(scope: Scope, unit: str, depth: int) -> Typed:
    """A share of something, or something a few times."""
    w = scope.world
    right = real(scope, unit, depth - 1)
    options = [lambda: integer(scope, "number", depth - 1)]
    if unit == "number":
        options.append(lambda: real(scope, "number", depth - 1))
    if unit in ("reward", "probability", "fraction"):
        options += [
            lambda: integer(scope, "count", depth - 1),
            lambda: real(scope, "number", depth - 1),
        ]
    if unit in ("reward", "probability"):
        options.append(lambda: real(scope, "probability", depth - 1))
    if unit == "reward" or (unit == "fraction" and right[1].unit != "number"):
        options.append(lambda: real(scope, "fraction", depth - 1))
    left = w.random.choice(options)()
    if right[1].unit == "number" and left[1].unit not in ("number", unit):
        left = written(scope, "real", "number")
    if max(map(abs, (*ends_of(left), *ends_of(right)))) > LARGE and w.is_now(0.7):
        return right
    return combined("*", *(w.random.sample((left, right), 2)))


def quotient(scope: Scope, unit: str, depth: int) -> Typed:
    """Something over a number that cannot be 0."""
    r = scope.world.random
    left = real(scope, unit, depth - 1) if r.random() < 0.6 else integer(scope, "number", depth - 1)
    below = [v for v in scope.single_values("int") if v[1].unit in ("count", "number")]
    divisor: Typed = (str(r.choice((2, 4, 3))), whole_type(2, 4, "number"))
    if below and r.random() < 0.5:
        text, type_ = r.choice(below)
        divisor = f"(max({text}, 1) + 1)", whole_type(2, max(type_.high, 1) + 1, type_.unit)
    if divisor[1].unit == "count" and left[1].unit == "count":
        divisor = "2", whole_type(2, 2, "number")
    low, high = interval("/", left[1], divisor[1])
    return f"({left[0]}) / {divisor[0]}", real_type(low, high, left[1].unit)


def elementary(scope: Scope, depth: int) -> Typed:
    """Returns a root, an exponential, a logarithm or a power of a number that it takes."""
    r = scope.world.random
    inner = real(scope, "number", depth - 1)
    match r.choice(("sqrt", "exp", "log", "product", "power")):
        case "sqrt":
            return f"sqrt({fitted(inner, 0, 9)})", real_type(0, 3, "number")
        case "exp":
            return f"exp({fitted(inner, -5, 2)})", real_type(0, 7.4, "number")
        case "log":
            return f"log({fitted(inner, 1, 9)})", real_type(0, 2.2, "number")
        case "product":
            return f"({fitted(inner, -3, 3)} * 1.0) ^ 3", real_type(-27, 27, "number")
        case _:
            exponent = r.choice((0.5, 1.5, -0.5))
            return f"({fitted(inner, 1, 4)}) ^ {exponent}", real_type(0.5, 8, "number")


# Functions of any numbers; those that want more of them, and reals alone, are made one by one.
PLAIN = [
    row
    for row in CALCULATIONS.values()
    if not (
        row.sign
        or row.whole_only
        or row.bounded
        or row.apart
        or row.domain is not None
        or row.divisor is not None
        or row.kind == "real"
    )
]


def plain(scope: Scope, parts: list[Typed], kind: str) -> Typed:
    """Returns a function of numbers of one kind, such as `min(…)`; of several if it takes several."""
    row = scope.world.random.choice(PLAIN)
    parts = parts[: row.most]
    low, high = interval(row.name, *(p[1] for p in parts))
    unit = row.unit(*(p[1].unit for p in parts))
    assert unit is not None
    type_ = ir.Type(kind="int" if row.kind == "whole" else kind, unit=unit, low=low, high=high)
    return f"{row.name}({', '.join(p[0] for p in parts)})", type_


def case(scope: Scope, value, depth: int) -> Typed:
    """Returns a `case` of a word, a condition or a number, each arm made by `value`."""
    from tests.fuzz.conditions import condition, word

    r = scope.world.random
    arms: list[tuple[str, Typed]] = []
    subject = ""
    sort = r.choice(("word", "condition", "number"))
    if sort == "word":
        found = word(scope, r.choice(scope.world.words()), depth - 1)
        if found is not None and len(found[1]) > 1:
            subject = found[0]
            keys = list(found[1])
            r.shuffle(keys)
            if len(keys) > 2 and r.random() < 0.4:
                keys = [*keys[: r.randint(1, len(keys) - 1)], "otherwise"]
            arms = [(k, value(scope)) for k in keys]
    if sort == "number":
        subject, type_ = integer(scope, "count", depth - 1)
        arms = (
            [
                (k, value(scope))
                for k in _number_keys(scope, int(type_.low) if type_.low > -inf else 0, type_.high)
            ]
            if type_.low > -inf
            else []
        )
    if not arms:
        subject = condition(scope, depth - 1)
        arms = [(k, value(scope)) for k in r.sample(("yes", "no"), 2)]
    types = [v[1] for _, v in arms]
    unit = next((t.unit for t in types if t.unit != "number"), "number")
    low, high = hull(types)
    kind = "int" if all(t.kind == "int" for t in types) else "real"
    text = f"case {subject} {{ {', '.join(f'{k}: {v[0]}' for k, v in arms)} }}"
    return text, ir.Type(kind=kind, unit=unit, low=low, high=high)


def _number_keys(scope: Scope, low: int, high: float) -> list[str]:
    """Returns keys that cover `low` .. `high`; keys are not negative."""
    r = scope.world.random
    if low < 0 or (high < inf and r.random() < 0.3):
        keys = [
            str(k) for k in r.sample(range(max(low, 0), max(low, 0) + 3), 2) if low < 0 or k <= high
        ]
        return [*keys, "otherwise"] if low < 0 or high - low + 1 > len(keys) else keys
    if high < inf and high - low > LARGE:
        return [str(low), "otherwise"]
    if high == low:
        return [str(low)]
    if high - low <= 2 and r.random() < 0.5:
        return [str(k) for k in range(low, int(high) + 1)]
    cut = low + r.randint(0, int(min(2, high - low - 1)))
    first = str(low) if cut == low else f"{low} .. {cut}"
    return [
        first,
        f"{cut + 1}.." if high == inf or r.random() < 0.6 else f"{cut + 1} .. {int(high)}",
    ]


def count(scope: Scope, depth: int) -> Typed:
    from tests.fuzz.members import domain

    text, _, most = domain(scope, depth - 1, counted=True)
    return f"count({text})", whole_type(0, most, "count")


def total(scope: Scope, kind: str, unit: str, depth: int) -> Typed:
    """Returns the sum of a row, or over a domain."""
    from tests.fuzz.members import domain

    r = scope.world.random
    rows = [
        v for v in scope.rows(kind) if v[1].unit in (unit, "number") and len(v[1].indexed_by) == 1
    ]
    if rows and r.random() < 0.5:
        text, type_ = r.choice(rows)
        n = len(type_.indexed_by[0])
        if r.random() < 0.3:
            return f"{r.choice(('min', 'max'))}({text})", element(type_)
        least = 1 if type_.indexed_by[0].kind == "agent" else n  # a variant may have fewer agents
        low, high = (
            type_.low * (least if type_.low > 0 else n),
            type_.high * (least if type_.high < 0 else n),
        )
        return f"sum({text})", _beyond_one(
            type_.model_copy(update={"indexed_by": (), "low": low, "high": high})
        )
    text, inner, most = domain(scope, depth - 1, counted=True)
    value, type_ = (integer if kind == "int" else real)(inner, unit, min(depth - 1, 1))
    low, high = min(0, type_.low), max(0, type_.high)
    type_ = type_.model_copy(
        update={"low": low * most if low else 0, "high": high * most if high else 0}
    )
    return f"sum({value} over {text})", _beyond_one(type_)


def over(scope: Scope, kind: str, unit: str, depth: int) -> Typed:
    """Returns the least or greatest value over a domain; `otherwise` stays out half of the times that there always is a member."""
    from tests.fuzz.members import domain

    w = scope.world
    text, inner, _ = domain(scope, depth - 1, counted=True)
    made = integer if kind == "int" else real
    parts = [made(inner, unit, min(depth - 1, 1))]
    whose, *rest = text.split()
    whole = not rest or (len(rest) == 2 and rest[0] == "as")
    around = scope.sort in ("phase", "metric", "check") and scope.agents()
    if whose in w.movers:
        sure = (
            whole
            and scope.sort in ("phase", "metric", "check")
            and any(v.sort == whose for v in scope.movers())
        )
    else:
        sure = whole and (around if whose == "agent" else w.num_cells(w.kinds_of(whose)))
    if not sure or w.is_now(0.5):
        parts.append(made(scope, unit, 0))
        text += f" otherwise {parts[1][0]}"
    types = [part[1] for part in parts]
    low, high = hull(types)
    unit = next((t.unit for t in types if t.unit != "number"), "number")
    sort = "int" if all(t.kind == "int" for t in types) else "real"
    return f"{w.random.choice(('min', 'max'))}({parts[0][0]} over {text})", ir.Type(
        kind=sort, unit=unit, low=low, high=high
    )


def apart(scope: Scope) -> Typed | None:
    """Returns the distance between two that have a place."""
    w = scope.world
    placed = (
        []
        if scope.sort == "forbid"
        else [v.name for v in scope.variables if scope.sort != "start" or not v.turns]
    )
    if not placed:
        return None
    names = [w.random.choice(placed) for _ in "ab"]
    turning = {v.name for v in scope.variables if v.turns}
    if names[0] in turning and names[0] > names[1]:
        farthest = max(len(w.rows), len(w.rows[0])) - 1
        return f"steps_ahead({', '.join(names)})", whole_type(-farthest, farthest, "cells")
    return f"distance({', '.join(names)})", whole_type(0, len(w.rows) + len(w.rows[0]) - 2, "cells")


def _beyond_one(type_: ir.Type) -> ir.Type:
    if type_.unit in ("probability", "fraction") and type_.high > 1:
        return type_.model_copy(update={"unit": "number"})
    return type_


def used(scope: Scope, kind: str, unit: str, depth: int) -> Typed | None:
    """Returns the use of a define that gives such a number."""
    from tests.fuzz.members import use_of

    fitting = [
        d for d in scope.world.defines if d.type.kind == kind and d.type.unit in (unit, "number")
    ]
    for define in scope.world.random.sample(fitting, len(fitting)):
        text = use_of(scope, define, depth)
        if text:
            return text, define.type
    return None


def ramp(scope: Scope, depth: int) -> Typed:
    """Returns a ramp between two numbers that differ."""
    r = scope.world.random
    value = integer(scope, r.choice(("count", "steps")), depth - 1)
    ends = r.choice((("0", "4"), ("5", "1"), ("0.5", "3"), ("-1", "2")))
    pairs = [c for c in scope.world.requires if " < " in c]
    if pairs and r.random() < 0.3:
        low, high = r.choice(pairs).split(" < ")
        if _unit_of(scope, low) in (value[1].unit, "number") or value[1].unit == "number":
            ends = (low, high) if r.random() < 0.5 else (high, low)
    return f"ramp({value[0]}, {ends[0]}, {ends[1]})", real_type(0.0, 1.0, "fraction")


def _unit_of(scope: Scope, name: str) -> str:
    return next((p.type.unit for p in scope.world.params if p.name == name), "")


def share(scope: Scope, depth: int) -> Typed:
    """Returns how many of the cells of some kinds: a fraction."""
    from tests.fuzz.members import domain

    w = scope.world
    wholes = [n for n in (*w.kinds, *w.groups) if w.num_cells(w.kinds_of(n)) > 0]
    whole = w.random.choice(wholes)
    text, *_ = domain(scope, depth - 1, kind=w.random.choice(w.kinds_of(whole)))
    name = "" if not scope.uses(whole) else f" as {w.variable()}"
    return f"count({text}) / count({whole}{name})", real_type(0.0, 1.0, "fraction")


def expected(scope: Scope, unit: str) -> Typed | None:
    """Returns an entry of a table of numbers by the shares of a row that is not empty."""
    r = scope.world.random
    tables = [
        p
        for p in scope.world.params
        if p.type.indexed_by and p.type.kind in ("int", "real") and p.type.unit == unit
    ]
    for table in r.sample(tables, len(tables)):
        text, type_ = table.name, table.type
        for words in table.type.indexed_by:
            filled = [
                v
                for v in scope.rows("int")
                if v[0] in scope.filled and v[1].indexed_by == (words,) and v[1].low >= 0
            ]
            if filled and r.random() < 0.7:
                text = f"{text}[mix({r.choice(filled)[0]})]"
                type_ = element(type_).model_copy(update={"kind": "real"})
            else:
                text, type_ = f"{text}[{key_for(scope, words, 1) or '?'}]", element(type_)
        if "mix(" in text and "?" not in text:
            return text, type_
    return None
