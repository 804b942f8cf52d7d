"""`sjdsl test`: tests the checks of games and prints a verdict on each, as soon as it is known."""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict
from pathlib import PurePath
from typing import Any

import click

from sjdsl.cli.diagnostics import print_diagnostics
from sjdsl.cli.episode_options import seed_option
from sjdsl.cli.game_file import open_game, variant_option
from sjdsl.cli.stages import StatusLine, status_line
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.library.checked_game import split_variants
from sjdsl.properties import Effort, GameFamily, Report, Verdict, Verification
from sjdsl.properties.hidden_task import HiddenTask, hidden_task

STATUS = {
    "passed": "passed",
    "untested": "untested",
    "failed": "FAILED",
    "not decided": "not decided",
}
INDENT = " " * 14


@click.command("test")
@click.argument("files", nargs=-1, required=True, metavar="FILE...")
@click.option(
    "--examples",
    type=click.IntRange(min=1),
    default=200,
    show_default=True,
    metavar="N",
    help="How much random play, in units of 655,360 cell updates (steps x cells of the map); "
    "without JAX, of 10 steps.",
)
@seed_option("Seed of the random play.")
@variant_option
@click.option("--strict", is_flag=True, help="An untested check also makes the exit status 1.")
@click.option(
    "--full",
    is_flag=True,
    help="Print every change of a counterexample's last step, not only a few of those that are "
    "alike.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the verdicts as JSON.")
def command(
    files: tuple[str, ...],
    examples: int,
    seed: int,
    variant: str | None,
    strict: bool,
    full: bool,
    as_json: bool,
) -> int:
    """Tests the checks of games: FILE is a `.sj` file or the name of a bundled game.

    A check is proved if possible. Otherwise the game is played with random actions and parameters
    on its own map, in thousands of worlds at once. A check that fails is shown with a
    counterexample. A check that depends on a line that never ran is untested, and the line is
    named. The exit status is 1 if a check fails or cannot be tested; with --strict also if one is
    untested.
    """
    effort = Effort(examples, seed, full=full)
    documents: list[dict[str, Any]] = []
    failed = False
    for file in files:
        file_test = FileTest(file, variant, effort, (lambda _: None) if as_json else click.echo)
        try:
            with status_line(f"testing the checks of {file}") as status:
                file_test.run(status)
        except CompileError as error:
            print_diagnostics(error.diagnostics, err=as_json)
            failed = True
            continue
        except KeyboardInterrupt:
            if as_json:
                click.echo(json.dumps([*documents, file_test.document()], indent=2))
            raise
        documents.append(file_test.document())
        report = file_test.report
        if report.faults or not all(verdict.passed for verdict in report.verdicts):
            failed = True
        if strict and any(verdict.untested for verdict in report.verdicts):
            failed = True
    if as_json:
        click.echo(json.dumps(documents, indent=2))
    return int(failed)


class FileTest:
    """The test of the checks of one file.

    `say` prints lines. `report` is empty until all checks have a verdict; `decided` has the
    verdicts so far, by the number of their check.
    """

    def __init__(self, file: str, variant: str | None, effort: Effort, say: Callable[[str], None]):
        self.file = file
        self.variant = variant
        self.effort = effort
        self.say = say
        self.report = Report(())
        self.verification: Verification | None = None
        self.decided: dict[int, Verdict] = {}
        self.hidden_task: HiddenTask | None = None

    def run(self, status: StatusLine) -> None:
        """Prints each verdict as soon as it is known, in the order of the checks.

        When interrupted, prints which are known and which are not. Raises CompileError for mistakes
        in the game, and KeyboardInterrupt when interrupted.
        """
        name = f"{self.file}, variant {self.variant}" if self.variant else self.file
        family = GameFamily(open_game(self.file), split_variants(self.variant))
        self.verification = Verification(family, self.effort, progress=status.show)
        if self.verification.numbers:
            self._print([name], status)
        try:
            for number in self.verification.numbers:
                verdict = self.verification.verdict(number)
                self._print(verdict_lines(verdict), status)
                self.decided[number] = verdict
            self.report = self.verification.report()
        except KeyboardInterrupt:
            printed = self.decided
            self.decided = dict(sorted((self.verification.decided() | printed).items()))
            self._print(self._interrupted_lines(name, printed), status)
            raise
        self.hidden_task = hidden_task(family.own)
        if self.hidden_task is not None:
            self._print([f"  {self.hidden_task}"], status)
        self._print([*ending_lines(self.report), f"{name}: {summary(self.report)}"], status)

    def _print(self, lines: Iterable[str], status: StatusLine) -> None:
        with status.hidden():
            self.say("\n".join(lines))

    def _interrupted_lines(self, name: str, printed: Mapping[int, Verdict]) -> Iterator[str]:
        """Yields the verdicts that are known but not printed, the undecided checks, and a
        summary.
        """
        for number, verdict in self.decided.items():
            if number not in printed:
                yield from verdict_lines(verdict)
        undecided = self._undecided()
        for check in undecided:
            yield f"  not yet   {PurePath(check['file']).name}:{check['line']}  {check['check']}"
        total = len(self.decided) + len(undecided)
        failed = sum(not verdict.passed for verdict in self.decided.values())
        failures = f", {failed} not passed" if failed else ""
        yield f"{name}: interrupted: {len(self.decided)} of {total} checks decided{failures}"

    def _undecided(self) -> list[dict[str, Any]]:
        """Returns the checks without a verdict, as values that JSON can hold."""
        if self.verification is None:
            return []
        family = self.verification.family
        documents = []
        for number in self.verification.numbers:
            check = family.own.checks[number]
            if number not in self.decided and check.origin is not None:
                documents.append(
                    {
                        "check": family.text_of(check),
                        "file": check.origin.file,
                        "line": check.origin.line,
                    }
                )
        return documents

    def document(self) -> dict[str, Any]:
        """Returns the verdicts as values that JSON can hold."""
        task = {} if self.hidden_task is None else {"task": asdict(self.hidden_task)}
        return {
            "file": self.file,
            "variant": self.variant,
            **task,
            "checks": [as_document(verdict) for verdict in self.decided.values()],
            "undecided": self._undecided(),
            "faults": [as_document(verdict) for verdict in self.report.faults],
            "steps": self.report.steps,
            "idle_lines": list(self.report.idle),
        }


def verdict_lines(verdict: Verdict) -> Iterator[str]:
    """Yields a line for a check, and its counterexample if it failed, or the lines that never
    ran.
    """
    place = f"{PurePath(verdict.file).name}:{verdict.line}"
    yield f"  {STATUS[verdict.status]:8}  {place}  {verdict.text}  [{how_reached(verdict)}]"
    yield from (INDENT + line for line in verdict.trace)
    if verdict.untested:
        lines = "lines" if len(verdict.untested) > 1 else "a line"
        yield f"{INDENT}depends on {lines} that never ran:"
        yield from (f"{INDENT}  {line}" for line in verdict.untested)


def ending_lines(report: Report) -> Iterator[str]:
    """Yields the faults that don't depend on a check, and the lines that no check was tested on."""
    for verdict in report.faults:
        yield from verdict_lines(verdict)
    if report.idle:
        plural = "s" if len(report.idle) > 1 else ""
        yield (
            f"  nothing that line{plural} {', '.join(map(str, report.idle))} would change ever "
            "happened in random play: no check was tested on it"
        )


def summary(report: Report) -> str:
    """Returns how many checks there are, and how many of them did not pass or are untested."""
    verdicts = report.verdicts
    count = "1 check" if len(verdicts) == 1 else f"{len(verdicts)} checks"
    if not verdicts and not report.faults:
        return f"{count} (write them in `checks {{ … }}`)"
    problems = []
    if failed := sum(not verdict.passed for verdict in verdicts):
        problems.append(f"{failed} not passed")
    if untested := sum(verdict.status == "untested" for verdict in verdicts):
        problems.append(f"{untested} untested")
    if report.faults:
        problems.append("a real number leaves float32")
    return f"{count}, {', '.join(problems)}" if problems else f"{count} passed"


def how_reached(verdict: Verdict) -> str:
    """Returns how a verdict was reached: `proved: REASON`, or the reason alone after play."""
    is_certain = verdict.how in ("proved", "decided")
    return f"{verdict.how}: {verdict.reason}" if is_certain else verdict.reason


def as_document(verdict: Verdict) -> dict[str, Any]:
    """Returns a verdict as values that JSON can hold."""
    return {
        "check": verdict.text,
        "file": verdict.file,
        "line": verdict.line,
        "verdict": verdict.status,
        "how": verdict.how,
        "reason": verdict.reason,
        "trace": list(verdict.trace),
        "untested": list(verdict.untested),
    }
