"""Commands that take a policy know those of the game's file; `play` follows them on the interpreter, without JAX."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import Sjdsl

pytestmark = pytest.mark.usefixtures("grove")


def test_play_follows_a_policy_without_jax(folder: Path) -> None:
    program = (
        "import sys; from sjdsl.cli import run; "
        "s = run(['play', 'grove.sj', '--watch', '--others', 'eater', '--record', 'e.json']); sys.exit(s or int('jax' in sys.modules))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert sum(json.loads((folder / "e.json").read_text())["returns"]) >= 2, (
        "who walks to fruit eats"
    )


def test_an_episode_of_a_policy_is_recorded_and_drawn(sjdsl: Sjdsl) -> None:
    drawn = sjdsl("render grove.sj --policy eater --steps 4 -o film.gif")
    assert drawn.status == 0, drawn.text
    recorded = sjdsl("record grove.sj --policy eater --episodes 1 -o kept.npz")
    assert recorded.status == 0, recorded.text
    misspelt = sjdsl("record grove.sj --policy eatre -o more.npz")
    assert misspelt.status == 1
    assert "there is no policy `eatre`; did you mean `eater`?" in misspelt.err
