"""A rule that is added, whether it never fires or fires without anybody's reading it, changes no draw of any other."""

import re
import shutil
from pathlib import Path
from random import Random

import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.interpreter.state import default_params
from sjdsl.library.games_folder import find_game
from tests.fuzz.judge import written
from tests.fuzz.programs import program
from tests.laws.added import with_rules
from tests.laws.corpus import FEW, SOME_OF_NINE, game_of, random_games
from tests.laws.streams import streams
from tests.laws.trajectory import parting, start_of, trajectory

STEPS = 6


def parts(game: ir.Game, more: ir.Game, random: Random) -> str:
    """Returns where the game with more rules leaves the game's trajectory; nothing if it does not."""
    assert streams(game).keys() < streams(more).keys()
    start = start_of(game, random, STEPS)
    world = start.world
    fields = {**{f.name: 0 for f in more.fields if f.name == "law_tally"}, **world.fields}
    more_world = type(world)(**{**vars(world), "fields": fields, "params": default_params(more)})
    return parting(trajectory(game, start), trajectory(more, start, more_world))


@pytest.mark.parametrize("name", SOME_OF_NINE)
def test_nine_games(name: str, tmp_path: Path) -> None:
    """With the rules added to the text, also to the one that it extends."""
    folder = find_game(name).parent
    shutil.copytree(folder / "maps", tmp_path / "maps")
    shutil.copytree(folder / "meltingpot/shared", tmp_path / "meltingpot/shared")
    for path in folder.glob("*.sj"):
        text = path.read_text(encoding="utf-8")
        if re.search(r"^\s*schedule", text, re.MULTILINE):
            text = with_rules(Source(path.name, text, tmp_path)).text
        (tmp_path / path.name).write_text(text, encoding="utf-8")
    more = build(
        Source(f"{name}.sj", (tmp_path / f"{name}.sj").read_text(encoding="utf-8"), tmp_path)
    ).game
    assert not parts(game_of(name), more, Random(name))


def added_to_random_program(seed: int, game: ir.Game) -> str | None:
    """Returns where the random program of a seed parts from itself with more rules; None if these make it too large, or stand in its base."""
    with written(program(Random(seed))) as source:
        if " extends " in source.text:
            return None
        try:
            more = build(with_rules(source)).game
        except CompileError as refused:
            limits = {d.code for d in refused.diagnostics} <= {"SJ601"}
            return None if limits else f"refused: {refused}"
    return parts(game, more, Random(seed))


def test_random_programs() -> None:
    found = {seed: added_to_random_program(seed, game) for seed, game in random_games(FEW)}
    assert not {seed: where for seed, where in found.items() if where}
    assert sum(where is not None for where in found.values()) >= FEW // 2
