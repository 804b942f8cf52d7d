"""One report of one of everything, written once."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest import mock

import pytest
from report_folders import AGENTS, RULES, VARIANTS, write_everything

from sjdsl.report import read_folders, write_report
from sjdsl.report.evidence import Evidence


@pytest.fixture(scope="package")
def sources(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder `runs` with one of everything in it."""
    folder = tmp_path_factory.mktemp("sources") / "runs"
    folder.mkdir()
    write_everything(folder)
    return folder


@pytest.fixture(scope="package")
def evidence(sources: Path) -> Evidence:
    """What is in it, as it is read from its parent folder: names in notes are short."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(sources.parent)
        return read_folders([Path("runs")])


@contextmanager
def fixed() -> Iterator[None]:
    """Has the bundled games' rules be those of the folders here, but for harvest_open; and `rliable` not installed."""
    now = {**RULES, "harvest_open": "new"}
    known = {(game, ""): (rules, AGENTS[game]) for game, rules in now.items()}
    known |= {("coins", "socialjax"): ("c02", 2), ("gift_refinement", "socialjax+automatic"): ("a17", 5)}
    with (
        mock.patch("sjdsl.report.contents.rules_now", lambda *game: known.get(game)),
        mock.patch("sjdsl.report.contents.variant_now", lambda _, rules: VARIANTS.get(rules)),
        mock.patch("sjdsl.report.sections.over_games.is_installed", return_value=False),
    ):
        yield


@pytest.fixture(autouse=True)
def fixed_surroundings() -> Iterator[None]:
    """Has what a report says not depend on today's rules and on what is installed."""
    with fixed():
        yield


@pytest.fixture(scope="package")
def written(evidence: Evidence, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder that a report of it was written to, with its pictures and the JSON of marl-eval."""
    folder = tmp_path_factory.mktemp("written") / "report"
    with fixed():
        write_report(evidence, folder, "sjdsl report runs -o report", nested=True)
    return folder
