"""The table of functions and operators: the interpreter means the same by each row, and what a row says of itself holds."""

from collections.abc import Iterator
from itertools import product
from random import Random

import numpy as np
import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.ir.operations import (
    CALCULATIONS,
    COMPARISONS,
    FUNCTIONS,
    PAYOFF_CLASSES,
    Calculation,
    Function,
    Moving,
)
from sjdsl.compiler.ir.printer import expression_text as text
from sjdsl.compiler.ir.ranges import range_of
from sjdsl.interpreter import numbers
from sjdsl.interpreter.evaluate import is_of_class
from tests.fuzz.together import interpret, on_numpy, random_play, run

WHOLE = (-7, -2, -1, 0, 1, 2, 3, 9)
REAL = (-2.5, -1.5, -0.5, 0.0, 0.5, 1.0, 2.5, 3.75)
by_row = pytest.mark.parametrize("row", CALCULATIONS.values(), ids=lambda row: row.name)


def is_possible(row: Calculation, of: tuple[float, ...]) -> bool:
    """Returns whether a calculation has a value, as guards make sure in a game."""
    domain = row.domain
    return (
        (row.divisor is None or of[row.divisor] != 0)
        and (row.apart is None or of[row.apart[0]] != of[row.apart[1]])
        and (domain is None or domain.low <= of[0] <= domain.high)
        and (not row.finite or is_exponent(of[1]))
    )


def is_exponent(number: float) -> bool:
    return isinstance(number, int) and number >= 0


def arguments(row: Calculation) -> Iterator[tuple[float, ...]]:
    """Yields arguments of which the calculation has a value: whole numbers, reals, and both beside each other."""
    many = max(row.least, 2) if row.most > row.least else row.least
    for of in (WHOLE,) if row.whole_only else (WHOLE, REAL, (*WHOLE[::2], *REAL[::2])):
        yield from (found for found in product(of, repeat=many) if is_possible(row, found))


def is_whole(row: Calculation, of: tuple[float, ...]) -> bool:
    return row.kind == "whole" or (row.kind == "joined" and all(isinstance(x, int) for x in of))


@by_row
def test_the_interpreter_means_the_same(row: Calculation) -> None:
    for of in arguments(row):
        if row.unchanged and isinstance(of[0], int):
            continue  # that is no calculation
        found = numbers.arithmetic(
            row.name,
            [x if isinstance(x, int) else np.float32(x) for x in of],
            not is_whole(row, of),
        )
        expected = row.fold(*of) if is_whole(row, of) else np.float32(row.fold(*of))
        # An exponential or a logarithm is a sequence of operations, each of which rounds.
        units = 2 if row.domain is not None else 0
        assert abs(found - expected) <= units * abs(np.spacing(np.float32(expected))), of
        assert isinstance(found, int | np.integer) == is_whole(row, of), of


def boxes(row: Calculation) -> Iterator[tuple[tuple[tuple[float, ...], ...], bool]]:
    """Yields for each argument some numbers that it may be, in order; and whether they are whole."""
    random = Random(row.name)
    many = random.choice((2, 3)) if row.most > row.least else row.least
    for turn in range(400):
        of = WHOLE if row.whole_only or turn % 2 else REAL
        box = [tuple(sorted(random.sample(of, random.choice((1, 2, 3))))) for _ in range(many)]
        if row.finite:  # its exponent is fixed
            box[1] = (random.choice((0, 1, 2, 3)),)
        yield tuple(box), of is WHOLE


def local(name: str, of: tuple[float, ...], whole: bool) -> ir.Local:
    return ir.Local(
        name=name, type=ir.Type(kind="int" if whole else "real", low=of[0], high=of[-1])
    )


def node(
    row: Calculation, args: list[ir.Expr], whole: bool, unit: ir.Unit = "number"
) -> ir.Arithmetic:
    kind = "int" if row.kind == "whole" or (row.kind == "joined" and whole) else "real"
    return ir.Arithmetic(type=ir.Type(kind=kind, unit=unit), fn=row.name, args=tuple(args))  # type: ignore[arg-type]


@by_row
def test_every_value_is_in_its_interval_and_in_its_range(row: Calculation) -> None:
    seen = 0
    for box, whole in boxes(row):
        low, high = row.interval(*((of[0], of[-1]) for of in box))
        made = node(
            row,
            [local(name, of, isinstance(of[0], int)) for name, of in zip("abc", box, strict=False)],
            whole,
        )
        computed = range_of(made)
        for of in product(*box):
            if is_possible(row, of) and not (row.unchanged and whole):
                found = row.fold(*of)
                assert low <= found <= high, (box, of)
                assert not computed.sound or computed.low <= found <= computed.high, (box, of)
                seen += 1
    assert seen > 200


@by_row
def test_every_slope_is_the_direction_that_values_go_in(row: Calculation) -> None:
    decided = 0
    for box, _ in boxes(row):
        for moving in range(len(box)):
            ranges = [range_of(local("a", of, isinstance(of[0], int))) for of in box]
            parts = [
                Moving("rising" if place == moving else "level", r)
                for place, r in enumerate(ranges)
            ]
            found = row.slope(parts, lambda one, other, box=box: box[one][-1] < box[other][0])  # type: ignore[misc]
            if found is None:
                continue
            decided += 1
            for of in product(*box):
                after = [
                    (*of[:moving], x, *of[moving + 1 :]) for x in box[moving] if x >= of[moving]
                ]
                values = [row.fold(*x) for x in after if is_possible(row, x)]
                assert values == sorted(values, reverse=found == "falling"), (box, of, found)
                assert found != "level" or len(set(values)) < 2, (box, of)
    assert decided > 50 or all(
        row.slope([Moving("rising", range_of(local("a", (1, 2), True)))] * 3, lambda *_: True)
        is None
        for _ in "a"
    )


GAME = """sj 1
game table "Table" {{
  episode 9
  param one : number = 1.5 in 1 .. 2
  param two : number = 2.5 in 2.25 .. 3
  param pay : reward = 1
  kind grass "."
  map {{ "...." }}
  agents 2 {{
    acts stay
    field held : 0 .. 9 = 7
    field owed : 1 .. 9 = 3
    {fields}
  }}
  phase start {{ each agent {{ send agent to grass }} }}
  schedule tick -> rule
  phase rule {{
    each agent {{
      set agent.held = (agent.held + 3) % 10
      set agent.owed = 1 + (agent.owed * 5) % 9
      {rules}
    }}
  }}
}}
"""


def in_the_language(row: Calculation, args: list[str]) -> str:
    if not row.sign:
        return f"{row.name}({', '.join(args)})"
    return f"{row.sign}{args[0]}" if len(args) == 1 else f"{args[0]} {row.sign} {args[1]}"


def every_row() -> Source:
    """Returns a game that keeps what each row makes of whole numbers and of reals."""
    fields, rules = [], []
    for number, row in enumerate(CALCULATIONS.values()):
        for whole in (True, False):
            if (row.unchanged and whole) or (row.whole_only and not whole):
                continue
            numbers = (
                ["agent.held", "agent.owed", "0"] if whole else ["agent.held * one", "two", "0"]
            )
            if row.domain is not None:  # the first of them can be 0
                numbers = numbers[1:]
            numbers = numbers[: max(row.least, 2 if row.most > 1 else 1)]
            if row.finite:
                numbers[1] = "3"
            made = in_the_language(row, numbers)
            name = f"kept_{number}_{'whole' if whole else 'real'}"
            if row.kind == "whole" or (row.kind == "joined" and whole):
                fields.append(f"field {name} : -9 .. 9 = 0")
                rules.append(f"set agent.{name} = max(-9, min(9, {made}))")
            else:
                fields.append(f"field {name} : reward")
                rules.append(f"set agent.{name} = pay * ({made})")
    return Source(
        "table.sj", GAME.format(fields="\n    ".join(fields), rules="\n      ".join(rules))
    )


def test_each_row_is_read_printed_compiled_and_interpreted_alike() -> None:
    built = build(every_row())
    nodes = [n for n in ir.walk(built.game) if isinstance(n, ir.Arithmetic)]
    assert {n.fn for n in nodes} == CALCULATIONS.keys()
    for row in CALCULATIONS.values():
        names = ["a", "b", "c"][: row.most]
        said = in_the_language(row, names)
        assert text(node(row, [local(name, (1, 2), True) for name in names], True)) == (
            f"({said})" if row.sign else said
        )
    play = random_play(built.game, 1, 8)
    report = run(on_numpy(built.game), play, interpret(built.game, play))
    assert report.steps == 8
    assert report.differences == []


def test_comparisons_are_the_interpreters_and_fit_together() -> None:
    for (sign, row), a, b in product(COMPARISONS.items(), WHOLE, (*WHOLE, *REAL)):
        assert row.holds(a, b) == numbers.compare(sign, a, b) == COMPARISONS[row.mirror].holds(b, a)
        assert row.holds(a, b) != COMPARISONS[row.opposite].holds(a, b)


def test_classes_of_games_are_the_interpreters() -> None:
    for table in product(((x, y) for x in range(4) for y in range(4)), repeat=2):
        (r, s), (t, p) = table
        assert [row.holds(r, s, t, p) for row in PAYOFF_CLASSES.values()] == [
            is_of_class(name, table) for name in PAYOFF_CLASSES
        ]  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "row", [row for row in FUNCTIONS.values() if row.yields], ids=lambda row: row.name
)
def test_a_define_of_a_games_own_keeps_its_meaning(row: Function) -> None:
    """A function that came later has a name that games may have used before."""
    text = GAME.format(fields="", rules=f"give pay * {row.name}(agent.held) to agent")
    game = build(
        Source(
            "table.sj",
            text.replace(
                "  phase start", f"  define {row.name}(number) = number + 100\n  phase start"
            ),
        )
    ).game
    (given,) = [n for n in ir.walk(game) if isinstance(n, ir.Give)]
    assert any(isinstance(n, ir.Named) and n.name == row.name for n in ir.walk(given))


# ---- nobody else knows an operation
