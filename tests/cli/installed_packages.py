"""Makes packages of games as an installer leaves them: a folder, and beside it the metadata with the entry point."""

from collections.abc import Mapping
from pathlib import Path

GAME = """sj 1
game NAME "A {title}" {
  episode 3
  kind floor "."
  map { "..." }
  agents 2 { acts forward, stay  moves relative }
  phase start { each agent { send agent to floor } }
  schedule walk
  phase walk { move each agent }
  observe { window ahead 1, behind 0, left 1, right 1 }
}
"""
BOOM = "raise RuntimeError('this package was imported')\n"


def game(name: str) -> str:
    """Returns the text of a small game."""
    return GAME.replace("NAME", name).replace("{title}", name.title())


def install(place: Path, package: str, files: Mapping[str, str], version: str = "1.0", value: str | None = None) -> Path:
    """Installs a package into a folder on the path of imports, and returns its own folder; importing any of it fails.

    value: of the entry point, if it is not the package's name.
    """
    home = place.joinpath(*package.split("."))
    home.mkdir(parents=True)
    for folder in (home, *home.parents):
        if folder == place:
            break
        (folder / "__init__.py").write_text(BOOM)
    for name, text in files.items():
        (home / name).parent.mkdir(parents=True, exist_ok=True)
        (home / name).write_text(text)
    register(place, package.replace(".", "-").replace("_", "-"), package, value or package, version)
    return home


def register(place: Path, distribution: str, name: str, value: str, version: str = "1.0") -> None:
    """Writes the metadata of a distribution whose entry point has this name and value."""
    told = place / f"{distribution.replace('-', '_')}-{version}.dist-info"
    told.mkdir()
    (told / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: {version}\n")
    (told / "entry_points.txt").write_text(f"[sjdsl.games]\n{name} = {value}\n")
