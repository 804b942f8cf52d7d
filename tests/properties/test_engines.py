"""The compiled game and the interpreter play the same episodes under the scripted policies, and their checks read the same values."""

import sys
from pathlib import Path

import numpy as np
import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.read import read_source
from sjdsl.properties import GameFamily
from sjdsl.properties.effects import is_untouched
from sjdsl.properties.engines import EpisodeRunner
from sjdsl.properties.state_conversion import world_of
from sjdsl.properties.symmetry import why_symmetric
from sjdsl.properties.trajectory import choose, play
from sjdsl.properties.verify_properties import Verification

from .small_games import ORCHARD, small_game

TRIALS = Path(__file__).parents[1] / "cases" / "trials.sj"
STARTING_PHASES = Path(__file__).parents[1] / "cases" / "starting.sj"
SEED = 1
CHECKS = """always fruit <= 2  always eaten <= 2 and zaps >= 0  conserved count(agent)  monotone bare falling in fruit
  expect eaten == 0 with never(zap, forward), seek tree where tree.fruit is ripe over 3 episodes
  expect zaps > 0 with random, seek agent as other where other is not agent over 3 episodes
  expect zaps > 0 with seek tree in disc(2) of agent, seek grass where grass.row == 0 over 3 episodes"""
RULE = """each agent where agent chose zap { set agent.tired = 2  tally zaps for agent }
  each tree where tree.fruit is none and nobody on tree { chance regrow { set tree.fruit = ripe } }
  each agent where agent.wealth == 3 { send agent to grass after 2 }"""


@pytest.fixture(scope="module")
def orchard() -> GameFamily:
    text = ORCHARD.replace('"..T" ".T."', '"..T." ".T#." "...."')
    return small_game(CHECKS, RULE, text=text)


@pytest.fixture(scope="module")
def runner(orchard: GameFamily) -> EpisodeRunner:
    """Of one seed, so that tests share what is compiled."""
    return EpisodeRunner(orchard, SEED)


def assert_engines_agree(family: GameFamily, runner: EpisodeRunner) -> None:
    """Plays three episodes of each `expect` on both engines."""
    runner.checks = dict(enumerate(family.own.checks))
    for check in (c for c in family.own.checks if c.kind == "expect"):
        compiled = runner.play_compiled(check.policies, 0, 3)
        interpreted = [runner.play_interpreted(check.policies, number) for number in range(3)]
        for mine, theirs in zip(compiled, interpreted, strict=True):
            assert mine.actions == theirs.actions
            assert mine.totals == theirs.totals
            for number, values in mine.values.items():
                np.testing.assert_allclose(
                    np.asarray(values, float), np.asarray(theirs.values[number], float), rtol=1e-6
                )
        assert any(
            len(set(values)) > 1 for episode in compiled for values in episode.values.values()
        ), "nothing that is read ever changed"


def test_both_engines_play_the_same(orchard: GameFamily, runner: EpisodeRunner) -> None:
    assert_engines_agree(orchard, runner)


@pytest.mark.thorough
@pytest.mark.parametrize("path", [TRIALS, STARTING_PHASES], ids=lambda path: path.stem)
def test_both_engines_play_the_same_case(path: Path) -> None:
    family = GameFamily(read_source(path))
    assert_engines_agree(family, EpisodeRunner(family, SEED))


@pytest.mark.parametrize(
    ("path", "before", "written", "untouched"),
    [(TRIALS, "count", "mood", "luck"), (STARTING_PHASES, "owned + begun", "owned", "begun")],
    ids=["trials", "phases at the start"],
)
def test_conserved_is_not_proved_of_what_the_beginning_writes(
    path: Path, before: str, written: str, untouched: str
) -> None:
    text = path.read_text(encoding="utf-8")
    more = f"conserved {written}  conserved {untouched}  conserved {before}"
    family = GameFamily(Source(path.name, text.replace(f"conserved {before}", more), path.parent))
    for name, expected in ((written, False), (untouched, True)):
        (check,) = (c for c in family.own.checks if family.text_of(c) == f"conserved {name}")
        assert is_untouched(check.values[0], family.own, family.sends_later) is expected


def test_symmetry_tells_which_phase_at_the_start_reads_a_number() -> None:
    game = build(read_source(STARTING_PHASES)).game
    check = next(check for check in game.checks if check.kind == "symmetric")
    assert "`phase claim` does, in line" in why_symmetric(check, game)


def test_a_state_of_an_episode_is_the_interpreters(
    orchard: GameFamily, runner: EpisodeRunner
) -> None:
    """Also with agents that are away, and sets and timers that are not at their start."""
    policies = orchard.own.checks[4].policies
    episode, *_ = runner.play_compiled(policies, 0, 3)
    trajectory = play(orchard.own, runner.scenario(policies, 0), len(episode.actions))
    player, away = runner._player, 0
    for step in range(0, len(episode.actions), 2):
        found = world_of(player.env, player.state_before(episode.actions, SEED, 0, step))
        wanted = trajectory.worlds[step]
        for part in ("step", "cells", "agents", "fields", "position", "heading", "away"):
            assert getattr(found, part) == getattr(wanted, part), (step, part)
        away += sum(a is not None for a in wanted.away)
    assert away > 0


def test_a_seeker_arrives_and_stays() -> None:
    game = small_game("", text=ORCHARD.replace('"..T" ".T."', '"....." "#.##." "....T"')).own
    seek = ir.Policy(
        name="seek",
        domain=ir.Domain(var=ir.Member(name="tree", entity_type=ir.EntityType("cell", ("tree",)))),
    )
    from sjdsl.interpreter.state import Cell, default_params
    from sjdsl.interpreter.step import reset, step
    from sjdsl.properties.biased_draws import episode_key, step_key

    world = reset(game, default_params(game), step_key(episode_key(0, 0), 0))
    world.position = [Cell(0, 0), Cell(2, 0)]
    stay, steady = game.agents.actions.index("stay"), (0, 2**32 - 1)
    for number in range(6):
        actions = [choose(seek, game, world, 0, steady), stay]
        world, _ = step(
            game, world, actions, default_params(game), step_key(episode_key(0, 0), number)
        )
    assert world.position[0] == Cell(2, 4)
    assert choose(seek, game, world, 0, steady) == stay


def test_without_jax_an_expect_with_long_episodes_is_undecided(
    orchard: GameFamily, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "jax", None)
    short = Verification(orchard, only=[4]).verdict(4)
    assert short.passed is not None
    monkeypatch.setattr("sjdsl.properties.engines.LITTLE", 0)
    long = Verification(orchard, only=[4]).verdict(4)
    assert long.passed is None
    assert "JAX isn't installed here; `sjdsl test` plays them" in long.reason
