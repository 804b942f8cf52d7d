"""The optimisation passes: what each changes, that the rules still fit together, that no value and no draw changes."""

import re
from functools import cache
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.elaborate import Overrides
from sjdsl.compiler.emit.module import render
from sjdsl.compiler.ir import printer
from sjdsl.compiler.ir.traverse import rewrite
from sjdsl.compiler.ir.verify import verify
from sjdsl.compiler.lower import lower
from sjdsl.compiler.optimise import PASSES, Pass, optimise
from sjdsl.compiler.optimise.drop_impossible import drop_impossible
from sjdsl.compiler.optimise.drop_unused import drop_unused
from sjdsl.compiler.optimise.fold_constants import fold_constants
from sjdsl.compiler.syntax.read import read_source
from sjdsl.factory import load_module

ROOT = Path(__file__).parents[2]
GAMES = sorted((ROOT / "games").glob("*.sj"))
CASES = sorted((ROOT / "tests" / "cases").glob("*.sj"))
FIVE = ("coins", "harvest_open", "harvest_closed", "harvest_partnership", "clean_up")
STEPS = 50

pytestmark = pytest.mark.usefixtures("strict_jax")

FRAME = """sj 1
game frame "A frame for statements" {{
  param luck : probability = 0.5
  episode 10
  kind grass "."
  kind tree  "T" {{ field fruit : {{ none, ripe }} = ripe }}
  kind pond  "o" {{ field fish : {{ none, some }} = none }}
  map {{ ".T.T" }}
  agents 2 {{ acts stay, shake  field bag : 0 .. 9 capped = 0 }}
  shape ray = line(2)
  phase start {{ each agent {{ send agent to grass }} }}
  schedule rule
  phase rule {{
    {rule}
  }}
  metrics {{ event seen }}
}}
"""


# What each pass changes


def framed(rule: str) -> ir.Game:
    return build(Source("frame.sj", FRAME.format(rule=rule))).game


def shown(game: ir.Game) -> list[str]:
    """Returns the schedule as text, without streams (they are made from the text as it was) and without types."""
    lines = printer.game(game, positions=False).splitlines()
    begin = next(i for i, line in enumerate(lines) if line.startswith("  schedule"))
    end = next(i for i, line in enumerate(lines) if i > begin and re.match(r"  \S", line) and not line.startswith("  schedule"))
    return [re.sub(r"  : .*", "", line) for line in lines[begin:end] if "stream:" not in line]


# pass, statements before, statements after
CHANGES: list[tuple[Pass, str, str]] = [
    (fold_constants, "each agent { when 2 + 3 * 2 > 7 and agent chose shake { give 1 to agent } }", "each agent { when agent chose shake { give 1 to agent } }"),
    (fold_constants, "each agent { when 1 > 2 or agent chose shake { give 1 to agent } }", "each agent { when agent chose shake { give 1 to agent } }"),
    (fold_constants, "each agent where not not (agent on tree) { give 1 to agent }", "each agent where agent on tree { give 1 to agent }"),
    (fold_constants, "each agent { set agent.bag = 7 % 4 - 1 }", "each agent { set agent.bag = 2 }"),
    (fold_constants, "each tree where tree.fruit is ripe and tree.col == 1 { set tree.fruit = none }", ""),
    (drop_impossible, "each agent { chance 0 { give 1 to agent } otherwise chance luck { give 2 to agent } otherwise { give 3 to agent } }", "each agent { chance luck { give 2 to agent } otherwise { give 3 to agent } }"),
    (drop_impossible, "each agent { chance luck { give 1 to agent } otherwise chance 0 { give 2 to agent } otherwise { give 3 to agent } }", "each agent { chance luck { give 1 to agent } otherwise { give 3 to agent } }"),
    (drop_impossible, "each agent { chance 0 { give 1 to agent } otherwise { give 3 to agent } }", "each agent { give 3 to agent }"),
    (drop_impossible, "each agent { chance 1 { give 1 to agent } otherwise { give 3 to agent } }", "each agent { give 1 to agent }"),
    (drop_impossible, "each agent { chance luck { give 1 to agent } otherwise chance 1 { give 2 to agent } }", ""),
    (drop_impossible, "each pond where pond.fish is some { set pond.fish = none }  give 1 to all", "give 1 to all"),
    (drop_impossible, "each agent on pond { give 1 to agent }  give 1 to all", "give 1 to all"),
    (drop_impossible, "pick 1 pond { set pond.fish = some } otherwise { tally seen }", "tally seen"),
    (drop_impossible, "each agent { each pond in ray of agent { give 1 to agent } }  give 1 to all", "give 1 to all"),
    (drop_unused, "each agent { let a = count(tree)  let b = a + 1  draw c from 1 .. 6  give 1 to agent }", "each agent { give 1 to agent }"),
    (drop_unused, "each agent { let a = count(tree)  draw b from 1 .. 6  set agent.bag = a + b }", ""),
    (drop_unused, "each agent { draw c from 1 .. 6  when agent on tree { draw d from 1 .. 6  set agent.bag = c } }", "each agent { draw c from 1 .. 6  when agent on tree { set agent.bag = c } }"),
]  # fmt: skip


@pytest.mark.parametrize(("pass_", "before", "after"), CHANGES)
def test_change(pass_: Pass, before: str, after: str) -> None:
    """An empty `after`: nothing changes."""
    game = framed(before)
    changed = verify(pass_(game))
    assert shown(changed) == shown(framed(after or before))
    assert pass_(changed) is changed


def test_impossible_branches_of_conditions_go() -> None:
    """What a folded condition leaves: the branch that happens, or the shorter chain."""
    both: tuple[Pass, ...] = (fold_constants, drop_impossible)
    for before, after in (
        ("each agent { when 1 > 2 { give 1 to agent } otherwise { give 2 to agent } }", "each agent { give 2 to agent }"),
        ("each agent { when 1 < 2 { give 1 to agent } otherwise { give 2 to agent } }", "each agent { give 1 to agent }"),
        (
            "each agent { when agent on tree { give 1 to agent } otherwise when 1 < 2 { give 2 to agent } otherwise { give 3 to agent } }",
            "each agent { when agent on tree { give 1 to agent } otherwise { give 2 to agent } }",
        ),
        (
            "each agent { when agent on tree { give 1 to agent } otherwise when 1 > 2 { give 2 to agent } otherwise { give 3 to agent } }",
            "each agent { when agent on tree { give 1 to agent } otherwise { give 3 to agent } }",
        ),
        ("each agent { when 1 > 2 { give 1 to agent } }  give 1 to all", "give 1 to all"),
    ):
        assert shown(verify(optimise(framed(before), both))) == shown(framed(after))


def test_unused_shapes_go() -> None:
    game = framed("each agent { give 1 to agent }")
    assert [s.name for s in game.shapes] == ["ray"]
    assert drop_unused(game).shapes == ()
    used = framed("each agent { mark ray of agent }")
    assert drop_unused(used) is used


# What no pass changes


@pytest.mark.parametrize("path", [*GAMES, *CASES], ids=lambda path: path.stem)
def test_the_rules_fit_together_after_every_pass(path: Path) -> None:
    game = verify(build(read_source(path)).game)
    for pass_ in PASSES:
        game = verify(pass_(game))
    assert optimise(game) == game


SETS: dict[str, tuple[Pass, ...]] = {"all": PASSES, "none": (), **{p.__name__: (p,) for p in PASSES}, "reversed": PASSES[::-1]}


@cache
def history(game: ir.Game) -> Any:
    """Returns every state, outcome and measure of a run with random actions."""
    module = load_module(render(lower(game, "game.sj")), f"<{game.name}>", game.name)
    params = module.default_params()

    def advance(state: Any, given: Any) -> Any:
        after, out = module.step(state, given[0], params, given[1])
        after = after.replace(step=after.step + 1)
        return after, (after, out, module.measures(after, params), module.allowed_actions(after, params))

    def run(key: jax.Array, actions: jax.Array) -> Any:
        first, *keys = jax.random.bits(key, (STEPS + 1, 2), jnp.uint32)
        return jax.lax.scan(advance, module.reset(params, first), (actions, jnp.stack(keys)))[1]

    actions = np.random.default_rng(0).integers(-1, len(game.agents.actions) + 1, (STEPS, game.agents.number))
    return jax.tree.map(np.asarray, jax.jit(run)(jax.random.key(1), jnp.asarray(actions, jnp.int32)))


def assert_same_history(found: Any, expected: Any) -> None:
    for a, b in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        np.testing.assert_array_equal(a, b)


def assert_passes_change_nothing(game: ir.Game) -> int:
    """Asserts that all sets of passes give one history; returns how many different programs there were."""
    forms = {name: optimise(game, passes) for name, passes in SETS.items()}
    for form in forms.values():
        assert_same_history(history(form), history(game))
    return len(set(forms.values()))


# Harvest with things to optimise in its rules: it must play exactly as Harvest
DULL = """sj 1
game dull "Harvest with idle statements" extends "harvest_open.sj" {
  kind marsh "~" { field depth : { low, high } = low }
  phase eat {
    each agent on soil where soil.fruit is ripe and 1 < 2 {
      let idle = count(soil as other)
      draw idle_too from 1 .. 6
      chance 0 { give 9 to agent } otherwise chance 1 {
        set soil.fruit = none
        give apple to agent
        tally eaten for agent
      }
    }
    each marsh where marsh.depth is low { set marsh.depth = high }
  }
}
"""


def variation(name: str) -> ir.Game:
    """Returns one of the five games with something for the passes to do."""
    match name:
        case "dull harvest":
            return build(Source("dull.sj", DULL, ROOT / "games")).game
        case "harvest without soil":
            return build(read_source(ROOT / "games/harvest_open.sj"), (), Overrides(rows=("QQ.#.", "PPPPP", ".#PP.", "....."))).game
        case "clean_up without an orchard":
            return build(read_source(ROOT / "games/clean_up.sj"), (), Overrides(rows=("HHFFS", "PPPPP", "HFPP.", "FFFFF"))).game
        case _:
            return build(read_source(ROOT / "tests" / "cases" / f"{name}.sj")).game


@pytest.mark.parametrize("name", FIVE)
def test_games_play_the_same(name: str) -> None:
    """These are written so that nothing can be left out; if a pass changes one, it must not show."""
    game = build(read_source(ROOT / "games" / f"{name}.sj")).game
    if any(optimise(game, passes) != game for passes in SETS.values()):
        assert_passes_change_nothing(game)


VARIATIONS = [
    "dull harvest",
    "constants",
    "chances",
    "harvest without soil",
    "clean_up without an orchard",
]


@pytest.mark.thorough
@pytest.mark.parametrize("name", VARIATIONS)
def test_variations_play_the_same(name: str) -> None:
    programs = assert_passes_change_nothing(variation(name))
    assert programs > 1 or name == "chances"


def test_a_constant_condition_among_others() -> None:
    assert_passes_change_nothing(framed("each agent on grass { when 1 > 2 { give 7 to agent } otherwise { give 1 to agent } }"))


def test_idle_statements_change_no_draw() -> None:
    """The dull game plays as the game it extends: streams come from a statement's own text."""
    plain = build(read_source(ROOT / "games/harvest_open.sj")).game
    dull, expected = history(optimise(variation("dull harvest"))), history(plain)
    for name in ("position", "heading", "soil_fruit", "mark_fire"):
        np.testing.assert_array_equal(getattr(dull[0], name), getattr(expected[0], name))
    assert_same_history(dull[1:], expected[1:])
    assert dull[1].reward.sum() > 0


def test_a_pass_that_changes_a_draw_is_found() -> None:
    """The comparison itself: one stream moved is one history changed."""
    game = variation("chances")

    def moved(node: Any) -> Any:
        return node.model_copy(update={"stream": node.stream ^ 1}) if isinstance(node, ir.Chance) else node

    with pytest.raises(AssertionError):
        assert_same_history(history(rewrite(game, moved)), history(game))
