"""What a program costs on a GPU, counted by bench/gpu_cost.py in programs small enough to count by hand."""

import runpy
from pathlib import Path

import pytest

COST = runpy.run_path(str(Path(__file__).parents[2] / "bench" / "gpu_cost.py"), run_name="gpu_cost")
cost_of, GPUS = COST["cost_of"], COST["GPUS"]

# A loop of five turns that writes one row of a [5, 100] array in each, in place; a branch; a look-up of 3 of 1,000 numbers.
PROGRAM = """HloModule jit_f, is_scheduled=true

%store (p.0: f32[5,100], p.1: f32[1,100], p.2: s32[]) -> f32[5,100] {
  %p.0 = f32[5,100]{1,0} parameter(0)
  %p.1 = f32[1,100]{1,0} parameter(1)
  %p.2 = s32[] parameter(2)
  %zero.0 = s32[] constant(0)
  ROOT %update = f32[5,100]{1,0} dynamic-update-slice(%p.0, %p.1, %p.2, %zero.0)
}

%look_up (q.0: f32[1000], q.1: s32[3,1]) -> f32[3] {
  %q.0 = f32[1000]{0} parameter(0)
  %q.1 = s32[3,1]{1,0} parameter(1)
  ROOT %found = f32[3]{0} gather(%q.0, %q.1), offset_dims={}, collapsed_slice_dims={0}, start_index_map={0}, index_vector_dim=1, slice_sizes={1}
}

%sum_of_squares (r.0: f32[8,50]) -> f32[8] {
  %r.0 = f32[8,50]{1,0} parameter(0)
  %square = f32[8,50]{1,0} multiply(%r.0, %r.0)
  %zero.1 = f32[] constant(0)
  ROOT %sum = f32[8]{0} reduce(%square, %zero.1), dimensions={1}, to_apply=%adder
}

%adder (x: f32[], y: f32[]) -> f32[] {
  %x = f32[] parameter(0)
  %y = f32[] parameter(1)
  ROOT %add = f32[] add(%x, %y)
}

%body (b: (s32[], f32[5,100], f32[1,100])) -> (s32[], f32[5,100], f32[1,100]) {
  %b = (s32[], f32[5,100]{1,0}, f32[1,100]{1,0}) parameter(0)
  %number = s32[] get-tuple-element(%b), index=0
  %rows = f32[5,100]{1,0} get-tuple-element(%b), index=1
  %row = f32[1,100]{1,0} get-tuple-element(%b), index=2
  %stored = f32[5,100]{1,0} fusion(%rows, %row, %number), kind=kLoop, calls=%store
  ROOT %next = (s32[], f32[5,100]{1,0}, f32[1,100]{1,0}) tuple(%number, %stored, %row)
}

%more (m: (s32[], f32[5,100], f32[1,100])) -> pred[] {
  %m = (s32[], f32[5,100]{1,0}, f32[1,100]{1,0}) parameter(0)
  ROOT %yes = pred[] constant(true)
}

%left (l: f32[8]) -> f32[8] {
  %l = f32[8]{0} parameter(0)
  ROOT %copied = f32[8]{0} copy(%l)
}

%right (o: f32[8]) -> f32[8] {
  ROOT %o = f32[8]{0} parameter(0)
}

ENTRY %main (s: (s32[], f32[5,100], f32[1,100]), t: f32[1000], i: s32[3,1], u: f32[8,50], which: s32[]) -> f32[8] {
  %s = (s32[], f32[5,100]{1,0}, f32[1,100]{1,0}) parameter(0)
  %t = f32[1000]{0} parameter(1)
  %i = s32[3,1]{1,0} parameter(2)
  %u = f32[8,50]{1,0} parameter(3)
  %which = s32[] parameter(4)
  %loop = (s32[], f32[5,100]{1,0}, f32[1,100]{1,0}) while(%s), condition=%more, body=%body, backend_config={"known_trip_count":{"n":"5"}}
  %three = f32[3]{0} fusion(%t, %i), kind=kLoop, calls=%look_up
  %eight = f32[8]{0} fusion(%u), kind=kInput, calls=%sum_of_squares
  ROOT %one = f32[8]{0} conditional(%which, %eight, %eight), branch_computations={%left, %right}
}
"""


def test_each_kernel_is_counted_as_often_as_it_is_launched() -> None:
    cost = cost_of(PROGRAM)
    assert {kernel.name: kernel.times for kernel in cost.kernels} == {
        "stored": 5,
        "three": 1,
        "eight": 1,
        "copied": 1,
    }
    assert cost.launches == 8
    assert cost.waits == 1  # the branch; the loop's turns are known


def test_bytes_are_those_that_are_touched() -> None:
    found = {kernel.name: kernel.bytes for kernel in cost_of(PROGRAM).kernels}
    assert found["stored"] == 400 + 400 + 4  # a row in, a row out, its number; not the array
    assert (
        found["three"] == 3 * 32 + 3 * 4 + 3 * 4
    )  # three sectors, three indices, three numbers out
    assert found["eight"] == 4 * (8 * 50 + 8)
    assert found["copied"] == 4 * (8 + 8)


def test_operations_are_counted_where_they_are_asked_for() -> None:
    found = {kernel.name: kernel.operations for kernel in cost_of(PROGRAM).kernels}
    assert found["eight"] == 2 * 8 * 50  # as many products as sums


def test_a_product_of_matrices_and_convolutions() -> None:
    lines = (
        "  ROOT %c = f32[6,7]{1,0} dot(%a, %b), lhs_contracting_dims={1}, rhs_contracting_dims={0}",
        '  ROOT %c = f32[2,9,9,4]{3,2,1,0} custom-call(%a, %b), dim_labels=b01f_01io->b01f, custom_call_target="__cudnn$convForward"',
        '  ROOT %c = f32[5,5,3,4]{3,2,1,0} custom-call(%a, %b), dim_labels=b01f_01io->b01f, custom_call_target="__cudnn$convBackwardFilter"',
    )
    shapes = (
        ("f32[6,5]", "f32[5,7]"),
        ("f32[2,9,9,3]", "f32[5,5,3,4]"),
        ("f32[2,9,9,3]", "f32[2,9,9,4]"),
    )
    for line, (a, b), number in zip(
        lines, shapes, (6 * 7 * 5, *[2 * 9 * 9 * 4 * 5 * 5 * 3] * 2), strict=True
    ):
        text = f"ENTRY %main (a: {a}, b: {b}) -> f32[] {{\n  %a = {a} parameter(0)\n  %b = {b} parameter(1)\n{line}\n}}\n"
        assert [kernel.operations for kernel in cost_of(text).kernels] == [number]


def test_a_kernel_of_triton_reads_and_writes_all_that_it_is_given() -> None:
    text = """ENTRY %main (a: u8[64,276], b: u32[64,20]) -> u32[64,9] {
  %a = u8[64,276]{1,0} parameter(0)
  %b = u32[64,20]{1,0} parameter(1)
  ROOT %picked = u32[64,9]{1,0} custom-call(%a, %b), custom_call_target="__gpu$xla.gpu.triton", backend_config={ir = "ML\\EF", num_warps = 4 : i32}
}
"""
    (kernel,) = cost_of(text).kernels
    assert kernel.bytes == 64 * (276 + 4 * 20 + 4 * 9)


def test_the_time_is_that_of_the_launch_or_of_the_bytes() -> None:
    text = "ENTRY %main (a: f32[{n}]) -> f32[{n}] {{\n  %a = f32[{n}]{{0}} parameter(0)\n  ROOT %b = f32[{n}]{{0}} copy(%a)\n}}\n"
    assert cost_of(text.format(n=8)).seconds(GPUS["a100"]) == pytest.approx((2e-6, 3.5e-6))
    low, high = cost_of(text.format(n=10**8)).seconds(GPUS["a100"])
    assert low == high == pytest.approx(8e8 / (0.85 * 1555e9) + 1e-6)


def test_what_is_no_module_is_refused() -> None:
    with pytest.raises(ValueError, match="ENTRY"):
        cost_of("no program")


def test_a_kernel_names_the_functions_that_it_comes_from() -> None:
    """The last three of a stack of calls; none of JAX's own. A module writes each parent's number one too high."""
    text = """HloModule jit_step

FileNames
1 "games/coins.py"
2 "lib/site-packages/jax/core.py"

FunctionNames
1 "step"
2 "walk"
3 "bind"

FileLocations
1 {file_name_id=1 function_name_id=1 line=4 end_line=4 column=6 end_column=35}
2 {file_name_id=1 function_name_id=2 line=9 end_line=9 column=6 end_column=35}
3 {file_name_id=2 function_name_id=3 line=2 end_line=2 column=6 end_column=35}

StackFrames
1 {file_location_id=1 parent_frame_id=1}
2 {file_location_id=2 parent_frame_id=2}
3 {file_location_id=3 parent_frame_id=3}

ENTRY %main (x: f32[8]) -> f32[8] {
  %x = f32[8]{0} parameter(0)
  %one = f32[8]{0} sine(%x), metadata={op_name="a" stack_frame_id=3}
  ROOT %two = f32[8]{0} negate(%one), metadata={op_name="b" stack_frame_id=1}
}
"""
    assert [kernel.made_by for kernel in cost_of(text).kernels] == [("step > walk",), ("step",)]
