"""Builds the playground: static files that any web server can give, with Python, the front end and the interpreter in them.

Run in an environment that has `sjdsl[studio]`, after `npm ci` in this folder: `python editors/playground/build.py build/playground`.
"""

import argparse
import json
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from importlib import import_module
from importlib.metadata import files, version
from pathlib import Path

import jinja2

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
PYODIDE = ("pyodide.mjs", "pyodide.asm.mjs", "pyodide.asm.wasm", "python_stdlib.zip", "pyodide-lock.json")
PAGE = ("studio.css", "studio.js", "studio.licences.txt")
PLATFORM = ("--platform", "pyemscripten_2026_0_wasm32", "--python-version", "3.14", "--abi", "cp314", "--only-binary", ":all:", "--no-deps")
# Of the language server, the compiler and what draws: all of pure Python, as this environment has them.
PACKAGES = ("lark", "interegular", "pydantic", "typing_inspection", "annotated_types", "jinja2", "markupsafe", "typing_extensions")
PACKAGES += ("pygls", "lsprotocol", "cattrs", "attr", "attrs")
DISTRIBUTIONS = ("lark", "interegular", "pydantic", "pydantic_core", "typing-inspection", "annotated-types", "jinja2", "markupsafe")
DISTRIBUTIONS += ("typing_extensions", "pygls", "lsprotocol", "cattrs", "attrs")
LEFT_OUT = ("bench", "cli", "experiments", "interop", "report", "starter", "sweeps")  # folders of sjdsl that the studio does not use
DATA = (".j2", ".json", ".lark", ".md", ".sj", ".svg", ".toml", ".txt", ".html", ".css", ".js")


def main() -> None:
    """Writes the files into the folder that is given, which is made anew."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    out = parser.parse_args().out
    shutil.rmtree(out, ignore_errors=True)
    (out / "pyodide").mkdir(parents=True)
    for name in PYODIDE:
        shutil.copy(HERE / "node_modules/pyodide" / name, out / "pyodide")
    _wheel(out / "pydantic_core.whl")
    sources = out / "sources.zip"
    with zipfile.ZipFile(sources, "w") as packed:
        for path, name in _sources():
            packed.write(path, name)
    compiling = ["node", str(HERE / "compile.mjs"), str(sources), str(out / "pydantic_core.whl"), str(out / "packages.zip")]
    subprocess.run(compiling, check=True)
    sources.unlink()
    for name in PAGE:
        shutil.copy(ROOT / "sjdsl/studio/page" / name, out)
    shutil.copy(ROOT / "sjdsl/render/page/board.js", out)
    for name in ("transport.js", "worker.js"):
        shutil.copy(HERE / name, out)
    (out / "index.html").write_text(_page(), encoding="utf-8")
    (out / "licences.txt").write_text("\n----\n\n".join(_licences()), encoding="utf-8")
    sizes = {path.relative_to(out).as_posix(): path.stat().st_size for path in sorted(out.rglob("*")) if path.is_file()}
    print(json.dumps(sizes, indent=2))
    print(f"{sum(sizes.values()) / 1e6:.1f} MB in {out}")


def _wheel(to: Path) -> None:
    """Fetches the one package that is no pure Python, in the version that pydantic wants."""
    wanted = f"pydantic_core=={version('pydantic_core')}"
    subprocess.run([sys.executable, "-m", "pip", "download", "--quiet", *PLATFORM, "--dest", str(to.parent), wanted], check=True)
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
    yield from _files(ROOT / "trainers", "sjdsl/trainers")  # the studio asks them for names alone
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
        texts = [path for path in files(name) or () if path.name.upper().startswith(("LICEN", "COPYING"))]
        assert texts, f"{name} has no licence file"
        yield f"{name} {version(name)}\n\n" + "\n".join(path.read_text(encoding="utf-8") for path in texts)


def _page() -> str:
    """Returns the studio's page with what answers it before its script, and with all addresses beside it."""
    page = (ROOT / "sjdsl/studio/page/studio.html").read_text(encoding="utf-8")
    environment = jinja2.Environment(undefined=jinja2.StrictUndefined, autoescape=True)
    text = environment.from_string(page).render(token="", opened="example:clean_up.sj")
    script = '<script type="module" src="./studio.js">'
    text = text.replace("/assets/", "./").replace("<title>sjdsl studio</title>", "<title>sjdsl playground</title>")
    assert script in text, "the studio's page has changed"
    return text.replace(script, '<script type="module" src="./transport.js"></script>\n' + script)


if __name__ == "__main__":
    main()
