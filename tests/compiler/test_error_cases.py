"""Every code of the compiler: a wrong program in `tests/errors/` beside exactly what is said about it.

A case may begin with `# variants: a b`: it is checked with these variants.
"""

import os
import re
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

import pytest

from sjdsl.compiler import check
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic
from sjdsl.compiler.diagnostics.explanations import all_codes, explain, kinds
from sjdsl.compiler.diagnostics.limits import MAX_BYTES, MAX_LINE
from sjdsl.compiler.diagnostics.report import render
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.parse import parse
from sjdsl.compiler.syntax.read import read_source

ERRORS = Path(__file__).parent.parent / "errors"
MANUAL = (ERRORS.parents[1] / "docs" / "language.md").read_text(encoding="utf-8")
CASES = sorted(path.stem for path in ERRORS.glob("*.sj"))
# Cases that cannot be kept as files: the bytes of the file, None for no file, "folder" and "pipe" for those, "link" for a folder of maps that is one.
MADE: dict[str, bytes | str | None] = {
    "SJ005_file_too_large": b"sj 1 # " + b"." * MAX_BYTES,
    "SJ007_line_too_long": b"sj 1\n# " + b"." * MAX_LINE,
    "SJ008_missing_file": None,
    "SJ008_folder": "folder",
    "SJ008_pipe": "pipe",
    "SJ009_nul_byte": b"sj 1\ngame pond {\0}\n",
    "SJ009_not_utf8": 'sj 1\ngame pond "Étang" { }\n'.encode("latin-1"),
    "SJ112_link_outside": "link",
}


@cache
def check_file(name: str) -> tuple[Sequence[Diagnostic], dict[str, Source]]:
    """Returns the diagnostics of a file, and its text if it can be read."""
    try:
        source = read_source(name)
    except CompileError as error:
        return error.diagnostics, {}
    variants = re.match(r"# variants: (.*)", source.text)
    return check(source, variants.group(1).split() if variants else ()), {source.name: source}


def assert_case(case: str, golden: Callable[[Path, str], None]) -> None:
    found, sources = check_file(f"{case}.sj")
    golden(ERRORS / f"{case}.err", render(found, sources, colour=False) + "\n")
    assert {d.code for d in found} == {case[:5]}


@pytest.mark.parametrize("case", CASES)
def test_case(
    case: str, golden: Callable[[Path, str], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ERRORS)
    assert_case(case, golden)


@pytest.mark.parametrize("case", sorted(MADE))
def test_made_case(
    case: str, golden: Callable[[Path, str], None], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    content = MADE[case]
    monkeypatch.chdir(tmp_path)
    match content:
        case bytes():
            Path(f"{case}.sj").write_bytes(content)
        case "folder":
            Path(f"{case}.sj").mkdir()
        case "pipe":
            os.mkfifo(f"{case}.sj")
        case "link":
            Path(f"{case}.sj").write_text(
                (ERRORS / "SJ112_file_outside.sj").read_text().replace("../", "maps/")
            )
            Path("maps").symlink_to("../elsewhere")
    assert_case(case, golden)


def test_every_code_has_a_case() -> None:
    covered = {case[:5] for case in (*CASES, *MADE)}
    assert covered == set(all_codes())


def test_every_kind_of_mistake_has_a_case(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ERRORS)
    found = {type(d) for case in CASES for d in check_file(f"{case}.sj")[0]}
    made = {kind for kind in kinds() if kind.code in {case[:5] for case in MADE}}
    assert {kind.__name__ for kind in set(kinds()) - found - made} == set()


@pytest.mark.parametrize("code", all_codes())
def test_every_code_is_explained(code: str) -> None:
    title = all_codes()[code].title
    assert explain(code).startswith(f"# {code}: {title}\n")
    assert f"`{code}` {title}" in MANUAL


def test_an_unknown_code_is_refused_with_the_nearest() -> None:
    with pytest.raises(ValueError, match="no code `SJ2044`; did you mean `SJ204`"):
        explain("SJ2044")


@pytest.mark.parametrize("code", all_codes())
def test_the_examples_of_an_explanation_are_in_the_language(code: str) -> None:
    """The right one always is; the wrong one is too, unless the code is about syntax: then it has this mistake alone."""
    examples = re.findall(r"```sj\n(.*?)```", explain(code), re.DOTALL)
    if not examples:
        return
    wrong, right = examples
    assert set() in _syntax_errors(right)
    assert ({code} if code < "SJ1" else set()) in _syntax_errors(wrong)


def _syntax_errors(text: str) -> list[set[str]]:
    """Returns the codes found in a text read as a file, as declarations, and as statements."""
    frames = (
        "{}",
        "sj 1\n{}",
        "sj 1\ngame x {{\n{}\n}}",
        "sj 1\ngame x {{\nphase p {{\n{}\n}}\n}}",
    )
    found = []
    for frame in frames:
        try:
            parse(Source("example.sj", frame.format(text)))
            found.append(set())
        except CompileError as error:
            found.append({d.code for d in error.diagnostics})
    return found
