"""`sjdsl list`, `dump` and `explain`: what there is to know about games, stages and messages."""

import json
from pathlib import Path

import pytest
from command_line import Sjdsl

from sjdsl.cli.dump import STAGES
from sjdsl.library.games_folder import main_games, melting_pot_games
from sjdsl.version import __version__

POLICIES = Path(__file__).parents[1] / "cases" / "policies.sj"


def test_all_games_are_listed(sjdsl: Sjdsl, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sjdsl.cli.describe.agent_range", lambda *_: pytest.fail("what the table does not show is not worked out"))
    shown = sjdsl("list")
    assert shown.status == 0
    _, own, further, rest = shown.out.split("\n\n")
    assert rest.startswith("`sjdsl list GAME`")
    assert own.splitlines()[0] == f"of sjdsl {__version__}"
    assert further.splitlines()[0] == f"of sjdsl {__version__}, further families of Melting Pot"
    rows = [[line.split()[0] for line in group.splitlines()[1:] if line[0] != " "] for group in (own, further)]
    assert rows == [main_games(), melting_pot_games()]
    assert "\n    variants socialjax, meltingpot, crowd\n" in own
    assert max(map(len, shown.out.splitlines())) <= 80


def test_a_game_as_json(sjdsl: Sjdsl) -> None:
    (game,) = json.loads(sjdsl("list", "orchard.sj", "--json").out)
    assert game["title"] == "A Small Orchard"
    assert game["agents"] == 2
    assert game["map"] == {"rows": 4, "columns": 5}
    assert game["actions"] == ["turn_left", "turn_right", "forward", "stay"]
    assert game["variants"] == [{"name": "rich", "title": "apples are worth more"}]
    params = {p["name"]: p for p in game["params"]}
    assert params["apple"] == {"name": "apple", "unit": "reward", "default": 1.0, "low": 0, "high": 5}
    assert params["growth"]["default"] == {"none": 0.1, "ripe": 0.0}
    assert game["sizes"] == [{"name": "players", "unit": "count", "default": 2, "low": 1, "high": 3}]
    assert [(m["name"], m["sort"]) for m in game["metrics"]] == [("eaten", "event"), ("left", "mean")]
    assert {"name": "soil", "fields": {"fruit": ["none", "ripe"]}} in game["kinds"]


def test_a_game_for_a_reader(sjdsl: Sjdsl) -> None:
    shown = sjdsl("list", "orchard.sj").out
    for part in ("4 x 5", "apple", "0 .. 5", "none: 0.1", "rich", "event eaten", "written for a test"):
        assert part in shown


def test_policies_and_scenarios_are_listed(sjdsl: Sjdsl) -> None:
    shown = sjdsl("list", str(POLICIES)).out.splitlines()
    assert "    gatherer  eats, and rests with a full bag" in shown
    assert "    alone  1 focal, 2 bully               one among bullies" in shown
    (game,) = json.loads(sjdsl("list", str(POLICIES), "--json").out)
    assert [policy["name"] for policy in game["policies"]] == ["gatherer", "bully"]
    assert game["scenarios"][0]["slots"] == [{"number": 1, "policy": None}, {"number": 2, "policy": "bully"}]


@pytest.mark.parametrize("stage", STAGES)
def test_every_stage_can_be_dumped(sjdsl: Sjdsl, stage: str) -> None:
    first, second = sjdsl("dump", "orchard.sj", "--after", stage), sjdsl("dump", "orchard.sj", "--after", stage)
    assert first.status == 0
    assert first.out == second.out
    assert "orchard" in first.out


def test_codes_are_explained(sjdsl: Sjdsl) -> None:
    assert "SJ101" in sjdsl("explain", "SJ101").out
    unknown = sjdsl("explain", "SJ9999")
    assert unknown.status == 1
    assert unknown.err.startswith("error:")
