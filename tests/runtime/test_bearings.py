"""`steps_ahead` and `steps_right`, beside the plane of complex numbers; and what a define shows of the observer."""

from pathlib import Path

import numpy as np
import pytest

from sjdsl.compiler import build
from sjdsl.compiler.syntax.read import read_source
from sjdsl.interpreter.observe import observe
from sjdsl.interpreter.planes import planes
from tests.fuzz import together as quick

CASE = Path(__file__).parents[1] / "cases" / "bearings.sj"
FAR = 7  # added to what is shown
FACING = (-1j, 1, 1j, -1)  # north, east, south, west: columns + rows * 1j, downwards


def shorter(steps: int, size: int) -> int:
    """Returns the shortest of the ways round with the same end; the positive one of two."""
    return min((steps + round_ * size for round_ in (-1, 0, 1)), key=lambda n: (abs(n), -n))


@pytest.mark.parametrize("variants", [(), ("wraps",)], ids=["edges", "wraps"])
def test_both_forms_and_the_plane_agree(variants: tuple[str, ...]) -> None:
    game = build(read_source(CASE), variants).game
    rows, cols = len(game.rows), len(game.rows[0])
    names = [plane.name for plane in planes(game)]
    seen = set()
    for seed in range(3):
        play = quick.random_play(game, seed=seed, steps=40)
        history = quick.interpret(game, play)
        report = quick.run(quick.on_numpy(game), play, history)
        assert not report.differences, report.differences
        for world in (moment.ended for moment in history.moments):
            observation = observe(game, world)
            for agent, place in enumerate(world.position):
                home = world.agents["home"][agent]
                if place is None or home is None:
                    continue
                way = complex(home.col - place.col, home.row - place.row)
                turned = way / FACING[world.heading[agent]]
                ahead, right = round(turned.real), round(turned.imag)
                if variants:
                    is_north_or_south = world.heading[agent] % 2 == 0
                    along, across = (rows, cols) if is_north_or_south else (cols, rows)
                    ahead, right = shorter(ahead, along), shorter(right, across)
                shown = observation[agent, :, 0, 0]
                assert shown[names.index("agent.ahead_of_home")] == ahead + FAR
                assert shown[names.index("agent.right_of_home")] == right + FAR
                assert shown[names.index("agent.faces_home")] == (right == 0)
                seen.add((np.sign(ahead), np.sign(right)))
    assert len(seen) == 9, "home was on every side"
