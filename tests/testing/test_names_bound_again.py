"""A define may count over `agent` where `agent` is also what it is asked of: what is counted is kept, what it is asked of is not."""

from pathlib import Path

import pytest

from sjdsl.testing import Stage

TEXT = """sj 1
game names "Names that mean two things" {
  episode 5
  kind grass "."
  map { "..." }
  agents 2 { acts stay }
  define some = count(agent where agent.index >= 0) > 0
  define low(one) = case some { yes: one.index == 0, no: one.index == 1 }
  phase start { each agent { send agent to grass } }
  schedule pay
  phase pay { each agent { give case low(agent) { yes: 1, no: -1 } to agent } }
}
"""


@pytest.mark.parametrize("interpreted", [True, False])
def test_a_name_that_an_inner_count_binds_again_keeps_its_value(
    interpreted: bool, tmp_path: Path
) -> None:
    (tmp_path / "names.sj").write_text(TEXT)
    Stage(tmp_path / "names.sj", interpreted=interpreted).start().step().has({"reward": [1, -1]})
