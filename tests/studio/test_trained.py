"""Trained policies drive agents: those of this folder and of this game; what they do is what they do in `sjdsl play`."""

import json
import shutil
from itertools import repeat
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from starlette.testclient import TestClient

import sjdsl
from sjdsl.cli.play import compiled
from sjdsl.studio.access import Access
from sjdsl.studio.bench import Bench
from sjdsl.studio.requests import READ
from sjdsl.studio.runs import policy_file, stored_policies
from sjdsl.studio.server import make_app
from sjdsl.trainers import load_policy
from tests.experiments.stored_policies import store
from tests.studio.test_workbench import GAME

RUN = "runs/first"


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns a folder with the game and two runs: one whose networks remember, one of another game."""
    folder = tmp_path_factory.mktemp("home").resolve()
    (folder / "yard.sj").write_text(GAME, encoding="utf-8")
    env = sjdsl.make(folder / "yard.sj")
    store(folder / RUN, env, 3, memory="gru")
    for suffix in (".safetensors", ".json"):
        shutil.copy(folder / RUN / f"policies/last{suffix}", folder / RUN / f"policies/00000007{suffix}")
        shutil.copy(folder / RUN / f"policies/last{suffix}", folder / f"alone{suffix}")
    store(folder / "runs/elsewhere", env, 3, {"name": "orchard"})
    return folder


@pytest.fixture(scope="module")
def bench(home: Path) -> Bench:
    """Returns a bench that has loaded the policy."""
    made = Bench(home)
    opened(made)
    assert ask(made, do="others", policy=RUN)["others"] == RUN
    return made


def ask(bench: Bench, **request: Any) -> dict[str, Any]:
    return json.loads(json.dumps(bench.answer(READ.validate_json(json.dumps({"id": 7, **request})))))


def opened(bench: Bench, text: str = GAME) -> dict[str, Any]:
    answer = ask(bench, do="text", version=1, path="yard.sj", text=text)
    assert answer["compiles"], answer
    return answer


def test_what_it_does_is_what_it_does_in_play(home: Path, bench: Bench) -> None:
    opened(bench)
    ask(bench, do="begin", seed=5)
    mine = [ask(bench, do="step")["scene"] for _ in range(6)]
    env = sjdsl.make(home / "yard.sj")
    _, *theirs = compiled(env, load_policy(home / RUN, env), 5, repeat({}, 6))
    for scene, played in zip(mine, theirs, strict=True):
        places = np.stack([played.snapshot.row, played.snapshot.col], axis=1).tolist()
        assert scene == scene | {"actions": list(played.actions), "places": places}


def test_it_remembers_what_can_be_gone_back_to(bench: Bench) -> None:
    """From any moment it goes on as it did the first time: what it remembers is of the moments before that one, not of those undone."""
    opened(bench)
    ask(bench, do="begin", seed=2)
    first = [ask(bench, do="step")["scene"]["actions"] for _ in range(6)]
    for back in (4, 1, 5):
        ask(bench, do="go", to=back)
        again = [ask(bench, do="step")["scene"]["actions"] for _ in range(back, 6)]
        assert again == first[back:]
    fresh = Bench(bench.folder)
    opened(fresh)
    ask(fresh, do="begin", seed=2)
    for actions in first[:4]:
        ask(fresh, do="step", actions={str(agent): action for agent, action in enumerate(actions)})
    ask(fresh, do="others", policy=RUN)
    assert [ask(fresh, do="step")["scene"]["actions"] for _ in range(2)] == first[4:], "chosen late, it has seen what went before"
    assert len(bench._trained._known) == 6


def test_somebody_drives_beside_it(bench: Bench) -> None:
    opened(bench)
    ask(bench, do="begin", seed=2)
    alone = ask(bench, do="step")["scene"]["actions"]
    ask(bench, do="go", to=0)
    other = (alone[0] + 1) % 4
    assert ask(bench, do="step", actions={"0": other})["scene"]["actions"] == [other, alone[1]]


def test_it_stays_through_edits_that_it_need_not_notice(bench: Bench) -> None:
    opened(bench)
    loaded = bench._trained
    assert opened(bench, GAME.replace("add 1 to agent.bag", "add 2 to agent.bag"))["game"]["others"] == RUN
    ask(bench, do="step")
    assert bench._trained is loaded, "nothing is compiled anew"
    wider = GAME.replace("window ahead 1, behind 1", "window ahead 2, behind 2")
    opened(bench, wider)
    assert "doesn't fit yard" in ask(bench, do="step")["refused"]
    opened(bench)
    assert "refused" not in ask(bench, do="step")
    assert opened(bench, GAME.replace("game yard", "game garden"))["game"]["others"] == "random", "this is another game"
    opened(bench)
    ask(bench, do="others", policy=RUN)


def test_those_of_another_game_are_refused_by_name(bench: Bench) -> None:
    opened(bench)
    reason = ask(bench, do="others", policy="runs/elsewhere")["refused"]
    assert "`runs/elsewhere` was trained on the game `orchard`, and this is `yard`" in reason
    assert opened(bench)["game"]["others"] == RUN, "who drove before goes on"


def test_the_list_has_what_can_be_chosen(home: Path) -> None:
    client = TestClient(make_app(home, Access(8123, "secret")), headers={"host": "127.0.0.1:8123"})
    listed = client.get("/policies?token=secret").json()["policies"]
    assert listed == [["alone.safetensors", "yard"], ["runs/elsewhere", "orchard"], [RUN, "yard"], [RUN + "@7", "yard"]]
    assert client.get("/policies").status_code == 403
    assert policy_file(home, "alone.safetensors", "yard") == home / "alone.safetensors"
    assert policy_file(home, RUN + "@7", "yard") == home / RUN / "policies" / "00000007.safetensors"


@pytest.fixture
def hostile(home: Path, tmp_path: Path) -> Path:
    """Returns a folder in which links, and descriptions of runs, lead outside or name Python code."""
    inside = tmp_path / "inside"
    for name in ("code", "partner", "partner_code"):
        shutil.copytree(home / RUN, inside / name)
    (tmp_path / "outside").mkdir()
    shutil.copytree(home / RUN, tmp_path / "outside" / "run")
    (inside / "linked").symlink_to(tmp_path / "outside" / "run")
    (tmp_path / "steal.py").write_text(f"open({str(tmp_path / 'stolen')!r}, 'w')\ndef act(key, seen): return seen\n", encoding="utf-8")
    changes = {
        "code": {"network": f"{tmp_path}/steal.py:act"},
        "partner": {"partners": [[0, str(tmp_path / "outside" / "run")]]},
        "partner_code": {"partners": [[0, f"{tmp_path}/steal.py:act"]]},
    }
    for name, change in changes.items():
        path = inside / name / "policies" / "last.json"
        described = json.loads(path.read_text(encoding="utf-8"))
        path.write_text(json.dumps(described | {"config": described["config"] | change}), encoding="utf-8")
    return inside.resolve()


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("../outside/run", "outside the folder"),
        ("linked", "outside the folder"),
        ("linked@last", "outside the folder"),
        ("/etc/passwd", "outside the folder"),
        ("code@../../../outside/run/policies/last", "outside the folder"),
        ("partner", "outside the folder"),
        ("code", "Python code of your own"),
        ("partner_code", "Python code of your own"),
        ("steal.py:act", "no policy `steal.py:act`"),
        ("code@best", "no policy `code@best`"),
        ("\0", "no p"),
        ("x" * 900, "no policy"),
    ],
)
def test_a_hostile_name_or_file_gets_nothing(hostile: Path, name: str, reason: str) -> None:
    made = Bench(hostile)
    opened(made)
    assert reason in ask(made, do="others", policy=name)["refused"]
    assert not (hostile.parent / "stolen").exists()
    assert ask(made, do="step")["at"] == 1
    assert "linked" not in [stored.name for stored in stored_policies(hostile)]
