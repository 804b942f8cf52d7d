"""`sjdsl trace`: agents that follow a policy, and how many steps there are."""

import pytest
from command_line import Sjdsl


def test_no_steps_are_none(sjdsl: Sjdsl) -> None:
    """Also where actions are written for two; by default all of them are played."""
    assert "step 0" not in sjdsl("trace coins --steps 0 --actions 'stay; stay'").out
    assert "step 1" in sjdsl("trace coins --actions 'stay; stay'").out


@pytest.mark.thorough
def test_agents_follow_a_policy_of_the_file(sjdsl: Sjdsl) -> None:
    """Cooperators of Clean Up walk to the dirt, which no random play does as fast."""
    followed = sjdsl("trace clean_up --policy cooperator --steps 40").out
    assert followed != sjdsl("trace clean_up --steps 40").out
    assert "set water.state = clean" in followed
