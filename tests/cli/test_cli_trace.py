"""`sjdsl trace`: agents that follow a policy."""

import pytest
from command_line import Sjdsl


@pytest.mark.thorough
def test_agents_follow_a_policy_of_the_file(sjdsl: Sjdsl) -> None:
    """Cooperators of Clean Up walk to the dirt, which no random play does as fast."""
    followed = sjdsl("trace", "clean_up", "--policy", "cooperator", "--steps", "40").out
    assert followed != sjdsl("trace", "clean_up", "--steps", "40").out
    assert "set water.state = clean" in followed
