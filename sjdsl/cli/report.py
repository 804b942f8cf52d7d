"""`sjdsl report`: makes tables, pictures and a page from the results of runs, sweeps, diagrams and
cross-play."""

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
    help="The new folder to write to.",
)
def command(sources: tuple[str, ...], output: str) -> None:
    """Makes a report of DIRs: a page, a CSV for each table, pictures as PNG and SVG, and the
    results as CSV.

    DIR is the folder of a run, a sweep, a Schelling diagram or a cross-play, a folder of such
    folders, or the `data` of an earlier report. Of results found twice, the folder named later
    wins.
    """
    require("results", "pandas", "rliable")
    require("plots", "matplotlib")
    folder = Path(output)
    require_folder_of(folder)
    call = shlex.join(["sjdsl", "report", *sources, "-o", output])
    with stages("reading the results and drawing"):
        from sjdsl.results.figures import counted
        from sjdsl.results.report import write_report

        report = write_report([Path(source) for source in sources], folder, call)
    for note in report.notes:
        click.echo(f"note: {note}", err=True)
    numbers = (
        counted(report.runs, "run"),
        counted(report.seeds, "seed"),
        counted(report.tables, "table"),
        counted(report.pictures, "picture"),
    )
    click.echo(f"{folder / 'report.md'}  {', '.join(numbers)}")
