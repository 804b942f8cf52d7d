"""`sjdsl report`: makes tables, pictures and a page of what runs, sweeps, diagrams, cross-play and benchmarks have found."""

import shlex
from pathlib import Path

import click

from sjdsl.cli.folders import require_folder_of
from sjdsl.cli.stages import stages
from sjdsl.extras import require


@click.command("report")
@click.argument("sources", nargs=-1, required=True, metavar="DIR...")
@click.option(
    "-o",
    "output",
    default="report",
    show_default=True,
    metavar="OUT",
    help="Where to write: a folder, or a page NAME.md with its files in a folder NAME.",
)
@click.option("--json", "nested", is_flag=True, help="Also write marl_eval.json, the results as the library marl-eval reads them.")
@click.option("--suite", is_flag=True, help="Show all nine games of the SocialJax paper, also those of which nothing is known yet.")
@click.option("--check", is_flag=True, help="Write nothing; report what of OUT is not up to date.")
def command(sources: tuple[str, ...], output: str, nested: bool, suite: bool, check: bool) -> int:
    """Makes a report of DIRs, beside the published figures: a page, a CSV for each table, pictures as PNG and SVG.

    DIR is the folder of a run, a sweep, a Schelling diagram or a cross-play, a folder of such folders, the `data` of an earlier report, or
    a JSON file of `sjdsl bench --json`. What is found twice is taken from the one named later.
    """
    require("plots", "matplotlib")
    path = Path(output)
    if not check:
        require_folder_of(path)
    with stages("reading the results") as say:
        from sjdsl.report.reading import read_folders
        from sjdsl.report.written import check_report, place_of, require_place, write_report

        if not check:
            require_place(place_of(path))
        evidence = read_folders([Path(source) for source in sources])
        call = shlex.join(["sjdsl", "report", *sources, "-o", output, *(["--suite"] if suite else [])])
        if check:
            return _told(check_report(evidence, path, call, suite))
        say("drawing and writing the report")
        report = write_report(evidence, path, call, suite, nested)
    for note in (*report.notes, *(report.unequal if nested else ()), *report.lacks):
        click.echo(f"note: {note}", err=True)
    place = place_of(path)
    click.echo(f"{place.page}  {_counted(len(evidence.runs), 'way')} of training, {_counted(len(evidence.seeds), 'seed')}")
    click.echo(f"{place.folder}/  {_counted(len(report.files), 'CSV file')}, {_counted(len(report.pictures), 'picture')}")
    return 0


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def _told(problems: list[str]) -> int:
    for problem in problems:
        click.echo(problem)
    return 1 if problems else 0
