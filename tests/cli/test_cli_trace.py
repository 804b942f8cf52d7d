"""`sjdsl trace`: the text, the data, and mistakes in what is asked for."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import GAME, Sjdsl


def test_steps_in_the_order_of_the_schedule(sjdsl: Sjdsl) -> None:
    shown = sjdsl("trace", "orchard.sj", "--steps", "2", "--actions", "forward, stay; turn_left, stay")
    assert shown.status == 0
    lines = shown.out.splitlines()
    assert lines[0] == "A Small Orchard, seed 0"
    assert "A soil: ripe" in lines[1]
    heads = [line for line in lines if line.startswith(("an episode", "step"))]
    assert heads == ["an episode begins", "step 0", "step 1"]
    assert "  actions  0 forward, 1 stay" in lines
    written = GAME.splitlines()
    line = next(number for number, text in enumerate(written, 1) if "send agent to floor" in text)
    assert f"    orchard.sj:{line}  send agent to floor" in lines
    pictures = [line.split()[0] for line in lines if line.strip().startswith("#") and "." not in line]
    assert pictures.count("#####") == 6


def test_a_rule_names_its_draws(sjdsl: Sjdsl, folder: Path) -> None:
    (folder / "sure.sj").write_text((folder / "orchard.sj").read_text().replace("none: 0.1, ripe: 0", "none: 1, ripe: 0"))
    text = (folder / "sure.sj").read_text().replace("{ none, ripe } = ripe", "{ none, ripe } = none")
    (folder / "sure.sj").write_text(text)
    shown = sjdsl("trace", "sure.sj", "--steps", "1", "--phase", "grow", "--actions", "stay")
    line = next(number for number, line in enumerate(text.splitlines(), 1) if "chance growth" in line)
    assert f"    sure.sj:{line}  set soil.fruit = ripe\n      soil (1, 3)  fruit: none -> ripe\n" in shown.out
    (draw, *_) = [line for line in shown.out.splitlines() if "because chance growth[soil.fruit] drew 0." in line]
    assert draw.endswith(" < 1")
    assert shown.out.count("chance growth") == 3
    assert "move each agent" not in shown.out


def test_all_shows_what_changed_nothing(sjdsl: Sjdsl) -> None:
    plain = sjdsl("trace", "orchard.sj", "--steps", "1", "--actions", "stay", "--phase", "grow")
    assert "orchard.sj:" not in plain.out
    shown = sjdsl("trace", "orchard.sj", "--steps", "1", "--actions", "stay", "--phase", "grow", "--all")
    assert "set soil.fruit = ripe: did not happen" in shown.out


def test_json_has_the_same_changes(sjdsl: Sjdsl) -> None:
    shown = sjdsl("trace", "orchard.sj", "--steps", "3", "--json", "--all")
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


def test_actions_from_a_file(sjdsl: Sjdsl, folder: Path) -> None:
    (folder / "walk.txt").write_text("# two steps\nforward stay\n\nturn_left, stay  # and turn\n")
    shown = sjdsl("trace", "orchard.sj", "--actions", "walk.txt")
    assert [line for line in shown.out.splitlines() if "actions" in line] == [
        "  actions  0 forward, 1 stay",
        "  actions  0 turn_left, 1 stay",
    ]


def test_numbers_variants_and_agents(sjdsl: Sjdsl) -> None:
    arguments = ("--steps", "1", "--json", "--agents", "3", "--variant", "rich", "--param", "length=1")
    report = json.loads(sjdsl("trace", "orchard.sj", *arguments).out)
    assert len(report["steps"][1]["rewards"]) == 3
    assert report["steps"][1]["truncated"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("orchrd.sj", "orchard.sj"),
        ("orchard.sj --phase eet", "did you mean `eat`?"),
        ("orchard.sj --phase dance", "start, walk, eat, grow"),
        ("orchard.sj --actions forwrd,stay", "did you mean `forward`?"),
        ("orchard.sj --actions walk.txt", "no file `walk.txt`"),
        ("orchard.sj --actions forward,stay,stay", "step 1 has 3 actions; write one for each of the 2 agents, or one for all"),
        ("orchard.sj --actions stay;stay --steps 3", "written for 2 steps, not for 3"),
        ("orchard.sj --actions ;", "names no actions"),
        ("orchard.sj --param aple=2", "did you mean `apple`?"),
        ("orchard.sj --param apple=9", "outside 0 .. 5"),
        ("orchard.sj --agents 9", "1 .. 3"),
        ("orchard.sj --variant ritch", "rich"),
    ],
)
def test_mistakes(sjdsl: Sjdsl, arguments: str, said: str) -> None:
    shown = sjdsl("trace", *arguments.split())
    assert shown.status == 1
    assert said in shown.text
    assert "Traceback" not in shown.text


def test_tracing_needs_no_jax(folder: Path) -> None:
    program = "import sys; from sjdsl.cli import run; s = run(['trace', 'orchard.sj', '--param', 'apple=2']); sys.exit(s or int('jax' in sys.modules))"
    assert subprocess.run([sys.executable, "-c", program], cwd=folder, check=False, capture_output=True).returncode == 0


@pytest.mark.thorough
def test_agents_follow_a_policy_of_the_file(sjdsl: Sjdsl) -> None:
    """Cooperators of Clean Up walk to the dirt, which no random play does as fast."""
    followed = json.loads(sjdsl("trace", "clean_up", "--policy", "cooperator", "--steps", "40", "--json").out)
    drawn = json.loads(sjdsl("trace", "clean_up", "--steps", "40", "--json").out)
    cleaned = [sum("clean" in str(step) for step in trace["steps"]) for trace in (followed, drawn)]
    assert followed != drawn
    assert cleaned[0] > 0


def test_a_policy_is_one_of_the_file_and_stands_alone(sjdsl: Sjdsl) -> None:
    assert "no policy `cooperatr`" in sjdsl("trace", "clean_up", "--policy", "cooperatr").err
    assert "give only one of them" in sjdsl("trace", "clean_up", "--policy", "cooperator", "--actions", "stay").err
