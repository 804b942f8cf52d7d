"""Experiments with policies: cross-play, Schelling diagrams of cooperators and defectors, and scenarios with focal agents."""

from typing import TYPE_CHECKING

from sjdsl.lazy_names import lazy_names

if TYPE_CHECKING:
    from .crossplay import cross_play
    from .diagram import Diagram
    from .mixtures import CrossPlay
    from .players import find_pool
    from .refusals import ExperimentError
    from .scenario_scores import ScenarioScores
    from .scenarios import play_scenarios
    from .schelling import schelling_diagram

__all__ = ["CrossPlay", "Diagram", "ExperimentError", "ScenarioScores", "cross_play", "find_pool", "play_scenarios", "schelling_diagram"]

__getattr__ = lazy_names(
    __name__,
    {
        "CrossPlay": "mixtures",
        "Diagram": "diagram",
        "ExperimentError": "refusals",
        "ScenarioScores": "scenario_scores",
        "cross_play": "crossplay",
        "find_pool": "players",
        "play_scenarios": "scenarios",
        "schelling_diagram": "schelling",
    },
)
