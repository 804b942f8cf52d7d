"""The files of a new game (`sjdsl new`): a small dilemma with its map and its tests, alone or as a package for others to install."""

import keyword
import re
import sys
from importlib.resources import files
from pathlib import Path, PurePosixPath

from sjdsl.compiler import ast
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.syntax.parse import parse
from sjdsl.compiler.syntax.read import inside_folder, read_source
from sjdsl.version import HOMEPAGE, __version__

FILES = {"game.sj": "{name}.sj", "map.txt": "{name}.txt", "test_game.py": "test_{name}.py"}
OF_PACKAGE = {
    "package_pyproject.toml": "pyproject.toml",
    "package_readme.md": "README.md",
    "package_gitignore": ".gitignore",
    "package_tests.yml": ".github/workflows/tests.yml",
    "package_init.py": "src/{package}/__init__.py",
    "game.sj": "src/{package}/{name}.sj",
    "map.txt": "src/{package}/{name}.txt",
    "test_game.py": "tests/test_{name}.py",
}
NAME = re.compile(r"[a-z][a-z0-9_]*")
GAMES = "_games"  # what the name of a package may end with, and that of its first game does not


def starting_files(name: str) -> dict[str, str]:
    """Returns the texts of a new game's files by their names.

    Raises:
      ValueError: the name cannot be that of a game and of a Python module.
    """
    if not NAME.fullmatch(name) or keyword.iskeyword(name):
        raise ValueError(f"`{name}` cannot name a game: small letters, digits and _, a letter first, such as my_game")
    words = {"IMPORTS": "from pathlib import Path\n\n", "FILE": f'Path(__file__).parent / "{name}.sj"'} | _names(name)
    return {path.format(name=name): _filled(file, words) for file, path in FILES.items()}


def copied_files(game: Path, name: str) -> dict[str, str]:
    """Returns the texts of a copy of a game called `name`, by the names of its files: the game, those that it extends, and their maps.

    Raises:
      ValueError: the name cannot be that of a game.
      CompileError: a file of the game cannot be read.
    """
    if not NAME.fullmatch(name):
        raise ValueError(f"`{name}` cannot name a game: small letters, digits and _, a letter first, such as my_game")
    source = read_source(game)
    span = parse(source).game.name.span
    texts = {f"{name}.sj": source.text[: span.start] + name + source.text[span.end :]}
    waiting, problems = [(source, PurePosixPath())], Problems()
    while waiting:
        source, folder = waiting.pop()
        for node in walk(parse(source)):
            named = node.file if isinstance(node, ast.Map) else node.extends if isinstance(node, ast.Game) else None
            path = None if named is None else inside_folder(named.text, named.span, source, problems)
            if named is None or path is None:
                continue
            found = read_source(path)
            texts[str(folder / named.text)] = found.text
            if isinstance(node, ast.Game):
                waiting.append((found, (folder / named.text).parent))
    if problems.found:
        raise CompileError(problems.found)
    return texts


def package_files(package: str) -> dict[str, str]:
    """Returns the texts of a package with one game, by their paths in its folder. The game is called as `game_of` says.

    Raises:
      ValueError: the name cannot be that of a package of games.
    """
    name = game_of(package)
    if not NAME.fullmatch(package) or not NAME.fullmatch(name) or keyword.iskeyword(name) or package in sys.stdlib_module_names:
        raise ValueError(f"`{package}` cannot name a package of games: small letters, digits and _, a letter first, such as my_games")
    words = {"IMPORTS": "", "FILE": f'"{package}:{name}"', "DISTRIBUTION": package.replace("_", "-"), "PACKAGE": package}
    words |= {"RELEASE": ".".join(__version__.split(".")[:2]), "URL": HOMEPAGE} | _names(name)
    return {path.format(name=name, package=package): _filled(file, words) for file, path in OF_PACKAGE.items()}


def game_of(package: str) -> str:
    """Returns the name of a new package's first game: that of the package, without `_games` at its end."""
    return package.removesuffix(GAMES)


def _names(name: str) -> dict[str, str]:
    return {"NAME": name, "TITLE": name.replace("_", " ").title()}


def _filled(file: str, words: dict[str, str]) -> str:
    """Returns the text of a template. Words in it that are replaced are capitals alone, longer ones first."""
    text = files("sjdsl.library.starter").joinpath(f"{file}.txt").read_text(encoding="utf-8")
    return re.sub(rf"\b({'|'.join(sorted(words, key=len, reverse=True))})(?=\b|import)", lambda found: words[found[0]], text)
