"""The files of a new game (`sjdsl new`): a small dilemma with its map and its tests."""

import keyword
import re
from importlib.resources import files
from pathlib import Path, PurePosixPath

from sjdsl.compiler import ast
from sjdsl.compiler.compose import bases
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
      ValueError: the name can't be that of a game and of a Python module.
    """
    if not NAME.fullmatch(name) or keyword.iskeyword(name):
        raise _invalid_name(name)
    values = {"NAME": name, "TITLE": name.replace("_", " ").title()}
    templates = files("sjdsl.library.starter")
    texts = {}
    for file, path in FILES.items():
        template = templates.joinpath(f"{file}.txt").read_text("utf-8")
        text = re.sub(r"\b(NAME|TITLE)\b", lambda match: values[match[0]], template)
        texts[path.format(name=name)] = text
    return texts


def copied_files(game: Path, name: str) -> dict[str, str]:
    """Returns the files of a copy of a game, by their paths beside it.

    These are the game, called `name`, those that it extends, and their maps.

    Raises:
      ValueError: the name can't be that of a game.
      CompileError: a file of the game can't be read.
    """
    if not NAME.fullmatch(name):
        raise _invalid_name(name)
    source = read_source(game)
    span = parse(source).game.name.span
    texts = {f"{name}.sj": source.text[: span.start] + name + source.text[span.end :]}
    problems = Problems()
    copy = PurePosixPath(f"{name}.sj")
    for base, file in bases(source):
        texts.setdefault(str(copy), base.text)
        for node in walk(file):
            if isinstance(node, ast.Map) and node.file is not None:
                path = inside_folder(node.file.text, node.file.span, base, problems)
                if path is not None:
                    texts[str(copy.parent / node.file.text)] = read_source(path).text
        if file.game.extends is not None:
            copy = copy.parent / file.game.extends.text
    if problems.diagnostics:
        raise CompileError(problems.diagnostics)
    return texts


def _invalid_name(name: str) -> ValueError:
    return ValueError(
        f"`{name}` cannot name a game: use small letters, digits and _, a letter first, and no "
        "keyword of Python, such as my_game"
    )
