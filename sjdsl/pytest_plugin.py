"""`pytest --sj games/`: collects the checks of `.sj` files as tests, one item a check. Without `--sj` it imports and collects nothing."""

from collections.abc import Iterable
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from sjdsl.properties import Verdict, Verification


def pytest_addoption(parser: pytest.Parser) -> None:
    """Adds `--sj` and what goes with it."""
    group = parser.getgroup("sjdsl", "checks of .sj games")
    group.addoption("--sj", action="store_true", help="collect .sj files: each check of a game is a test")
    group.addoption("--sj-examples", type=int, default=200, metavar="N", help="how much random play of each game (200)")
    group.addoption("--sj-seed", type=int, default=0, metavar="S", help="the same seed plays the same (0)")
    group.addoption("--sj-strict", action="store_true", help="an untested check fails; otherwise it is skipped")
    group.addoption("--sj-variant", default=None, metavar="V", help="a variant of the games; several as a+b")


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> "GameFile | None":
    """Collects a `.sj` file if `--sj` is given."""
    if parent.config.getoption("sj") and file_path.suffix == ".sj":
        return GameFile.from_parent(parent, path=file_path)
    return None


class GameFile(pytest.File):
    """A game; its checks are verified together, when the first of them is asked for."""

    @cached_property
    def verification(self) -> "Verification":
        from sjdsl.compiler.syntax.read import read_source
        from sjdsl.properties import Effort, GameFamily, Verification

        option = self.config.getoption
        variants = tuple(option("sj_variant").split("+")) if option("sj_variant") else ()
        return Verification(GameFamily(read_source(self.path), variants), Effort(option("sj_examples"), option("sj_seed")))

    def collect(self) -> Iterable["CheckItem"]:
        from sjdsl.compiler.diagnostics.diagnostic import CompileError

        try:
            verification = self.verification
        except CompileError as error:
            raise self.CollectError(_rendered(error)) from None
        seen: dict[str, int] = {}
        for number in verification.numbers:
            text = verification.family.text_of(verification.family.own.checks[number])
            seen[text] = seen.get(text, 0) + 1
            name = text if seen[text] == 1 else f"{text} ({seen[text]})"
            yield CheckItem.from_parent(self, name=name, number=number)


class CheckFailed(Exception):
    """A check that failed; its argument is the verdict."""


class CheckItem(pytest.Item):
    """One check of a game."""

    def __init__(self, *, number: int, **rest: Any):
        super().__init__(**rest)
        self.number = number
        self.funcargs: dict[str, Any] = {}  # no fixtures; plugins such as pytest-lsp want to look through them

    def runtest(self) -> None:
        assert isinstance(self.parent, GameFile)
        verdict = self.parent.verification.verdict(self.number)
        if not verdict.passed or (verdict.untested and self.config.getoption("sj_strict")):
            raise CheckFailed(verdict)
        if self.parent.verification.faults:  # whatever the checks say, no real may leave float32
            raise CheckFailed(self.parent.verification.faults[0])
        if verdict.untested:
            pytest.skip("untested: these lines never ran: " + "; ".join(verdict.untested))
        self.add_report_section("call", "check", f"{verdict.how}: {verdict.reason}")  # `pytest -rP` shows it

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], *rest: Any) -> Any:
        """Returns the counterexample to a failed check, or what is wrong with the file; a Python traceback only for faults of our own."""
        from sjdsl.compiler.diagnostics.diagnostic import CompileError

        match excinfo.value:
            case CheckFailed(args=(verdict,)):
                return _verdict_text(verdict)
            case CompileError() as error:
                return _rendered(error)
            case _:
                return super().repr_failure(excinfo, *rest)

    def reportinfo(self) -> tuple[Path, int | None, str]:
        """Returns where the check stands, and its heading; `-v` prints `::` for each `.` of a heading that is the name itself."""
        assert isinstance(self.parent, GameFile)
        origin = self.parent.verification.family.own.checks[self.number].origin
        return self.path, origin.line - 1 if origin is not None else None, f"check: {self.name}"


def _verdict_text(verdict: "Verdict") -> str:
    status = "failed" if verdict.status == "failed" else f"is {verdict.status}"
    head = f"{Path(verdict.file).name}:{verdict.line}: the check {status}: {verdict.text}"
    never = ["it depends on lines that never ran:"] * bool(verdict.untested)
    return "\n".join([head, verdict.reason, *never, *(f"  {line}" for line in (*verdict.untested, *verdict.trace))])


def _rendered(error: Any) -> str:
    from sjdsl.cli.diagnostics import texts_of
    from sjdsl.compiler.diagnostics.report import render

    return render(error.diagnostics, texts_of(error.diagnostics), colour=False)
