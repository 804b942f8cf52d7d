"""The unit and interval of a quotient: what a fraction divided by a number can be, where the compiler relies on it."""

import pytest

from tests.compiler.refusals import errors_in

POND = """sj 1
game pond {{
  param share : fraction = 0.5
  param sure : probability = 1
  param parts : count = 2 in 1 .. 5
  param scale : count = 2 in 0 .. 5
  episode 20
  kind grass "."
  map {{ "..." }}
  agents 2 {{ acts stay  field bag : 0 .. 9 capped = 0 }}
  phase start {{ each agent {{ send agent to grass }} }}
  schedule rule
  phase rule {{ each agent {{ {rule} }} }}
  checks {{ }}
}}
"""


@pytest.mark.parametrize(
    ("rule", "refused"),
    [
        ("chance sure * (share / 0.1) { add 1 to agent.bag }", "SJ202"),
        ("chance sure * (share / 0.5) { add 1 to agent.bag }", "SJ202"),
        ("chance share / (share - 2) + 1 { add 1 to agent.bag }", ""),
        ("chance sure / 0.5 { add 1 to agent.bag }", "SJ202"),
        ("give 1 / (2 - share / 0.1) to agent", "SJ207"),
        ("give 1 / (1 + share / (0 - 0.5)) to agent", "SJ207"),
        ("chance sure * ramp(share, share / 0.25, 1.5) { add 1 to agent.bag }", "SJ215"),
        ("give 1 / (1.00000001 - share) to agent", "SJ207"),
        ("give 1 / (share + 16777216 - 16777215.9) to agent", "SJ207"),
        ("chance sure * ramp(share, 1, 1.00000001) { add 1 to agent.bag }", "SJ215"),
        ("give 1 / (1.001 - share) to agent", ""),
        ("chance sure * ramp(share, 1, 1.001) { add 1 to agent.bag }", ""),
        ("chance sure * (share / 2) { add 1 to agent.bag }", ""),
        ("chance sure * (share / parts) { add 1 to agent.bag }", ""),
        ("when scale > 0 { chance sure * (share / scale) { add 1 to agent.bag } }", ""),
        ("when agent.bag > 0 { chance sure / agent.bag { add 1 to agent.bag } }", ""),
        ("give 1 / (2 - share / 1) to agent", ""),
        ("give 1 / (0.1 + share / 0.1) to agent", ""),
        (
            "chance sure * (count(grass where grass.col > 0) / count(grass)) { add 1 to agent.bag }",
            "",
        ),
    ],
)
def test_what_a_quotient_can_be(rule: str, refused: str) -> None:
    found = errors_in(POND.format(rule=rule))
    assert found == [] if not refused else found and found[0].code == refused, found
