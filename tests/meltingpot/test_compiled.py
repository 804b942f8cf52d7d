"""Every substrate compiled: its steps are the interpreter's, and its checks pass. Slow: `--all`."""

import numpy as np
import pytest

from sjdsl.compiler.syntax.read import read_source
from sjdsl.games_folder import find_game
from sjdsl.properties import Effort, GameFamily, verify_properties
from sjdsl.substrates import Substrate, written_substrates
from sjdsl.testing import Stage

STEPS = 3


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
    family = GameFamily(read_source(find_game(entry.game)), tuple(entry.variant.split("+")) if entry.variant else ())
    report = verify_properties(family, Effort(400, seed=0))
    assert [(v.text, v.status, v.untested) for v in report.verdicts if v.status != "passed"] == []
    assert not report.faults
