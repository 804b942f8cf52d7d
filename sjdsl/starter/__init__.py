"""The files of a new game (`sjdsl new`): a small dilemma with its map and its tests."""

import keyword
import re
from importlib.resources import files

FILES = {"game.sj": "{name}.sj", "map.txt": "{name}.txt", "test_game.py": "test_{name}.py"}
NAME = re.compile(r"[a-z][a-z0-9_]*")


def starting_files(name: str) -> dict[str, str]:
    """Returns the texts of a new game's files by their names.

    Raises:
      ValueError: the name cannot be that of a game and of a Python module.
    """
    if not NAME.fullmatch(name) or keyword.iskeyword(name):
        raise ValueError(f"`{name}` cannot name a game: small letters, digits and _, a letter first, such as my_game")
    folder = files("sjdsl.starter")
    texts = {file: folder.joinpath(f"{file}.txt").read_text(encoding="utf-8") for file in FILES}
    title = name.replace("_", " ").title()
    return {FILES[file].format(name=name): text.replace("NAME", name).replace("TITLE", title) for file, text in texts.items()}
