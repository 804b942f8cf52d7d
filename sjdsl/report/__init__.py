"""Reports: what runs, sweeps, diagrams, cross-play and benchmarks have found, beside the published figures."""

from typing import TYPE_CHECKING

from sjdsl.lazy_names import lazy_names

if TYPE_CHECKING:
    from .evidence import Evidence
    from .reading import read_folders
    from .refusals import ReportError
    from .written import check_report, write_report

__all__ = ["Evidence", "ReportError", "check_report", "read_folders", "write_report"]

__getattr__ = lazy_names(
    __name__,
    {
        "Evidence": "evidence",
        "ReportError": "refusals",
        "check_report": "written",
        "read_folders": "reading",
        "write_report": "written",
    },
)
