"""`pytest --sj games/`: the promises of `.sj` files as tests, one item a promise. Without `--sj` nothing is imported and nothing collected."""

from collections.abc import Iterable
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from sjdsl.properties import Examination, Verdict


def pytest_addoption(parser: pytest.Parser) -> None:
    """Adds `--sj` and what goes with it."""
    group = parser.getgroup("sjdsl", "promises of .sj games")
    group.addoption("--sj", action="store_true", help="collect .sj files: each promise of a game is a test")
    group.addoption("--sj-examples", type=int, default=400, metavar="N", help="random courses on small maps for each game (400)")
    group.addoption("--sj-seed", type=int, default=0, metavar="S", help="the same seed plays the same (0)")
    group.addoption("--sj-strict", action="store_true", help="a promise that is untested fails; otherwise it is skipped")
    group.addoption("--sj-variant", default=None, metavar="V", help="a variant of the games; several as a+b")


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> "GameFile | None":
    """Collects a `.sj` file if `--sj` is given."""
    if parent.config.getoption("sj") and file_path.suffix == ".sj":
        return GameFile.from_parent(parent, path=file_path)
    return None


class GameFile(pytest.File):
    """A game; its promises are put to the test together, when the first of them is asked for."""

    @cached_property
    def examination(self) -> "Examination":
        from sjdsl.compiler.syntax.read import read_source
        from sjdsl.properties import Effort, Examination, Ground

        option = self.config.getoption
        variants = tuple(option("sj_variant").split("+")) if option("sj_variant") else ()
        return Examination(Ground(read_source(self.path), variants), Effort(option("sj_examples"), seed=option("sj_seed")))

    def collect(self) -> Iterable["PromiseItem"]:
        from sjdsl.compiler.diagnostics.diagnostic import CompileError

        try:
            examination = self.examination
        except CompileError as error:
            raise self.CollectError(_rendered(error)) from None
        seen: dict[str, int] = {}
        for number in examination.numbers:
            text = examination.ground.text_of(examination.ground.own.checks[number])
            seen[text] = seen.get(text, 0) + 1
            name = text if seen[text] == 1 else f"{text} ({seen[text]})"
            yield PromiseItem.from_parent(self, name=name, number=number)


class PromiseBroken(Exception):
    """A promise that is not kept; its argument is the verdict."""


class PromiseItem(pytest.Item):
    """One promise of a game."""

    def __init__(self, *, number: int, **rest: Any):
        super().__init__(**rest)
        self.number = number

    def runtest(self) -> None:
        assert isinstance(self.parent, GameFile)
        verdict = self.parent.examination.verdict(self.number)
        if not verdict.kept or (verdict.untested and self.config.getoption("sj_strict")):
            raise PromiseBroken(verdict)
        if self.parent.examination.faults:  # whatever is promised, no real may leave float32
            raise PromiseBroken(self.parent.examination.faults[0])
        if verdict.untested:
            pytest.skip("untested: these lines never ran: " + "; ".join(verdict.untested))
        self.add_report_section("call", "promise", f"{verdict.how}: {verdict.said}")  # `pytest -rP` shows it

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], *rest: Any) -> Any:
        """Returns the trace of a broken promise, or what is wrong with the file; a Python traceback only for faults of our own."""
        from sjdsl.compiler.diagnostics.diagnostic import CompileError

        match excinfo.value:
            case PromiseBroken(args=(verdict,)):
                return _told(verdict)
            case CompileError() as error:
                return _rendered(error)
            case _:
                return super().repr_failure(excinfo, *rest)

    def reportinfo(self) -> tuple[Path, int | None, str]:
        """Returns where the promise stands, and its heading; `-v` prints `::` for each `.` of a heading that is the name itself."""
        assert isinstance(self.parent, GameFile)
        origin = self.parent.examination.ground.own.checks[self.number].origin
        return self.path, origin.line - 1 if origin is not None else None, f"promise: {self.name}"


def _told(verdict: "Verdict") -> str:
    head = f"{Path(verdict.file).name}:{verdict.line}: the promise is {verdict.word}: {verdict.text}"
    never = ["it depends on lines that never ran in any course:"] * bool(verdict.untested)
    return "\n".join([head, verdict.said, *never, *(f"  {line}" for line in (*verdict.untested, *verdict.trace))])


def _rendered(error: Any) -> str:
    from sjdsl.cli.diagnostics import texts_of
    from sjdsl.compiler.diagnostics.report import render

    return render(error.diagnostics, texts_of(error.diagnostics), colour=False)
