"""What the tests of the command line share: a small game, the same with a policy and scenarios, and what a command leaves behind."""

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
PLAYED = """  policy eater "walks to fruit" { seek soil where soil.fruit is ripe }
  scenario guest "one among those who eat" { slots 1 focal  slots players - 1 policy eater }
  scenario pair  "two who are the same" { slots 2 focal }
}
"""
GROVE = GAME.rstrip().removesuffix("}").replace("game orchard", "game grove") + PLAYED
INTERRUPTIBLE = """
import signal, sys
from sjdsl.cli import main
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell that runs the tests in the background has it ignored
sys.exit(main())
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
