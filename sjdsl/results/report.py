"""Writes a report of results to a folder, without touching files that no report has written."""

import json
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from sjdsl.experiments.folder import write_compact_json
from sjdsl.files import UNFINISHED, read_json, write_whole
from sjdsl.results.figures import counted
from sjdsl.results.loading import CURVES, KEY, RESULTS, load_both, write_frame
from sjdsl.results.marl_eval import marl_eval
from sjdsl.results.page import drawn, file_texts, page_text
from sjdsl.results.refusals import ResultsError, ResultsWarning
from sjdsl.results.sections import report_sections
from sjdsl.results.selecting import games

if TYPE_CHECKING:
    import pandas as pd

PAGE, LISTED, MARL_EVAL, DATA = "report.md", "report_files.json", "marl_eval.json", "data"
METHOD = (
    "A cell is the mean over training seeds, with its 95 % interval (Student's t) in brackets. A single seed has no interval. "
    "A cell with a diverged seed (non-finite loss) has failed, and has no mean. "
    "Returns are summed over agents, and averaged over the episodes in which the last policy of a seed was evaluated.",
    "Seeds with different settings are never averaged. `rules 1a2b3c` (the start of a hash) marks results under an older version of the game's rules.",
)


@dataclass(frozen=True)
class Report:
    """What was written: the numbers of runs, seeds, tables and pictures; notes: what is left out or needs care, a sentence each."""

    runs: int
    seeds: int
    tables: int
    pictures: int
    notes: tuple[str, ...]


def write_report(sources: Sequence[Path], output: Path, command: str, nested: bool = False) -> Report:
    """Writes the page, its tables and data as CSV, and its pictures as PNG and SVG, each file atomically.

    Args:
      sources: folders, as `load` takes them.
      output: a folder: new, empty, or holding an earlier report.
      command: the command that makes the report.
      nested: whether to write `marl_eval.json` too.
    Raises:
      ResultsError: as `load`; or the folder holds something else, or results that would be lost.
    """
    before = require_place(output)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ResultsWarning)
        frame, curves = load_both(sources)
    require_nothing_lost(output, frame)
    notes = [str(warning.message) for warning in caught if issubclass(warning.category, ResultsWarning)]
    few = [run for _, rows in games(frame) for run, seeds in rows.groupby("run") if len(seeds) < 2]
    notes += [f"too few seeds for an interval, which needs at least two: {', '.join(few)}"] if few else []
    sections = report_sections(frame, curves)
    contents: dict[str, bytes] = {name: text.encode() for name, text in file_texts(sections).items()}
    pictures = drawn(sections)
    contents |= pictures | {f"{DATA}/{RESULTS}": write_frame(frame).encode(), f"{DATA}/{CURVES}": write_frame(curves).encode()}
    if nested:
        found, unequal = marl_eval(frame, curves)
        contents[MARL_EVAL] = json.dumps(found, indent=1).encode()
        notes += unequal
    method = (*METHOD, f"The data behind the page are in [{DATA}]({DATA}): the same command on them makes the page again.")
    page = page_text("Results", f"Written by `{command}`.", sections, method, notes)
    contents[PAGE] = page.encode()
    _write(output, contents, before)
    seeds = int((frame.record == "seed").sum())
    return Report(frame.run.replace("", None).nunique(), seeds, len(file_texts(sections)), len(pictures) // 2, tuple(notes))


def _write(folder: Path, contents: dict[str, bytes], before: set[str]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    write_compact_json(folder / LISTED, {"written_by": "sjdsl report", "files": sorted(before | set(contents))})
    for name, content in contents.items():
        (folder / name).parent.mkdir(exist_ok=True)
        write_whole(folder / name, content)
    for name in before - set(contents):
        (folder / name).unlink(missing_ok=True)
    write_compact_json(folder / LISTED, {"written_by": "sjdsl report", "files": sorted(contents)})


def require_place(folder: Path) -> set[str]:
    """Returns the files that a new report may replace in a folder, which must be new or empty, or hold a report and nothing else.

    Unfinished files of an interrupted command don't count.

    Raises:
      ResultsError: there are other files.
    """
    if folder.exists() and not folder.is_dir():
        raise ResultsError(f"`{folder}` is a file, expected a folder; name another place")
    listed = _listed(folder)
    there = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file() and not path.name.endswith(UNFINISHED)}
    others = sorted(there - {*listed, LISTED})
    if others:
        more = f" and {len(others) - 3} more" if len(others) > 3 else ""
        raise ResultsError(f"`{folder}` holds files that no report has written ({', '.join(others[:3])}{more}); name another place")
    return listed


def _listed(folder: Path) -> set[str]:
    """Returns the names of the files of the report in a folder."""
    try:
        listed = set(map(str, read_json(folder / LISTED)["files"]))
    except (OSError, ValueError, KeyError, TypeError):
        return set()
    inside = folder.resolve()  # files listed here get removed, so ignore names outside the folder
    return {name for name in listed if (inside / name).resolve().is_relative_to(inside)}


def require_nothing_lost(folder: Path, frame: "pd.DataFrame") -> None:
    """Checks that the new results include those of the report in a folder.

    Raises:
      ResultsError: some are missing, so its `data` has to be named as a source.
    """
    data = folder / DATA
    if not (data / RESULTS).is_file():
        return
    before = load_both([data])[0]
    lost = _keys(before) - _keys(frame)
    if lost:
        raise ResultsError(
            f"`{data}` has {counted(len(lost), 'row')} that the new results lack; name `{data}` as well to keep them, "
            "or write the report to another folder"
        )


def _keys(frame: "pd.DataFrame") -> set[tuple[str, ...]]:
    return set(frame.reindex(columns=KEY).astype("string").fillna("").itertuples(index=False, name=None))
