"""Writes of one phase: which pairs are seen to be safe, and which near relatives of these are refused."""

import pytest

from sjdsl.compiler import build
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source
from tests.compiler.refusals import codes_in

GAME = """sj 1
game frame "Writes" {{
  episode 9
  kind grass "."
  kind tree "T" {{ field fruit : {{ none, ripe }} = ripe  field taker : agent = nobody }}
  kind pond "O" {{ field fish : 0 .. 9 = 0 }}
  group woods = tree, grass
  group wet = tree, pond
  map {{ "...." "TTOO" }}
  field king : agent = nobody
  param p : probability = 0.5
  param times : count = 1 in 0 .. 3
  agents 3 {{
    acts turn_left, forward, stay, zap, call, shout, whistle
    moves relative
    field bag : 0 .. 9 = 0
    forbid call when agent.index != 2 or agent.bag > 3
    forbid shout when agent.index > 1
    forbid whistle when agent.bag > 0
    field last : agent = nobody
    field seen by agent : 0 .. 9 = 0
    field times by {{ none, ripe }} : 0 .. 9 capped = 0
  }}
  field rank by agent : 0 .. 9 = 0
  field line by 0 .. 2 : agent
  phase start {{ each agent {{ send agent to grass }} }}
  schedule rule
  phase rule {{ {body} }}
}}
"""


def codes(body: str) -> set[str]:
    """Returns the codes of the errors of a phase."""
    return codes_in(GAME.format(body=body))


SAFE = [
    # an agent stands on one cell
    "each pond { each agent on pond { set agent.bag = pond.fish } }",
    # an entry of a row by agent for each pair
    "each agent as a { each agent as b { set a.seen[b] = b.index } }",
    "each agent as b { each agent as a in disc(2) of b { set a.seen[b] = b.index + a.index } }",
    "each agent as a { set rank[a] = a.index } each tree as t { each agent as b in disc(1) of t { give 1 to b } }",
    "each agent as a { each agent as b where b is not a { when a.seen[b] < 9 { add 1 to a.seen[b] } } }",
    "each agent as a { each agent as b { when b chose zap { set a.seen[b] = 1 } otherwise { set a.seen[b] = 2 } } }",
    "each agent as a { each agent as b where b chose zap { set a.seen[b] = 1 } } each agent as x { each agent as y where y chose stay"
    " { set x.seen[y] = y.index } }",
    "match agent as a with agent as b in disc(2) of a { set a.seen[b] = b.index  set b.seen[a] = a.index }",
    "match agent as a with agent as b in disc(2) of a { each agent as one in { a, b } { each agent as c { set one.seen[c] = c.index } } }",
    "each agent as a { pick 2 agent as b { set b.seen[a] = a.index } }",
    "each agent as a { each tree { each agent as b in disc(1) of tree { set b.seen[a] = 3 } } }",
    "pick 1 agent as a { set line[0] = a } set line[1] = nobody",
    # one way of a statement that is met once
    "chance p { each agent { set agent.bag = 1 } } otherwise { each agent { set agent.bag = agent.index } }",
    "when step > 3 { pick 1 agent { set king = agent } } otherwise { set king = nobody }",
    "pick 1 tree { each agent { set agent.bag = 1 } } otherwise { each agent as a { set a.bag = 2 } }",
    # different kinds underfoot
    "each agent on tree { set agent.bag = 1 } each agent on pond { set agent.bag = agent.index }",
    "each agent on tree { set agent.bag = 1 } each agent where not agent on woods { set agent.bag = 2 }",
    # at most one partner for each
    "each agent as a { first agent as b in line(2) of a { set a.last = b } }",
    "each tree as t { pick 1 agent as b in disc(2) of t { set t.taker = b } otherwise { set t.taker = nobody } }",
    "each agent as a { first tree in line(3) of a { pick 1 agent as b in disc(1) of tree { set a.last = b } } }",
    "pick 1 tree { pick 1 agent as b in disc(2) of tree { set b.bag = 1  set tree.taker = b  set king = b } }",
    "pick 1 agent as a { first agent as b in line(2) of a { set b.bag = a.index } }",
    # one lane
    "each agent as a { first tree in line(2) of a { set a.bag = 1 } }",
    "each agent as a { first tree in fan(2, 1) of a { set a.bag = 1  set tree.fruit = none } }",
    # one agent, by its number, or because the others may not
    "each agent as a where a.index == 1 { set king = a }",
    "each agent as a { when a.index == 1 and a.bag > 3 { set king = a  set rank[a] = a.bag } }",
    "each agent where agent chose call { set king = agent }",
    "each agent where agent chose call { each tree { set tree.taker = agent } }",
]
REFUSED = [
    "each pond { each tree { each agent on tree { set agent.bag = pond.fish } } }",
    # several agents may
    "each agent where agent.index > 0 { set king = agent }",
    "each agent where agent chose whistle { set king = agent }",
    "each agent where agent chose shout { set king = agent }",
    # one entry for several instances: more than its two agents multiply
    "each agent as a { each tree { each agent as b in disc(1) of tree { set b.seen[a] = count(tree as u in disc(1) of tree) } } }",
    "each agent as a { each agent as b { set rank[b] = a.index } }",
    "each agent as a { each agent as b { set b.seen[b] = a.index } }",
    "each agent as a { each agent as b { each agent as c { set a.seen[c] = b.index } } }",
    "each agent as a { first agent as b in fan(2, 1) of a { draw n from 0 .. 3 set a.seen[b] = n } }",
    "each agent as a { set line[a.index] = a  set line[0] = a }",
    # a whole row, and an entry of it
    "each agent as a { set a.seen = 0  each agent as b { set a.seen[b] = b.index } }",
    # conditions about the other agent of the pair
    "each agent as a { each agent as b where a chose zap { set a.seen[b] = 1 } } each agent as x { each agent as y where y chose stay"
    " { set x.seen[y] = 2 } }",
    "pick 1 agent as a { set line[0] = a } set line[0] = nobody",
    # the branch is met once for each agent
    "each agent as a { chance p { each tree { set tree.fruit = none } } otherwise { each tree { set tree.fruit = ripe } } }",
    "each agent as a { when a.bag > 3 { set king = a } otherwise { set king = nobody } }",
    # two statements, not two branches of one
    "chance p { each agent { set agent.bag = 1 } } chance p { each agent { set agent.bag = 2 } }",
    # kinds that overlap
    "each agent on tree { set agent.bag = 1 } each agent on wet { set agent.bag = 2 }",
    "each agent on pond { set agent.bag = 1 } each agent where not agent on tree { set agent.bag = 2 }",
    # the partner of several
    "each agent as a { first agent as b in line(2) of a { set b.last = a } }",
    "each agent as a { pick 1 tree in disc(2) of a { set tree.taker = a } }",
    "each agent as a { each agent as b in disc(2) of a { set a.last = b } }",
    "each agent as a { pick times tree in disc(2) of a { set a.last = a.last  set tree.taker = a } }",
    "pick 1 agent as a { each agent as b in disc(2) of a { set king = b } }",
    "each agent as a { pick 1 agent as b { set b.last = a } }",
    # one for each lane
    "each agent as a { first agent as b in fan(2, 1) of a { set a.last = b } }",
    "pick 1 agent as a { first agent as b in fan(2, 1) of a { set king = b } }",
]


@pytest.mark.parametrize("body", SAFE)
def test_accepted(body: str) -> None:
    assert codes(body) == set()


@pytest.mark.parametrize("body", REFUSED)
def test_refused(body: str) -> None:
    assert codes(body) in ({"SJ401"}, {"SJ402"})


def test_an_add_in_every_lane_may_leave_the_range() -> None:
    """A guard holds for one add; a shape with several lanes makes several."""
    add = "when a.bag < 9 { add 1 to a.bag }"
    for shape, refused in (("line(2)", set()), ("fan(2, 1)", {"SJ204"})):
        assert codes(f"each agent as a {{ first tree in {shape} of a {{ {add} }} }}") == refused


APART = {  # writes that cannot draw lots together -> the same as the message says to write it instead
    "each agent as a { set king = a by lot } set king = nobody": "each agent as a { set king = a by lot } set king = nobody by lot",
    "each agent as a { each agent as b { set b.seen[a] = 1 by lot  set b.seen = 2 by lot } }": (
        "each agent as a { each agent as b { set b.seen = 1 by lot  set b.seen = 2 by lot } }"
    ),
    "each agent as a { set rank[a] = 1 by lot  set rank = a.seen by lot }": (
        "each agent as a { set rank[a] = 1 by lot  each agent as b { set rank[b] = a.index by lot } }"
    ),
}


@pytest.mark.parametrize("body", APART)
def test_lots_are_drawn_together(body: str) -> None:
    """What is refused says how to write it, and that is accepted."""
    with pytest.raises(CompileError, match="lot") as raised:
        build(Source("frame.sj", GAME.format(body=body)))
    assert [d.code for d in raised.value.diagnostics] == ["SJ401"]
    assert codes(APART[body]) == set()
