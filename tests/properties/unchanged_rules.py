"""A step beside the same step of agents with other numbers, or on the mirrored map, under the very same rules: what a symmetry says."""

from dataclasses import replace
from random import Random

from sjdsl.compiler import ir
from sjdsl.interpreter.overflow import LeavesFloat32
from sjdsl.interpreter.state import World
from sjdsl.interpreter.step import step
from sjdsl.interpreter.threefry import Recorded
from sjdsl.properties.symmetry import SIDES
from tests.fuzz.numpy_jax import as_array
from tests.fuzz.together import on_numpy, runs_away
from tests.laws.corpus import biased_draws, crowded, some_actions
from tests.laws.obeyed import compiled_difference
from tests.laws.other_draws import NeverDrawn, RunsOut, other_draws, tied
from tests.laws.other_world import other_outcome, other_world, outcome_differences, world_differences
from tests.laws.symmetry import Symmetry, renamed
from tests.properties.random_worlds import as_interpreted, encoded, random_params

STEPS, TRIES = 5, 3


def asymmetry(game: ir.Game, check: ir.Check, random: Random) -> tuple[int, str]:
    """Returns how many steps were compared, and where one differed; no steps where this cannot be told."""
    what = check.words[0]
    if what not in ("agents", "mirror") or (what == "mirror" and _draws_by_place(game)):
        return 0, ""
    compared = 0
    for _ in range(TRIES):
        s = renamed(game, random) if what == "agents" else _mirror(game)
        changed = game if what == "agents" else game.model_copy(update={"rows": s.rows(game.rows), "checks": ()})
        env = on_numpy(changed)
        params = random_params(game, random)
        env.params = replace(env.params, **{name: as_array(value) for name, value in encoded(game, params).items()})
        world = replace(crowded(game, random), params=as_interpreted(game, params))
        for _ in range(STEPS):
            actions, drawn, before = some_actions(game, random, world), Recorded(biased_draws(random)), world
            try:
                world, outcome = step(game, before, actions, before.params, drawn)
                words = other_draws(game, changed, drawn, s)
            except RunsOut:
                continue
            except (LeavesFloat32, AssertionError):  # the interpreter asserts that whole numbers keep to int32
                break
            if runs_away(world):
                break
            if drawn.near or tied(game, drawn):
                continue
            given = [_taken(actions[s.order.index(agent)], game, s) for agent in range(len(actions))]
            start, wanted = other_world(game, changed, before, s), (other_world(game, changed, world, s), other_outcome(game, outcome, s))
            where = _differs(changed, start, given, words, wanted) or compiled_difference(env, start, given, words, wanted)
            if where:
                return compared, f"{s}: {where}"
            compared += 1
    return compared, ""


def _mirror(game: ir.Game) -> Symmetry:
    return Symmetry(len(game.rows), len(game.rows[0]), tuple(range(game.agents.number)), mirror=True)


def _taken(action: int, game: ir.Game, s: Symmetry) -> int:
    """Returns the action that is the same under a symmetry: of an agent by its new number, in a mirror a step to the other side."""
    action, names = s.number(action, game), game.agents.actions
    return names.index(SIDES[names[action]]) if s.mirror and names[action] in SIDES else action


def _draws_by_place(game: ir.Game) -> bool:
    """Returns whether draws are told apart by the places of a shape, or by its lanes: which numbers mirrored ones have is not known here."""
    domains = [n.domain for n in ir.walk(game) if isinstance(n, ir.Each | ir.Pick)]
    return any(isinstance(n, ir.First) for n in ir.walk(game)) or any(
        isinstance(d.restriction, ir.Near) and d.var.sort.what == "cell" for d in domains
    )


def _differs(changed: ir.Game, start: World, actions: list[int], words: object, wanted: tuple[World, object]) -> str:
    try:
        after, outcome = step(changed, start, actions, start.params, words)  # type: ignore[arg-type]
    except NeverDrawn as draw:
        return f"a draw that the first game did not make: {draw}"
    found = world_differences(after, wanted[0]) + outcome_differences(outcome, wanted[1])  # type: ignore[arg-type]
    return found[0] if found else ""
