"""Makes a report of evidence: its sections, its page, and all its files as bytes."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sjdsl.report.contents import Contents, contents_of, notes_of_rules
from sjdsl.report.evidence import Evidence
from sjdsl.report.evidence_files import evidence_files
from sjdsl.report.markdown import TABLES, earlier_section, page_text, section_text, table_csv
from sjdsl.report.marl_eval import marl_eval
from sjdsl.report.opening import opening
from sjdsl.report.page import Picture
from sjdsl.report.sections import SECTIONS
from sjdsl.report.sections.findings import findings

DATA = "data"


@dataclass(frozen=True)
class Report:
    """A report before it is written.

    page: its text. files: the text of each other file by its name in the folder. pictures: what is still to be drawn. marl_eval: the
    nested results. kept: sections that an earlier page has of the same results, by title, where their extra is not installed here.
    lacks: what to install for sections that could not be made.
    """

    page: str
    files: dict[str, str]
    pictures: tuple[Picture, ...]
    marl_eval: dict[str, Any]
    notes: tuple[str, ...]
    unequal: tuple[str, ...]  # what marl-eval will not take of its results
    kept: dict[str, str]
    lacks: tuple[str, ...]


def make_report(evidence: Evidence, command: str, folder: str = "", whole_suite: bool = False, earlier: str = "") -> Report:
    """Returns the report of evidence.

    Args:
      evidence: as `read_folders` returns it.
      command: the call that makes the report, for its first lines.
      folder: where its files are as seen from the page: empty, or with a `/` at its end.
      whole_suite: whether tables have all nine games of the paper.
      earlier: the page that is there, of which sections stay that need an extra, where it is missing here and nothing has changed.
    """
    contents = contents_of(evidence, whole_suite)
    sections = [make(contents) for make in ((findings, *SECTIONS) if whole_suite else SECTIONS)]
    nested, unequal = marl_eval(contents)
    notes = [*_notes_of_seeds(contents), *notes_of_rules(contents), *contents.index.notes, *evidence.notes]
    stay = {section.title: text for section in sections if section.lacks and (text := earlier_section(earlier, section)) is not None}
    texts = [stay[section.title] if section.title in stay else section_text(section, folder) for section in sections]
    page = page_text("Results", opening(contents, command, f"{folder}{DATA}"), texts, notes)
    files = {f"{DATA}/{name}": text for name, text in evidence_files(evidence).items()}
    files |= {f"{TABLES}/{table.name}.csv": table_csv(table) for section in sections for table in section.tables}
    pictures = tuple(picture for section in sections for picture in section.pictures)
    lacks = tuple(section.lacks for section in sections if section.lacks and section.title not in stay)
    return Report(page, files, pictures, nested, tuple(notes), tuple(unequal), stay, lacks)


def _notes_of_seeds(contents: Contents) -> list[str]:
    """Returns which ways of training have too few seeds for an interval."""
    few: Sequence[str] = [
        run.run
        for game in contents.games
        if game.setting is not None
        for run in contents.index.runs(game.setting)
        if len(contents.index.seeds(run)) < 2
    ]
    return [f"too few seeds for an interval, which takes two at least: {', '.join(few)}"] if few else []
