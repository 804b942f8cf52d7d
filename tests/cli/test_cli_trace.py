"""`sjdsl trace`: the text, the data, and mistakes in what is asked for."""

import json

import pytest
from command_line import Sjdsl


def test_json_has_the_same_changes(sjdsl: Sjdsl) -> None:
    shown = sjdsl("trace", "orchard.sj", "--steps", "3", "--json")
    report = json.loads(shown.out)
    assert [moment["step"] for moment in report["steps"]] == [None, 0, 1, 2]
    start = report["steps"][0]["turns"][0]
    assert start["turn"] == "start"
    places = [effect for effect in start["effects"] if effect["sort"] == "place"]
    assert [effect["agent"] for effect in places] == [0, 1]
    assert places[0]["by"][0]["text"] == "send agent to floor"
    assert all(effect["old"] is None and len(effect["new"]) == 2 for effect in places)
    assert [turn["turn"] for turn in report["steps"][1]["turns"]] == ["walk", "eat", "grow"]
    assert len(report["steps"][1]["rewards"]) == 2


@pytest.mark.thorough
def test_agents_follow_a_policy_of_the_file(sjdsl: Sjdsl) -> None:
    """Cooperators of Clean Up walk to the dirt, which no random play does as fast."""
    followed = json.loads(sjdsl("trace", "clean_up", "--policy", "cooperator", "--steps", "40", "--json").out)
    drawn = json.loads(sjdsl("trace", "clean_up", "--steps", "40", "--json").out)
    cleaned = [sum("clean" in str(step) for step in trace["steps"]) for trace in (followed, drawn)]
    assert followed != drawn
    assert cleaned[0] > 0
