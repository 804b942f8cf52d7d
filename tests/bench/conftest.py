"""The small game that benchmarks are tested with."""

from pathlib import Path

import pytest

import sjdsl
from sjdsl.runtime.env import Environment

GAME = """sj 1
game meadow "Meadow" {
  episode 3
  kind soil "A" { field fruit : { none, ripe } = ripe }
  map { "AAA" }
  agents 2 { acts forward, stay  moves relative }
  phase start { each agent { send agent to soil } }
  schedule walk -> eat
  phase walk { move each agent }
  phase eat { each agent on soil where soil.fruit is ripe { set soil.fruit = none  give 1 to agent } }
  variant dry "nothing grows" { observe { window ahead 2, behind 0, left 1, right 1 } }
  observe { window ahead 1, behind 0, left 1, right 1 }
}
"""


@pytest.fixture(scope="package")
def meadow(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Its file: three cells in a row, each eaten once in an episode of three steps."""
    path = tmp_path_factory.mktemp("games") / "meadow.sj"
    path.write_text(GAME)
    return path


@pytest.fixture(scope="package")
def meadow_env(meadow: Path) -> Environment:
    return sjdsl.make(meadow)
