"""The error that a real leaves float32 (overflow), with the part of the rules that computed it."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np

from sjdsl.compiler import ir


class LeavesFloat32(ArithmeticError):
    """A real became larger than any float32 (3.4e38), or no number at all.

    node: the statement that computes it, or the expression of a metric or check. before: steps of the episode that were over.
    """

    def __init__(self, node: ir.Node, before: int):
        super().__init__(
            "a real number leaves float32 (it is larger than 3.4e38, or no number any more)"
        )
        self.node, self.before = node, before


@contextmanager
def watched(node: Callable[[], ir.Node], before: int) -> Iterator[None]:
    """Raises LeavesFloat32 where a real leaves float32 inside; without this, NumPy warns and goes on with infinity."""
    try:
        with np.errstate(over="raise", invalid="raise"):
            yield
    except FloatingPointError:
        raise LeavesFloat32(node(), before) from None
