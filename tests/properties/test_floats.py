"""Reals that leave float32 (overflow): reported by `sjdsl test` and `sjdsl trace` with the line, the step and the state before; never a traceback."""

import warnings
from pathlib import Path

import pytest

from sjdsl.cli import run
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.interpreter.overflow import LeavesFloat32
from sjdsl.properties import Effort, GameFamily, verify_properties

GAME = """sj 1
game growth "Wealth that grows" {{
  episode {steps}
  kind grass "."
  map {{ ".." }}
  agents 1 {{ acts turn_left, turn_right, forward, stay  moves relative  field wealth : reward = 1 }}
  phase start {{ each agent {{ send agent to grass }} }}
  schedule walk -> grow
  phase walk {{ move each agent }}
  phase grow {{ {rule} }}
  checks {{ {checks} }}
}}
"""
ALWAYS = "always sum(agent.wealth over agent) > 0"
FAST = "each agent { set agent.wealth = 2000000000 * agent.wealth }"  # 2e9^k passes 3.4e38 in the step with k = 5
SLOW = "each agent { set agent.wealth = 2 * agent.wealth }"  # 2^128 is the first power that float32 has not


def text(rule: str, steps: int = 20, checks: str = ALWAYS) -> str:
    return GAME.format(rule=rule, steps=steps, checks=checks)


def growth(rule: str, steps: int = 20, checks: str = ALWAYS) -> GameFamily:
    return GameFamily(Source("growth.sj", text(rule, steps, checks), None))


@pytest.mark.parametrize(
    "rule",
    [
        FAST,
        "each agent { add 2000000000 * agent.wealth to agent.wealth }",
        "each agent { set agent.wealth = 1999999999 * agent.wealth  give 2000000000 * agent.wealth to agent }",
        "each agent { let more = 2000000000 * agent.wealth  set agent.wealth = more }",
        "each agent { set agent.wealth = agent.wealth / 0.0000000005 }",
    ],
)
def test_a_trajectory_shows_the_line_and_the_step(rule: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        report = verify_properties(growth(rule), Effort(examples=30, compiled=False))
    (fault,) = report.faults
    assert fault.status == "failed"
    assert fault.line == 10
    assert "a real leaves float32" in fault.reason
    assert any("agent.wealth before this step" in line for line in fault.trace)


def test_the_trajectory_up_to_it_is_shown() -> None:
    """Five steps: (2e9)^4 = 1.6e37 is a float32, (2e9)^5 is none."""
    (fault,) = verify_properties(growth(FAST), Effort(examples=30, compiled=False)).faults
    assert fault.reason.endswith("in step 4")
    assert sum(line.startswith("step ") for line in fault.trace) == 5
    assert any("up to 1.6e+37" in line for line in fault.trace)


def test_it_is_found_late_in_an_episode_of_the_compiled_game() -> None:
    """There infinity is a value like others; the interpreter then plays the same, and names the line."""
    report = verify_properties(growth(SLOW, steps=200), Effort(examples=5))
    (fault,) = report.faults
    assert fault.reason.endswith("in step 127")
    assert fault.line == 10
    assert fault.trace[127].startswith("step 127: ")


def test_an_expectation_whose_episodes_leave_float32_is_not_decided() -> None:
    report = verify_properties(
        growth(SLOW, 200, f"expect {ALWAYS.removeprefix('always ')} with random over 2 episodes"),
        Effort(examples=5),
    )
    assert [v.status for v in report.verdicts] == ["not decided"]
    assert len(report.faults) == 1


def test_the_commands_end_without_a_traceback(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "growth.sj"
    path.write_text(text(FAST))
    for arguments in (
        ["test", str(path), "--examples", "5"],
        ["trace", str(path), "--steps", "12"],
        ["play", str(path), "--watch"],
    ):
        assert run(arguments) == 1
        shown = "".join(capsys.readouterr())
        assert "growth.sj:10" in shown
        assert "leaves float32" in shown
        assert "Traceback" not in shown


def test_the_interpreter_names_the_statement() -> None:
    from sjdsl.interpreter.state import default_params
    from sjdsl.interpreter.step import reset, step
    from sjdsl.interpreter.threefry import Threefry

    game = growth(FAST).own
    world = reset(game, default_params(game), Threefry(0, 0))
    for _ in range(4):
        world, _ = step(game, world, [0], default_params(game), Threefry(0, 1))
    with pytest.raises(LeavesFloat32) as left:
        step(game, world, [0], default_params(game), Threefry(0, 1))
    assert left.value.before == 4
    assert left.value.node.origin is not None
    assert left.value.node.origin.line == 10
