"""Random conditions, words and agents."""

from math import inf
from random import Random

from sjdsl.compiler import ir
from sjdsl.compiler.ir.operations import COMPARISONS
from sjdsl.compiler.ir.types import element
from sjdsl.runtime.actions import HEADINGS
from tests.fuzz.quantities import integer, key_for, real
from tests.fuzz.reading import Scope, Typed

Word = tuple[str, tuple[str, ...]]  # text, and the words it can be


def condition(scope: Scope, depth: int) -> str:
    """Returns a condition."""
    r = scope.world.random
    if depth > 0 and r.random() < 0.3:
        left, right = condition(scope, depth - 1), condition(scope, depth - 1)
        match r.choice(("and", "or", "not", "not", "brackets")):
            case "not":
                return f"not ({left})" if " " in left else f"not {left}"
            case "brackets":
                return f"({left}) {r.choice(('and', 'or'))} ({right})"
            case joined:
                return f"{left} {joined} {right}"
    if scope.sort == "numbers":
        return compared(scope, depth)
    choices = [
        compared,
        compared,
        words_compared,
        words_compared,
        whereabouts,
        whereabouts,
        agents_compared,
        cells_compared,
        within,
        defined,
        quantified,
    ]
    for make in r.sample(choices, len(choices)):
        made = make(scope, depth)
        if made:
            return made
    return compared(scope, depth)


def compared(scope: Scope, depth: int) -> str:
    """Returns a comparison of two numbers, one of them perhaps a range."""
    r = scope.world.random
    if r.random() < 0.25:
        unit = r.choice(("reward", "probability", "fraction"))
        left, right = real(scope, unit, depth - 1), real(scope, unit, depth - 1)
    else:
        unit = r.choice(("count", "count", "steps", "cells", "number"))
        left, right = integer(scope, unit, depth), integer(scope, unit, min(depth - 1, 1))
        if left[1].unit == "number":
            right = integer(scope, "number", 0)
        if r.random() < 0.25:
            low = r.randint(0, 3)
            return f"{_operand(left)} in {low} .. {low + r.randint(0, 3)}"
    text = f"{_operand(left)} {r.choice(tuple(COMPARISONS))} {_operand(right)}"
    edge = Random(text)  # apart from all else: programs are otherwise the same
    return (
        tenths_compared(left[0], right[0], edge)
        if left[1].kind == "int" and edge.random() < 0.3
        else text
    )


def tenths_compared(left: str, right: str, r: Random) -> str:
    """Returns a comparison of reals made of two numbers that are often equal as fractions, so that the rounding of operations decides."""
    a, b, c = (r.randint(1, 9) / 10 for _ in "abc")
    sums = (
        f"({left}) * {a} + {b}",
        f"({left}) * {a} - {b} * ({right})",
        f"({left}) / 10 + {b}",
        f"({left}) * {a} * {b} - {c}",
    )
    others = (f"{c}", f"({right}) * {a}", f"({right}) / 10", f"({right}) / 3 * {c} + {b}")
    return f"{r.choice(sums)} {r.choice(tuple(COMPARISONS))} {r.choice(others)}"


def _operand(value: Typed) -> str:
    return value[0]


def words_compared(scope: Scope, depth: int) -> str:
    """Returns `x is w`, `x is not y` or `x in { … }` between words."""
    r = scope.world.random
    left = word(scope, r.choice(scope.world.words()), min(depth, 1), plain=False)
    if left is None or len(left[1]) < 2:
        return ""
    text, words = left
    if r.random() < 0.3:
        return f"{text} in {{ {', '.join(r.sample(words, r.randint(1, len(words))))} }}"
    if r.random() < 0.6:
        return f"{text} {r.choice(('is', 'is not'))} {r.choice(words)}"
    right = word(scope, r.choice(scope.world.words()), 0, plain=False)
    if right is None or not set(right[1]) & set(words):
        return ""
    return f"{text} {r.choice(('is', 'is not'))} {right[0]}"


def whereabouts(scope: Scope, depth: int) -> str:
    """Returns what an agent chose or stands on, whether it moved or is away, whether a cell is free."""
    w, r = scope.world, scope.world.random
    found = []
    for v in scope.agents():
        found += [f"{v.name}.moved", f"{v.name}.away"]
        if scope.counts:
            found.append(f"{v.name} on {r.choice([*w.kinds, *w.groups])}")
        if scope.sort == "phase":
            found += [f"{v.name} chose {r.choice(w.actions)}"] * 2
            if w.with_arguments and r.random() < 0.5:
                from tests.fuzz.acting import chosen

                return chosen(scope, v, depth)
    for v in scope.movers():
        found += [f"{v.name}.moved", f"{v.name}.away", f"not {v.name}.moved"]
        if scope.counts:
            found.append(f"{v.name} on {r.choice([*w.kinds, *w.groups])}")
    if scope.counts:
        found += [f"nobody on {v.name}" for v in scope.cells()]
    return r.choice(found) if found else ""


def agents_compared(scope: Scope, _depth: int) -> str:
    """Returns `a is b`, `a is nobody`, `set is nobody`, `a in set`."""
    r = scope.world.random
    holders, members = scope.nobodies(), [v.name for v in scope.agents()]
    sets = [text for text, _ in scope.single_values("agents")]
    found = [f"{h} {not_} nobody" for h in (*holders, *sets) for not_ in ("is", "is not")]
    found += [f"{a} is {b}" for a in (*holders, *members) for b in (*holders, *members) if a != b]
    found += [f"{a} is not {b}" for a in members for b in members if a != b]
    found += [
        f"{a.name} is not {b.name}"
        for a in scope.movers()
        for b in scope.movers()
        if a.name != b.name and a.sort == b.sort
    ]
    found += [f"{a} in {s}" for a in (*holders, *members) for s in sets]
    return r.choice(found) if found else ""


def cells_compared(scope: Scope, _depth: int) -> str:
    """Returns `a is b`, `a is nowhere` between cells."""
    r = scope.world.random
    held = [(text, type_.kinds) for text, type_ in scope.single_values("cell")]
    members = [(v.name, v.kinds) for v in scope.cells()]
    found = [f"{text} {not_} nowhere" for text, _ in held for not_ in ("is", "is not")]
    pairs = [(a, b) for a in (*held, *members) for b in held if a != b and set(a[1]) & set(b[1])]
    found += [f"{a[0]} {r.choice(('is', 'is not'))} {b[0]}" for a, b in pairs]
    return r.choice(found) if found else ""


def within(scope: Scope, depth: int) -> str:
    """Returns a whole number in a range computed from others."""
    r = scope.world.random
    if r.random() < 0.5:
        return ""
    unit = r.choice(("count", "cells"))
    value, low, high = (
        integer(scope, unit, depth - 1),
        integer(scope, unit, 0),
        integer(scope, unit, 0),
    )
    return f"{value[0]} in {low[0]} .. {high[0]}"


def quantified(scope: Scope, depth: int) -> str:
    """Returns whether a domain has a member, or a condition holds for all of them."""
    from tests.fuzz.members import domain

    if not scope.counts or depth <= 0 or scope.world.is_now(0.5):
        return ""
    text, inner, _ = domain(scope, depth - 1, counted=True)
    if scope.world.is_now(0.5):
        return f"any({text})"
    return f"all({text})" if " where " in text else f"all({text} where {condition(inner, 0)})"


def defined(scope: Scope, depth: int) -> str:
    """Returns the use of a define that is a condition."""
    from tests.fuzz.members import use_of

    found = [d for d in scope.world.defines if d.type.kind == "condition"]
    return use_of(scope, scope.world.random.choice(found), depth) if found else ""


def word(scope: Scope, allowed: tuple[str, ...], depth: int, plain: bool = True) -> Word | None:
    """Returns a word of the allowed ones; `plain`: also one written out."""
    r = scope.world.random
    known = [
        (text, t.words) for text, t in scope.single_values("word") if set(t.words) <= set(allowed)
    ]
    if not plain:
        known = [(text, t.words) for text, t in scope.single_values("word") if len(t.words) > 1]
    rows = [v for v in scope.rows("word") if set(v[1].words) <= set(allowed)]
    numbers = [
        v
        for v in scope.rows("int")
        if len(v[1].indexed_by) == 1 and set(v[1].indexed_by[0].names) <= set(allowed)
    ]
    made: list[Word] = []
    if rows and depth > 0:
        found = _entry(scope, r.choice(rows), depth - 1)
        made += [found] if found else []
    if numbers and depth > 0:
        row = r.choice(numbers)
        made.append((f"{r.choice(('lowest', 'highest'))}({row[0]})", row[1].indexed_by[0].names))
    if depth > 0 and plain and r.random() < 0.3:
        arms = [word(scope, allowed, depth - 1), word(scope, allowed, depth - 1)]
        if all(arms):
            text = f"case {condition(scope, depth - 1)} {{ yes: {arms[0][0]}, no: {arms[1][0]} }}"  # type: ignore[index]
            made.append((text, tuple(dict.fromkeys((*arms[0][1], *arms[1][1])))))  # type: ignore[index]
    if made and r.random() < 0.5:
        return r.choice(made)
    if known and (not plain or r.random() < 0.7):
        return r.choice(known)
    if plain:
        chosen = r.choice(allowed)
        return chosen, (chosen,)
    return r.choice(made) if made else None


def _entry(scope: Scope, row: Typed, depth: int) -> Word | None:
    text, type_ = row
    while type_.indexed_by:
        key = key_for(scope, type_.indexed_by[0], depth)
        if not key:
            return None
        text, type_ = f"{text}[{key}]", element(type_)
    return text, type_.words


def somebody(scope: Scope) -> list[str]:
    """Returns every agent that can be named here and is not nobody."""
    return [v.name for v in scope.agents()] + [s for s in scope.sure if ".." not in s]


def agent_value(scope: Scope) -> str:
    """Returns an agent or nobody."""
    return scope.world.random.choice([*somebody(scope), *scope.nobodies(), "nobody"])


def probability(scope: Scope, depth: int) -> str:
    """Returns a number that is surely in 0 .. 1."""
    from tests.fuzz.typed_numbers import fitted

    r = scope.world.random
    if r.random() < 0.15:
        return r.choice(("0", "1", "0.5"))
    value = real(scope, "probability", depth)
    return fitted(value, 0, 1)


__all__ = ["HEADINGS", "inf", "ir"]
