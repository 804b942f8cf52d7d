"""Files that nobody wrote: random bytes, random characters, words of the language in any order, games cut off, spliced or overwritten."""

import tempfile
import time
from pathlib import Path
from random import Random
from string import printable

from sjdsl.cli.check import find_problems
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.report import render, to_json
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.parse import parser
from sjdsl.compiler.syntax.read import read_source
from tests.damage.edits import FOLDER, GAMES, tokens
from tests.damage.judge import SECONDS, told

SORTS = ("bytes", "characters", "words", "cut", "splice", "overwritten", "pieces")
HEAD = "sj 1\ngame noise {\n"


def noise(sort: str, random: Random) -> bytes:
    """Returns a random file of one sort."""
    text = tokens(random.choice(GAMES))[0]
    match sort:
        case "bytes":
            return random.randbytes(random.randrange(2000))
        case "characters":
            head = random.choice(("", HEAD))
            return (
                head + "".join(random.choice(printable) for _ in range(random.randrange(2000)))
            ).encode()
        case "words":
            return (
                HEAD + " ".join(random.choice(_words()) for _ in range(random.randrange(300)))
            ).encode()
        case "cut":
            return text[: random.randrange(len(text))].encode()
        case "splice":
            other = tokens(random.choice(GAMES))[0]
            return (
                text[: random.randrange(len(text))] + other[random.randrange(len(other)) :]
            ).encode()
        case "overwritten":
            data = bytearray(text.encode())
            for _ in range(random.randrange(1, 20)):
                data[random.randrange(len(data))] = random.randrange(256)
            return bytes(data)
        case _:
            lines = text.splitlines(keepends=True)
            random.shuffle(lines)
            return "".join(["sj 1\n", *lines[: random.randrange(len(lines))]]).encode()


def _words() -> list[str]:
    known = [str(t.pattern.value) for t in parser().terminals if t.pattern.type == "str"]
    return [*known, "agent", "tile", "a", "b", "0", "1", "0.5", '"x"', "\n"]


def fault_of(data: bytes) -> str:
    """Returns what goes wrong while a file is checked, in the game and its variants, and its problems shown; empty if nothing does."""
    begun = time.process_time()
    try:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "noise.sj"
            path.write_bytes(data)
            read = read_source(path)
        source = Source("noise.sj", read.text, FOLDER)
        found = [d for problems in find_problems(source).values() for d in problems]
        render(found, {source.name: source}, colour=True)
        to_json(found, {source.name: source})
    except CompileError as refused:
        render(refused.diagnostics, {}, colour=False)
    except Exception as error:
        return told(error)
    seconds = time.process_time() - begun
    return f"{seconds:.1f} s" if seconds > SECONDS else ""
