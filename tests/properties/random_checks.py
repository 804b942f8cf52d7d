"""Random checks for random games: bounds of numbers at the ends of their intervals, what is conserved, slopes, symmetries."""

from collections.abc import Callable
from math import isfinite
from random import Random

from tests.fuzz.conditions import condition
from tests.fuzz.declared import Lines, World
from tests.fuzz.quantities import integer, real
from tests.fuzz.reading import Scope, Typed
from tests.fuzz.statements import braces

UNITS = ("count", "steps", "cells"), ("reward", "probability", "fraction")
REMOVABLE = ("always", "once", "conserved", "monotone", "define value_", "define argument_")
NUMBERS = (0.1, 0.05, 0.3, 1.1, 3.0, 0.7, 2.5)


def many_checks(number: int) -> Callable[[World], list[Lines]]:
    """Returns what makes so many checks, and the defines of those about slopes."""

    def made(w: World) -> list[Lines]:
        lines = [f"require {test}" for test in w.requires] + ["symmetric agents"]
        lines += [f"symmetric {sort}" for sort in w.movers]
        declared: list[Lines] = []
        for i in range(number):
            kind = w.random.choice(
                ("bound",) * 6
                + ("single", "single", "conserved", "conserved", "slope", "slope", "once")
            )
            scope = Scope(w, "check")
            if kind == "slope":
                value, argument = slope(scope)
                declared += [[f"define value_{i} = {value}"], [f"define argument_{i} = {argument}"]]
                lines.append(
                    f"monotone value_{i} {w.random.choice(('rising', 'falling'))} in argument_{i}"
                )
            else:
                lines.append(
                    {"bound": bound, "single": single, "conserved": conserved, "once": once}[kind](
                        scope
                    )
                )
        return [*declared, braces("checks", lines)]

    return made


def without(text: str, lines: set[int], removable: tuple[str, ...] = REMOVABLE) -> str:
    """Returns a text without the checks in these lines, from 1, and without the slopes whose numbers are declared in them.

    removable: how such lines begin; with another one among them nothing is returned.
    """
    written = text.split("\n")
    gone = [written[line - 1].strip() for line in lines]
    if any(not line.startswith(removable) for line in gone):
        return ""
    names = {line.split()[1] for line in gone if line.startswith("define ")}
    kept = [
        line
        for line in written
        if line.strip() not in gone
        and not (line.strip().startswith("monotone") and names & set(line.split()))
    ]
    return "\n".join(kept)


def number_of(scope: Scope, depth: int) -> Typed:
    """Returns any number, with its interval as the generator knows it."""
    r = scope.world.random
    whole = r.random() < 0.5
    return (integer if whole else real)(scope, r.choice(UNITS[not whole]), depth)


def bound(scope: Scope) -> str:
    """Returns that a number keeps to the ends of its interval, or nearly."""
    r = scope.world.random
    text, type_ = number_of(scope, r.choice((1, 2, 2, 3)))
    return _within(r, f"({text})", type_.low, type_.high)


def single(scope: Scope) -> str:
    """Returns the bound of one operation, as it is in exact numbers."""
    r = scope.world.random
    text, type_ = number_of(scope, 0)
    by, fn = r.choice(NUMBERS), r.choice("*/+-")
    ends = [
        {"*": x * by, "/": x / by, "+": x + by, "-": x - by}[fn] for x in (type_.low, type_.high)
    ]
    return _within(
        r,
        f"{text} {fn} {by}",
        round(ends[0], 6) if isfinite(ends[0]) else ends[0],
        round(ends[1], 6) if isfinite(ends[1]) else ends[1],
    )


def _within(r: Random, text: str, low: float, high: float) -> str:
    near = r.choice((0, 0, 0, 0, 1, -1))
    upper, lower = f"{text} <= {_said(high - near)}", f"{text} >= {_said(low + near)}"
    match r.choice(("upper", "lower", "both", "not")):
        case "upper" if isfinite(high):
            return f"always {upper}"
        case "both" if isfinite(low) and isfinite(high) and low <= high:
            return f"always {text} in {_said(low)} .. {_said(high)}"
        case "not" if isfinite(high):
            return f"always not ({text} > {_said(high - near)})"
        case _:
            return (
                f"always {lower}"
                if isfinite(low)
                else f"always {upper}"
                if isfinite(high)
                else f"conserved {text}"
            )


def _said(number: float) -> str:
    """Returns a number as it is written."""
    if not isfinite(number):
        return "0"
    text = f"{abs(number):.0f}" if number == int(number) else f"{abs(number):.9f}".rstrip("0")
    return f"(0 - {text})" if number < 0 else text


def conserved(scope: Scope) -> str:
    return f"conserved {number_of(scope, scope.world.random.choice((0, 1, 2)))[0]}"


def once(scope: Scope) -> str:
    said = bound(scope)
    return f"once {condition(scope, 1)} {said}" if said.startswith("always") else said


def slope(scope: Scope) -> tuple[str, str]:
    """Returns a number made of another one by a few operations, and that other one."""
    r = scope.world.random
    argument, _ = number_of(scope, 0)
    value = f"({argument})"
    for _ in range(r.choice((1, 1, 2, 3))):
        other, _ = number_of(scope, r.choice((0, 0, 1)))
        other = r.choice((f"({other})", str(r.choice(NUMBERS)), f"(0 - {r.choice(NUMBERS)})"))
        pattern = r.choice(
            (
                "{v} + {o}",
                "{o} - {v}",
                "{v} * {o}",
                "{v} / {o}",
                "min({v}, {o})",
                "ramp({v}, {a}, {b})",
                "1 / ({v} + {o})",
            )
        )
        ends = (
            r.sample(scope.world.requires, 1)[0].split()
            if scope.world.requires and r.random() < 0.5
            else ["1", "<", "2.5"]
        )
        a, b = r.sample((ends[0], ends[2]), 2)
        value = f"({pattern.format(v=value, o=other, a=a, b=b)})"
    return value, argument
