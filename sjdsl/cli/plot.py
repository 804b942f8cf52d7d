"""`sjdsl plot`: plots the learning curves of runs in one picture."""

from pathlib import Path

import click

from sjdsl.cli.folders import require_folder_of
from sjdsl.extras import require
from sjdsl.short_paths import short_names


@click.command("plot")
@click.argument("runs", nargs=-1, required=True, metavar="RUN...")
@click.option(
    "-o",
    "output",
    default="curves.png",
    show_default=True,
    metavar="FILE",
    help="The picture to write: a .png, .svg or .pdf.",
)
@click.option(
    "--metric",
    default="collective_return",
    show_default=True,
    help="A column of metrics.jsonl.",
)
@click.option("--by", type=click.Choice(["trial"]), help="A curve for each trial of an episode.")
def command(runs: tuple[str, ...], output: str, metric: str, by: str | None) -> None:
    """Plots a metric of RUNs over environment steps: the mean over the seeds of each run, and their
    range.

    RUN is a folder that `sjdsl train` wrote, named in the picture by the part of its path that
    tells it apart, or NAME=FOLDER to choose its name.
    """
    short = short_names(text for text in runs if "=" not in text)
    folders: list[tuple[str, Path]] = []  # with their names in the picture
    for text in runs:
        name, equals, folder = text.partition("=")
        folders.append((name, Path(folder)) if equals else (short[text], Path(text)))
    path = Path(output)
    if path.suffix not in (".png", ".svg", ".pdf"):
        raise click.UsageError(f"`{path}` must end in .png, .svg or .pdf")
    require("plots", "matplotlib")
    require_folder_of(path)

    from sjdsl.trainers.runs.curves import draw_curves

    draw_curves(folders, metric, path, by_trial=by == "trial")
    of_trials = " by trial" if by == "trial" else ""
    click.echo(f"{path}  {metric}{of_trials} of {', '.join(name for name, _ in folders)}")
