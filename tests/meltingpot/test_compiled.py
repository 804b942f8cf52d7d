"""Every substrate compiled: its steps are the interpreter's, its checks pass, and it is small. Slow: `--all`; a part with `--thorough`."""

import numpy as np
import pytest

import sjdsl
from sjdsl.bench.compilation import lower_step
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import find_game, melting_pot_games
from sjdsl.library.substrates import Substrate, written_substrates
from sjdsl.properties import Effort, GameFamily, verify_properties
from sjdsl.testing import Stage

STEPS = 3
MOST_STABLEHLO = 3500  # lines of a step; XLA's time to compile grows with them
FEW = Effort(25, compiled=False)


@pytest.mark.slow
@pytest.mark.parametrize("entry", written_substrates(), ids=lambda entry: entry.name)
def test_steps_are_those_of_the_interpreter(entry: Substrate) -> None:
    stage = Stage(entry.game, variant=entry.variant or None)
    scene, chosen = stage.start(seed=1), np.random.default_rng(0)
    for _ in range(STEPS):
        scene.step(", ".join(chosen.choice(stage.env.action_names, stage.env.num_agents)))


@pytest.mark.slow
@pytest.mark.parametrize("entry", written_substrates(), ids=lambda entry: entry.name)
def test_checks_pass(entry: Substrate) -> None:
    """Every check, as `sjdsl test --strict` has it."""
    family = GameFamily(
        read_source(find_game(entry.game)), tuple(entry.variant.split("+")) if entry.variant else ()
    )
    report = verify_properties(family, Effort(400, seed=0))
    assert [(v.text, v.status, v.untested) for v in report.verdicts if v.status != "passed"] == []
    assert not report.faults


@pytest.mark.thorough
@pytest.mark.parametrize("game", sorted(melting_pot_games()))
def test_no_check_fails_in_a_few_trajectories(game: str) -> None:
    """Checks of states, symmetry and numbers in 250 steps; lines may stay uncovered, and no `expect` is played.

    The 19 files took 149 processor seconds together, the slowest (predator_prey_open) 28.
    """
    family = GameFamily(read_source(find_game(game)))
    report = verify_properties(
        family, FEW, [i for i, check in enumerate(family.own.checks) if check.kind != "expect"]
    )
    assert [
        (v.text, v.status) for v in report.verdicts if v.status in ("failed", "not decided")
    ] == []
    assert report.verdicts and not report.faults


@pytest.mark.slow
@pytest.mark.parametrize("game", melting_pot_games())
def test_a_step_is_small(game: str) -> None:
    assert len(lower_step(sjdsl.make(game)).as_text().splitlines()) < MOST_STABLEHLO
