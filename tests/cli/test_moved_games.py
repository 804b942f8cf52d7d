"""A run, an episode or a sweep finds its game again when folders have moved, by the hash of its rules."""

import json
import shutil
from pathlib import Path
from typing import Any

import pytest
from command_line import GAME, GROVE, Sjdsl

from sjdsl.cli.environment_options import EnvironmentOptions
from sjdsl.compiler.ir.hash import game_hash
from sjdsl.library.stored_game import GameMoved, locate_game
from sjdsl.sweeps.folder import merge_sweep

MAP = "#####\n#.AA#\n#A.A#\n#####\n"


@pytest.fixture
def project(folder: Path) -> Path:
    """A folder with games that extend one another, maps, and a run."""
    project = folder / "project"
    (project / "games/maps").mkdir(parents=True)
    (project / "runs/one").mkdir(parents=True)
    (project / "games/grove.sj").write_text(GROVE)
    (project / "games/short.sj").write_text('sj 1\ngame short extends "grove.sj" { episode 3 }\n')
    (project / "games/mapped.sj").write_text(
        'sj 1\ngame mapped extends "grove.sj" { map "maps/a.txt" }\n'
    )
    (project / "games/maps/a.txt").write_text(MAP)
    (project / "wide.txt").write_text(MAP.replace("#A", "##"))
    return project


def described(game: Path, map: Path | None = None, **options: Any) -> tuple[dict[str, Any], str]:
    asked = EnvironmentOptions(map=map and str(map), **options)
    return asked.describe(str(game)), game_hash(asked.check(str(game)))


@pytest.mark.parametrize("name", ["grove", "short", "mapped"])
@pytest.mark.parametrize("with_map", [False, True])
@pytest.mark.parametrize("place", ["runs/one", "runs/sweep/cells/two", "episode.npz"])
def test_a_game_is_found_where_its_folder_is_now(
    name: str, with_map: bool, place: str, project: Path
) -> None:
    stored, rules = described(
        project / f"games/{name}.sj", project / "wide.txt" if with_map else None, num_agents=1
    )
    moved = project.rename(project.with_name("other"))
    found = locate_game(stored, rules, moved / place)
    assert found == {
        **stored,
        "game": str(moved / f"games/{name}.sj"),
        "map": str(moved / "wide.txt") if with_map else None,
    }


def test_a_copy_uses_its_own_game_when_the_first_has_changed(project: Path) -> None:
    stored, rules = described(project / "games/grove.sj")
    copy = shutil.copytree(project, project.with_name("copy"))
    assert locate_game(stored, rules, copy / "runs/one") == stored
    (project / "games/grove.sj").write_text(
        GROVE.replace("apple   : reward = 1", "apple   : reward = 2")
    )
    assert locate_game(stored, rules, copy / "runs/one")["game"] == str(copy / "games/grove.sj")
    assert locate_game(stored, rules, project / "runs/one") == stored  # whose rules have changed


def test_a_file_of_that_name_with_other_rules_is_not_taken(project: Path) -> None:
    stored, rules = described(project / "games/short.sj")
    (project / "runs/short.sj").write_text(GAME)
    moved = project.rename(project.with_name("other"))
    assert locate_game(stored, rules, moved / "runs/one")["game"] == str(moved / "games/short.sj")
    (moved / "games/short.sj").unlink()
    with pytest.raises(
        GameMoved,
        match=rf"there is no {stored['game']}, and no file of that name near it has the rules {rules}",
    ):
        locate_game(stored, rules, moved / "runs/one")


def a_run(folder: Path, stored: dict[str, Any], rules: str) -> None:
    manifest = {"provenance": stored, "game": {"hash": rules}, "config": {}, "versions": {}}
    (folder / "manifest.json").write_text(json.dumps(manifest))


@pytest.mark.parametrize(
    ("words", "remedy"),
    [
        (["evaluate", "project/runs/one"], "sjdsl evaluate project/runs/one --game GAME"),
        (
            ["evaluate", "project/runs/one", "--scenario", "all"],
            "sjdsl evaluate project/runs/one --game GAME",
        ),
        (["train", "--resume", "project/runs/one"], "sjdsl train GAME --resume project/runs/one"),
        (["replay", "project/episode.json"], "sjdsl replay project/episode.json --game GAME"),
    ],
)
def test_a_missing_game_is_named_with_the_remedy(
    words: list[str], remedy: str, project: Path, sjdsl: Sjdsl
) -> None:
    stored, rules = described(project / "games/short.sj")
    a_run(project / "runs/one", stored, rules)
    episode = {
        "format": "sjdsl-episode-1",
        "environment": stored,
        "hash": rules,
        "seed": 0,
        "actions": [[0, 0]],
        "returns": [0, 0],
    }
    (project / "episode.json").write_text(json.dumps(episode))
    (project / "games").rename(project / "rules")
    refused = sjdsl(*words)
    assert refused.status == 1
    assert f"there is no {stored['game']}" in refused.err
    assert remedy in refused.err
    other = sjdsl(*(word.replace("GAME", "orchard.sj") for word in remedy.split()[1:]))
    assert other.status == 1
    assert "orchard.sj has the rules" in other.err
    assert rules in other.err


@pytest.mark.thorough
def test_an_episode_is_replayed_with_the_game_that_is_named(project: Path, sjdsl: Sjdsl) -> None:
    stored, rules = described(project / "games/short.sj")
    episode = {
        "format": "sjdsl-episode-1",
        "environment": stored,
        "hash": rules,
        "seed": 0,
        "actions": [],
        "returns": [0, 0],
    }
    (project / "episode.json").write_text(json.dumps(episode))
    (project / "games").rename(project / "rules")
    shown = sjdsl("replay project/episode.json --game project/rules/short.sj")
    assert shown.status == 0, shown.err


def test_a_sweep_takes_its_game_by_another_path(project: Path) -> None:
    stored, rules = described(project / "games/short.sj")
    cell = {"game": "short", "hash": rules, "provenance": stored, "config": {}, "values": {}}
    before = {"format": 1, "episodes": 30, "loggers": [], "versions": {}, "cells": {"short": cell}}
    (project / "sweep.json").write_text(json.dumps(before))
    there = {**stored, "game": "/elsewhere/short.sj"}
    wanted = {**before, "cells": {"short": {**cell, "provenance": there}}}
    assert merge_sweep(project, wanted)["cells"]["short"]["provenance"] == there
