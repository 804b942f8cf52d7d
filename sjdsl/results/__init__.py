"""Results of runs, sweeps, Schelling diagrams and cross-play as tables of pandas, and the report that is made of them."""

from typing import TYPE_CHECKING

from sjdsl.lazy_names import lazy_names

if TYPE_CHECKING:
    from .loading import load, load_curves
    from .refusals import ResultsError, ResultsWarning
    from .report import write_report

__all__ = ["ResultsError", "ResultsWarning", "load", "load_curves", "write_report"]

__getattr__ = lazy_names(
    __name__,
    {
        "ResultsError": "refusals",
        "ResultsWarning": "refusals",
        "load": "loading",
        "load_curves": "loading",
        "write_report": "report",
    },
)
