"""Writes a report to its place, or checks that the one there is up to date; touches nothing that no report has written."""

from dataclasses import dataclass
from pathlib import Path

from sjdsl.experiments.pictures import picture_bytes
from sjdsl.experiments.result_files import write_compact_json
from sjdsl.files import UNFINISHED, read_json, write_whole
from sjdsl.report.evidence import Evidence, key_of
from sjdsl.report.evidence_files import is_evidence, read_evidence
from sjdsl.report.markdown import FIGURES
from sjdsl.report.page import Picture
from sjdsl.report.refusals import ReportError
from sjdsl.report.report import DATA, Report, make_report

PAGE, LISTED, MARL_EVAL = "report.md", "report_files.json", "marl_eval.json"
ENDINGS = ("png", "svg")


@dataclass(frozen=True)
class Place:
    """Where a report is: its page, and the folder of all else."""

    page: Path
    folder: Path

    @property
    def seen(self) -> str:
        """The folder as seen from the page."""
        return "" if self.page.parent == self.folder else f"{self.folder.name}/"

    @property
    def before(self) -> str:
        """The page that is there; empty where there is none."""
        return self.page.read_text(encoding="utf-8") if self.page.is_file() else ""


def place_of(output: Path) -> Place:
    """Returns where a report goes: a folder with `report.md` in it, or a page `NAME.md` with the folder `NAME` beside it."""
    return Place(output, output.with_suffix("")) if output.suffix == ".md" else Place(output / PAGE, output)


def require_place(place: Place) -> None:
    """Checks that a report may be written to a place: it is new or empty, or holds a report and nothing else.

    What an interrupted command was writing does not count.

    Raises:
      ReportError: there are other files, which are named.
    """
    listed = _listed(place)
    for path in (place.folder, place.page.parent):
        if path.exists() and not path.is_dir():
            raise ReportError(f"`{path}` is a file, and a folder is wanted; name another place")
    if place.page.exists() and listed is None:
        raise ReportError(f"`{place.page}` is there, and no report has written it; name another place")
    there = (
        {
            path.relative_to(place.folder).as_posix()
            for path in place.folder.rglob("*")
            if path.is_file() and not path.name.endswith(UNFINISHED)
        }
        if place.folder.is_dir()
        else set()
    )
    others = sorted(there - {*(listed or ()), LISTED})
    if others:
        more = f" and {len(others) - 3} more" if len(others) > 3 else ""
        raise ReportError(f"`{place.folder}` holds files that no report has written ({', '.join(others[:3])}{more}); name another place")


def _listed(place: Place) -> set[str] | None:
    """Returns the files of the report that is there, by their names in its folder; None where there is none."""
    try:
        listed = set(map(str, read_json(place.folder / LISTED)["files"]))
    except (OSError, ValueError, KeyError, TypeError):
        return None
    inside = place.folder.resolve()  # what is listed and not written again is removed: nothing outside, whoever wrote the list
    return {name for name in listed if (inside / name).resolve().is_relative_to(inside)}


def require_nothing_lost(place: Place, evidence: Evidence) -> None:
    """Checks that what the report there was made of is in the new evidence, too.

    Raises:
      ReportError: something is not: then its `data` has to be named among what is read.
    """
    data = place.folder / DATA
    if not is_evidence(data):
        return
    before, now = read_evidence(data).rows(), evidence.rows()
    for name in ("runs", "seeds", "diagrams", "speeds", "updates", "random", "meetings"):
        lost = {key_of(name, row) for row in before[name]} - {key_of(name, row) for row in now[name]}
        if lost:
            raise ReportError(
                f"`{data}` has {len(lost)} rows of {name} that are not among what was read; name `{data}`, too, and they stay, "
                "or write the report to another place"
            )


def write_report(evidence: Evidence, output: Path, command: str, whole_suite: bool = False, nested: bool = False) -> Report:
    """Writes the page, the CSV of its tables and of its data, and its pictures as PNG and SVG, each file whole or not at all.

    Args:
      evidence: as `read_folders` returns it.
      output: a folder, or a page `NAME.md`; new, empty, or an earlier report.
      command: the call that makes the report.
      whole_suite: whether tables have all nine games of the paper.
      nested: whether `marl_eval.json` is written, too.
    Raises:
      ReportError: the place holds something else, or results that would be lost.
    """
    place = place_of(output)
    require_place(place)
    require_nothing_lost(place, evidence)
    report = make_report(evidence, command, place.seen, whole_suite, place.before)
    contents: dict[str, bytes] = {name: text.encode() for name, text in report.files.items()}
    for picture in report.pictures:
        contents |= _drawn(picture)
    before = _listed(place) or set()
    kept = {name for name in before if any(name.rpartition(".")[0] in text for text in report.kept.values())}
    names = sorted({*contents, *kept, *([MARL_EVAL] if nested else []), *([PAGE] if not place.seen else [])})
    place.folder.mkdir(parents=True, exist_ok=True)
    write_compact_json(place.folder / LISTED, {"written_by": "sjdsl report", "files": sorted(before | set(names))})
    for name, content in contents.items():
        (place.folder / name).parent.mkdir(exist_ok=True)
        write_whole(place.folder / name, content)
    if nested:
        write_compact_json(place.folder / MARL_EVAL, report.marl_eval)
    write_whole(place.page, report.page.encode())
    for name in before - set(names):
        (place.folder / name).unlink(missing_ok=True)
    write_compact_json(place.folder / LISTED, {"written_by": "sjdsl report", "files": names})
    return report


def _drawn(picture: Picture) -> dict[str, bytes]:
    """Returns the files of a picture, PNG and SVG."""
    figure = picture.draw()
    return {f"{FIGURES}/{picture.name}.{ending}": picture_bytes(figure, ending) for ending in ENDINGS}


def check_report(evidence: Evidence, output: Path, command: str, whole_suite: bool = False) -> list[str]:
    """Returns what of a report is not as `write_report` would write it: texts that differ, pictures that are missing."""
    place = place_of(output)
    report = make_report(evidence, command, place.seen, whole_suite, place.before)
    problems = [] if place.before == report.page else [f"{place.page}: not what its results say"]
    for name, text in report.files.items():
        path = place.folder / name
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            problems.append(f"{path}: not what its results say" if path.is_file() else f"{path}: missing")
    pictures = [place.folder / FIGURES / f"{picture.name}.{ending}" for picture in report.pictures for ending in ENDINGS]
    return [*problems, *(f"{path}: missing" for path in pictures if not path.is_file())]
