"""A batch equals a loop: a `vmap` of a step, compiled, gives each environment what it gets alone, also where one of them begins anew."""

from pathlib import Path
from random import Random
from typing import Any

import jax
import numpy as np
import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.syntax.read import read_source
from sjdsl.testing.engines import QUICK
from tests.fuzz.judge import on_jax
from tests.fuzz.together import module_text, on_numpy
from tests.laws.corpus import crowded, game_of, random_games, some_actions
from tests.laws.numpy_state import numpy_state

SOME = (
    "coins",
    pytest.param("clean_up", marks=pytest.mark.slow),
    pytest.param("mushrooms", marks=pytest.mark.thorough),
    pytest.param("pd_arena", marks=pytest.mark.slow),
)
TOGETHER = 5
STEPS = 3
CLOSE = {"rtol": 1e-6, "atol": 1e-6}


def parts(game: ir.Game, random: Random) -> str:
    """Returns where an environment of a batch and the same one alone differ; nothing if they do not."""
    alone = on_numpy(game)
    env = on_jax(game, module_text(game))
    batch = jax.jit(jax.vmap(env._step), compiler_options=QUICK)
    states = [numpy_state(alone, crowded(game, random)) for _ in range(TOGETHER)]
    last = alone.module.episode_length(alone.params) - 2
    states[1] = states[1].replace(
        step=np.int32(last)
    )  # this one ends in the second step, and begins anew
    names = list(vars(states[0]))
    together = env.module.initial_state().replace(
        **{n: np.stack([np.asarray(vars(s)[n]) for s in states]) for n in names}
    )
    for number in range(STEPS):
        keys = np.array([[random.getrandbits(32) for _ in range(2)] for _ in states], np.uint32)
        actions = np.array([some_actions(game, random) for _ in states], np.int32)
        seen, together, reward, done, info = jax.tree.map(
            np.asarray, batch(keys, together, actions)
        )
        info["terminal_state"] = vars(info["terminal_state"])
        for one, words in enumerate(keys.tolist()):
            wanted, state = _alone(alone, tuple(words), states[one], actions[one].tolist())
            got = jax.tree.map(lambda x: x[one], (seen, vars(together), reward, done, info))  # noqa: B023
            differing = _differing(wanted, got)
            if differing:
                return f"step {number} of environment {one}: {differing}"
            states[one] = state
    return ""


def _alone(env: Any, words: tuple[int, int], state: Any, actions: list[int]) -> tuple[Any, Any]:
    with np.errstate(all="ignore"):  # what a guard protects is computed and not used
        ended, reward, done, info = env.advance(words, state, actions)
        after = env.begin(words) if done else ended
        info |= {"terminal_observation": env._observe(ended), "terminal_state": vars(ended)}
        return (env._observe(after), vars(after), reward, done, info), after


def _differing(wanted: Any, got: Any) -> str:
    left, right = (jax.tree_util.tree_leaves_with_path(x) for x in (wanted, got))
    assert [path for path, _ in left] == [path for path, _ in right]
    for (path, a), (_, b) in zip(left, right, strict=True):
        a, b = np.asarray(a), np.asarray(b)
        same = (
            np.allclose(a, b, **CLOSE, equal_nan=True)
            if b.dtype.kind == "f"
            else np.array_equal(a, b)
        )
        if not same:
            return f"{jax.tree_util.keystr(path)}: {a.tolist()} / {b.tolist()}"
    return ""


@pytest.mark.parametrize("name", SOME)
def test_games(name: str) -> None:
    """Some stand for the nine: `tests/games/test_contract.py` plays them all in batches; the campaign tries this law on each."""
    assert not parts(game_of(name), Random(name))


@pytest.mark.thorough
def test_movers() -> None:
    game = build(read_source(Path(__file__).parents[1] / "cases" / "moving.sj")).game
    assert not parts(game, Random(7))


def test_random_programs() -> None:
    for seed, game in random_games(1):
        found = parts(game, Random(seed))
        assert not found, (seed, found)
