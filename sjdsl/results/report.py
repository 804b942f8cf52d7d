"""Writes a report of results to a folder; touches nothing that no report has written."""

import json
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from sjdsl.experiments.result_files import write_compact_json
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
    "A cell is the mean over training seeds with its 95 % interval by Student's t, in brackets. One seed has no interval. "
    "A cell with a seed whose loss was not finite has failed, and has no mean. "
    "Returns are summed over agents, and are means over the episodes in which the last policy of a seed was evaluated.",
    "Seeds of different settings are never averaged. `rules` and six letters mark results under rules that the bundled game no longer has.",
)


@dataclass(frozen=True)
class Report:
    """What was written: the number of runs, seeds, tables and pictures; notes: what is left out or to be known, a sentence each."""

    runs: int
    seeds: int
    tables: int
    pictures: int
    notes: tuple[str, ...]


def write_report(sources: Sequence[Path], output: Path, command: str, nested: bool = False) -> Report:
    """Writes the page, the CSV of its tables and of its data, and its pictures as PNG and SVG, each file whole or not at all.

    Args:
      sources: folders, as `load` takes them.
      output: a folder; new, empty, or that of an earlier report.
      command: the call that makes the report.
      nested: whether `marl_eval.json` is written, too.
    Raises:
      ResultsError: what `load` refuses; the place holds something else, or results that would be lost.
    """
    before = require_place(output)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ResultsWarning)
        frame, curves = load_both(sources)
    require_nothing_lost(output, frame)
    notes = [str(warning.message) for warning in caught if issubclass(warning.category, ResultsWarning)]
    few = [run for _, rows in games(frame) for run, seeds in rows.groupby("run") if len(seeds) < 2]
    notes += [f"too few seeds for an interval, which takes two at least: {', '.join(few)}"] if few else []
    sections = report_sections(frame, curves)
    contents: dict[str, bytes] = {name: text.encode() for name, text in file_texts(sections).items()}
    pictures = drawn(sections)
    contents |= pictures | {f"{DATA}/{RESULTS}": write_frame(frame).encode(), f"{DATA}/{CURVES}": write_frame(curves).encode()}
    if nested:
        found, unequal = marl_eval(frame, curves)
        contents[MARL_EVAL] = json.dumps(found, indent=1).encode()
        notes += unequal
    method = (*METHOD, f"All that the page is made of is in [{DATA}]({DATA}): the same command on it makes the page again.")
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
    """Returns the files of the report in a folder that a new one may replace: it is new or empty, or holds a report and nothing else.

    What an interrupted command was writing does not count.

    Raises:
      ResultsError: there are other files, which are named.
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
    """Returns the files of the report that is there, by their names in its folder."""
    try:
        listed = set(map(str, read_json(folder / LISTED)["files"]))
    except (OSError, ValueError, KeyError, TypeError):
        return set()
    inside = folder.resolve()  # what is listed and not written again is removed: nothing outside, whoever wrote the list
    return {name for name in listed if (inside / name).resolve().is_relative_to(inside)}


def require_nothing_lost(folder: Path, frame: "pd.DataFrame") -> None:
    """Checks that what the report in a folder was made of is in the new results, too.

    Raises:
      ResultsError: something is not: then its `data` has to be named among what is read.
    """
    data = folder / DATA
    if not (data / RESULTS).is_file():
        return
    before = load_both([data])[0]
    lost = _keys(before) - _keys(frame)
    if lost:
        raise ResultsError(
            f"`{data}` has {counted(len(lost), 'row')} that are not among what was read; name `{data}`, too, and they stay, "
            "or write the report to another place"
        )


def _keys(frame: "pd.DataFrame") -> set[tuple[str, ...]]:
    return set(frame.reindex(columns=KEY).astype("string").fillna("").itertuples(index=False, name=None))
