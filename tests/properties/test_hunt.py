"""The hunter of counterexamples: it finds none of what is proved, and one for each wrong rule of proving that is put back."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from importlib import import_module
from math import inf

import pytest

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.elaborate import arithmetic
from sjdsl.compiler.elaborate.scope import Scope
from sjdsl.compiler.ir import implications, operations, range_arithmetic, ranges
from sjdsl.compiler.ir.operations import Calculation
from sjdsl.compiler.ir.values import holds
from sjdsl.properties import GameFamily, effects, intervals, monotonicity, symmetry
from tests.properties.hunt import Hunted, hunt, hunt_seeds
from tests.properties.test_false_proofs import SEEN, meet, numbers, yard
from tests.properties.test_rounded_numbers import large

Put = Callable[[pytest.MonkeyPatch], None]
FEW, STEPPED = 512, 256


@pytest.mark.thorough
def test_nothing_that_is_proved_of_random_games_is_false() -> None:
    hunted = hunt_seeds(iter(range(90, 200)), 120, FEW)
    assert not hunted.found
    assert sum(hunted.proofs.values()) >= 120
    assert all(hunted.proofs[sort] for sort in ("always", "conserved", "monotone"))


@pytest.mark.thorough
def test_nothing_that_is_proved_of_many_random_games_is_false() -> None:
    hunted = hunt_seeds(iter(range(10_000, 20_000)), 1000, FEW)
    assert not hunted.found


def by_types(*numbers: ir.Expr) -> list[ranges.Range]:
    """Returns the intervals of exact numbers."""
    return [ranges.Range(e.type.low, e.type.high) for e in numbers]


def exact(put: pytest.MonkeyPatch) -> None:
    put.setattr(intervals, "compared", by_types)


def share_to_one(put: pytest.MonkeyPatch) -> None:
    """Of a fraction over a number it is taken for granted that it is a fraction."""
    exact(put)
    result = arithmetic._result

    def clamped(row: Calculation, e: ast.Expr, args: Sequence[ir.Expr], scope: Scope) -> ir.Type:
        made = result(row, e, args, scope)
        is_share = row.share and args[0].type.unit == "fraction"
        return made.model_copy(update={"low": 0.0, "high": 1.0}) if is_share else made

    put.setattr(arithmetic, "_result", clamped)


def without_blocks(put: pytest.MonkeyPatch) -> None:
    put.setattr(effects, "reads_and_blocks", lambda node, _: set(effects.reads(node)))


def without_tables(put: pytest.MonkeyPatch) -> None:
    reads = symmetry._reads_number
    put.setattr(
        symmetry,
        "_reads_number",
        lambda node, sort: "" if isinstance(node, ir.ParamRef) else reads(node, sort),
    )


def ramp_of_the_file(put: pytest.MonkeyPatch) -> None:
    """The order of the ends of a ramp is that of the file's own numbers."""
    values = {"low": 2, "high": 5}
    put.setattr(
        monotonicity,
        "compares",
        lambda a, fn, b, _: holds(ir.Compare(fn=fn, left=a, right=b), values),
    )


def endless(put: pytest.MonkeyPatch) -> None:
    """Whole numbers are never too large, for proofs and for the compiler, which refuses these."""
    put.setattr(import_module("sjdsl.compiler"), "check_whole_numbers", lambda *_: None)
    put.setattr(range_arithmetic, "INT32", (-inf, inf))


def one_size(put: pytest.MonkeyPatch) -> None:
    put.setattr(import_module("sjdsl.properties.verify_properties"), "in_all_sizes", lambda *_: [])


def compared_exactly(put: pytest.MonkeyPatch) -> None:
    """A whole number beside a real isn't rounded."""
    put.setattr(implications, "is_exact", lambda _: True)


def ends_as_whole_numbers(put: pytest.MonkeyPatch) -> None:
    for module in (ranges, operations):
        put.setattr(module, "differ_as_reals", lambda *_: True)


def own_number_of_agents(put: pytest.MonkeyPatch) -> None:
    put.setattr(symmetry, "_forbidden_by_number", lambda _: None)


def without_nan(put: pytest.MonkeyPatch) -> None:
    compared = intervals.compared
    put.setattr(
        intervals, "compared", lambda *numbers: [replace(r, sound=True) for r in compared(*numbers)]
    )


def voting(number: str) -> GameFamily:
    """Returns a game with one agent, or with more, in which nobody can vote for agent 0."""
    rule = "each agent where agent chose vote { give 1 to agent.vote }"
    return large(
        "symmetric agents",
        rule,
        players="1 in 1 .. 4",
        number=number,
        forbid="forbid vote(0) when step >= 0",
    )


SLOPE = "define value = {}  define argument = pot"
FAULTS: dict[str, tuple[Put, Callable[[], GameFamily]]] = {
    "a fraction over a number": (share_to_one, lambda: numbers("always share / 0.1 <= 1")),
    "what blocks a shape": (
        without_blocks,
        lambda: yard(SEEN, "each door { set door.open = yes }"),
    ),
    "an agent who blocks a shape": (
        without_blocks,
        lambda: yard(
            SEEN, "each door { set door.open = yes }  each agent { set agent.tall = yes }"
        ),
    ),
    "a whole table by agent": (without_tables, lambda: meet("set purse = gift")),
    "a sum of a table by agent and an entry of it": (
        without_tables,
        lambda: meet("each agent { give gift[agent] to agent }"),
    ),
    "a ramp whose ends differ": (
        ramp_of_the_file,
        lambda: numbers("monotone value rising in argument", SLOPE.format("ramp(pot, low, high)")),
    ),
    "rounding to float32": (exact, lambda: numbers("always pot * 0.05 <= 0.45")),
    "several roundings": (exact, lambda: numbers("always pot * rate * 10 <= 99")),
    "whole numbers that wrap": (endless, lambda: numbers("always hoard * 10000 >= 0")),
    "other numbers of agents": (one_size, lambda: numbers("always players == 3")),
    "other sizes": (one_size, lambda: numbers("always free == 4")),
    "a guard with a real": (
        compared_exactly,
        lambda: large(
            "always k <= 5", "when n >= 16777211 and n <= 16777216.0 { set k = n - 16777211 }"
        ),
    ),
    "a guard on a sum with a real": (
        compared_exactly,
        lambda: large(
            "always k <= 5",
            "when n + j >= 16777211 and n + j <= 16777216 + 0.0 { set k = n + j - 16777211 }",
        ),
    ),
    "a ramp between whole numbers": (
        ends_as_whole_numbers,
        lambda: large("always not (n < m) or ramp(n, n, m) <= 1"),
    ),
    "more agents than named": (own_number_of_agents, lambda: voting("players")),
    "agents whose number is computed": (own_number_of_agents, lambda: voting("players * 1")),
    "a product with infinity": (without_nan, lambda: large("always pot * 0 <= 0")),
    "the least of NaN and a number": (without_nan, lambda: large("always min(pot, 5) <= 5")),
    "a sum that overflows": (
        without_nan,
        lambda: large("always sum(pot * 0 over grass) in 0 .. 0"),
    ),
}


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.thorough) if name == "a sum that overflows" else name
        for name in FAULTS
    ],
)
def test_a_wrong_rule_is_found(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    put, game = FAULTS[name]
    found = Hunted()
    with monkeypatch.context() as patched:
        put(patched)
        hunt(game(), 1, FEW, found, STEPPED)
    assert found.found
    found = Hunted()
    with suppress(CompileError):  # what is refused is not proved
        hunt(game(), 1, FEW, found, STEPPED)
    assert not found.found
