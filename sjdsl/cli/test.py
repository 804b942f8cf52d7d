"""`sjdsl test`: tests the checks of games and prints a verdict on each."""

import json
import os
from collections.abc import Iterator
from pathlib import PurePath
from typing import Any

import click

from sjdsl.cache import cache_folder
from sjdsl.cli.diagnostics import print_diagnostics
from sjdsl.cli.game_file import open_game, split_variants, variant_option
from sjdsl.cli.stages import stages
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.properties import Effort, GameFamily, Report, Verdict, verify_properties

STATUS = {"passed": "passed", "untested": "untested", "failed": "FAILED", "not decided": "not decided"}


@click.command("test")
@click.argument("files", nargs=-1, required=True, metavar="FILE...")
@click.option(
    "--examples", type=click.IntRange(min=1), default=400, show_default=True, metavar="N", help="Random trajectories on small maps."
)
@click.option(
    "--seed", type=click.IntRange(min=0, max=2**32 - 1), metavar="N", default=0, show_default=True, help="Seed of the trajectories."
)
@variant_option
@click.option("--strict", is_flag=True, help="An untested check also makes the exit status 1.")
@click.option("--json", "as_json", is_flag=True, help="Print the verdicts as JSON.")
def command(files: tuple[str, ...], examples: int, seed: int, variant: str | None, strict: bool, as_json: bool) -> int:
    """Tests the checks of games: FILE is a `.sj` file or the name of a bundled or installed game.

    A check is proved if possible. Otherwise the game is played: random trajectories on small maps, whole episodes on its own map. A check
    that fails is shown with the shortest counterexample found. A check that depends on a line that never ran is untested, and the line is
    named. The exit status is 1 if a check fails or cannot be tested; with --strict also if one is untested.
    """
    os.environ.setdefault("HYPOTHESIS_STORAGE_DIRECTORY", str(cache_folder() / "hypothesis"))  # else it makes .hypothesis/ here

    effort, documents, failed = Effort(examples, seed=seed), [], False
    for file in files:
        try:
            with stages(f"testing the checks of {file}"):
                report = test_file(file, variant, effort)
        except CompileError as error:
            print_diagnostics(error.diagnostics, err=as_json)
            failed = True
            continue
        failed |= bool(report.faults) or not all(verdict.passed for verdict in report.verdicts)
        failed |= strict and any(verdict.untested for verdict in report.verdicts)
        documents.append({"file": file, "variant": variant, **as_document(report)})
        if not as_json:
            name = f"{file}, variant {variant}" if variant else file
            click.echo("\n".join(report_lines(name, report)))
    if as_json:
        click.echo(json.dumps(documents, indent=2))
    return int(failed)


def test_file(file: str, variant: str | None, effort: "Effort") -> "Report":
    """Returns the verdicts on the checks of a game. Raises CompileError for what is wrong with it."""

    return verify_properties(GameFamily(open_game(file), split_variants(variant)), effort)


def report_lines(name: str, report: "Report") -> Iterator[str]:
    """Yields a line for each check; under a failed one its counterexample, under an untested one the lines that never ran."""
    yield f"{name}: {summary(report)}"
    for verdict in (*report.verdicts, *report.faults):
        yield f"  {STATUS[verdict.status]:8}  {PurePath(verdict.file).name}:{verdict.line}  {verdict.text}  [{how(verdict)}]"
        yield from (f"              {line}" for line in verdict.trace)
        if verdict.untested:
            yield f"              depends on {'lines that' if len(verdict.untested) > 1 else 'a line that'} never ran in any trajectory:"
            yield from (f"                {line}" for line in verdict.untested)
    if report.idle:
        lines = f"line{'s' * (len(report.idle) > 1)} {', '.join(map(str, report.idle))}"
        yield f"  nothing that {lines} would change ever happened in a trajectory: no check was tested on it"


def summary(report: "Report") -> str:
    """Returns how many checks there are, and how many of them did not pass or are untested."""
    verdicts = report.verdicts
    count = f"{len(verdicts)} check{'s' * (len(verdicts) != 1)}"
    missed, untested = sum(not v.passed for v in verdicts), sum(v.status == "untested" for v in verdicts)
    parts = [f"{missed} not passed"] * bool(missed) + [f"{untested} untested"] * bool(untested)
    parts += ["a real number leaves float32"] * bool(report.faults)
    if not verdicts:
        return f"{count} (write them in `checks {{ … }}`)"
    return f"{count}, {', '.join(parts)}" if parts else f"{count} passed"


def how(verdict: "Verdict") -> str:
    """Returns how a verdict was found."""
    return f"{verdict.how}: {verdict.reason}" if verdict.how in ("proved", "decided") else verdict.reason


def as_document(report: "Report") -> dict[str, Any]:
    """Returns a report as values that JSON can hold."""
    checks = [
        {
            "check": v.text,
            "file": v.file,
            "line": v.line,
            "verdict": v.status,
            "how": v.how,
            "reason": v.reason,
            "trace": list(v.trace),
            "untested": list(v.untested),
        }
        for v in (*report.verdicts, *report.faults)
    ]
    return {
        "checks": checks[: len(report.verdicts)],
        "faults": checks[len(report.verdicts) :],
        "trajectories": report.trajectories,
        "idle_lines": list(report.idle),
    }
