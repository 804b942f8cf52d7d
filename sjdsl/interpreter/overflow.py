"""The error that a real is out of the range of float32 (overflow).

It has the part of the rules that computed it.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np

from sjdsl.compiler import ir


class LeavesFloat32(ArithmeticError):
    """A real became larger than any float32 (3.4e38), or not a number (NaN).

    node: the statement that computes it, or the expression of a metric or check.
    before: completed steps of the episode.
    """

    def __init__(self, node: ir.Node, before: int):
        super().__init__(
            "a real number leaves float32 (it is larger than 3.4e38, or no number any more)"
        )
        self.node = node
        self.before = before


@contextmanager
def watched(node: Callable[[], ir.Node], before: int) -> Iterator[None]:
    """Raises LeavesFloat32 if a real inside leaves float32.

    NumPy alone would warn and return infinity.
    """
    try:
        with np.errstate(over="raise", invalid="raise"):
            yield
    except FloatingPointError:
        raise LeavesFloat32(node(), before) from None
