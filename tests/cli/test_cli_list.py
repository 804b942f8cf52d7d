"""`sjdsl list`, `dump` and `explain`: what there is to know about games, stages and messages."""

from importlib import import_module
from os import terminal_size

import pytest
from command_line import Sjdsl

from sjdsl.cli.dump import STAGES
from sjdsl.library.games_folder import melting_pot_games


def test_games_are_listed(sjdsl: Sjdsl, monkeypatch: pytest.MonkeyPatch) -> None:
    """Some: all are built to be listed, which takes seconds."""
    games, further_games = ("coins", "gift_refinement", "mushrooms"), melting_pot_games()[:2]
    command = import_module("sjdsl.cli.list")
    monkeypatch.setattr(command, "main_games", lambda: games)
    monkeypatch.setattr(command, "melting_pot_games", lambda: further_games)
    shown = sjdsl("list")
    assert shown.status == 0
    own, further, rest = shown.out.split("\n\n")
    assert rest.startswith("`sjdsl doc GAME`")
    assert own.splitlines()[0].split() == ["game", "agents", "map", "actions", "title"]
    assert further.splitlines()[0] == "further games of Melting Pot"
    rows = [own.splitlines()[1:], further.splitlines()[2:]]
    assert [[row.split()[0] for row in group] for group in rows] == [list(games), further_games]
    coins, _, mushrooms = rows[0]
    title = own.splitlines()[0].index("title")
    assert coins[title:] == "Coins; variants socialjax, meltingpot"
    assert mushrooms[title:].startswith("Externality Mushrooms; variants ")


def test_lines_end_at_the_width_of_a_terminal(
    sjdsl: Sjdsl, monkeypatch: pytest.MonkeyPatch
) -> None:
    command = import_module("sjdsl.cli.list")
    monkeypatch.setattr(command, "main_games", lambda: ["coins"])
    monkeypatch.setattr(command, "melting_pot_games", lambda: [])
    whole = sjdsl("list").out.splitlines()[1]
    monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
    monkeypatch.setattr(command.shutil, "get_terminal_size", lambda: terminal_size((50, 24)))
    assert sjdsl("list").out.splitlines()[1] == f"{whole[:49]}…"


@pytest.mark.parametrize("stage", STAGES)
def test_every_stage_can_be_dumped(sjdsl: Sjdsl, stage: str) -> None:
    first, second = (
        sjdsl("dump orchard.sj --after", stage),
        sjdsl("dump orchard.sj --after", stage),
    )
    assert first.status == 0
    assert first.out == second.out
    assert "orchard" in first.out
