"""The example player reads all that its messages show, and that is enough to play well."""

import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import sjdsl
from sjdsl.compiler.lower import token_planes
from sjdsl.experiments import cross_play
from sjdsl.interpreter.observe import observe
from sjdsl.interpreter.step import action_mask, reset
from sjdsl.interpreter.threefry import Threefry
from sjdsl.told import Window, message
from tests.told.corpus import game

FILE = Path(__file__).parents[2] / "examples/text_player.py"


def example() -> ModuleType:
    spec = importlib.util.spec_from_file_location("text_player", FILE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_it_reads_the_apples_of_the_window() -> None:
    g = game("open_harvest")
    planes = token_planes(g)
    window = Window(g, planes)
    world = reset(g, {param.name: param.value for param in g.params}, Threefry(3, 0))
    total = 0
    for seen, allowed in zip(observe(g, world), action_mask(g, world), strict=True):
        labels = np.array(planes[0].labels)[seen[0]]
        apples = {
            (g.window.ahead - row, col - g.window.left)
            for row, col in np.argwhere(np.char.startswith(labels.astype(str), "tree"))
            if seen[1, row, col] == 0 and "bare" not in labels[row, col]
        }
        assert set(example().apples_in(message(window, seen, allowed))) == apples
        total += len(apples)
    assert total > 20


@pytest.mark.thorough
def test_it_earns_more_than_the_greedy() -> None:
    """Five of a kind in the same episode, long enough for patches to be eaten bare."""
    env = sjdsl.make("open_harvest", params={"rounds": 1, "length": 150})
    earned = {}
    for name in (f"{FILE}:patient", "greedy"):
        played = cross_play(env, slots=[name] * 5, episodes=1, seed=1)
        earned[name] = played.parts[0].returns.sum()
    assert earned[f"{FILE}:patient"] > 1.2 * earned["greedy"]
