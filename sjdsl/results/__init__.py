"""Results of runs, sweeps, Schelling diagrams and cross-play as tables of pandas, and the report
that is made of them.
"""

from typing import TYPE_CHECKING

from sjdsl.lazy_names import lazy_names

if TYPE_CHECKING:
    from .loading import load as load
    from .loading import load_curves as load_curves
    from .refusals import ResultsError as ResultsError
    from .refusals import ResultsWarning as ResultsWarning
    from .report import write_report as write_report

__getattr__ = lazy_names(
    __name__,
    {
        "loading": ("load", "load_curves"),
        "refusals": ("ResultsError", "ResultsWarning"),
        "report": ("write_report",),
    },
)
