"""Every program of the repository that compiles: games with their variants, cases, differential games, examples of the manual."""

import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.read import read_source
from sjdsl.doc import Written, read_written
from tests.manual.blocks import blocks, examples, frames

TESTS = Path(__file__).parent.parent
GAMES = sorted((TESTS.parent / "games").glob("*.sj"))
SMALL = [
    *sorted((TESTS / "cases").glob("*.sj")),
    *sorted((TESTS / "differential" / "games").glob("*.sj")),
]


@cache
def games() -> dict[str, Written]:
    """Returns the bundled games, alone and in each of their variants: `coins`, `coins+socialjax`."""
    found = {}
    for path in GAMES:
        plain = read_written(read_source(path))
        found[path.stem] = plain
        found |= {
            f"{path.stem}+{name}": read_written(read_source(path), (name,))
            for name, _ in plain.variants
        }
    return found


@cache
def small() -> dict[str, Written]:
    """Returns the programs that tests are made of."""
    return {
        path.stem: read_written(read_source(path))
        for path in (*SMALL, TESTS.parent / "games" / "pd_arena.sj")
    }


@cache
def manual() -> dict[str, Written]:
    """Returns the examples of the manual that compile."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for path, text in _files():
            (folder / path).write_text(text, encoding="utf-8")
        sound = [e for e in examples() if not e.said("error")]
        return {e.name: read_written(Source(f"{e.name}.sj", e.source, folder)) for e in sound}


def _files() -> Iterator[tuple[str, str]]:
    yield from ((f"{name}.sj", text) for name, text in frames().items())
    yield from ((block.info["file"], block.text) for block in blocks() if "file" in block.info)
