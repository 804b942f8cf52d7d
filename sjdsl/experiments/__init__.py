"""Experiments with policies: cross-play, Schelling diagrams of cooperators and defectors, and
scenarios with focal agents."""

from typing import TYPE_CHECKING

from sjdsl.lazy_names import lazy_names

if TYPE_CHECKING:
    from .crossplay import cross_play as cross_play
    from .diagram import Diagram as Diagram
    from .mixtures import CrossPlay as CrossPlay
    from .players import find_pool as find_pool
    from .refusals import ExperimentError as ExperimentError
    from .scenario_scores import ScenarioScores as ScenarioScores
    from .scenarios import play_scenarios as play_scenarios
    from .schelling import schelling_diagram as schelling_diagram

__getattr__ = lazy_names(
    __name__,
    {
        "crossplay": ("cross_play",),
        "diagram": ("Diagram",),
        "mixtures": ("CrossPlay",),
        "players": ("find_pool",),
        "refusals": ("ExperimentError",),
        "scenario_scores": ("ScenarioScores",),
        "scenarios": ("play_scenarios",),
        "schelling": ("schelling_diagram",),
    },
)
