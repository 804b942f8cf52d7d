"""Reductions in both forms: NumPy's values; for GPUs, none of a size of which XLA makes a kernel."""

import re
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.runtime.forms import forced
from sjdsl.runtime.reductions import all_of, any_of, argmax_of, count_of, max_of, min_of, sum_of

KERNELS: dict[str, tuple[Callable[..., Any], Callable[..., Any]]] = {
    "any": (any_of, np.any),
    "all": (all_of, np.all),
    "count": (count_of, np.count_nonzero),
    "sum": (sum_of, np.sum),
    "max": (max_of, np.max),
    "min": (min_of, np.min),
    "argmax": (argmax_of, np.argmax),
}
SHAPES = [((6, 4), -1), ((4, 6), 0), ((2, 2), None), ((3, 2, 4), (1, 2))]


@pytest.mark.usefixtures("form")
@pytest.mark.parametrize("dtype", ["bool", "uint8", "int32", "float32"])
@pytest.mark.parametrize("kernel", KERNELS)
def test_a_reduction_is_that_of_numpy(kernel: str, dtype: str) -> None:
    """Also of entries that are all less than 0, or all 0."""
    ours, of_numpy = KERNELS[kernel]
    for shape, axis in SHAPES:
        if kernel == "argmax" and not isinstance(axis, int):
            continue
        if kernel == "count" and dtype != "bool":
            continue
        numbers = np.random.default_rng(0).integers(-3, 4, shape)
        for values in (numbers, -abs(numbers) - 1, np.zeros(shape, int)):
            if dtype in ("bool", "uint8"):
                values = abs(values) % 2
            array = values.astype(dtype)
            options = {"dtype": jnp.int32} if kernel == "sum" else {}
            result = ours(jnp.asarray(array), axis=axis, **options)
            np.testing.assert_array_equal(result, of_numpy(array, axis=axis))


@pytest.mark.parametrize("size", [2, 4, 5, 8, 16, 31, 32, 64])
def test_on_a_gpu_no_reduction_has_a_size_that_divides_a_warp(size: int) -> None:
    with forced("gpu"):
        traced = jax.make_jaxpr(lambda x: sum_of(x, axis=1))(jnp.zeros((3, size)))
    (reduced,) = re.findall(r"reduce_sum.*", str(traced))
    found = 32 % size == 0 and size < 32
    assert ("pad" in str(traced)) == found, reduced
