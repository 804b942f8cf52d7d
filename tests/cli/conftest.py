"""A small game in a folder of its own, and a way to run the command line in it."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from sjdsl.cli import run

GAME = """sj 1
game orchard "A Small Orchard" {
  cite "written for a test"
  size  players : count = 2 in 1 .. 3
  param length  : steps = 6
  param apple   : reward = 1 in 0 .. 5
  param growth  : probability = { none: 0.1, ripe: 0 }
  episode length

  kind floor "."
  kind wall  "#" { blocks agents }
  kind soil  "A" { field fruit : { none, ripe } = ripe }
  map { "#####"
        "#..A#"
        "#.AA#"
        "#####" }

  agents players {
    acts turn_left, turn_right, forward, stay
    moves relative
  }
  phase start { each agent { send agent to floor } }
  schedule walk -> eat -> grow
  phase walk { move each agent }
  phase eat {
    each agent on soil where soil.fruit is ripe { set soil.fruit = none  give apple to agent  tally eaten for agent }
  }
  phase grow {
    each soil where soil.fruit is none {
      chance growth[soil.fruit] { set soil.fruit = ripe }
    }
  }
  observe { window ahead 2, behind 1, left 1, right 1 }
  metrics { event eaten  mean left = count(soil where soil.fruit is ripe) }
  variant rich "apples are worth more" { set apple = 2 }
}
"""


@dataclass(frozen=True)
class Output:
    """What a command left behind."""

    status: int
    out: str
    err: str

    @property
    def text(self) -> str:
        return self.out + self.err


Sjdsl = Callable[..., Output]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, empty but for `orchard.sj`."""
    (tmp_path / "orchard.sj").write_text(GAME)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def sjdsl(folder: Path, capsys: pytest.CaptureFixture[str]) -> Sjdsl:
    """Runs `sjdsl` with arguments in the folder."""
    del folder

    def call(*arguments: str | Path) -> Output:
        status = run([str(argument) for argument in arguments])
        return Output(status, *capsys.readouterr())

    return call
