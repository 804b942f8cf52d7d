"""One value means one value, wherever several may be given."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sjdsl.experiments import cross_play
from sjdsl.library.factory import make
from sjdsl.several import several
from sjdsl.sweeps import Axis, SweepSpec, plan_sweep
from sjdsl.sweeps.running import describe_with_make


@pytest.mark.parametrize(
    "one", ["45", "", 0.5, True, None, Path("a/b"), len, {"a": 1}, np.float32(2), np.array(3)]
)
def test_one_value(one: Any) -> None:
    assert several(one) == (one,)
    assert several([one, one]) == (one, one)
    assert Axis("gamma", one).values == (one,)


@pytest.mark.parametrize(
    "many", [("a", "b"), ["a", "b"], iter("ab"), dict.fromkeys("ab").keys(), np.array(["a", "b"])]
)
def test_several_values(many: Any) -> None:
    assert several(many) == ("a", "b")


def test_a_sweep_of_one_game_and_one_axis() -> None:
    one = SweepSpec("coins", Axis("svo_angle", "45"), {"reward": "svo"}, loggers="wandb")  # type: ignore[arg-type]
    assert (one.games, one.loggers) == (("coins",), ("wandb",))
    assert [cell.values for cell in plan_sweep(one, describe_with_make)] == [{"svo_angle": 45.0}]
    assert SweepSpec(Path("mine.sj")).games == ("mine.sj",)  # type: ignore[arg-type]


def test_one_policy_plays_with_itself() -> None:
    met = cross_play(make("coins", params={"length": 2}), policies="stay", episodes=1)
    assert met.names == ("stay",)
