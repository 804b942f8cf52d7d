"""The games whose texts are read: all bundled ones, all of Melting Pot, and examples."""

from functools import cache
from pathlib import Path

from sjdsl.compiler import build, ir
from sjdsl.compiler.compose import compose
from sjdsl.compiler.syntax.read import read_source

ROOT = Path(__file__).parents[2]
GOLDEN = ROOT / "tests" / "golden" / "told"
FOLDERS = (ROOT / "games", ROOT / "games" / "meltingpot", ROOT / "examples")
FILES = {path.stem: path for folder in FOLDERS for path in sorted(folder.glob("*.sj"))}
CASES = {path.stem: path for path in sorted((ROOT / "tests" / "cases").glob("*.sj"))}


@cache
def game(name: str) -> ir.Game:
    """Returns the typed rules of a game: `coins`, `coins+socialjax`, or a case such as `tasks`."""
    name, *variants = name.split("+")
    return build(read_source((FILES | CASES)[name]), variants).game


def variants() -> list[str]:
    """Returns each variant of each game."""
    return [
        f"{name}+{variant}"
        for name, path in FILES.items()
        for variant in compose(read_source(path)).variants
    ]
