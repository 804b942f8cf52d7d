"""What the tests of the command line share: a small game, and what a command leaves behind."""

from collections.abc import Callable
from dataclasses import dataclass

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
