"""`sjdsl test`: are the promises of games kept?"""

import json
import os
from collections.abc import Iterator
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cache import cache_folder
from sjdsl.cli.diagnostics import print_diagnostics
from sjdsl.cli.game_file import open_game, split_variants, variant_option
from sjdsl.cli.stages import stages
from sjdsl.compiler.diagnostics.diagnostic import CompileError

if TYPE_CHECKING:
    from sjdsl.properties import Effort, Report, Verdict

WORDS = {"kept": "kept", "untested": "untested", "broken": "BROKEN", "not decided": "not decided"}


@click.command("test")
@click.argument("files", nargs=-1, required=True, metavar="FILE...")
@click.option("--examples", type=click.IntRange(min=1), default=400, show_default=True, metavar="N", help="Random courses on small maps.")
@click.option("--seed", type=click.IntRange(min=0, max=2**32 - 1), default=0, show_default=True, help="The same seed plays the same.")
@variant_option
@click.option("--strict", is_flag=True, help="A promise that is untested also makes the exit status 1.")
@click.option("--json", "as_json", is_flag=True, help="Print the verdicts as JSON.")
def command(files: tuple[str, ...], examples: int, seed: int, variant: str | None, strict: bool, as_json: bool) -> int:
    """Puts the promises of games (`checks`) to the test: FILE is a `.sj` file or the name of a bundled game.

    What can be decided is proved. The rest is played: random courses on small maps, whole episodes on the game's own map. A promise that
    breaks is shown in the shortest course found. One that holds, but depends on a line that never ran, is untested, and the line is named.
    The exit status is 1 if one breaks, or cannot be put to the test; with --strict also if one is untested.
    """
    os.environ.setdefault("HYPOTHESIS_STORAGE_DIRECTORY", str(cache_folder() / "hypothesis"))  # else it makes .hypothesis/ here

    from sjdsl.properties import Effort

    effort, documents, failed = Effort(examples, seed=seed), [], False
    for file in files:
        try:
            with stages(f"testing the promises of {file}"):
                report = test_file(file, variant, effort)
        except CompileError as error:
            print_diagnostics(error.diagnostics, err=as_json)
            failed = True
            continue
        failed |= bool(report.faults) or not all(verdict.kept for verdict in report.verdicts)
        failed |= strict and any(verdict.untested for verdict in report.verdicts)
        documents.append({"file": file, "variant": variant, **as_document(report)})
        if not as_json:
            name = f"{file}, variant {variant}" if variant else file
            click.echo("\n".join(report_lines(name, report)))
    if as_json:
        click.echo(json.dumps(documents, indent=2))
    return int(failed)


def test_file(file: str, variant: str | None, effort: "Effort") -> "Report":
    """Returns what becomes of the promises of a game. Raises CompileError for what is wrong with it."""
    from sjdsl.properties import Ground, examine

    return examine(Ground(open_game(file), split_variants(variant)), effort)


def report_lines(name: str, report: "Report") -> Iterator[str]:
    """Yields a line for each promise; under a broken one its trace, under an untested one the lines that never ran."""
    yield f"{name}: {summary(report)}"
    for verdict in (*report.verdicts, *report.faults):
        yield f"  {WORDS[verdict.word]:8}  {PurePath(verdict.file).name}:{verdict.line}  {verdict.text}  [{how(verdict)}]"
        yield from (f"              {line}" for line in verdict.trace)
        if verdict.untested:
            yield f"              depends on {'lines that' if len(verdict.untested) > 1 else 'a line that'} never ran in any course:"
            yield from (f"                {line}" for line in verdict.untested)
    if report.idle:
        lines = f"line{'s' * (len(report.idle) > 1)} {', '.join(map(str, report.idle))}"
        yield f"  nothing that {lines} would change ever happened in a course: no promise was tested on it"


def summary(report: "Report") -> str:
    """Returns how many promises there are, and how many of them are not kept or untested."""
    verdicts = report.verdicts
    count = f"{len(verdicts)} promise{'s' * (len(verdicts) != 1)}"
    missed, untested = sum(not v.kept for v in verdicts), sum(v.word == "untested" for v in verdicts)
    parts = [f"{missed} not kept"] * bool(missed) + [f"{untested} untested"] * bool(untested)
    parts += ["a real number leaves float32"] * bool(report.faults)
    if not verdicts:
        return f"{count} (write them in `checks {{ … }}`)"
    return f"{count}, {', '.join(parts)}" if parts else f"{count} kept"


def how(verdict: "Verdict") -> str:
    """Returns how a verdict was found."""
    return f"{verdict.how}: {verdict.said}" if verdict.how in ("proved", "decided") else verdict.said


def as_document(report: "Report") -> dict[str, Any]:
    """Returns a report as values that JSON can hold."""
    promises = [
        {
            "promise": v.text,
            "file": v.file,
            "line": v.line,
            "verdict": v.word,
            "how": v.how,
            "said": v.said,
            "trace": list(v.trace),
            "untested": list(v.untested),
        }
        for v in (*report.verdicts, *report.faults)
    ]
    return {
        "promises": promises[: len(report.verdicts)],
        "faults": promises[len(report.verdicts) :],
        "courses": report.courses,
        "idle_lines": list(report.idle),
    }
