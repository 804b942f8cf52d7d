"""Hostile texts: each gives one clear message, never a traceback, within seconds."""

import gc
import os
import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sjdsl.compiler import check
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic
from sjdsl.compiler.diagnostics.limits import (
    MAX_BYTES,
    MAX_DEPTH,
    MAX_LINE,
    MAX_PROBLEMS,
    MAX_STATEMENTS,
)
from sjdsl.compiler.diagnostics.report import render, to_json
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.parse import parse, parser
from sjdsl.compiler.syntax.read import read_source

SECONDS = 5.0  # of the thread's own; what is not linear takes minutes
HEAD = "sj 1\ngame x {\n"


def found_in(text: str) -> list[Diagnostic]:
    """Returns what is wrong with a text, shown both ways, within the time allowed."""
    parser()
    source = Source("game.sj", text)
    gc.disable()  # what other tests have left is not gone through again and again
    begin = time.thread_time()
    try:
        parse(source)
        found: list[Diagnostic] = []
    except CompileError as error:
        found = list(error.diagnostics)
    finally:
        gc.enable()
    render(found, {source.name: source}, colour=True)
    to_json(found, {source.name: source})
    assert time.thread_time() - begin < SECONDS
    return found


def in_phase(statements: str) -> str:
    return f"{HEAD}phase p {{\n{statements}\n}}\n}}\n"


ONE_MESSAGE = {
    "ten megabytes": ("x" * 10_000_000, "SJ005"),
    "a megabyte of other letters": ("é\n" * (MAX_BYTES // 2), "SJ005"),
    "NUL characters": ("sj 1\0game", "SJ009"),
    "nothing": ("", "SJ012"),
    "blanks": (" \n\t\r\n" * 1000, "SJ012"),
    "comments only": ("# a\n" * 100_000, "SJ012"),
    "a million characters in one line": (HEAD + "x" * 1_000_000, "SJ007"),
    "a million characters in one comment": (HEAD + "# " + "x" * 1_000_000, "SJ007"),
    "the longest line and one more": ("sj 1 #" + "." * (MAX_LINE - 5), "SJ007"),
    "100,000 brackets": (in_phase("let a = " + "(\n" * 100_000), "SJ006"),
    "100,000 brackets, closed": (
        in_phase("let a = " + "(\n" * 100_000 + "1" + ")\n" * 100_000),
        "SJ006",
    ),
    "100,000 times not": (in_phase("let a = " + "not\n" * 100_000 + "b"), "SJ006"),
    "100,000 signs": (in_phase("let a = " + "-\n" * 100_000 + "b"), "SJ006"),
    "100,000 braces": (HEAD + "{\n" * 100_000, "SJ006"),
    "100,000 indices": (in_phase("let a = " + "a[\n" * 100_000), "SJ006"),
    "brackets in brackets": (in_phase("let a = " + "(not - f[" * 40), "SJ006"),
    "a sum of 1,000": (in_phase("let a = " + "1 +\n" * 1000 + "1"), "SJ006"),
    "a product of 1,000": (in_phase("let a = " + "1 *\n" * 1000 + "1"), "SJ006"),
    "a thousand conditions": (in_phase("let a = " + "b and\n" * 1000 + "b"), "SJ006"),
    "a thousand branches": (in_phase("when a { }\n" + "otherwise when a { }\n" * 1000), "SJ006"),
    "too many statements": (in_phase("end\n" * (MAX_STATEMENTS + 1)), "SJ007"),
    "too many words": (in_phase("a\n" * 400_000), "SJ007"),
    "a number of 5,000 digits": (in_phase("let a =\n" + "9" * 4000), "SJ007"),
    "a decimal number of 5,000 digits": (
        in_phase("let a =\n" + "9" * 3000 + "." + "9" * 900),
        "SJ007",
    ),
    "another version and rubbish": ("sj 99999999999999999999999\n" + "$" * 4000, "SJ001"),
    "an open text": (HEAD + 'cite "abc\n}\n', "SJ010"),
    "an open text to the end": (HEAD + 'cite "', "SJ010"),
    "an open file": (HEAD + "phase p { end }\n", "SJ011"),
    "many open blocks": (HEAD + "phase p {\n" + "each a {\n" * 60, "SJ011"),
    "the version alone": ("sj 1", "SJ002"),
    "half a version": ("sj", "SJ002"),
    "a control character in a comment": (HEAD + "# \x1b[31m\n}", "SJ004"),
    "a turned text": (HEAD + "# \u202e evil\n}", "SJ004"),
    "a byte order mark inside": (HEAD + "\ufeff}", "SJ004"),
    "a space without a break": (HEAD + "episode\u00a010\n}", "SJ004"),
    "a letter of another alphabet": (in_phase("let c\u043ein = 1"), "SJ004"),
    "digits of another alphabet": (HEAD + "episode \u0663\u0663\n}", "SJ004"),
    "half a surrogate": (HEAD + "# \ud800\n}", "SJ004"),
    "an invisible character in a name": (in_phase("let co\u200bin = 1"), "SJ004"),
    "old line ends": (HEAD.replace("\n", "\r") + "}\r", "SJ009"),
}


@pytest.mark.parametrize("name", ONE_MESSAGE)
def test_one_message(name: str) -> None:
    text, code = ONE_MESSAGE[name]
    found = found_in(text)
    if name.startswith("digits"):  # and then the number is missing
        found = found[:1]
    assert [d.code for d in found] == [code]


@pytest.mark.parametrize(
    "text",
    [
        in_phase("@\n" * 60_000),
        in_phase("set x = 1 1\n" * 5000),
        in_phase("not not end\n" * 8000),
        in_phase("foo\n" * 20_000),
        in_phase("} {\n" * 15_000),
        in_phase("{ }\n" * 15_000),
        in_phase('"a\n' * 50_000),
        in_phase("each a { " * 2000 + "\n" * 10),
        in_phase("= : , .. -> . ] )\n" * 4000),
        in_phase("when when when\n" * 10_000),
        HEAD + "phase\n" * 30_000,
        HEAD + "\x07" * 4000 + "\n" + "\x08 " * 2000,
        HEAD + ";\n" * 200_000,
        HEAD + 'kind a "b" {\n' * 60 + "glyph\n" * 20_000,
    ],
)
def test_floods_of_mistakes_end_early(text: str) -> None:
    assert 1 <= len(found_in(text)) <= 2 * MAX_PROBLEMS


def test_what_is_just_allowed() -> None:
    assert (
        found_in(in_phase("let a = " + "(" * (MAX_DEPTH - 2) + "1" + ")" * (MAX_DEPTH - 2))) == []
    )
    assert found_in(in_phase("when a {\n" * (MAX_DEPTH - 2) + "}" * (MAX_DEPTH - 2))) == []
    assert found_in(in_phase("end\n" * (MAX_STATEMENTS - 1))) == []
    assert found_in(in_phase("let a = " + "1 + " * 100 + "1")) == []
    assert found_in(in_phase("let a = 2147483647 + 0000000000001.5")) == []
    assert found_in(HEAD + "#" + "." * (MAX_LINE - 1) + "\n}") == []
    assert found_in((HEAD + "phase p { end }\n}\n").replace("\n", "\r\n")) == []


WORDS = sorted(
    {t.pattern.value for t in parser().terminals if t.pattern.type == "str"}
    | {"a", "b1", "3", "0.5", '"x"', "==", "-", "*"}
)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.sampled_from(WORDS), max_size=60), st.booleans())
def test_any_row_of_words_is_read_or_refused(words: list[str], inside: bool) -> None:
    found_in(in_phase(" ".join(words)) if inside else HEAD + "\n".join(words))


@settings(max_examples=60, deadline=None)
@given(st.text(max_size=80))
def test_any_text_is_read_or_refused(text: str) -> None:
    found_in(text)
    found_in(HEAD + text)


# ---- chains of defines, kinds and agents: what only later stages count

POND = """sj 1
game pond {{
  episode 20
  kind shore "."
{more}  map {{ "....." }}
  agents {agents} {{ acts turn_left, forward, stay }}
  phase start {{ each agent {{ send agent to shore }} }}
  schedule pay
  phase pay {{ each agent {{ give {reward} to agent }} }}
}}
"""
DOUBLING = "  define d0 = 1\n" + "".join(
    f"  define d{i} = d{i - 1} + d{i - 1}\n" for i in range(1, 41)
)
CHAIN = "  define d0 = 1\n" + "".join(f"  define d{i} = d{i - 1} + 1\n" for i in range(1, 401))
BROAD = "  define d0 = 1\n" + "".join(
    f"  define d{i} = {' + '.join([f'd{i - 1}'] * 20)}\n" for i in range(1, 5)
)
GLYPHS = [chr(c) for c in range(33, 127) if chr(c) not in '\\".']
KINDS = "".join(f'  kind k{i} "{GLYPHS[i]}"\n' for i in range(65))


@pytest.mark.parametrize(
    ("more", "agents", "reward", "code"),
    [
        (DOUBLING, 2, "d40", "SJ007"),
        (CHAIN, 2, "d400", "SJ007"),
        (BROAD, 2, "d4", "SJ007"),
        (KINDS, 2, "1", "SJ007"),
        ("", 65, "1", "SJ214"),
        ("", 6, "1", "SJ303"),
    ],
)
def test_what_only_later_stages_count_gives_one_message_quickly(
    more: str, agents: int, reward: str, code: str
) -> None:
    began = time.process_time()
    found = [
        d
        for d in check(Source("pond.sj", POND.format(more=more, agents=agents, reward=reward)))
        if d.severity == "error"
    ]
    assert [d.code for d in found] == [code], [d.message for d in found]
    assert time.process_time() - began < 2


# ---- files


def failure(path: Path) -> Diagnostic:
    with pytest.raises(CompileError) as raised:
        read_source(path)
    (only,) = raised.value.diagnostics
    return only


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    (tmp_path / "coins.sj").write_text("sj 1")
    missing = failure(tmp_path / "coin.sj")
    assert (missing.code, missing.hint) == ("SJ008", "did you mean `coins.sj`?")
    assert failure(tmp_path).code == "SJ008"
    assert failure(tmp_path / "coins.sj" / "x.sj").code == "SJ008"
    assert failure(tmp_path / ("x" * 5000)).code == "SJ008"
    assert failure(Path("a\0b")).code == "SJ008"
    assert failure(tmp_path / "no" / "folder.sj").code == "SJ008"


@pytest.mark.parametrize("what", ["map {}", "extends {}"])
def test_names_that_no_file_can_have(what: str, tmp_path: Path) -> None:
    """A name that is too long, links that lead to each other, a link to itself, a name inside what is no folder."""
    (tmp_path / "one.txt").symlink_to("two.txt")
    (tmp_path / "two.txt").symlink_to("one.txt")
    (tmp_path / "self.txt").symlink_to("self.txt")
    (tmp_path / "plain.txt").write_text("....")
    for name in (
        "a" * 300,
        f"{'b' * 300}/c.txt",
        "one.txt",
        "self.txt",
        "plain.txt/map.txt",
        "\ud800.txt",
    ):
        said = what.format(f'"{name}"')
        text = f"sj 1\ngame x {said if what.startswith('extends') else ''} {{ {said if what.startswith('map') else ''} }}\n"
        found = check(Source("game.sj", text, tmp_path))
        assert {d.code for d in found} & {"SJ008", "SJ111", "SJ112", "SJ004"}, (name, found)
        assert all("\n" not in d.message for d in found)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_file_that_may_not_be_read(tmp_path: Path) -> None:
    path = tmp_path / "game.sj"
    path.write_text("sj 1")
    path.chmod(0)
    assert failure(path).code == "SJ008"


@pytest.mark.parametrize(
    ("content", "code"),
    [
        (b"sj 1\0", "SJ009"),
        (b"\xff\xfes\0j\0", "SJ009"),
        (b"sj 1 \xe9", "SJ009"),
        (b"\x89PNG\r\n\x1a\n\0\0", "SJ009"),
        (b" " * (MAX_BYTES + 1), "SJ005"),
        (b"\0" * 10_000_000, "SJ005"),
    ],
)
def test_files_that_are_no_games(content: bytes, code: str, tmp_path: Path) -> None:
    path = tmp_path / "game.sj"
    path.write_bytes(content)
    assert failure(path).code == code


def test_a_byte_order_mark_and_windows_line_ends_are_read(tmp_path: Path) -> None:
    path = tmp_path / "game.sj"
    path.write_bytes(b"\xef\xbb\xbf" + (HEAD + "episode 5\n}\n").replace("\n", "\r\n").encode())
    source = read_source(path)
    assert source.folder == tmp_path
    (section,) = parse(source).game.sections
    assert (section.span.line, section.span.column) == (3, 1)
