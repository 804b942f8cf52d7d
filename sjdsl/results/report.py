"""Writes a report of results to a new folder."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from sjdsl.files import write_whole
from sjdsl.results.loading import CURVES, RESULTS, load_both, write_frame
from sjdsl.results.page import draw_pictures, file_texts, page_text
from sjdsl.results.refusals import ResultsError, ResultsWarning
from sjdsl.results.sections import report_sections
from sjdsl.results.selecting import games
from sjdsl.several import several

PAGE = "report.md"
DATA = "data"
METHOD = (
    "A cell is the mean over training seeds, with its 95 % interval (Student's t) in brackets. A "
    "single seed has no interval. "
    "A cell with a diverged seed (non-finite loss) has failed, and has no mean. "
    "Returns are summed over agents, and averaged over the episodes in which the last policy of a "
    "seed was evaluated.",
    "Seeds with different settings are never averaged. `rules 1a2b3c` (the start of a hash) marks "
    "results under an older version of the game's rules.",
)


@dataclass(frozen=True)
class Report:
    """The numbers of runs, seeds, tables and pictures in a report."""

    runs: int
    seeds: int
    tables: int
    pictures: int
    notes: tuple[str, ...]  # results that are left out or need care, a sentence each


def write_report(sources: Path | Sequence[Path], output: Path, command: str) -> Report:
    """Writes the page, its tables and data as CSV, and its pictures as PNG and SVG, each file
    atomically.

    Args:
      sources: a folder or several, as `load` takes them.
      output: a new or empty folder.
      command: the command that makes the report.
    Raises:
      ResultsError: as `load`; or the folder holds something.
    """
    if output.exists() and (not output.is_dir() or any(output.iterdir())):
        fault = "not empty" if output.is_dir() else "a file, expected a folder"
        raise ResultsError(f"`{output}` is {fault}; name another place")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ResultsWarning)
        frame, curves = load_both(several(sources))
    notes = [
        str(warning.message) for warning in caught if issubclass(warning.category, ResultsWarning)
    ]
    few: list[str] = []  # runs without an interval
    for _, rows in games(frame):
        few += [run for run, seeds in rows.groupby("run") if len(seeds) < 2]
    if few:
        notes.append(f"too few seeds for an interval, which needs at least two: {', '.join(few)}")
    sections = report_sections(frame, curves)
    tables = file_texts(sections)
    pictures = draw_pictures(sections)
    data = (
        f"The data behind the page are in [{DATA}]({DATA}): "
        "the same command on them makes the page again."
    )
    method = (*METHOD, data, f"Written by `{command}`.")
    page = page_text("Results", sections, method, notes)
    contents = {
        **{name: text.encode() for name, text in tables.items()},
        **pictures,
        f"{DATA}/{RESULTS}": write_frame(frame).encode(),
        f"{DATA}/{CURVES}": write_frame(curves).encode(),
        PAGE: page.encode(),
    }
    for name, content in contents.items():
        (output / name).parent.mkdir(parents=True, exist_ok=True)
        write_whole(output / name, content)
    return Report(
        runs=frame.run.replace("", None).nunique(),
        seeds=int((frame.record == "seed").sum()),
        tables=len(tables),
        pictures=len(pictures) // 2,
        notes=tuple(notes),
    )
