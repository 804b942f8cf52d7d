"""What becomes of a damaged game: refused near the edit or far from it, compiled to other rules, to the same ones, or a fault of ours."""

import shutil
import tempfile
import time
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from sjdsl.compiler import Build, build_composition, lower_build
from sjdsl.compiler.compose import compose
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic
from sjdsl.compiler.diagnostics.report import LINES, render, to_json
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.ir import printer
from sjdsl.compiler.syntax.read import read_source
from tests.damage.edits import FOLDER, Edit
from tests.verify_ir import verify

SECONDS = 2.0
NEAR = 1  # lines

Variants = tuple[str, ...]


@dataclass
class Verdict:
    """`outcome`: refused, warned (the same rules, and something said), other (rules), same (rules, nothing said), fault."""

    outcome: str = "same"
    found: list[Diagnostic] = field(default_factory=list)
    near: bool = False
    fault: str = ""
    seconds: float = 0.0

    @property
    def messages(self) -> list[str]:
        return [f"{d.code} {d.span.file}:{d.span.line} {d.message}" for d in self.found]


def judge(edit: Edit, lowered: bool = True) -> Verdict:
    """Returns what becomes of an edit, in the game itself and in each of its variants, as `sjdsl check` looks at them."""
    verdict = Verdict()
    with written(edit) as source:
        begun = time.process_time()
        try:
            _look(edit.game, source, verdict, lowered)
            render(verdict.found, {source.name: source}, colour=True)
            to_json(verdict.found, {source.name: source})
        except Exception as error:
            verdict.outcome, verdict.fault = "fault", told(error)
        verdict.seconds = time.process_time() - begun
        verdict.near = any(_is_near(d, edit, source) for d in verdict.found)
    if verdict.seconds > SECONDS and not verdict.fault:
        verdict.outcome, verdict.fault = "fault", f"{verdict.seconds:.1f} s"
    return verdict


@contextmanager
def written(edit: Edit) -> Iterator[Source]:
    """Returns the damaged game; where its map is damaged, in a copy of the folder of games."""
    if edit.file.endswith(".sj"):
        yield Source(edit.file, edit.text, FOLDER)
        return
    folder = Path(tempfile.mkdtemp(prefix="damage"))
    try:
        shutil.copytree(FOLDER, folder, dirs_exist_ok=True)
        (folder / edit.file).write_text(edit.text, "utf-8")
        yield Source(f"{edit.game}.sj", read_source(FOLDER / f"{edit.game}.sj").text, folder)
    finally:
        shutil.rmtree(folder)


def _look(game: str, source: Source, verdict: Verdict, lowered: bool) -> None:
    try:
        names: Sequence[Variants] = ((), *((name,) for name in compose(source).variants))
    except CompileError as refused:
        verdict.found += refused.diagnostics
        verdict.outcome = "refused"
        return
    said: list[Diagnostic] = []
    changed = False
    for variants in names:
        try:
            made, text = _made(source, variants)
            if lowered and not changed:
                lower_build(made, source)
            said += [d for d in made.warnings if d not in said]
            verify(made.game)
            changed = changed or text != rules(game, variants)
        except CompileError as refused:
            known = [(d.span, d.message) for d in verdict.found]
            found = [d for d in refused.diagnostics if d.severity == "error"]
            verdict.found += [d for d in found if (d.span, d.message) not in known]
    if verdict.found:
        verdict.outcome = "refused"
    elif changed:
        verdict.outcome = "other"
    elif said:
        verdict.outcome, verdict.found = "warned", said


@cache
def rules(game: str, variants: Variants) -> str:
    """Returns the rules of an undamaged game as text; of a variant that it does not have, none."""
    source = read_source(FOLDER / f"{game}.sj")
    try:
        return _made(source, variants)[1]
    except CompileError:
        return ""


def _made(source: Source, variants: Variants) -> tuple[Build, str]:
    """Returns what `build` does of a file, and its rules as text.

    The text has no positions, but the limits of sizes: what a caller may set is not in the rules of one size.
    """
    composed = compose(source, variants)
    made = build_composition(composed)
    limited = [
        c
        for c in composed.constants.values()
        if c.is_size and c.low is not None and c.high is not None
    ]
    limits = [
        composed.sources[c.span.file].text[c.low.span.start : c.high.span.end] for c in limited
    ]  # type: ignore[union-attr]
    return made, "\n".join([printer.game_text(made.game), *limits])


def _is_near(d: Diagnostic, edit: Edit, source: Source) -> bool:
    spans = [
        span for span in (d.span, *(label.span for label in d.labels)) if span.file == edit.file
    ]
    return any(
        abs(shown - line) <= NEAR
        for span in spans
        for shown in _shown(span, source)
        for line in edit.lines
    )


def _shown(span: Span, source: Source) -> Sequence[int]:
    """Returns the lines that a message shows of a place: all of a few, of many the first and the last."""
    last = source.span(span.end, span.end).line if span.file == source.name else span.line
    return range(span.line, last + 1) if last - span.line < LINES else (span.line, last)


def told(error: Exception) -> str:
    """Returns an error of ours as its type, text and the last place of the compiler that it went through."""
    places = [f for f in traceback.extract_tb(error.__traceback__) if "sjdsl" in f.filename]
    where = f" at {Path(places[-1].filename).name}:{places[-1].lineno}" if places else ""
    return f"{type(error).__name__}{where}: {str(error)[:200]}"
