"""Every example of the manual is compiled and run, and what the manual says of it is compared.

The reference interpreter and the compiled step, on NumPy, play side by side on the same draws; means over many runs are the interpreter's.
"""

import re
from collections.abc import Callable, Sequence
from functools import cache, partial
from pathlib import Path

import pytest

from sjdsl.compiler import Build, build, check, compile_build
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic
from sjdsl.compiler.diagnostics.report import render
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.elaborate import Overrides

from .blocks import Example, blocks, examples
from .plays import Play
from .scripts import Script, given_params, perform, read_script


def chosen(wanted: Callable[[Example], bool]) -> pytest.MarkDecorator:
    """Returns the parametrisation of a test over the examples wanted."""
    return pytest.mark.parametrize(
        "example", [pytest.param(e, id=e.name) for e in examples() if wanted(e)]
    )


def source_of(example: Example, folder: Path) -> Source:
    return Source(f"{example.name}.sj", example.source, folder)


@cache
def built(example: Example, folder: Path, variants: tuple[str, ...] = ()) -> Build:
    return build(source_of(example, folder), variants, Overrides())


def test_every_example_says_what_becomes_of_it():
    silent = [e.name for e in examples() if not e.expected and "frame" not in e.block.info]
    assert not silent
    assert len({e.name for e in examples()}) == len(examples())


@chosen(lambda e: not e.said("error"))
def test_example_compiles(example, folder):
    found = [d for d in built(example, folder).warnings if d.span.file == f"{example.name}.sj"]
    if (example.frame is None and "frame" not in example.block.info) or example.said("warning"):
        compare(example, found, example.said("warning"))


@chosen(lambda e: bool(e.said("error")))
def test_example_is_refused(example, folder):
    for block in example.said("error"):
        variants = tuple(
            v for v in re.findall(r"^variant (\S+)", block.text, re.MULTILINE) for v in v.split("+")
        )
        with pytest.raises(CompileError) as refused:
            compile_build(build(source_of(example, folder), variants), source_of(example, folder))
        compare(example, [d for d in refused.value.diagnostics if d.severity == "error"], (block,))


def test_errors_look_as_the_manual_shows_them(folder):
    shown = [b for b in blocks() if "shown" in b.info]
    assert shown
    for block in shown:
        example = next(e for e in examples() if e.name == block.info["shown"])
        source = source_of(example, folder)
        assert (
            render(check(source), {source.name: source}, colour=False).strip() == block.text.strip()
        )


@pytest.mark.thorough
def test_the_python_of_the_manual_runs(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    for block in (b for b in blocks() if b.language == "python"):
        exec(compile(block.text, f"line {block.line}", "exec"), {})
    assert "turn_left" in capsys.readouterr().out


def compare(example: Example, found: Sequence[Diagnostic], blocks: Sequence) -> None:
    """Compares diagnostics with lines like `SJ204 line 3` and, where it is written, the message."""
    lines = [x for b in blocks for x in b.text.splitlines() if x.startswith("SJ")]
    ordered = sorted(found, key=lambda d: (d.span.line, d.code))
    shown = [f"{d.code} line {d.span.line - example.offset}: {d.message}" for d in ordered]
    assert len(shown) == len(lines), shown
    for line, full in zip(lines, shown, strict=True):
        assert line == full or line == full.partition(":")[0], shown


FEW = 3  # runs that both play


def scripts_of(example: Example) -> list[Script]:
    return [read_script(block) for block in example.said("result")]


@chosen(lambda e: any(script.runs > FEW for script in scripts_of(e)))
def test_means_are_as_the_manual_says(example, folder):
    for script in scripts_of(example):
        made = built(example, folder, script.variants)
        perform(script, Play(made, given_params(made.game, script.params)), partial(rest, folder))


def rest(folder: Path, name: str, seed: int, steps: int) -> Play:
    """Returns another example after some steps in which nobody does anything."""
    play = Play(built(next(e for e in examples() if e.name == name), folder), {})
    play.reset((seed, 0))
    for step in range(1, steps + 1):
        play.step([play.game.agents.actions.index("stay")] * play.board.agents, (seed, step))
    return play


@chosen(lambda e: not e.said("error"))
def test_example_runs_as_the_manual_says(example, folder):
    """Both engines play; an example without a shown play is compiled."""
    for script in scripts_of(example):
        made = built(example, folder, script.variants)
        text = compile_build(made, source_of(example, folder))
        perform(
            script,
            Play(made, given_params(made.game, script.params), text),
            partial(rest, folder),
            most_runs=FEW,
        )
    if not example.said("result"):
        compile_build(built(example, folder), source_of(example, folder))
