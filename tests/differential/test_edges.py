"""Reals that decide: a comparison on the edge comes out as float32 says, where one operation rounded otherwise would turn it.

Each row of the table is an expression and what NumPy makes of it, operation by operation. A game compares all of them with the values of
NumPy, for many numbers at once, and must find each of them equal: with parameters as arguments and as constants of the program, in a
batch, in a loop, at a reset, in the forms for GPUs, and as a standalone module.
"""

import math
import sys
from collections.abc import Callable
from fractions import Fraction
from functools import reduce
from types import ModuleType
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.emit.standalone import standalone
from sjdsl.compiler.lower import lower
from sjdsl.interpreter.threefry import Threefry
from sjdsl.runtime.forms import forced
from tests.fuzz.judge import on_jax
from tests.fuzz.together import module_text

Reals = Any  # float32 of NumPy
F = np.float32
T, P, R = F(3), F(0.1), F(0.3)  # the parameters
MANY = 300
RANDOM = np.random.default_rng(5)
NUMBERS = RANDOM.random((2, MANY)).astype(F) * F(8)
BAGS = RANDOM.integers(1, 10, (3, MANY))
SHARES = BAGS.astype(F) / BAGS.sum(axis=0).astype(F)
PAY = F(0.1), F(0.3), F(0.7)


def once(*terms: Reals) -> Reals:
    """Returns exact sums, rounded once."""
    return np.array(
        [nearest(sum(map(Fraction, map(float, each)))) for each in zip(*terms, strict=True)], F
    )


def nearest(exact: Fraction) -> Reals:
    """Returns the float32 nearest to a number, of two the even one."""
    if not exact:
        return F(0)
    last_bit = Fraction(2) ** (math.frexp(float(exact))[1] - 24)
    return F(float(round(exact / last_bit) * last_bit))


def in_order(*terms: Reals) -> Reals:
    """Returns sums, each addition rounded."""
    return reduce(np.add, terms)


def ramp(value: Reals, zero_at: Reals, one_at: Reals) -> Reals:
    return np.clip((value - zero_at) / (one_at - zero_at), F(0), F(1))


EXPRESSIONS: dict[str, Callable[[Reals, Reals], Reals]] = {
    "x * p + y": lambda x, y: x * P + y,
    "y - x * p": lambda x, y: y - x * P,
    "-(x * p) + y": lambda x, y: -(x * P) + y,
    "x * p - y * r": lambda x, y: x * P - y * R,
    "min(x * p, y) + y": lambda x, y: np.minimum(x * P, y) + y,
    "(case step { 0: x * p, 1..: y }) + y": lambda x, y: x * P + y,
    "x / t": lambda x, _: x / T,
    "x / 7": lambda x, _: x / F(7),
    "x / t / r": lambda x, _: x / T / R,
    "x / (t / r)": lambda x, _: x / (T / R),
    "x / t * p": lambda x, _: x / T * P,
    "x * p * r": lambda x, _: x * P * R,
    "x + p + r": lambda x, _: x + P + R,
    "p - x + r": lambda x, _: P - x + R,
    "x * 0.1 * 0.7": lambda x, _: x * F(0.1) * F(0.7),
    "ramp(x, p, t) * y": lambda x, y: ramp(x, P, T) * y,
    "ramp(x * p, r, t) * y + x": lambda x, y: ramp(x * P, R, T) * y + x,
    "sum(agent.share * p over agent)": lambda x, y: once(x * P, y * P, (x - y) * P),
    "sum(agent.share over agent) * r + y": lambda x, y: once(x, y, x - y) * R + y,
    "sum(p over agent where agent.share > 0)": lambda x, y: once(
        P * (x > 0), P * (y > 0), P * (x > y)
    ),
    "pay[mix(bag)] * y": lambda _, y: (
        in_order(*(shares * pay for shares, pay in zip(SHARES, PAY, strict=True))) * y
    ),
    "stored + y": lambda x, y: x * P + y,
    "pot": lambda x, y: once(x * P, y * P, (x - y) * P, x, np.full_like(x, R)),
}


def game_text() -> str:
    """Returns the rules: what is stored and added up in one phase is compared in the next."""
    fields = "".join(
        f"  field want_{i} : reward  field hit_{i} : {{ no_, yes_ }} = no_\n"
        for i in range(len(EXPRESSIONS))
    )
    tests = "".join(
        f"    when {text} == want_{i} {{ set hit_{i} = yes_ }}\n"
        for i, text in enumerate(EXPRESSIONS)
    )
    return f"""sj 1
game edges "Comparisons on the edge" {{
  param t : number = 3 in 1 .. 9  param p : number = 0.1 in 0.01 .. 0.9  param r : number = 0.3 in 0.01 .. 0.9
  param low : number = 0 in -9 .. 9  param base : number = 0 in -9 .. 9
  param pay by {{ red, blue, grey }} : number = {{ red: 0.1, blue: 0.3, grey: 0.7 }}
  episode 50
  field x : reward  field y : reward  field stored : reward  field pot : reward
  field bag by {{ red, blue, grey }} : 1 .. 9 = 1
  field begun : {{ no_, yes_ }} = no_  field drawn : {{ no_, yes_ }} = no_
{fields}
  kind land "."
  map {{ "...." }}
  agents 3 {{ acts stay, left, right  field share : reward }}
  phase start {{
    each agent {{ send agent to land }}
    when low * p + base >= 0 {{ set begun = yes_ }}
    chance min(1, max(0, low * p + base)) {{ set drawn = yes_ }}
  }}
  phase keep {{
    set stored = x * p
    each agent {{ add agent.share * p to pot }}
    add x to pot  add r to pot
  }}
  phase compare {{
{tests}  }}
  schedule keep -> compare
  observe {{ window ahead 1, behind 1, left 1, right 1 }}
}}
"""


WANTED = {f"world_want_{i}": fn(*NUMBERS) for i, fn in enumerate(EXPRESSIONS.values())}


def states(env: Any) -> Any:
    """Returns a batch of states with the numbers and what the expressions are wanted to be."""
    x, y = NUMBERS
    begun = env.reset(jax.random.key(0))[1]
    batch = jax.tree.map(lambda leaf: np.broadcast_to(leaf, (MANY, *leaf.shape)), begun)
    return batch.replace(
        world_x=x,
        world_y=y,
        world_bag=BAGS.T.astype(np.uint8),
        agent_share=np.stack([x, y, x - y], axis=1),
        **WANTED,
    )


def missed(after: Any) -> dict[str, int]:
    """Returns the expressions that were not equal to what NumPy makes of them, and how often."""
    counts = {
        text: int((np.asarray(getattr(after, f"world_hit_{i}")) != 1).sum())
        for i, text in enumerate(EXPRESSIONS)
    }
    return {text: count for text, count in counts.items() if count}


def step(env: Any, params: Any, state: Any) -> Any:
    return env.step(jax.random.key(1), state, jnp.zeros(3, jnp.int32), params)[1]


def as_arguments(env: Any) -> Any:
    return jax.jit(jax.vmap(lambda params, state: step(env, params, state), (None, 0)))(
        env.params, states(env)
    )


def as_constants(env: Any) -> Any:
    return jax.jit(jax.vmap(lambda state: step(env, env.params, state)))(states(env))


def in_a_loop(env: Any) -> Any:
    one_by_one = jax.jit(
        lambda batch: jax.lax.scan(
            lambda _, state: (None, step(env, env.params, state)), None, batch
        )[1]
    )
    return one_by_one(states(env))


@pytest.fixture(scope="module")
def env() -> Any:
    game = build(Source("edges.sj", game_text())).game
    return on_jax(game, module_text(game))


THOROUGH = pytest.mark.thorough


@pytest.mark.parametrize(
    "manner",
    [
        as_constants,
        pytest.param(as_arguments, marks=THOROUGH),
        pytest.param(in_a_loop, marks=THOROUGH),
    ],
)
def test_what_decides_is_float32(env: Any, manner: Callable[[Any], Any]) -> None:
    assert not missed(manner(env))


@THOROUGH
def test_what_decides_is_float32_in_the_forms_for_gpus(env: Any) -> None:
    with forced("gpu"):
        assert not missed(as_constants(env))


@THOROUGH
def test_what_decides_is_float32_in_a_standalone_module(
    env: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    module = ModuleType("alone")
    monkeypatch.setitem(sys.modules, "alone", module)
    exec(standalone(lower(env.game, "edges.sj")), module.__dict__)
    assert not missed(as_constants(module.Environment()))


def test_a_reset_decides_as_a_step_does(env: Any) -> None:
    """The state is constant there, and the key as well: only parameters are not."""
    low = NUMBERS[0]
    base = -(low * P)

    def begun(low: jax.Array, base: jax.Array) -> jax.Array:
        return env.reset(jax.random.key(0), env.params.replace(low=low, base=base))[1].world_begun

    assert (np.asarray(jax.jit(jax.vmap(begun))(low, base)) == 1).all()


def test_chances_are_float32(env: Any) -> None:
    """Of sums just above a draw: if the product were not rounded before, an eighth of the draws would come out otherwise."""
    (stream,) = (node.stream for node in ir.walk(env.game.start) if isinstance(node, ir.Chance))
    keys = np.random.default_rng(6).integers(0, 2**32, (MANY, 2), np.uint32)
    drawn = np.array([Threefry(int(a), int(b)).bits(stream, 0) >> 1 for a, b in keys])
    low, rate = F(5) + NUMBERS[0] / F(4), F(0.9)
    product = low * rate
    base = F((drawn // 2**10 + 1) / 2**21) - product
    expected = drawn < (product + base) * F(2**31)
    fused = drawn < (low.astype(float) * rate + base).astype(F) * F(2**31)
    assert (expected != fused).sum() > MANY / 16

    def happens(key: jax.Array, low: jax.Array, base: jax.Array) -> jax.Array:
        return env.reset(key, env.params.replace(low=low, base=base, p=rate))[1].world_drawn

    np.testing.assert_array_equal(
        np.asarray(jax.jit(jax.vmap(happens))(keys, low, base)) == 1, expected
    )
