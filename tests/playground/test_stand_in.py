"""The stand-in for NumPy in the playground, against NumPy: number by number, function by function, game by game."""

import importlib.util
import math
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from sjdsl.library.games_folder import bundled

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "editors" / "playground"
GAMES = ("coins", "open_harvest")  # the second with a split of tasks, timers and what they forbid


def load() -> ModuleType:
    """Returns the stand-in under another name."""
    spec = importlib.util.spec_from_file_location(
        "stand_in", FOLDER / "numpy/__init__.py", submodule_search_locations=[str(FOLDER / "numpy")]
    )
    assert spec is not None and spec.loader is not None
    module = sys.modules["stand_in"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


own = load()
REALS = st.floats(width=32, allow_nan=False) | st.integers(-100, 100).map(float)
OPERATORS = (
    "add",
    "sub",
    "mul",
    "truediv",
    "mod",
    "lt",
    "le",
    "eq",
    "radd",
    "rsub",
    "rmul",
    "rtruediv",
)


def same(mine: Any, theirs: Any) -> bool:
    return bool(mine == theirs) or (math.isnan(mine) and math.isnan(theirs))


@given(
    REALS,
    REALS
    | st.floats(allow_nan=False, allow_infinity=False, width=64)
    | st.integers(-(2**31), 2**31),
    st.sampled_from(OPERATORS),
)
def test_reals_of_32_bits(left: float, right: float, name: str) -> None:
    assume(abs(right) < 3e38 or math.isinf(right))
    assume(name != "mod" or np.float32(right) != 0)  # guarded by the compiler
    with np.errstate(all="ignore"):
        theirs = getattr(np.float32(left), f"__{name}__")(right)
        mine = getattr(own.float32(left), f"__{name}__")(right)
        assert same(mine, theirs), (mine, theirs)
        if name not in ("lt", "le", "eq"):
            assert type(mine) is own.float32
            assert math.copysign(1, mine) == math.copysign(1, theirs) or math.isnan(mine)


@given(st.floats(width=32, allow_nan=False))
def test_reals_are_written_as_numpy_writes_them(value: float) -> None:
    assert float(str(own.float32(value))) == float(str(np.float32(value)))
    assert f"{own.float32(value):.7g}" == f"{np.float32(value):.7g}"


@given(REALS, REALS, st.sampled_from(("add", "sub", "mul", "truediv")))
@example(1e30, 1e30, "mul")  # finite in 64 bits
@example(1.0, 2.0**-148, "truediv")
@example(3e38, 3e38, "add")
def test_what_leaves_32_bits_is_noticed(left: float, right: float, name: str) -> None:
    assume(not (name == "truediv" and right == 0))

    def raises(module: Any) -> bool:
        try:
            with module.errstate(over="raise", invalid="raise"):
                getattr(module.float32(left), f"__{name}__")(module.float32(right))
        except FloatingPointError:
            return True
        return False

    with np.errstate(all="ignore"):
        assert raises(own) == raises(np)


# expressions of `n`, which is NumPy or the stand-in
CASES = """
n.zeros((2, 3), int) + n.arange(3)
n.array([[1, 2], [3, 4]])[:, 1]
n.array([[1, 2], [3, 4]])[n.array([1, 0, 1])]
n.array([[1, 2], [3, 4]])[n.array([1, 0]), n.array([0, 0])]
n.array([[1, 2, 3], [4, 5, 6]])[:, n.array([[0, 2], [1, 1]])]
n.array([1, 2, 3])[n.array([True, False, True])]
n.arange(4)[:, None] == n.array([0, 2])[None]
n.arange(6).reshape(2, 3).sum(axis=1)
n.arange(6).reshape(2, 3).min(axis=0)
n.arange(6).reshape(2, -1).T
n.arange(6).reshape(2, 3)[1, 1:]
n.array([1.5, 2.5]) * 2 - 1
n.array([3, -3]) // 2 + n.array([3, -3]) % 2
n.array([1, 2]) / 2
-n.array([1, -2])
~n.array([True, False]) | n.array([False, False])
n.where(n.array([True, False]), n.array([1, 2]), -1)
n.clip(n.array([-1, 5, 9]), 0, 7)
n.isin(n.array(['a', 'b']), ('b', 'c'))
n.equal(n.array(['a', 'b']), 'b')
n.array(['a', 'b'])[n.array([1, 1, 0])]
n.logical_and.reduce(n.broadcast_arrays(n.array([True, True, False]), n.array([True])))
n.ceil(n.array([0.1, 2.0]) / 0.5).astype(int)
n.bitwise_count(n.array([0, 5, 255]))
n.stack([n.arange(3), n.array([True, False, True]).astype(int)], axis=1)
n.stack([n.arange(4).reshape(2, 2), n.ones((2, 2), int)], axis=-1)
n.flatnonzero(n.array([[0, 3], [1, 0]]))
n.nonzero(n.array([['a', 'b'], ['b', 'b']]) == 'b')[1]
n.divmod(n.array([7, -1]), 3)[0]
n.minimum(n.array([1, 9]), 4)
n.full((2, 2), 7, n.uint8) + n.array([250, 1]).astype(n.uint8)
n.array([300, -1]).astype(n.uint8)
n.unique(n.array([[2, 1], [0, 1], [2, 1]]), axis=0, return_inverse=True)[0]
n.unique(n.array([[2, 1], [0, 1], [2, 1]]), axis=0, return_inverse=True)[1].reshape(-1)
n.unique(['b', 'a', 'b'], return_counts=True)[1]
n.meshgrid(n.arange(2), n.arange(3), indexing='ij')[1]
n.argmin(n.array([3, 1, 1]))
(n.arange(3) == n.arange(3)).all()
n.reshape(n.array(3), -1)
n.zeros_like(n.array([True, True]))
written(n.zeros((3, 2), bool), (n.array([0, 2]), n.array([1, 0])), True)
written(n.zeros((2, 3), int), (0,), n.array([4, 5, 6]))
written(n.zeros(4, n.bool_).reshape(-1, 2), ([1],), True)
written(n.arange(4), (n.arange(4) > 1,), 0)
""".strip().splitlines()


def written(array: Any, key: tuple[Any, ...], value: Any) -> Any:
    array[key if len(key) > 1 else key[0]] = value
    return array


@pytest.mark.parametrize("case", CASES)
def test_functions(case: str) -> None:
    theirs, mine = (eval(case, {"n": module, "written": written}) for module in (np, own))
    if isinstance(theirs, np.ndarray):
        assert mine.shape == theirs.shape
        assert mine.dtype.kind == theirs.dtype.kind
        assert mine.tolist() == theirs.tolist()
    else:
        assert mine == theirs


def test_a_wrong_place_is_an_error() -> None:
    with pytest.raises(IndexError):
        own.arange(3)[3]
    with pytest.raises(ValueError, match="do not fit"):
        own.arange(3) + own.arange(4)


def answered(path: list[Path], games: tuple[str, ...]) -> list[str]:
    command = [sys.executable, str(Path(__file__).with_name("numpy_answers.py")), *games]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(map(str, [*path, ROOT]))}
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, env=environment, cwd=ROOT
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@pytest.mark.parametrize(
    "games",
    [GAMES, pytest.param(tuple(bundled()), marks=pytest.mark.thorough)],
    ids=["two", "all"],
)
def test_the_studio_answers_the_same(games: tuple[str, ...]) -> None:
    with_numpy, without = answered([], games), answered([FOLDER], games)
    assert (with_numpy[0], without[0]) == ("site-packages", "playground")
    assert without[1:] == with_numpy[1:]
