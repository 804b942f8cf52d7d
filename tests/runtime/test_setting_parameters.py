"""Parameters are refused where they are set if the game cannot be played with them, by their names and with the limit."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import sjdsl
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.library.parameters import param_values
from sjdsl.runtime.env import Environment

MARKET = """sj 1
game market {
  size  sellers : count = 3 in 1 .. 9
  param price : count = 30
  param most  : count = 3 in 0 .. 5000
  param days  : steps = 30
  param rest  : steps = 3
  param stock : count = { red: 1, green: 2 }
  param worth : reward = 1.5
  param share : fraction = 0.5 in 0.1 .. 0.7
  param liked : word = red
  episode days - 1
  kind floor "."
  map { "........." }
  field pot : 0 .. 1000000 capped = 0
  agents sellers {
    acts stay, wave
    moves relative
    field colour : { red, green } = red
    field coins : 0 .. 1000000 capped = 0
    timer tired
  }
  phase start { each agent { send agent to floor } }
  phase sell {
    each agent {
      set agent.tired = rest
      add price to pot
      add price * most to agent.coins
      tally sold by stock[red] for agent
      when agent.colour is liked { give worth * share to agent }
    }
  }
  schedule tick -> sell
  metrics { event sold  final tired = sum(agent.tired over agent) }
  checks { require price > 0 }
}
"""
STAY = jnp.zeros(3, jnp.int32)


@pytest.fixture(scope="module")
def market(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("games") / "market.sj"
    file.write_text(MARKET)
    return file


@pytest.fixture(scope="module")
def env(market: Path) -> Environment:
    return sjdsl.make(market)


REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "a power of two": ({"price": 2**40}, r"^`price` is 1099511627776, outside 0 \.\. 1073741824$"),
    "four hundred digits": ({"price": 10**400}, r"^`price` is 10+, outside 0 \.\. 1073741824$"),
    "beyond float32": ({"worth": 1e39}, r"^`worth` is 1e\+39, outside -1073741824 \.\. 1073741824$"),
    "a huge whole number for a real": ({"worth": -(10**400)}, r"^`worth` is -10+, outside"),
    "infinity": ({"worth": float("inf")}, "^`worth` is inf, outside"),
    "no number": ({"worth": float("nan")}, r"^`worth` is a number \(reward\), not nan$"),
    "no whole number": ({"price": 3.5}, r"^`price` is a whole number \(count\), not 3.5$"),
    "infinitely many": ({"price": float("inf")}, r"^`price` is a whole number \(count\), not inf$"),
    "outside its range": ({"most": 5001}, r"^`most` is 5001, outside 0 \.\. 5000$"),
    "a step of float32 outside": ({"share": 0.7000002}, r"^`share` is 0.7000002, outside 0.1 \.\. 0.7$"),
    "an array of one": ({"price": np.array([3])}, r"^`price` is a number \(count\), not array\(\[3\]\)$"),
    "a condition": ({"price": np.bool_(True)}, r"^`price` is a number \(count\)"),
    "text": ({"price": "3"}, r"^`price` is a number \(count\), not '3'$"),
    "nothing": ({"price": None}, "^`price` is None: give it a number, or leave it out$"),
    "one number for a table": ({"stock": 3}, "^`stock` wants 2 values: its words are red, green$"),
    "three for two": ({"stock": [1, 2, 3]}, "^`stock` wants 2 values"),
    "a table in a table": ({"stock": [[1, 2], 3]}, r"^`stock\[red\]` is a number \(count\), not \[1, 2\]$"),
    "an entry too large": ({"stock": {"red": 2**31}}, r"^`stock\[red\]` is 2147483648, outside 0 \.\. 1073741824$"),
    "an endless episode": ({"days": 2**40}, r"^`days` is 1099511627776, outside 0 \.\. 1073741824$"),
    "an episode of no steps": ({"days": 1}, "^`days` is 1, and can be 2 at least: the number of steps of an episode is 0, outside 1 .. 2147483647"),
    "a requirement": ({"price": 0}, "^these parameters fail a check of the game: require"),
    "a product": ({"price": 5000000, "most": 5000}, r"^`price` is 5000000, and can be 715827 at most: .*3 times in a phase, this can let `coins`|`price \* most` can become 25000000000"),
    "a sum over agents": ({"rest": 2**30}, r"^`rest` is 1073741824, and can be 715827882 at most: `sum\(agent.tired over agent as agent\)` can become 3221225472; whole numbers end at 2147483647 \(.*market.sj:\d+\)$"),
    "what is added in a phase": ({"price": 800000000, "most": 0}, r"^`price` is 800000000, and can be 715494549 at most: 3 times in a phase, this can let `pot` become 2401000000"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_make_refuses(market: Path, case: str) -> None:
    given, message = REFUSED[case]
    with pytest.raises(ValueError, match=message):
        sjdsl.make(market, params=given)


@pytest.mark.parametrize(("name", "limit"), [("rest", 715827882), ("price", 715494549)])
def test_the_limit_that_is_told_is_the_last_value_that_is_taken(
    env: Environment, name: str, limit: int
) -> None:
    given = {"most": 0} if name == "price" else {}
    assert param_values(env.game, {name: limit, **given})[name] == limit
    with pytest.raises(ValueError, match=f"`{name}` is {limit + 1}, and can be {limit} at most"):
        param_values(env.game, {name: limit + 1, **given})


@pytest.mark.parametrize(
    "given",
    [
        {"sellers": 2**40},
        {"sellers": float("nan")},
        {"sellers": float("inf")},
        {"sellers": 10**400},
        {"sellers": 0},
        {"sellers": 2.5},
    ],
)
def test_sizes_are_refused_too(market: Path, given: dict[str, Any]) -> None:
    with pytest.raises(CompileError, match="`sellers`"):
        sjdsl.make(market, params=given)


def test_with_params_takes_what_make_takes(env: Environment, market: Path) -> None:
    changed = env.with_params(
        env.params.replace(
            price=7,
            worth=np.float64(0.25),
            share=jnp.float32(0.7),
            liked=1,
            stock=jnp.array([5, 6]),
        )
    )
    made = sjdsl.make(
        market,
        params={
            "price": 7,
            "worth": 0.25,
            "share": 0.7,
            "liked": "green",
            "stock": {"red": 5, "green": 6},
        },
    )
    assert jax.tree.map(lambda x: (x.dtype, x.tolist()), changed.params) == jax.tree.map(
        lambda x: (x.dtype, x.tolist()), made.params
    )
    assert changed.with_params(changed.params).episode_length == made.episode_length
    with pytest.raises(TypeError, match="these are not parameters of"):
        env.with_params(sjdsl.make("coins").params)


def played(env: Environment, params: Any) -> Any:
    other = env.with_params(params)
    _, state = other.reset(jax.random.key(0))
    _, state, reward, *_ = other.step(jax.random.key(1), state, STAY)
    return state.world_pot, reward, other.module.episode_length(other.params)


@pytest.mark.parametrize(
    "trace", [jax.jit, lambda f: jax.vmap(f, in_axes=0), lambda f: jax.jit(jax.vmap(f))]
)
def test_traced_parameters_are_taken(env: Environment, trace: Callable[[Any], Any]) -> None:
    batched = trace is not jax.jit
    prices = jnp.array([1, 20, 300]) if batched else jnp.int32(20)
    found = trace(lambda price: played(env, env.params.replace(price=price, days=9)))(prices)
    assert found[0].tolist() == ([3, 60, 900] if batched else 60)
    assert found[2].tolist() == ([8, 8, 8] if batched else 8)
    with pytest.raises(
        ValueError, match=r"`most` is 5001, outside 0 \.\. 5000"
    ):  # of the others the values are known
        trace(lambda price: played(env, env.params.replace(price=price, most=5001)))(prices)
    with pytest.raises(ValueError, match=r"`price` is float32\[\], and int32\[\] is wanted"):
        trace(lambda price: played(env, env.params.replace(price=price)))(
            prices.astype(jnp.float32)
        )


def test_a_step_takes_arrays_of_its_game_only(env: Environment) -> None:
    _, state = env.reset(jax.random.key(0))
    with pytest.raises(ValueError, match=r"`price` is int32\[2\], and int32\[\] is wanted"):
        env.step(jax.random.key(0), state, STAY, env.params.replace(price=jnp.array([1, 2])))
    both = jax.tree.map(
        lambda *leaves: jnp.stack(leaves), env.params, env.params.replace(price=jnp.int32(8))
    )
    after = jax.vmap(env.step, in_axes=(None, None, None, 0))(jax.random.key(0), state, STAY, both)[
        1
    ]
    assert after.world_pot.tolist() == [90, 24]
