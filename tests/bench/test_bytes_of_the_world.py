"""One number of the world is never a byte: XLA ends the process on some processors when it is compared with bytes of agents."""

import os
import subprocess
import sys
from pathlib import Path

import jax
import pytest

from sjdsl.library.factory import make

BALLOT = """sj 1
game ballot "Ballot" {
  size players : count = 5  episode 100
  kind floor "."  kind start_point "P"  map { "PPPPP" "....." }
  field round : { playing, voting } = playing  field held : 0 .. 9 capped = 0  timer clock
  agents players {
    acts stay, vote(whom : agent), abstain  moves relative
    field state : { active, out } = active  field ballot : 0 .. players = players
  }
  phase start { each agent { send agent to start_point } }
  schedule tick -> vote -> adjourn
  phase vote {
    each agent as a where a chose vote { set a.ballot = a.vote.whom.index }
    each agent as a where a chose abstain { set a.ballot = players }
  }
  phase adjourn {
    when clock == 0 and round is playing {
      set round = voting  add 1 to held
      each agent where agent.state is active { set agent.ballot = players }
    }
  }
  observe { show everyone.ballot  show round  show held }
}
"""

COMPILE = """
import sys
import jax
from sjdsl.library.factory import make

env = make(sys.argv[1])
keys = jax.random.split(jax.random.key(0), 128)
states = jax.eval_shape(jax.vmap(env.reset), keys)[1]
actions = jax.ShapeDtypeStruct((128, env.num_agents), "int32")
jax.jit(jax.vmap(env.step)).lower(keys, states, actions).compile()
"""


def compiled_alone(game: str) -> subprocess.CompletedProcess[str]:
    """Compiles a step of 128 environments as users have it, in a process of its own, which XLA may end."""
    environment = {
        name: value for name, value in os.environ.items() if not name.startswith(("JAX_", "XLA_"))
    }
    return subprocess.run(
        [sys.executable, "-c", COMPILE, game],
        capture_output=True,
        text=True,
        timeout=300,
        env=environment,
    )


@pytest.fixture
def ballot(tmp_path: Path) -> Path:
    path = tmp_path / "ballot.sj"
    path.write_text(BALLOT)
    return path


def test_one_number_of_the_world_is_kept_in_32_bits(ballot: Path) -> None:
    state = jax.eval_shape(make(ballot).reset, jax.random.key(0))[1]
    assert {
        name: getattr(state, name).dtype.name
        for name in ("world_round", "world_held", "agent_state", "agent_ballot")
    } == {
        "world_round": "int32",
        "world_held": "int32",
        "agent_state": "uint8",
        "agent_ballot": "uint8",
    }


@pytest.mark.thorough
def test_a_ballot_of_128_environments_compiles(ballot: Path) -> None:
    done = compiled_alone(str(ballot))
    assert done.returncode == 0, done.stderr
