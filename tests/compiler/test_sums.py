"""What conditions on sums prove of other sums, and the intervals of whole quotients and of rounding."""

from itertools import product
from pathlib import Path
from random import Random

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import sjdsl
from sjdsl.compiler import ir
from sjdsl.compiler.ir.implications import facts, narrowed
from sjdsl.compiler.ir.operations import CALCULATIONS, COMPARISONS
from sjdsl.compiler.ir.types import integer
from tests.compiler.refusals import codes_in

QUOTIENT = CALCULATIONS["quotient"].interval
GAME = """sj 1
game frame "Sums" {{
  episode 9
  param p : probability = 0.2
  param q : probability = 0.2
  param r : probability = 0.6
  param much : number = 2 in -9 .. 9
  kind grass "."
  map {{ "...." }}
  agents 2 {{
    acts stay, leave
    field held : 0 .. 9 = 0
    field owed : 0 .. 9 = 0
  }}
  phase start {{ each agent {{ send agent to grass }} }}
  schedule tick -> rule -> go
  phase rule {{ {body} }}
  phase go {{ {go} }}
  checks {{ require {required} }}
}}
"""
AWAY = "each agent where agent chose leave { send agent to grass after 2 }"


def codes(body: str, required: str = "p >= 0", go: str = "") -> set[str]:
    return codes_in(GAME.format(body=body, required=required, go=go))


@pytest.mark.parametrize(
    ("required", "chance"),
    [
        ("p + q <= 1", "1 - p - q"),
        ("p + q <= 1", "p + q"),
        ("q + p < 1", "1 - (p + q)"),
        ("p + q + r <= 1", "1 - q - r"),
        ("1 >= r + p", "1 - p - r"),
        ("p <= q", "q - p"),
        ("p - q in 0 .. 1", "p - q"),
        ("p + q + r == 1", "p + r"),
    ],
)
def test_a_requirement_on_a_sum_is_a_guard(required: str, chance: str) -> None:
    assert codes(f"chance {chance} {{ end }}") == {"SJ202"}
    assert codes(f"chance {chance} {{ end }}", required) == set()


@pytest.mark.parametrize(
    ("required", "chance"),
    [("p + q <= 1.5", "1 - p - q"), ("p + q >= 1", "1 - p - q"), ("p + q <= 1", "1 - p - q - r")],
)
def test_another_requirement_is_none(required: str, chance: str) -> None:
    assert codes(
        f"chance {chance} {{ end }}",
        f"{required} or p < 2" if required.startswith("p + q >=") else required,
    ) >= {"SJ202"}


def test_a_guard_keeps_a_difference_in_its_range() -> None:
    assert (
        codes(
            "each agent where agent.held >= agent.owed { set agent.held = agent.held - agent.owed }"
        )
        == set()
    )
    assert (
        codes(
            "each agent where agent.held > agent.owed { set agent.held = agent.held - agent.owed - 1 }"
        )
        == set()
    )
    assert (
        codes(
            "each agent where agent.held + agent.owed < 10 { set agent.held = agent.owed + agent.held }"
        )
        == set()
    )
    assert codes(
        "each agent where agent.held + agent.owed < 11 { set agent.held = agent.owed + agent.held }"
    ) == {"SJ204"}
    assert codes(
        "each agent where agent.held >= agent.owed { set agent.held = agent.held - agent.owed - 1 }"
    ) == {"SJ204"}


def test_what_rounding_brings_below_0_is_no_chance(tmp_path: Path) -> None:
    """In float32 1 - p - q is negative here, and a negative probability would be a large one as an unsigned number."""
    assert np.float32(1) - np.float32(0.6) - np.float32(0.4) < 0
    body = "chance 1 - p - q { end }  each agent { draw n from { 3: 1 - p - q, 7: p, 9: q } give pay * n to agent }"
    text = GAME.format(body=body, required="1 - p - q + p + q == 1  require p + q <= 1", go="")
    text = text.replace(
        "p : probability = 0.2", "p : probability = 0.6  param pay : reward = 1"
    ).replace("q : probability = 0.2", "q : probability = 0.4")
    (tmp_path / "frame.sj").write_text(text)
    env = sjdsl.make(tmp_path / "frame.sj")
    _, state = env.reset(jax.random.key(0))
    for number in range(20):
        _, _, reward, done, _ = env.step_env(jax.random.key(number), state, jnp.zeros(2, jnp.int32))
        assert not done
        assert set(np.asarray(reward).tolist()) <= {7, 9}


def test_agents_who_cannot_be_away_are_always_some() -> None:
    divided = "give 1 / count(agent) to all"
    assert codes(divided) == set()
    assert codes(divided, go=AWAY) == {"SJ207"}
    assert codes("each agent { give 1 / count(agent as other) to agent }", go=AWAY) == set(), (
        "somebody is there"
    )
    assert codes("give 1 / count(agent on grass) to all") == {"SJ207"}


def test_intervals_of_sums_hold_whatever_the_facts() -> None:
    """Random sums of three numbers under random conditions, against all their values."""
    random = Random(0)
    names = ("a", "b", "c")

    def made() -> ir.Expr:
        parts = [
            ir.Local(type=integer(low, low + 3, "number"), name=name)
            for name, low in zip(names, lows, strict=True)
        ]
        number = random.randint(-2, 2)
        found: ir.Expr = ir.Number(type=integer(number, number, "number"), value=number)
        for _ in range(random.randint(1, 4)):
            part = random.choice(parts)
            fn = random.choice("+-")
            low, high = CALCULATIONS[fn].interval(
                (found.type.low, found.type.high), (part.type.low, part.type.high)
            )
            type_ = integer(low, high, "number")
            found = ir.Arithmetic(type=type_, fn=fn, args=(found, part))
        return found

    def value(e: ir.Expr, values: dict[str, int]) -> int:
        match e:
            case ir.Local():
                return values[e.name]
            case ir.Number():
                return int(e.value)
            case ir.Arithmetic(fn=fn, args=(x, y)):
                return value(x, values) + (1 if fn == "+" else -1) * value(y, values)
        raise AssertionError(e)

    narrower = 0
    for _ in range(400):
        lows = [random.randint(-2, 2) for _ in names]
        told = [
            ir.Compare(fn=random.choice(list(COMPARISONS)), left=made(), right=made())
            for _ in range(random.randint(1, 2))
        ]  # type: ignore[arg-type]
        asked = made()
        low, high = narrowed(asked, [fact for test in told for fact in facts(test)])
        narrower += (low, high) != (asked.type.low, asked.type.high)
        for values in product(*(range(low_, low_ + 4) for low_ in lows)):
            here = dict(zip(names, values, strict=True))
            if all(
                COMPARISONS[test.fn].holds(value(test.left, here), value(test.right, here))
                for test in told
            ):
                assert low <= value(asked, here) <= high, (told, asked)
    assert narrower > 50, "the facts are used"


def test_the_interval_of_a_whole_quotient_is_the_least_that_holds() -> None:
    for a, b, c, d in product(range(-4, 5), range(0, 4), range(-4, 5), range(0, 4)):
        values = {x // y for x in range(a, a + b + 1) for y in range(c, c + d + 1) if y}
        if values:
            assert QUOTIENT((a, a + b), (c, c + d)) == (min(values), max(values))


def test_the_interval_of_a_quotient_of_endless_numbers() -> None:
    endless = float("inf")
    assert QUOTIENT((0, endless), (1, endless)) == (0, endless)
    assert QUOTIENT((-3, 5), (2, endless)) == (-2, 2)


def test_rounding_stays_inside_its_interval_in_float32_too() -> None:
    random = np.random.default_rng(0)
    ends = np.sort(random.uniform(-9, 9, (2000, 2)), axis=1)
    for low, high in [*ends, *((np.floor(a) + 0.5, np.floor(b) + 0.5) for a, b in ends)]:
        found = CALCULATIONS["round"].interval((float(low), float(high)))
        for x in (low, high, (low + high) / 2):
            for near in (
                np.float32(x),
                np.nextafter(np.float32(x), np.float32(99)),
                np.nextafter(np.float32(x), np.float32(-99)),
            ):
                assert found[0] <= np.rint(near) <= found[1], (low, high, near)


def test_a_quotient_by_0_alone_is_bounded_by_what_is_divided() -> None:
    """Such a divisor stands where nothing is ever divided: behind `k != 0 and k <= 0`, for example."""
    assert QUOTIENT((-4, 9), (0, 0)) == (-9, 9)
