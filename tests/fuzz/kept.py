"""A program that fails, made small and written down so that it can be played again."""

import re
from collections.abc import Callable
from pathlib import Path

from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.format import format_source
from tests.fuzz.judge import Verdict
from tests.fuzz.programs import Program
from tests.fuzz.reduce import reduced

RUNS = Path("runs/fuzz")


def keep(
    made: Program,
    verdict: Verdict,
    name: str,
    again: Callable[[Program], list[Verdict]],
    tries: int,
    folder: Path = RUNS,
) -> Path:
    """Returns the file of a program that still fails as `verdict` says. `again`: judges a smaller one; `tries`: how many, 0 for none."""

    def fails(smaller: Program) -> bool:
        return any(v.sort == verdict.sort for v in again(smaller) if v.fault)

    small = reduced(made, fails, tries) if tries else made
    folder.mkdir(parents=True, exist_ok=True)
    for file, text in small.files.items():
        (folder / file).write_text(text, encoding="utf-8")
    path = folder / f"{name}.sj"
    path.write_text(
        f"# {verdict.fault.splitlines()[0][:130]}\n{_laid_out(small.text)}", encoding="utf-8"
    )
    return path


def _laid_out(text: str) -> str:
    try:
        return format_source(Source("game.sj", text))
    except (CompileError, AssertionError):  # it may be the formatter that fails
        return re.sub(r"\n\s*\n+", "\n", text)
