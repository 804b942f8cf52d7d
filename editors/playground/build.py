"""Builds the playground: static files that any web server can give, with Python, the front end and the interpreter in them.

Run in an environment that has `sjdsl[studio]`, after `npm ci` in this folder: `python editors/playground/build.py build/playground`.
With `--pyodide cdn` the files of Pyodide are not part of it: the visitor's browser loads them from a public server, and checks them.
"""

import argparse
import base64
import hashlib
import json
import shutil
import subprocess
import sys
import urllib.request
import zipfile
from collections.abc import Iterator
from importlib import import_module
from importlib.metadata import files, version
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import Any
from urllib.parse import quote

import jinja2

from sjdsl.editor.highlighting import patterns
from sjdsl.studio import tour
from sjdsl.studio.server import FirstGame
from sjdsl.studio.serverless import Serverless

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
PYODIDE = (
    "pyodide.mjs",
    "pyodide.asm.mjs",
    "pyodide.asm.wasm",
    "python_stdlib.zip",
    "pyodide-lock.json",
)
CDN = (
    "https://cdn.jsdelivr.net/npm/pyodide@{version}/"  # has the files of npm's package as they are
)
SITE = PurePosixPath("/lib/python3.14/site-packages")  # as in worker.js
PAGE = ("studio.css", "studio.js", "studio.licences.txt")
PLATFORM = (
    "--platform",
    "pyemscripten_2026_0_wasm32",
    "--python-version",
    "3.14",
    "--abi",
    "cp314",
    "--only-binary",
    ":all:",
    "--no-deps",
)
# Of the language server, the compiler and what draws: all of pure Python, as this environment has them.
PACKAGES = (
    "lark",
    "interegular",
    "pydantic",
    "typing_inspection",
    "annotated_types",
    "jinja2",
    "markupsafe",
    "typing_extensions",
)
PACKAGES += ("pygls", "lsprotocol", "cattrs", "attr", "attrs")
DISTRIBUTIONS = (
    "lark",
    "interegular",
    "pydantic",
    "pydantic_core",
    "typing-inspection",
    "annotated-types",
    "jinja2",
    "markupsafe",
)
DISTRIBUTIONS += ("typing_extensions", "pygls", "lsprotocol", "cattrs", "attrs")
LEFT_OUT = (
    "bench",
    "cli",
    "experiments",
    "interop",
    "report",
    "sweeps",
)  # folders of sjdsl that the studio does not use
DATA = (".j2", ".json", ".lark", ".md", ".sj", ".svg", ".toml", ".txt", ".html", ".css", ".js")


def main() -> None:
    """Writes the files into the folder that is given, which is made anew."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument(
        "--pyodide",
        metavar="URL",
        default="",
        help="a folder on a server with npm's files of Pyodide, or cdn: visitors load it there",
    )
    given = parser.parse_args()
    out = given.out
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    where = put_pyodide(out, HERE / "node_modules/pyodide", given.pyodide)
    _wheel(out / "pydantic_core.whl")
    sources = out / "sources.zip"
    with zipfile.ZipFile(sources, "w") as packed:
        for path, name in _sources():
            packed.write(path, name)
    compiling = [
        "node",
        str(HERE / "compile.mjs"),
        str(sources),
        str(out / "pydantic_core.whl"),
        str(out / "packages.zip"),
    ]
    subprocess.run(compiling, check=True)
    sources.unlink()
    for name in PAGE:
        shutil.copy(ROOT / "sjdsl/studio/page" / name, out)
    shutil.copy(ROOT / "sjdsl/render/page/board.js", out)
    shutil.copytree(ROOT / "sjdsl/studio/thumbnails", out / "thumbnails")
    for name in ("transport.js", "worker.js"):
        shutil.copy(HERE / name, out)
    (out / "index.html").write_text(_page(), encoding="utf-8")
    (out / "licences.txt").write_text("\n----\n\n".join(_licences()), encoding="utf-8")
    sizes = {
        path.relative_to(out).as_posix(): path.stat().st_size
        for path in sorted(out.rglob("*"))
        if path.is_file()
    }
    print(json.dumps(sizes, indent=2))
    print(f"{sum(sizes.values()) / 1e6:.1f} MB in {out}")
    print(where)


def put_pyodide(out: Path, package: Path, place: str = "") -> str:
    """Writes pyodide.js, which tells the worker where Pyodide is and what its files have to be, and copies the files if no place is given.

    package: the folder of npm's package. place: a URL, or "cdn". Returns a sentence that says what was done.
    Raises SystemExit for a place that is no URL of a server that browsers trust, or that has other files.
    """
    version = json.loads((package / "package.json").read_text(encoding="utf-8"))["version"]
    digests = {name: _integrity((package / name).read_bytes()) for name in PYODIDE}
    if place:
        place = CDN.format(version=version) if place == "cdn" else place.rstrip("/") + "/"
        if not place.startswith(("https://", "http://127.0.0.1:", "http://localhost:")):
            sys.exit(
                f"{place} is no place for Pyodide: name a URL that begins with https://, or cdn"
            )
        said = f"Pyodide {version} is not part of it: visitors load it from {place}, and their browsers check it. {_compared(place, digests)}"
    else:
        (out / "pyodide").mkdir()
        for name in PYODIDE:
            shutil.copy(package / name, out / "pyodide")
        place, said = (
            "./pyodide/",
            f"Pyodide {version} is part of it: visitors load nothing from elsewhere.",
        )
    text = f"export const PLACE = {json.dumps(place)};\nexport const INTEGRITY = {json.dumps(digests, indent=2)};\n"
    (out / "pyodide.js").write_text(text, encoding="utf-8")
    return said


def _integrity(content: bytes) -> str:
    """Returns a digest as browsers want it: https://www.w3.org/TR/sri/."""
    return "sha384-" + base64.b64encode(hashlib.sha384(content).digest()).decode("ascii")


def _compared(place: str, digests: dict[str, str]) -> str:
    """Says whether the files at a place were seen to be those of npm. Raises SystemExit if one is another."""
    for name, digest in digests.items():
        try:
            with urllib.request.urlopen(place + name, timeout=20) as answer:
                content = answer.read()
        except OSError as error:
            return f"NOT TESTED: {place}{name} cannot be loaded from here ({error}), so nobody has compared it to the file on npm."
        if _integrity(content) != digest:
            sys.exit(
                f"{place}{name} is not the file that npm has: visitors' browsers would refuse it"
            )
    return f"Its {len(digests)} files there are those of npm."


def _wheel(to: Path) -> None:
    """Fetches the one package that is no pure Python, in the version that pydantic wants."""
    wanted = f"pydantic_core=={version('pydantic_core')}"
    subprocess.run(
        [
            sys.executable,
            "-m",
            "pip",
            "download",
            "--quiet",
            *PLATFORM,
            "--dest",
            str(to.parent),
            wanted,
        ],
        check=True,
    )
    (fetched,) = to.parent.glob("pydantic_core-*.whl")
    fetched.rename(to)


def _sources() -> Iterator[tuple[Path, str]]:
    """Yields the files that Python needs in the browser, each with its name there."""
    for name in PACKAGES:
        place = Path(str(import_module(name).__file__))
        if place.name == "__init__.py":
            yield from _files(place.parent, name)
        else:
            yield place, place.name
    yield from _files(HERE / "numpy", "numpy")
    yield from _files(ROOT / "games", "sjdsl/games")
    for path, name in _files(ROOT / "sjdsl", "sjdsl"):
        if name.split("/")[1] not in LEFT_OUT:
            yield path, name


def _files(folder: Path, name: str) -> Iterator[tuple[Path, str]]:
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path.suffix in (".py", *DATA) and "__pycache__" not in path.parts:
            yield path, f"{name}/{path.relative_to(folder).as_posix()}"


def _licences() -> Iterator[str]:
    """Yields the licence of each part, with its version."""
    pyodide = json.loads((HERE / "node_modules/pyodide/package.json").read_text(encoding="utf-8"))
    yield f"pyodide {pyodide['version']} ({pyodide['license']}), with CPython (PSF-2.0) and its standard library\n"
    yield f"sjdsl {version('sjdsl')}\n\n{(ROOT / 'LICENSE').read_text(encoding='utf-8')}"
    for name in DISTRIBUTIONS:
        texts = [
            path for path in files(name) or () if path.name.upper().startswith(("LICEN", "COPYING"))
        ]
        assert texts, f"{name} has no licence file"
        yield f"{name} {version(name)}\n\n" + "\n".join(
            path.read_text(encoding="utf-8") for path in texts
        )


def _page() -> str:
    """Returns the studio's page, open on the tour, with what answers it before its script, and with all addresses beside it."""
    page = (ROOT / "sjdsl/studio/page/studio.html").read_text(encoding="utf-8")
    environment = jinja2.Environment(undefined=jinja2.StrictUndefined, autoescape=True)
    text = environment.from_string(page).render(
        token="", first=FirstGame(tour.games()[0]), patterns=json.dumps(patterns())
    )
    script = '<script type="module" src="./studio.js">'
    text = text.replace("/assets/", "./").replace(
        "<title>sjdsl studio</title>", "<title>sjdsl playground</title>"
    )
    assert script in text, "the studio's page has changed"
    ahead = json.dumps(_ahead(tour.games()[0])).replace("<", "\\u003c")
    data = f'<script type="application/json" id="ahead">{ahead}</script>\n'
    return text.replace(
        script, data + '<script type="module" src="./transport.js"></script>\n' + script
    )


def _ahead(path: str) -> dict[str, Any]:
    """Returns what Python will be asked first, with its answers: files, and the board of a game of the tour."""
    asked = f"/file?path={quote(path, safe='')}"
    with TemporaryDirectory() as folder:
        python = Serverless(Path(folder))
        files = {address: json.loads(python.file("GET", address)) for address in ("/tour", asked)}
        text = {"do": "text", "version": 0, "path": path, "text": files[asked]["text"]}
        answer = json.loads(python.bench(json.dumps(text)))
    files[asked]["uri"] = (SITE / "sjdsl/studio/tour" / path.removeprefix(tour.PREFIX)).as_uri()
    return {"path": path, "answer": answer, "files": files}


if __name__ == "__main__":
    main()
