"""Sweeps: many training runs over axes of a configuration or a game, resumable, on one machine or on many."""

from typing import TYPE_CHECKING

from sjdsl.lazy_names import lazy_names

if TYPE_CHECKING:
    from .axes import Axis
    from .cells import SweepSpec
    from .plan import plan_sweep
    from .running import Outcome, prepare, sweep
    from .work import Watch, run_cell

__all__ = ["Axis", "Outcome", "SweepSpec", "Watch", "plan_sweep", "prepare", "run_cell", "sweep"]

__getattr__ = lazy_names(
    __name__,
    {
        "Axis": "axes",
        "Outcome": "running",
        "SweepSpec": "cells",
        "Watch": "work",
        "plan_sweep": "plan",
        "prepare": "running",
        "run_cell": "work",
        "sweep": "running",
    },
)
