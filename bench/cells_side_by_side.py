"""Times eight cells of a sweep as one program and one after the other, for docs/sweeps.md: `python bench/cells_side_by_side.py [GAME]`."""

import sys
import time
from pathlib import Path
from typing import Any

import jax

import sjdsl
from sjdsl.trainers import load_preset, make_train
from sjdsl.trainers.compiled import Compiled, compile_train
from sjdsl.trainers.side_by_side import Part, compile_parts


def updates(run: Compiled, state: Any, number: int) -> tuple[Any, float]:
    """Returns the state after some updates, and the seconds that they took."""
    began = time.perf_counter()
    for _ in range(number):
        state, played = run.collect(state)
        state, _ = run.learn(state, played)
    jax.block_until_ready(state)
    return state, time.perf_counter() - began


def compare(game: str = "coins", cells: int = 8, turns: int = 7) -> None:
    """Prints the seconds of one update of each cell, one after the other and side by side."""
    env = sjdsl.make(game)
    given = [{"reward": "exchange", "exchange_ratio": number / cells, "seed": number} for number in range(cells)]
    configs = [load_preset("two_cores", values, game).config for values in given]
    runs = [compile_train(make_train(env, configs[0]), configs[0]), compile_parts([Part(env, config, Path(), {}) for config in configs])]
    states = [run.start() for run in runs]
    for _ in range(turns):
        for which, number in enumerate((cells, 1)):
            states[which], seconds = updates(runs[which], states[which], number)
            print(("apart", "side by side")[which], seconds)


if __name__ == "__main__":
    compare(*sys.argv[1:])
