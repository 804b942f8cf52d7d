"""Reads the folders and files that a report is made of: finds out what each is, and has its reader read it."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from sjdsl.report.evidence import Evidence, merged
from sjdsl.report.evidence_files import is_evidence, read_evidence
from sjdsl.report.reading_benchmarks import is_benchmark, read_benchmark
from sjdsl.report.reading_experiments import is_cross_play, is_diagram, read_cross_play, read_diagram
from sjdsl.report.reading_random import is_random, read_random
from sjdsl.report.reading_runs import is_run, read_run
from sjdsl.report.reading_sweeps import is_cell, is_sweep, read_cell, read_sweep
from sjdsl.report.refusals import ReportError
from sjdsl.stored_hashes import current_hash

Reader = tuple[Callable[[Path], bool], Callable[[Path], Evidence]]
READERS: tuple[Reader, ...] = (
    (is_sweep, read_sweep),
    (is_cell, read_cell),
    (is_run, read_run),
    (is_diagram, read_diagram),
    (is_cross_play, read_cross_play),
    (is_evidence, read_evidence),
    (is_benchmark, read_benchmark),
    (is_random, read_random),
)
KINDS = (
    "the folder of a run, a sweep, a Schelling diagram, a cross-play or an earlier report's `data`, "
    "or a JSON file of `sjdsl bench --json` or `sjdsl doc --all`"
)


def read_folders(paths: Sequence[Path]) -> Evidence:
    """Returns what folders and files have found, in their order: of what is found twice, the later counts.

    Raises:
      ReportError: one is not there, or is of no known kind; or cannot be read.
    """
    return merged(_with_current_hashes(_read(path)) for path in paths)


def _with_current_hashes(found: Evidence) -> Evidence:
    def renewed(row: Any) -> Any:
        return replace(row, hash=current_hash(row.hash)) if hasattr(row, "hash") else row

    return replace(found, **{name: tuple(map(renewed, rows)) for name, rows in found.rows().items()})


def _read(path: Path) -> Evidence:
    if not path.exists():
        raise ReportError(f"there is no folder or file `{path}`")
    for known, read in READERS:
        if known(path):
            return read(path)
    inside = _readable(path)
    if inside:
        return merged(_read(part) for part in inside)
    raise ReportError(f"`{path}` is nothing that a report is made of; name {KINDS}")


def _readable(path: Path) -> list[Path]:
    """Returns what a folder of folders holds that can be read; one such as `runs`, or an earlier report with its `data`."""
    parts = sorted(path.iterdir()) if path.is_dir() else []
    return [part for part in parts if any(known(part) for known, _ in READERS)]
