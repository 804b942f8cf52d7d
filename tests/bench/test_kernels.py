"""Kernels of a step: counted in programs small enough to count by hand, bytes against the arrays' own sizes."""

import json
import math
from dataclasses import asdict

import jax
import jax.numpy as jnp
import pytest

from bench.gpu_cost import count_kernels
from bench.speed.kernels import Kernels, StepKernels, copied_bytes_per_s, measure_kernels
from bench.speed.tables import kernel_table, notes_of
from sjdsl.bench import game_task
from sjdsl.runtime.env import Environment

# As XLA writes a program: two kernels in the entry, and a loop whose body has one and whose condition has one.
PROGRAM = """HloModule jit_f, is_scheduled=true

%fused_computation (param_0: f32[5]) -> f32[5] {
  %param_0 = f32[5]{0} parameter(0)
  ROOT %add.0 = f32[5]{0} add(%param_0, %param_0)
}

%adder (x: f32[], y: f32[]) -> f32[] {
  %x = f32[] parameter(0)
  %y = f32[] parameter(1)
  ROOT %add.1 = f32[] add(%x, %y)
}

%body (tuple: (s32[], f32[5])) -> (s32[], f32[5]) {
  %tuple = (s32[], f32[5]{0}) parameter(0)
  %item = f32[5]{0} get-tuple-element(%tuple), index=1
  %double = f32[5]{0} fusion(%item), kind=kLoop, calls=%fused_computation
  ROOT %pair = (s32[], f32[5]{0}) tuple(%item, %double)
}

%more (tuple.1: (s32[], f32[5])) -> pred[] {
  %tuple.1 = (s32[], f32[5]{0}) parameter(0)
  ROOT %less = pred[] custom-call(%tuple.1), custom_call_target="less"
}

ENTRY %main (x.1: f32[5]) -> f32[] {
  %x.1 = f32[5]{0} parameter(0)
  %zero = f32[] constant(0)
  %copied = (s32[], f32[5]{0}) custom-call(%x.1), custom_call_target="start"
  %loop = (s32[], f32[5]{0}) while(%copied), condition=%more, body=%body
  %last = f32[5]{0} get-tuple-element(%loop), index=1
  ROOT %sum = f32[] reduce(%last, %zero), dimensions={0}, to_apply=%adder
}
"""


def test_kernels_are_counted_where_they_are_launched() -> None:
    assert count_kernels(PROGRAM) == 4
    with pytest.raises(ValueError, match="ENTRY"):
        count_kernels("no program")


def test_what_fuses_is_one_kernel() -> None:
    text = jax.jit(lambda x: jnp.sin(x) * 2 + 1).lower(jnp.ones(8)).compile().as_text()
    assert count_kernels(text) == 1


def test_a_step_moves_at_least_what_goes_in_and_out(meadow_env: Environment) -> None:
    """State: step, three cells of fruit, of two agents the cell and the heading, the key and what goes on; counted by its arrays."""
    (step,) = measure_kernels([game_task(meadow_env)], num_envs=3, repeats=1, steps=1).steps
    observation, state = jax.eval_shape(meadow_env.reset, jax.random.key(0))
    in_and_out = 2 * sum(
        math.prod(leaf.shape) * leaf.dtype.itemsize for leaf in jax.tree.leaves(state)
    )
    assert (
        step.least_bytes == in_and_out + math.prod(observation.shape) + 2 * 4 + 2 * 4
    )  # actions and rewards of two agents
    assert step.kernels > 1
    assert len(step.seconds) == 1


def test_the_share_is_the_time_a_copy_of_the_least_bytes_would_take() -> None:
    step = StepKernels("meadow", 2, "tokens", 1000, 12, 5000.0, 2000.0, (1e-3, 2e-3, 4e-3))
    found = Kernels({"platform": "gpu"}, 4e9, (step,))
    (row,) = kernel_table(found).rows
    assert row == (
        "meadow",
        "2",
        "tokens",
        "1,000",
        "12",
        "5,000",
        "2,000",
        "2,000 µs",
        "500k",
        "25.0%",
    )
    assert "4 GB/s" in notes_of(found)[0]
    assert json.loads(json.dumps(asdict(found)))["steps"][0]["kernels"] == 12


def test_a_copy_has_a_speed() -> None:
    assert copied_bytes_per_s(1, numbers=64) > 0
