"""The table of functions and operators: the interpreter means the same by each row, what a row says of itself holds, and nobody else knows one."""

import ast
from collections.abc import Callable, Iterator
from itertools import product
from math import inf
from pathlib import Path
from random import Random

import numpy as np
import pytest

from sjdsl.compiler import build, compile_build, ir
from sjdsl.compiler.checks.start_values import holds_at_start
from sjdsl.compiler.checks.value_ranges import Here, Played, interval_of
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.ir import values
from sjdsl.compiler.ir.implications import facts, narrowed
from sjdsl.compiler.ir.operations import (
    CALCULATIONS,
    COMPARISONS,
    FUNCTIONS,
    INFIX,
    OPERATIONS,
    PAYOFF_CLASSES,
    PREFIX,
    REDUCTIONS,
    Calculation,
    Function,
    Moving,
)
from sjdsl.compiler.ir.printer import expression as text
from sjdsl.compiler.ir.ranges import range_of
from sjdsl.editor.highlighting import patterns
from sjdsl.interpreter import numbers
from sjdsl.interpreter.evaluate import is_of_class
from sjdsl.properties.monotonicity import decide_monotone
from tests.fuzz.together import interpret, on_numpy, random_play, run
from tests.verify_ir import verify

ROOT = Path(__file__).parents[2]
WHOLE = (-7, -2, -1, 0, 1, 2, 3, 9)
REAL = (-2.5, -1.5, -0.5, 0.0, 0.5, 1.0, 2.5, 3.75)
by_row = pytest.mark.parametrize("row", CALCULATIONS.values(), ids=lambda row: row.name)


def is_possible(row: Calculation, of: tuple[float, ...]) -> bool:
    """Returns whether a calculation has a value, as guards make sure in a game."""
    return (row.divisor is None or of[row.divisor] != 0) and (
        row.apart is None or of[row.apart[0]] != of[row.apart[1]]
    )


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
        assert found == (row.fold(*of) if is_whole(row, of) else np.float32(row.fold(*of))), of
        assert isinstance(found, int | np.integer) == is_whole(row, of), of


def boxes(row: Calculation) -> Iterator[tuple[tuple[tuple[float, ...], ...], bool]]:
    """Yields for each argument some numbers that it may be, in order; and whether they are whole."""
    random = Random(row.name)
    many = random.choice((2, 3)) if row.most > row.least else row.least
    for turn in range(400):
        of = WHOLE if row.whole_only or turn % 2 else REAL
        yield (
            tuple(tuple(sorted(random.sample(of, random.choice((1, 2, 3))))) for _ in range(many)),
            of is WHOLE,
        )


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
            row, [local(name, of, whole) for name, of in zip("abc", box, strict=False)], whole
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
def test_intervals_that_contradictory_conditions_leave_empty_are_accepted(row: Calculation) -> None:
    """`when n > 0 { when n <= 0 { … n … } }`: the lower end of what `n` can be is above the upper one."""
    for ends in ((1, 0), (0, -1), (5, -5), (inf, 0), (0, -inf), (1.5, 0.0), (0.0, -1e-45)):
        for number in (row.least, row.most):
            low, high = row.interval(*[ends] * min(number, 3))
            assert low == low and high == high, ends  # no NaN


@by_row
def test_every_slope_is_the_direction_that_values_go_in(row: Calculation) -> None:
    decided = 0
    for box, whole in boxes(row):
        for moving in range(len(box)):
            ranges = [range_of(local("a", of, whole)) for of in box]
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


@by_row
def test_what_is_called_a_sum_is_one(row: Calculation) -> None:
    for of in arguments(row):
        assert not row.factors or row.fold(*of) == sum(
            factor * x for factor, x in zip(row.factors, of, strict=True)
        ), of


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
            made = in_the_language(row, numbers[: max(row.least, 2 if row.most > 1 else 1)])
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


def without(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Takes a row out of the table."""
    for table in (CALCULATIONS, FUNCTIONS, REDUCTIONS, PAYOFF_CLASSES):
        monkeypatch.delitem(table, name, raising=False)
    for signs in (INFIX, PREFIX):
        for sign in [sign for sign, row in signs.items() if row.name == name]:
            monkeypatch.delitem(signs, sign)


@by_row
def test_without_its_row_nothing_can_be_done_with_a_calculation(
    row: Calculation, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = every_row()
    built = build(source)
    numbers = [ir.Number(type=ir.Type(kind="int", low=n, high=n), value=n) for n in (5, 2, 3)][
        : row.most
    ]
    made: ir.Expr = node(row, list(numbers), True).model_copy(
        update={"type": ir.Type(kind="int", low=-9, high=9)}
    )
    test = ir.Compare(fn=">", left=made, right=numbers[0])
    consumers: dict[str, Callable[[], object]] = {
        "elaboration": lambda: build(source),
        "checks of the IR": lambda: verify(built.game),
        "the printer": lambda: text(made),
        "`require`": lambda: values.holds(test, {}),
        "facts": lambda: narrowed(
            made, facts(ir.Compare(fn="<", left=numbers[0], right=numbers[0]))
        ),
        "ranges": lambda: range_of(made),
        "ranges of play": lambda: interval_of(made, Here(Played(built.game, {}))),
        "starts": lambda: holds_at_start(test, {}, built.game),
        "lowering": lambda: compile_build(built, source),
        "slopes": lambda: decide_monotone(
            ir.Check(sort="monotone", words=("rising",), values=(made, local("a", (1, 2), True))),
            built.game,
        ),
    }
    for consumer in consumers.values():
        consumer()
    without(row.name, monkeypatch)
    assert [name for name, consumer in consumers.items() if not fails(consumer)] == []


def fails(consumer: Callable[[], object]) -> bool:
    try:
        consumer()
    except (KeyError, CompileError):
        return True
    return False


@pytest.mark.parametrize("row", OPERATIONS, ids=lambda row: row.name)
def test_without_its_row_editors_and_pages_do_not_know_a_function(
    row: Function, monkeypatch: pytest.MonkeyPatch
) -> None:
    if row.name not in FUNCTIONS:
        return
    assert f"|{row.name}|" in coloured()
    without(row.name, monkeypatch)
    assert f"|{row.name}|" not in coloured()


def coloured() -> str:
    """Returns the functions that a grammar for editors knows, between bars."""
    found = next(
        p["match"]
        for p in patterns()
        if p.get("captures", {}).get("1", {}).get("name") == "support.function.sj"
    )
    return f"|{found.partition('(')[2].partition(')')[0]}|"


NAMES = {row.name for row in OPERATIONS} | {*INFIX, *PREFIX}
OF_OPERATIONS = {"Arithmetic", "SumRow", "Extreme", "MatrixClass", "Call", "Unary"}
# What stands before the table: the grammar's texts, and words that people try. The interpreter has its own meaning of each row.
NOT_READING = (
    "sjdsl/interpreter",
    "sjdsl/compiler/ir/operations.py",
    "sjdsl/compiler/syntax",
    "sjdsl/compiler/diagnostics",
    "sjdsl/compiler/elaborate/regrouping.py",  # which writes products
    "sjdsl/runtime",
)


def names_matched(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Yields where a program asks whether something is a certain operation, and which."""
    for n in ast.walk(tree):
        asked: list[ast.AST] = []
        match n:
            case ast.Compare(left=left, comparators=others):
                sides = [left, *others]
                if any(
                    isinstance(side, ast.Attribute) and side.attr in ("fn", "op", "text")
                    for side in sides
                ):
                    asked = [*sides]
            case ast.MatchClass(
                cls=ast.Attribute(attr=kind), kwd_attrs=keys, kwd_patterns=found
            ) if kind in OF_OPERATIONS:
                asked = [
                    p for key, p in zip(keys, found, strict=True) if key in ("fn", "op", "name")
                ]
            case ast.Match(subject=ast.Attribute(attr="fn" | "op" | "text"), cases=cases):
                asked = [case.pattern for case in cases]
            case ast.Subscript(
                value=ast.Dict(keys=keys), slice=ast.Attribute(attr="fn" | "op" | "text")
            ):
                asked = [key for key in keys if key is not None]
        for part in asked:
            for inner in ast.walk(part):
                if isinstance(inner, ast.Constant) and inner.value in NAMES:
                    yield inner.lineno, str(inner.value)


def test_nobody_asks_for_an_operation_by_its_name() -> None:
    found = []
    for path in sorted((ROOT / "sjdsl").rglob("*.py")):
        name = path.relative_to(ROOT).as_posix()
        if not name.startswith(NOT_READING) and "/trainers/" not in name:
            found += [
                f"{name}:{line} asks for {what}"
                for line, what in names_matched(ast.parse(path.read_text("utf-8")))
            ]
    assert found == []


@pytest.mark.parametrize(
    "program",
    [
        'e.fn == "+"', 'e.fn in ("min", "max")', '"round" == call.name.text', '{"sum": 1, "min": 2}[e.fn]',
        'match e:\n    case ir.Arithmetic(fn="%" | "quotient" as fn):\n        pass', 'match e.fn:\n    case "min" | "max":\n        pass',
    ],
)  # fmt: skip
def test_asking_for_an_operation_by_its_name_is_seen(program: str) -> None:
    assert list(names_matched(ast.parse(program))) != []
