"""Small games for the tests of checks, made of a few lines each."""

from sjdsl.compiler.diagnostics.source import Source
from sjdsl.properties import Effort, GameFamily
from sjdsl.properties.search import Search

ORCHARD = """sj 1
game orchard "Orchard" {{
  size  players : count = 2 in 1 .. 4
  param apple : reward = 1
  param regrow : probability = 0.1
  episode 20
  kind grass "."
  kind wall "#" {{ blocks agents, ray }}
  kind tree "T" {{ field fruit : {{ none, ripe }} = ripe }}
  map {{ "..T" ".T." }}
  agents players {{
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, zap
    moves relative
    field wealth : 0 .. 100 capped = 0
    timer tired
  }}
  shape ray = line(2)
  define fruit = count(tree where tree.fruit is ripe)
  define bare = count(tree) - fruit
  {more}
  phase start {{ each agent {{ send agent to grass }} }}
  schedule tick -> walk -> eat -> rule
  phase walk {{ move each agent }}
  phase eat {{
    each agent on tree where tree.fruit is ripe {{
      set tree.fruit = none  give apple to agent  add 1 to agent.wealth  tally eaten for agent
    }}
  }}
  phase rule {{ {rule} }}
  metrics {{ event eaten  event zaps }}
  checks {{ {checks} }}
}}
"""
TALLY = "each agent where agent chose zap { set agent.tired = 2  tally zaps for agent }"


def small_game(checks: str, rule: str = TALLY, more: str = "", text: str = ORCHARD) -> GameFamily:
    """Returns a small orchard with these checks, one more rule, and more declarations."""
    return GameFamily(Source("orchard.sj", text.format(rule=rule, checks=checks, more=more), None))


def searched(family: GameFamily, effort: Effort) -> Search:
    """Returns the search for counterexamples to the first check, at its end."""
    search = Search(family, [0], effort)
    search.run()
    return search
