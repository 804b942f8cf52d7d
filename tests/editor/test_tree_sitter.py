"""The tree-sitter grammar reads what the compiler reads, has all its words, colours them as the compiler takes them, and is generated anew."""

import ctypes
import json
import re
import runpy
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pygments.token import Comment, Keyword, Name, Number, Operator, String

from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.parse import automaton, read_tree
from sjdsl.compiler.syntax.soft_words import SOFT
from sjdsl.editor.pygments_lexer import SjLexer

ROOT = Path(__file__).parents[2]
GRAMMAR = ROOT / "editors" / "tree-sitter-sj"
GAMES = sorted(
    path
    for folder in (
        "games",
        "tests/cases",
        "tests/differential",
        "tests/runtime",
        "tests/statistics",
        "examples",
    )
    for path in (ROOT / folder).rglob("*.sj")
)
SYNTAX = ("SJ002", "SJ003", "SJ004", "SJ010", "SJ011")  # what no grammar can read
NO_NAMES = (
    "keyword",
    "keyword.conditional",
    "keyword.repeat",
    "keyword.operator",
    "constant.builtin",
    "function.builtin",
    "type.builtin",
)
PLAIN = {  # what Pygments calls it -> what the query does
    Comment.Single: {"comment"},
    String.Double: {"string"},
    String.Escape: {"string.escape"},
    Number: {"number", "number.float"},
    Operator: {"operator"},
    Keyword: {"keyword.conditional", "keyword.repeat"},
    Keyword.Constant: {"constant.builtin"},
    Keyword.Type: {"type.builtin"},
    Keyword.Declaration: {"keyword"},
    Keyword.Reserved: {"keyword"},
    Operator.Word: {"keyword", "keyword.operator", "function.builtin"},
    Name.Attribute: {"property"},
    Name.Class: {"type", "constant", "function", "variable"},
}


@pytest.fixture(scope="module")
def language(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """The generated parser, compiled and loaded."""
    tree_sitter = pytest.importorskip(
        "tree_sitter", reason="the package tree-sitter is not installed: see requirements.txt"
    )
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        pytest.skip("there is no C compiler (cc, gcc or clang), which the generated parser needs")
    library = tmp_path_factory.mktemp("tree-sitter") / "sj.so"
    subprocess.run(
        [
            compiler,
            "-O0",
            "-shared",
            "-fPIC",
            f"-I{GRAMMAR / 'src'}",
            str(GRAMMAR / "src/parser.c"),
            "-o",
            str(library),
        ],
        check=True,
    )
    entry = ctypes.CDLL(str(library)).tree_sitter_sj
    entry.restype = ctypes.c_void_p
    capsule = ctypes.pythonapi.PyCapsule_New
    capsule.restype, capsule.argtypes = (
        ctypes.py_object,
        [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p],
    )
    return tree_sitter.Language(capsule(entry(), b"tree_sitter.Language", None))


def read(language: Any, text: str) -> Any:
    """Returns the root of the tree of a text."""
    from tree_sitter import Parser

    return Parser(language).parse(text.encode()).root_node


def ascii_text(path: Path) -> str:
    """Returns a text in which every letter is one byte, so that places in it are the same for all readers."""
    return path.read_text("utf-8").encode("ascii", "replace").decode()


def leaves(node: Any) -> Iterator[Any]:
    """Yields the tokens of a tree; a text in quotes is one of them."""
    if not node.children or node.type == "string":
        yield node
        return
    for child in node.children:
        yield from leaves(child)


@pytest.fixture(scope="module")
def highlights(language: Any) -> Any:
    """The query that colours."""
    from tree_sitter import Query

    return Query(language, (GRAMMAR / "queries/highlights.scm").read_text("utf-8"))


def colours(highlights: Any, root: Any) -> dict[tuple[int, int], list[str]]:
    """Returns what the query makes of each token, by its place."""
    from tree_sitter import QueryCursor

    found: dict[tuple[int, int], list[str]] = {}
    for name, nodes in QueryCursor(highlights).captures(root).items():
        for node in nodes:
            found.setdefault((node.start_byte, node.end_byte), []).append(name)
    return found


def strings(rule: Any, kind: str = "STRING") -> Iterator[str]:
    """Yields every word or sign that a part of the generated grammar names."""
    if isinstance(rule, dict):
        if rule.get("type") == kind:
            yield rule["value"]
        for part in rule.values():
            yield from strings(part, kind)
    elif isinstance(rule, list):
        for part in rule:
            yield from strings(part, kind)


def test_the_parser_is_generated_from_this_grammar() -> None:
    record = runpy.run_path(str(GRAMMAR / "record.py"))
    assert record["RECORD"].read_text("utf-8") == record["digests"](), (
        "`make tree-sitter` generates the parser again"
    )


def test_every_word_of_the_language_is_in_the_grammar() -> None:
    grammar = json.loads((GRAMMAR / "src/grammar.json").read_text("utf-8"))
    words = {word: kind for kind, word in automaton().words.items() if word.isalpha()}
    assert {word for word in strings(grammar["rules"]) if word.isalpha()} == set(words), (
        "editors/tree-sitter-sj/grammar.js"
    )
    reserved = set(strings(grammar["reserved"]))
    assert reserved == {word for word, kind in words.items() if kind not in SOFT}


def test_every_game_is_read(language: Any) -> None:
    assert len(GAMES) > 60
    assert [str(path) for path in GAMES if read(language, path.read_text("utf-8")).has_error] == []


def test_what_the_manual_shows_is_read(language: Any) -> None:
    manual = "\n".join(
        (ROOT / page).read_text("utf-8") for page in ("docs/language.md", "tests/manual/corners.md")
    )
    blocks = re.findall(
        r"^```sj\b[^\n]*\n(.*?)^```\n(?:```error\n(SJ\d+))?", manual, re.DOTALL | re.MULTILINE
    )
    assert len(blocks) > 100
    for text, code in blocks:
        assert read(language, text).has_error == (code in SYNTAX), text


def test_a_mistake_of_syntax_is_one_here_and_no_other_is(language: Any) -> None:
    otherwise = {
        "SJ001_newer_language",
        "SJ004_control_character",
    }  # another language; a sign that nobody sees, in a comment
    paths = [
        path for path in sorted((ROOT / "tests/errors").glob("*.sj")) if path.stem not in otherwise
    ]
    assert len(paths) > 100
    wrong = [
        path.name
        for path in paths
        if read(language, path.read_text("utf-8")).has_error != path.name.startswith(SYNTAX)
    ]
    assert wrong == []


@pytest.mark.parametrize(
    "path", sorted((GRAMMAR / "test/corpus").glob("*.txt")), ids=lambda path: path.stem
)
def test_the_corpus_holds(language: Any, path: Path) -> None:
    """The same cases as `tree-sitter test` has, which nobody needs to have installed."""
    cases = re.findall(
        r"^={80}\n(.+?)\n={80}\n(.*?)\n-{80}\n(.*?)(?=^={80}$|\Z)",
        path.read_text("utf-8"),
        re.DOTALL | re.MULTILINE,
    )
    assert cases
    for title, text, expected in cases:
        root = read(language, text)
        if title.endswith(":error"):
            assert root.has_error, title
        else:
            assert " ".join(str(root).split()) == re.sub(
                r"\s+\)", ")", " ".join(expected.split())
            ), title


@pytest.mark.parametrize(
    "path", sorted((GRAMMAR / "queries").glob("*.scm")), ids=lambda path: path.stem
)
def test_a_query_fits_the_grammar(language: Any, path: Path) -> None:
    from tree_sitter import Query

    assert Query(language, path.read_text("utf-8")).capture_count > 0


def test_the_mode_for_emacs_has_every_word_and_nodes_that_there_are(language: Any) -> None:
    from tree_sitter import Query

    mode = (GRAMMAR / "sj-ts-mode.el").read_text("utf-8")
    (words,) = re.findall(r"defvar sj-ts-keywords\s+'\((.*?)\)", mode, re.DOTALL)
    others = {"end", "ahead", "all", "any", "nobody", "count", "sum"}  # nodes of their own
    assert set(re.findall(r'"(\w+)"', words)) | others == {
        word for word in automaton().words.values() if word.isalpha()
    }
    patterns = re.findall(r"^ *'?[`(]*(\(\w+ .*?@font-lock-[\w-]+\))", mode, re.MULTILINE)
    assert len(patterns) > 25
    assert Query(language, "\n".join(patterns)).pattern_count == len(patterns)


def test_every_token_has_one_colour_and_words_are_words_where_the_compiler_reads_them_so(
    language: Any, highlights: Any
) -> None:
    met = set()
    for path in [
        *sorted((ROOT / "games").glob("*.sj")),
        *sorted((ROOT / "tests/cases").glob("*.sj")),
    ]:
        text = ascii_text(path)
        root = read(language, text)
        found = colours(highlights, root)
        for leaf in leaves(root):
            assert len(found.get((leaf.start_byte, leaf.end_byte), [])) == 1, (
                path.name,
                leaf,
                leaf.start_point,
            )
        for token in read_tree(Source(path.name, text))[0]:
            if token.isidentifier():
                (colour,) = found[token.start_pos, token.end_pos]
                met.add(token.type)
                assert (colour in NO_NAMES) >= (token.type != "NAME"), (path.name, token, colour)
                assert token.type != "NAME" or not colour.startswith("keyword"), (
                    path.name,
                    token,
                    colour,
                )
    assert met >= {kind for kind, word in automaton().words.items() if word.isalpha()}, (
        "words that no game has are not tried"
    )


@pytest.mark.parametrize("name", ["clean_up", "territory", "pd_arena", "meltingpot/paintball"])
def test_colours_are_those_of_the_other_highlighters(
    language: Any, highlights: Any, name: str
) -> None:
    text = ascii_text(ROOT / "games" / f"{name}.sj")
    found = colours(highlights, read(language, text))
    names = {token.start_pos for token in read_tree(Source(name, text))[0] if token.type == "NAME"}
    compared = 0
    for start, token, piece in SjLexer(stripnl=False).get_tokens_unprocessed(text):
        soft = start in names and (
            token in Keyword or token in Operator
        )  # patterns do not see where a word is a name
        if token in PLAIN and not soft and token not in String:
            (colour,) = found[start, start + len(piece)]
            assert colour in PLAIN[token], (piece, start, token, colour)
            compared += 1
    assert compared > 300
