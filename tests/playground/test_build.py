"""Where the playground has Pyodide from: the build copies its files, or says by which digests a visitor's browser knows them elsewhere."""

import base64
import hashlib
import json
import py_compile
import re
import runpy
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

BUILD = runpy.run_path(str(Path(__file__).parents[2] / "editors/playground/build.py"))
put_pyodide: Callable[..., str] = BUILD["put_pyodide"]


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """Returns a folder like that of npm's package, with short files."""
    folder = tmp_path / "pyodide-of-npm"
    folder.mkdir()
    for name in BUILD["PYODIDE"]:
        (folder / name).write_text(f"content of {name}")
    (folder / "package.json").write_text('{"version": "1.2.3"}')
    return folder


@pytest.fixture
def place(package: Path) -> Iterator[str]:
    """Returns the address of a server that has the files of the package."""

    class Quiet(SimpleHTTPRequestHandler):
        def log_message(self, *_: object) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(package))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


def told(out: Path) -> tuple[str, dict[str, str]]:
    """Returns what pyodide.js says: the place, and a digest for each file."""
    text = (out / "pyodide.js").read_text()
    found = re.fullmatch(
        r"export const PLACE = (.*);\nexport const INTEGRITY = (.*);\n", text, re.DOTALL
    )
    assert found is not None
    return json.loads(found[1]), json.loads(found[2])


def made(path: Path) -> Path:
    path.mkdir()
    return path


def test_its_files_are_part_of_the_build(tmp_path: Path, package: Path) -> None:
    out = made(tmp_path / "out")
    said = put_pyodide(out, package)
    assert said == "Pyodide 1.2.3 is part of it: visitors load nothing from elsewhere."
    place, digests = told(out)
    assert place == "./pyodide/"
    assert {path.name for path in (out / "pyodide").iterdir()} == set(digests)
    for name, digest in digests.items():
        content = (out / "pyodide" / name).read_bytes()
        assert content == (package / name).read_bytes()
        assert base64.b64decode(digest.removeprefix("sha384-")) == hashlib.sha384(content).digest()


def test_they_are_left_to_a_server_that_has_the_same(
    tmp_path: Path, package: Path, place: str
) -> None:
    out, beside = made(tmp_path / "out"), made(tmp_path / "beside")
    said = put_pyodide(out, package, place)
    assert [path.name for path in out.iterdir()] == ["pyodide.js"]
    assert said.endswith(
        f"visitors load it from {place}/, and their browsers check it. Its 5 files there are those of npm."
    )
    put_pyodide(beside, package)
    assert told(out) == (f"{place}/", told(beside)[1])


def test_a_server_with_another_file_is_refused(tmp_path: Path, package: Path, place: str) -> None:
    others = made(tmp_path / "others")
    for path in package.iterdir():
        (others / path.name).write_bytes(path.read_bytes())
    (others / "pyodide.asm.wasm").write_text("something else")
    with pytest.raises(SystemExit, match=r"pyodide\.asm\.wasm is not the file that npm has"):
        put_pyodide(made(tmp_path / "out"), others, place)


def test_packages_of_byte_code_alone_have_their_names(tmp_path: Path) -> None:
    """As in the browser, where there is no source to read: every public name that the page's packages load lazily is found."""
    for path, name in BUILD["_sources"]():
        if name.endswith(".py"):
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            py_compile.compile(str(path), str(tmp_path / name) + "c", doraise=True)
    script = "import sjdsl, sjdsl.render; print(sjdsl.CompileError.__name__, sjdsl.render.take_snapshot.__name__)"
    done = subprocess.run(
        [sys.executable, "-c", script],
        cwd=tmp_path,
        env={"PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
    )
    assert done.stdout == "CompileError take_snapshot\n", done.stderr
