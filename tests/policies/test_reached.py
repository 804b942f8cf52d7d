"""Rules of a policy that are never reached are warned of, and rules know what those above leave over."""

import pytest

from sjdsl.compiler import check
from sjdsl.compiler.diagnostics.source import Source

GAME = """sj 1
game rows "Policies of one agent" {{
  episode 10
  kind grass "."
  map {{ ".." }}
  agents 1 {{ acts stay, up  field bag : 0 .. 3 capped = 0 }}
  phase start {{ each agent {{ send agent to grass }} }}
  schedule rise
  phase rise {{ each agent where agent chose up {{ add 1 to agent.bag }} }}
  policy climbs {{ {} }}
}}
"""


def warnings(rules: str) -> list[tuple[str, str]]:
    """Returns for each warning the text it points at and what it says."""
    text = GAME.format(rules)
    return [(text[d.span.start : d.span.end], d.message) for d in check(Source("rows.sj", text))]


@pytest.mark.parametrize(
    ("rules", "unreached"),
    [
        ("when agent.bag > 3 choose up", "agent.bag > 3"),
        ("when step >= 0 choose up  seek grass", "seek grass"),
        ("when agent.bag > 1 choose up  when agent.bag > 2 choose stay", "agent.bag > 2"),
        ("when agent.bag > 1 choose up  when agent.bag <= 1 choose stay  seek grass", "seek grass"),
    ],
)
def test_a_rule_that_is_never_reached_is_warned_of_once(rules: str, unreached: str) -> None:
    ((where, said),) = warnings(rules)
    assert where == unreached
    assert "never happen" in said


@pytest.mark.parametrize(
    "rules",
    [
        "when agent.bag > 1 choose up  when agent.bag == 1 choose stay  seek grass",
        "when agent.bag > 1 and step > 3 choose up  when agent.bag > 2 choose stay",
        "seek grass  when agent.bag > 1 choose up",
        "when agent.bag == 0 choose stay  when 3 / agent.bag > 2 choose up",
    ],
)
def test_rules_that_may_be_reached_are_not(rules: str) -> None:
    assert warnings(rules) == []
