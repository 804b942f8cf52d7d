"""Where a report goes: nothing that no report has written is touched, no result is lost, and a page can be checked."""

import shutil
from pathlib import Path
from unittest import mock

import pytest
from report_folders import PAPERS, random_returns, write_run, write_sweep

from sjdsl.cli import run
from sjdsl.report import Evidence, ReportError, check_report, read_folders, write_report
from sjdsl.report.markdown import FIGURES
from sjdsl.report.written import ENDINGS

COMMAND = "sjdsl report runs"
INSTALLED = "sjdsl.report.sections.over_games.is_installed"


@pytest.fixture(autouse=True)
def no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures cost more than all else here, and are drawn in another file."""
    monkeypatch.setattr("sjdsl.report.written._drawn", lambda picture: {f"{FIGURES}/{picture.name}.{end}": b"" for end in ENDINGS})


@pytest.fixture
def found(tmp_path: Path) -> Evidence:
    return read_folders([write_run(tmp_path / "runs/a", "coins", (3.0, 5.0))])


def files(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_a_page_with_its_files_in_a_folder_beside_it(tmp_path: Path, found: Evidence) -> None:
    (tmp_path / "docs").mkdir()
    write_report(found, tmp_path / "docs/results.md", COMMAND)
    assert {"results.md", "results/data/runs.csv", "results/figures/curves_coins.svg"} <= files(tmp_path / "docs")
    page = (tmp_path / "docs/results.md").read_text()
    assert "(results/figures/curves_coins.png)" in page
    assert check_report(found, tmp_path / "docs/results.md", COMMAND) == []


def test_a_report_is_made_again_from_its_own_data(tmp_path: Path, found: Evidence) -> None:
    write_report(found, tmp_path / "out", COMMAND)
    before = {name: (tmp_path / "out" / name).read_bytes() for name in files(tmp_path / "out")}
    write_report(read_folders([tmp_path / "out/data"]), tmp_path / "out", COMMAND)
    assert {name: (tmp_path / "out" / name).read_bytes() for name in files(tmp_path / "out")} == before


def test_more_results_only_add_rows(tmp_path: Path, found: Evidence) -> None:
    write_report(found, tmp_path / "out", COMMAND)
    more = write_run(tmp_path / "runs/b", "coins", (4.0,), first=2)
    write_report(read_folders([tmp_path / "out/data", more]), tmp_path / "out", COMMAND)
    rows = (tmp_path / "out/data/seeds.csv").read_text().splitlines()
    assert len(rows) == 4


def test_no_result_is_lost(tmp_path: Path, found: Evidence) -> None:
    write_report(found, tmp_path / "out", COMMAND)
    other = read_folders([write_run(tmp_path / "runs/b", "coins", (4.0,), first=2)])
    with pytest.raises(ReportError, match=r"out/data` has 2 rows of seeds that are not among what was read; name"):
        write_report(other, tmp_path / "out", COMMAND)
    assert check_report(found, tmp_path / "out", COMMAND) == []


def test_a_place_with_other_files_is_refused(tmp_path: Path, found: Evidence) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "thesis.tex").write_text("mine")
    with pytest.raises(ReportError, match=r"holds files that no report has written \(thesis.tex\)"):
        write_report(found, out, COMMAND)
    assert files(out) == {"thesis.tex"}
    (tmp_path / "notes.md").write_text("mine")
    with pytest.raises(ReportError, match=r"notes.md` is there, and no report has written it"):
        write_report(found, tmp_path / "notes.md", COMMAND)
    (tmp_path / "file").write_text("mine")
    with pytest.raises(ReportError, match="is a file, and a folder is wanted"):
        write_report(found, tmp_path / "file", COMMAND)
    write_report(found, tmp_path / "good", COMMAND)
    (tmp_path / "good/figures/mine.png").write_text("mine")
    with pytest.raises(ReportError, match=r"figures/mine.png"):
        write_report(found, tmp_path / "good", COMMAND)


def test_a_report_that_was_interrupted_is_written_again(tmp_path: Path, found: Evidence) -> None:
    """What was being written when the disk was full, or the process was killed, is no file of somebody else's."""
    with (
        mock.patch("sjdsl.report.written.write_whole", side_effect=OSError(28, "No space left on device")),
        pytest.raises(OSError, match="space"),
    ):
        write_report(found, tmp_path / "out", COMMAND)
    (tmp_path / "out/tables").mkdir(exist_ok=True)
    (tmp_path / "out/tables/exchange.csv.7-vm.unfinished").write_text("half")
    write_report(found, tmp_path / "out", COMMAND)
    assert check_report(found, tmp_path / "out", COMMAND) == []


def test_files_that_are_no_longer_part_of_it_are_removed(tmp_path: Path, found: Evidence) -> None:
    write_report(found, tmp_path / "out", COMMAND, nested=True)
    assert "marl_eval.json" in files(tmp_path / "out")
    write_report(found, tmp_path / "out", COMMAND)
    assert "marl_eval.json" not in files(tmp_path / "out")


def test_what_is_not_up_to_date(tmp_path: Path, found: Evidence) -> None:
    out = tmp_path / "out"
    write_report(found, out, COMMAND)
    (out / FIGURES / "curves_coins.png").unlink()
    (out / "tables/exchange.csv").write_text("by hand")
    (out / "report.md").write_text((out / "report.md").read_text().replace("4 [", "5 ["))
    assert check_report(found, out, COMMAND) == [
        f"{out / 'report.md'}: not what its results say",
        f"{out / 'tables/exchange.csv'}: not what its results say",
        f"{out / 'figures/curves_coins.png'}: missing",
    ]


def test_a_section_stays_where_its_extra_is_missing_and_nothing_has_changed(tmp_path: Path) -> None:
    runs = [write_run(tmp_path / game, game, (30.0, 50.0), reward="common", **PAPERS) for game in ("coins", "harvest_open")]
    random_returns(tmp_path / "games.json", {"coins": 0.0, "harvest_open": 10.0}, PAPERS["rules"])
    found, out = read_folders([*runs, tmp_path / "games.json"]), tmp_path / "out"
    means = {"IPPO, common": (0.12345, 0.1, 0.2)}
    with mock.patch(INSTALLED, return_value=True), mock.patch("sjdsl.report.sections.over_games.interquartile_means", return_value=means):
        write_report(found, out, COMMAND)
    assert "| IPPO, common | 0.1235 [0.1, 0.2] | 2 seeds, 2 games, 400 steps, unnamed CPU |" in (out / "report.md").read_text()
    assert check_report(found, out, COMMAND) == []
    report = write_report(found, out, COMMAND)
    assert [*report.kept] == ["Over games"]
    assert {"tables/over_games.csv", "figures/performance_profiles.svg"} <= files(out)
    more = read_folders([out / "data", write_run(tmp_path / "more", "coins", (90.0,), first=0, reward="common", **PAPERS)])
    report = write_report(more, out, COMMAND)
    assert report.lacks == (
        "This section takes the extra `results`: install it with `pip install 'sjdsl[results]'` and make the report again.",
    )
    assert "0.1235" not in (out / "report.md").read_text()
    assert "tables/over_games.csv" not in files(out)


def test_svo_at_each_games_chosen_weight_is_one_way_over_games(tmp_path: Path) -> None:
    """The seeds that chose the weight are not among its scores, and other weights are ways of their own."""
    for game, weight in (("coins", 0.4), ("harvest_open", 0.8)):
        cells = tmp_path / "svo/cells"
        write_run(cells / f"{game}_chose", game, (1000.0, 1010.0), reward="svo", svo_weight=weight, **PAPERS)
        write_run(cells / f"{game}_is", game, (30.0, 50.0), first=2, reward="svo", svo_weight=weight, **PAPERS)
    write_sweep(tmp_path / "svo", "svo", {path.name: 1 + path.name.endswith("is") for path in cells.iterdir()})
    random_returns(tmp_path / "games.json", {"coins": 0.0, "harvest_open": 10.0}, PAPERS["rules"])
    with mock.patch(INSTALLED, return_value=True), mock.patch("sjdsl.report.sections.over_games.interquartile_means") as means:
        means.return_value = {"IPPO, SVO 90°, chosen weight": (0.2, 0.1, 0.3)}
        write_report(read_folders([tmp_path / "svo", tmp_path / "games.json"]), tmp_path / "out", COMMAND)
    (scores,) = means.call_args.args
    assert list(scores) == ["IPPO, SVO 90°, chosen weight"]
    coins, harvest = scores["IPPO, SVO 90°, chosen weight"].T
    assert coins.tolist() == pytest.approx([30 / 164, 50 / 164])
    assert harvest.tolist() == pytest.approx([20 / 410, 40 / 410])
    assert "The chosen weight of SVO is that of each game's own sweep." in (tmp_path / "out/report.md").read_text()


def test_what_marl_eval_will_not_take_is_said_where_its_file_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_run(Path("runs/a"), "coins", (3.0, 5.0))
    write_run(Path("runs/b"), "pd_arena", (3.0, 5.0), reward="common")
    for more, said in (([], False), (["--json"], True)):
        assert run(["report", "runs", "-o", "out", *more]) == 0
        assert ("marl-eval wants the same ways" in capsys.readouterr().err) is said


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_run(Path("runs/a"), "coins", (3.0, 5.0))
    write_run(Path("runs/b"), "coins", (3.0,), status="running", reward="common")
    assert run(["report", "runs", "-o", "out", "--json"]) == 0
    told = capsys.readouterr()
    assert "out/report.md  2 ways of training, 3 seeds" in told.out
    assert "note: `runs/b` is not finished" in told.err
    assert run(["report", "runs", "-o", "out", "--check"]) == 0
    shutil.rmtree("runs/b")
    for arguments, said in (
        (["nowhere", "-o", "other"], "error: there is no folder or file `nowhere`"),
        (["runs", "-o", "out"], "name `out/data`, too, and they stay"),
        (["out/report.md", "-o", "other"], "is nothing that a report is made of"),
        (["runs", "-o", "runs"], "error: `runs` holds files that no report has written"),
        (["runs", "-o", "no/such/place"], "error: there is no folder `no/such`"),
    ):
        assert run(["report", *arguments]) == 1
        assert said in capsys.readouterr().err
    assert run(["report", "-o", "out"]) == 2
