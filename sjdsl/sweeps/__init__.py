"""Sweeps: many training runs over axes of a configuration or a game, resumable, on one machine or
on many.
"""

from typing import TYPE_CHECKING

from sjdsl.lazy_names import lazy_names

if TYPE_CHECKING:
    from .axes import Axis as Axis
    from .cells import SweepSpec as SweepSpec
    from .plan import plan_sweep as plan_sweep
    from .running import Outcome as Outcome
    from .running import prepare as prepare
    from .running import sweep as sweep
    from .work import Watch as Watch
    from .work import run_cell as run_cell

__getattr__ = lazy_names(
    __name__,
    {
        "axes": ("Axis",),
        "cells": ("SweepSpec",),
        "plan": ("plan_sweep",),
        "running": ("Outcome", "prepare", "sweep"),
        "work": ("Watch", "run_cell"),
    },
)
