"""Sentences of single rules, compared with what a reader would expect: written by hand."""

import pytest

from sjdsl.compiler import build
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.told import told

FRAME = """sj 1
game one "One rule" {
  param cost : reward = -0.5
  param luck : probability = 0.25
  episode 100
  kind grass "."
  kind tree "T" { field fruit : { none, ripe, old } = ripe  field owner : agent }
  group ground = grass, tree
  map { "...." "TTTT" }
  agents 3 {
    acts turn_left, turn_right, forward, stay, zap
    moves relative
    field bag : 0 .. 9 capped = 0
    field friends : set of agent
  }
  movers deer 1 "d"
  shape beam = line(2)
  phase start { each agent { send agent to ground facing north } each deer { send deer to ground } }
  schedule rule -> pay
  phase rule { %s }
  phase pay { each agent as x { give 1 to x.friends } }
  observe { window ahead 2, behind 1, left 1, right 1  show agent.bag }
  metrics { event counted }
}
"""
SENTENCES = {
    "each agent on tree where tree.fruit is old and agent.bag > 2 { give cost to agent }": (
        "Each agent whose bag is more than 2, on a tree cell whose fruit is old: the agent gets a "
        "reward of -0.5."
    ),
    "each tree where not (tree.fruit in { none, old }) { set tree.fruit = none }": (
        "Each tree cell whose fruit is neither none nor old: the tree's fruit is set to none."
    ),
    "each tree { chance luck { set tree.fruit = ripe } otherwise { set tree.fruit = old } }": (
        "Each tree cell:\n    - With probability 0.25, the tree's fruit is set to ripe.\n"
        "    - Otherwise, the tree's fruit is set to old."
    ),
    "each agent as a { first agent as b in beam of a where b chose zap { add 1 to b.bag } }": (
        "Each agent a: in agent a's beam, the first agent b that chose zap: agent b's bag rises by "
        "1 (to at most 9)."
    ),
    "pick 2 tree where nobody on tree { set tree.fruit = old }": (
        "For each of 2 different tree cells with nobody on them, drawn at random (all, if there are "
        "fewer): the tree's fruit is set to old."
    ),
    "each agent as a { each agent as b where b is not a { add b to a.friends } }": (
        "Each agent a: each agent b that is not agent a: agent b joins agent a's friends."
    ),
    "when step >= 4 and count(tree where tree.fruit is ripe) == 0 { end }": (
        "If the step number is at least 4 and there is no tree cell whose fruit is "
        "ripe, the episode ends after this step."
    ),
    "each agent { when agent.bag > 3 { add -1 to agent.bag  give 1 to agent } }": (
        "Each agent:\n    - If the agent's bag is more than 3:\n"
        "      - The agent's bag falls by 1 (to at least 0).\n"
        "      - The agent gets a reward of 1."
    ),
    "each tree { chance 1 { set tree.fruit = ripe } otherwise { set tree.fruit = old } }": (
        "Each tree cell: the tree's fruit is set to ripe."
    ),
    "match agent as a with first agent as b in beam of a where a chose zap and b.bag > 0 { "
    "add -1 to b.bag }": (
        "Pairs are made in random order, with nobody and nothing in more than one. A pair is an agent a that "
        "chose zap and, in agent a's beam, the first agent b whose bag is more than 0. For each "
        "pair: agent b's bag falls by 1 (to at least 0)."
    ),
    "move each deer toward agent": (
        "At the same time, each deer steps to one of the free cells beside it that are nearer to "
        "the nearest of the agents, drawn at random; it stays if there is none."
    ),
    "each agent where agent.bag > count(deer where deer.row > 0) { give 1 to agent }": (
        "Each agent whose bag is more than (the number of deer whose row is more than 0): the agent "
        "gets a reward of 1."
    ),
    "each agent { tally counted for agent  give 2 * cost to agent }": (
        "Each agent: the agent gets a reward of -1."
    ),
}


def test_an_event_is_told_where_agents_see_it() -> None:
    rule = "each agent { tally counted by 2 for agent.friends }"
    text = FRAME % rule
    assert "is counted" not in told(build(Source("one.sj", text)).game)
    shown = told(build(Source("one.sj", text.replace("show agent.bag", "show event counted"))).game)
    assert (
        "Each agent: counted is counted for each agent among the agent's friends, 2 times.\n"
        in shown
    )
    assert "- agent.counted: 0 to 255\n" in shown


@pytest.mark.parametrize("rule", SENTENCES)
def test_a_rule_in_english(rule: str) -> None:
    text = told(build(Source("one.sj", FRAME % rule)).game)
    assert f"1. rule\n  - {SENTENCES[rule]}\n" in text
