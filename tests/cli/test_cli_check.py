"""`sjdsl check`: all problems of a game and its variants, each once."""

import json
from pathlib import Path

import pytest
from command_line import GAME, Sjdsl

WRONG = GAME.replace("send agent to floor", "send agent to flor").replace("each agent on soil", "each agnt on soil")
WRONG_VARIANT = GAME.replace("set apple = 2", "set aple = 2")
UNUSED = GAME.replace("  episode length", "  param idle : reward = 1\n  episode length")


def test_a_game_without_problems(sjdsl: Sjdsl) -> None:
    shown = sjdsl("check", "orchard.sj")
    assert shown.status == 0
    assert "no problems" in shown.out
    assert "rich" in shown.out


def test_all_errors_are_shown_with_their_lines(sjdsl: Sjdsl, folder: Path) -> None:
    (folder / "wrong.sj").write_text(WRONG)
    shown = sjdsl("check", "wrong.sj")
    assert shown.status == 1
    assert "did you mean `floor`?" in shown.out
    assert "agnt" in shown.out
    assert "2 errors" in shown.out


def test_a_problem_is_shown_once_for_all_variants(sjdsl: Sjdsl, folder: Path) -> None:
    (folder / "unused.sj").write_text(UNUSED)
    shown = sjdsl("check", "unused.sj")
    assert shown.out.count("`idle`") == 1
    assert shown.status == 0, "a warning is no error"


def test_a_problem_of_a_variant_names_it(sjdsl: Sjdsl, folder: Path) -> None:
    (folder / "wrong.sj").write_text(WRONG_VARIANT)
    shown = sjdsl("check", "wrong.sj")
    assert shown.status == 1
    assert "in variant `rich`" in shown.out
    assert "did you mean `apple`?" in shown.out
    assert sjdsl("check", "wrong.sj", "--variant", "rich").status == 1


def test_one_bad_file_does_not_hide_the_next(sjdsl: Sjdsl, folder: Path) -> None:
    (folder / "wrong.sj").write_text(WRONG)
    shown = sjdsl("check", "wrong.sj", "orchard.sj", "coins")
    assert shown.status == 1
    assert "orchard.sj: no problems" in shown.out
    assert "coins: no problems" in shown.out


def test_json_says_the_same(sjdsl: Sjdsl, folder: Path) -> None:
    (folder / "wrong.sj").write_text(WRONG)
    shown = sjdsl("check", "wrong.sj", "--json")
    assert shown.status == 1
    found = json.loads(shown.out)
    assert len(found) == 2
    assert {"code", "severity", "message", "file", "line", "column"} <= set(found[0])
    assert json.loads(sjdsl("check", "orchard.sj", "--json").out) == []


@pytest.mark.parametrize("game", ["coins", "clean_up"])
def test_bundled_games_have_no_errors(sjdsl: Sjdsl, game: str) -> None:
    assert sjdsl("check", game).status == 0


def test_warnings_count_where_they_are_asked_to(sjdsl: Sjdsl, folder: Path) -> None:
    (folder / "unused.sj").write_text(UNUSED)
    assert sjdsl("check", "unused.sj", "--strict").status == 1
    assert sjdsl("check", "orchard.sj", "--strict").status == 0
    assert sjdsl("compile", "unused.sj").status == 0


def test_a_run_ends_once_with_where_more_is_said(sjdsl: Sjdsl, folder: Path) -> None:
    (folder / "wrong.sj").write_text(WRONG_VARIANT)
    (folder / "unused.sj").write_text(UNUSED)
    shown = sjdsl("check", "unused.sj", "wrong.sj")
    assert shown.out.splitlines()[-1] == "`sjdsl explain SJ505` says more about the first message."
    assert shown.out.count("sjdsl explain") == 1
    refused = sjdsl("compile", "wrong.sj", "--variant", "rich")
    assert refused.err.splitlines()[-1] == "`sjdsl explain SJ108` says more about this message."
    assert "explain" not in sjdsl("check", "wrong.sj", "--json").out
    assert "explain" not in sjdsl("check", "orchard.sj").out


def test_actions_and_events_without_use_are_warned_of(sjdsl: Sjdsl, folder: Path) -> None:
    (folder / "idle.sj").write_text(GAME.replace("forward, stay", "forward, stay, dance").replace("event eaten", "event eaten  event lost"))
    shown = sjdsl("check", "idle.sj")
    assert shown.status == 0
    assert "no rule looks at the action `dance`" in shown.out
    assert "the event `lost` is listed in `metrics`, but no rule counts it" in shown.out
    assert "2 warnings" in shown.out
