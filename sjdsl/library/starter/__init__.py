"""The files of a new game (`sjdsl new`): a small dilemma with its map and its tests."""

import keyword
import re
from importlib.resources import files
from pathlib import Path, PurePosixPath

from sjdsl.compiler import ast
from sjdsl.compiler.compose import chain
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.syntax.parse import parse
from sjdsl.compiler.syntax.read import inside_folder, read_source

FILES = {"game.sj": "{name}.sj", "map.txt": "{name}.txt", "test_game.py": "test_{name}.py"}
NAME = re.compile(r"[a-z][a-z0-9_]*")


def starting_files(name: str) -> dict[str, str]:
    """Returns the texts of a new game's files by their names.

    Raises:
      ValueError: the name cannot be that of a game and of a Python module.
    """
    if not NAME.fullmatch(name) or keyword.iskeyword(name):
        raise ValueError(
            f"`{name}` cannot name a game: small letters, digits and _, a letter first, such as my_game"
        )
    words = {"NAME": name, "TITLE": name.replace("_", " ").title()}
    templates = files("sjdsl.library.starter")
    return {
        path.format(name=name): re.sub(
            r"\b(NAME|TITLE)\b",
            lambda found: words[found[0]],
            templates.joinpath(f"{file}.txt").read_text("utf-8"),
        )
        for file, path in FILES.items()
    }


def copied_files(game: Path, name: str) -> dict[str, str]:
    """Returns the texts of a copy of a game called `name`, by the names of its files: the game, those that it extends, and their maps.

    Raises:
      ValueError: the name cannot be that of a game.
      CompileError: a file of the game cannot be read.
    """
    if not NAME.fullmatch(name):
        raise ValueError(
            f"`{name}` cannot name a game: small letters, digits and _, a letter first, such as my_game"
        )
    source = read_source(game)
    span = parse(source).game.name.span
    texts = {f"{name}.sj": source.text[: span.start] + name + source.text[span.end :]}
    problems = Problems()
    place = PurePosixPath(f"{name}.sj")  # of a text in the copy
    for one, file in chain(source):
        texts.setdefault(str(place), one.text)
        for map_ in (
            node.file for node in walk(file) if isinstance(node, ast.Map) and node.file is not None
        ):
            path = inside_folder(map_.text, map_.span, one, problems)
            if path is not None:
                texts[str(place.parent / map_.text)] = read_source(path).text
        if file.game.extends is not None:
            place = place.parent / file.game.extends.text
    if problems.diagnostics:
        raise CompileError(problems.diagnostics)
    return texts
