"""Experiments with policies: who meets whom, and what cooperators and defectors earn among each other."""

from typing import TYPE_CHECKING

from sjdsl.lazy_names import lazy_names

if TYPE_CHECKING:
    from .crossplay import cross_play
    from .diagram import Diagram
    from .mixtures import CrossPlay
    from .players import find_pool
    from .refusals import ExperimentError
    from .schelling import schelling_diagram

__all__ = ["CrossPlay", "Diagram", "ExperimentError", "cross_play", "find_pool", "schelling_diagram"]

__getattr__ = lazy_names(
    __name__,
    {
        "CrossPlay": "mixtures",
        "Diagram": "diagram",
        "ExperimentError": "refusals",
        "cross_play": "crossplay",
        "find_pool": "players",
        "schelling_diagram": "schelling",
    },
)
