"""Commands with language models, on a server of this machine, with a key that stays secret."""

import io
import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from command_line import Sjdsl
from luna import KEY, MATRIX, SCHELLING, VISITORS, by_role, write_models

from sjdsl.replay import Dataset, load_recording
from tests.models.server import Server


def test_a_schelling_diagram_of_models(folder: Path, sjdsl: Sjdsl, server: Server) -> None:
    """Its payoffs are those of the matrix; the key is in no file and on no screen."""
    shown = sjdsl(*SCHELLING)
    assert shown.status == 0, shown.text
    assert "verdict: dilemma, fear and greed" in shown.text
    assert "models.toml:luna+cooperator" in shown.text
    assert "luna+defector: 24 calls" in shown.text
    report = json.loads((folder / "out/schelling.json").read_text())
    assert report["C"]["mean"] == [0, 12]
    assert report["D"]["mean"] == [4, 20]
    # 48 calls of 100 tokens, 60 of them cached, and 10 answered.
    dollars = sum(used["dollars"] for used in report["models"].values())
    assert dollars == pytest.approx(48 * (40 * 1 + 60 * 0.1 + 10 * 10) / 10**6)
    for path in (folder / "out").rglob("*"):
        assert not path.is_file() or KEY not in path.read_text(errors="replace")
    assert KEY not in shown.text
    assert set(server.keys) == {KEY}
    asked = len(server.requests)
    assert sjdsl(*SCHELLING).status == 0
    assert len(server.requests) == asked  # all is recorded
    status = sjdsl(*SCHELLING, "--status").out
    assert "out: 48 calls, of at most 48\n" in status
    assert "  luna+defector, trial 0: 24 calls, 0 of them" in status
    # Cooperators earn (0 + 12 + 12) / 3 on average, with each wording of their role.
    earned = [figure["mean"] for figure in report["wordings"]["models.toml:luna+cooperator"]]
    assert earned == [pytest.approx(6)] * 2
    assert len(server.requests) == asked


@pytest.mark.usefixtures("server")
def test_episodes_of_an_experiment_are_replayed(folder: Path, sjdsl: Sjdsl) -> None:
    """With the draws of `random` beside a model, and the reasons and messages of the model."""
    slots = ("--slots", "models.toml:luna+defector,random")
    assert sjdsl("crossplay", str(MATRIX), *slots, "--episodes", "3", "-o", "out").status == 0
    (header, *rows) = (folder / "out/crossplay.csv").read_text().splitlines()
    titles = header.split(",")
    table = [dict(zip(titles, row.split(",")[-len(titles) :], strict=True)) for row in rows]
    assert [row["server_model"] for row in table] == ["luna-2026", ""] * 3
    assert [row["wording"] for row in table] == ["0", "", "1", "", "0", ""]
    assert {row["calls"] for row in table} == {"4", ""}
    replay = ("replay", "out", "--game", str(MATRIX))
    for episode in range(3):  # a replay is refused if its returns aren't those of the episode
        shown = sjdsl(*replay, "--episode", str(episode))
        assert "0 models.toml:luna+defector: my part" in shown.out, shown.text
    film = sjdsl(*replay, "-o", "film.html")
    assert film.status == 0, film.text
    assert '"why":["my part",""]' in (folder / "film.html").read_text()
    told = sjdsl(*replay, "--episode", "1", "--messages").out
    assert told.count("---- to agent 0 before step ") == 4
    assert "What counts for you is your own part of the rewards" in told  # the second wording
    assert told.count("YOUR LAST REWARD") == 3
    assert "has 3 finished ones" in sjdsl(*replay, "--episode", "3").text
    silent = sjdsl(*replay, "--messages", "--agent", "1")
    assert "no model played agent 1; models played 0" in silent.err


def test_an_odd_answer_does_not_stop_an_experiment(
    folder: Path, sjdsl: Sjdsl, server: Server
) -> None:
    """The first is none, so that no model is named; the third counts no tokens."""
    command = ("crossplay", str(MATRIX), "--slots", "models.toml:luna,stay", "--episodes", "1")
    server.faults = ["empty", "ok", {"usage": None}]
    assert sjdsl(*command, "-o", "odd").status == 0
    assert sjdsl(*command, "-o", "even").status == 0
    (odd,), (even,) = (
        json.loads((folder / name / "talks/usage.json").read_text()) for name in ("odd", "even")
    )
    assert (odd["calls"], odd["invalid"], even["invalid"]) == (4, 1, 0)
    assert odd["dollars"] > 2 * even["dollars"], "two calls count as the most they may have cost"


def test_a_folder_in_which_nobody_answered_may_begin_anew(
    folder: Path, sjdsl: Sjdsl, server: Server
) -> None:
    command = ("crossplay", str(MATRIX), "--slots", "models.toml:luna,stay", "--episodes", "1")
    server.faults = [400]
    assert sjdsl(*command, "-o", "out").status == 1
    models = folder / "models.toml"
    models.write_text(models.read_text() + "max_tokens = 77\n")
    assert sjdsl(*command, "-o", "out").status == 0
    models.write_text(models.read_text().replace("77", "78"))
    assert "holds another experiment" in sjdsl(*command, "-o", "out").err
    unpriced = "\n".join(line for line in models.read_text().splitlines() if "price" not in line)
    models.write_text(unpriced)
    dry = sjdsl(*command, "-o", "dry", "--budget", "1", "--dry-run")
    assert (dry.status, (folder / "dry").exists()) == (1, False)
    assert "--budget needs the `price` of luna" in dry.err


def test_scenarios_by_the_wording_of_a_role(folder: Path, sjdsl: Sjdsl, server: Server) -> None:
    """Focal agents keep in the first wording and give in the second: alone each then earns 2."""
    by_wording = {"You care about your own reward only": "keep", "your own part": "stay"}

    def reply(body: dict[str, Any]) -> str:
        system = body["messages"][0]["content"]
        (action,) = [action for words, action in by_wording.items() if words in system]
        return json.dumps({"why": "", "goal": "", "note": {"op": "none"}, "action": action})

    server.reply = reply
    focal = ("evaluate", "models.toml:luna+defector", "--game", str(VISITORS))
    shown = sjdsl(*focal, "--scenario", "alone,visitor", "--episodes", "3", "-o", "out")
    assert shown.status == 0, shown.text
    earned = "luna+defector in alone: return of an agent by wording of its role: 0, 2\n"
    assert earned in shown.out
    assert "in visitor: return of an agent by wording of its role: 0, -0.6667\n" in shown.out
    stored = json.loads((folder / "out/scenarios.json").read_text())["scenarios"]
    assert [figure["mean"] for figure in stored["alone"]["wordings"]] == [0, 2]
    assert stored["alone"]["wordings"][0] == {"mean": 0, "low": 0, "high": 0}
    assert [figure["mean"] for figure in stored["visitor"]["wordings"]] == [
        0,
        pytest.approx(-2 / 3),
    ]
    one = sjdsl(*focal, "--scenario", "alone", "--episodes", "1", "-o", "one")
    assert "by wording of its role: 0\n" in one.out, "the second wording isn't played"


@pytest.mark.parametrize(
    ("command", "results", "model", "most"),
    [
        # two slots of two move on, and one is asked, in each of four steps
        (
            ("crossplay", MATRIX, "--slots", "models.toml:luna+defector,random", "--rotate"),
            "out",
            "luna+defector",
            2 * 4,
        ),
        # three focal agents, and one, in each of two steps
        (
            ("evaluate", "models.toml:luna", "--game", VISITORS, "--scenario", "alone,visitor"),
            "out/scenarios",
            "luna",
            2 * 2 * (3 + 1),
        ),
    ],
)
def test_how_far_it_is(
    sjdsl: Sjdsl,
    server: Server,
    command: tuple[str | Path, ...],
    results: str,
    model: str,
    most: int,
) -> None:
    """Before it has begun, where it stopped, and at its end; and of no other experiment."""
    command = (*command, "--episodes", "2", "-o", "out")
    server.reply = lambda _: json.dumps({"why": "", "goal": "", "action": "stay"})
    assert sjdsl(*command, "--status").out == f"{results}: 0 calls, of at most {most}\n"
    assert sjdsl(*command, "--calls", "5").status == 3
    stopped = sjdsl(*command, "--status").out.splitlines()
    assert stopped[0] == f"{results}: 5 calls, of at most {most}"
    (line,) = stopped[1:]
    assert line.startswith(f"  {model}, trial 0: 5 calls, 0 of them with replies that could not")
    assert "500 tokens in (300 cached), 50 out, $0.0007" in line
    assert len(server.requests) == 5
    assert sjdsl(*command).status == 0
    assert sjdsl(*command, "--status").out.startswith(f"{results}: {most} calls, of at most {most}")
    assert len(server.requests) == most
    other = sjdsl(*command, "--seed", "1", "--status")
    assert (other.status, "holds another experiment: seed 0 there, 1 here" in other.err) == (
        1,
        True,
    )


def test_a_dry_run_asks_nobody(folder: Path, sjdsl: Sjdsl, server: Server) -> None:
    shown = sjdsl(*SCHELLING, "--dry-run")
    assert shown.status == 0
    assert "models.toml:luna+cooperator: at most 24 calls of about " in shown.out
    assert server.requests == []
    assert not (folder / "out").exists()
    refused = sjdsl("crossplay", str(MATRIX), "--slots", "stay,stay", "--dry-run")
    assert "--dry-run and --status are for language models, and none plays" in refused.text
    refused = sjdsl("evaluate stay --status --game", str(MATRIX))
    assert "--dry-run and --status are for --scenario" in refused.text


def test_it_stops_and_goes_on(sjdsl: Sjdsl, server: Server) -> None:
    stopped = sjdsl(*SCHELLING, "--calls", "7")
    assert stopped.status == 3
    assert "the same command with a larger --calls goes on" in stopped.text
    assert len(server.requests) == 7
    server.faults = [401]
    refused = sjdsl(*SCHELLING)
    assert refused.status == 1
    assert "m at http://127.0.0.1" in refused.text
    assert "refuses the request with 401" in refused.text
    assert KEY not in refused.text
    assert len(server.requests) == 8
    assert sjdsl(*SCHELLING).status == 0
    assert len(server.requests) == 49


@pytest.mark.thorough
def test_it_survives_being_killed(folder: Path, server: Server) -> None:
    """kill -9 at any time; then it goes on, and ends as if it had never been killed."""
    server.reply = lambda body: time.sleep(0.05) or by_role(body)
    command = [sys.executable, "-m", "sjdsl", *SCHELLING, "--parallel", "2"]
    kills = 0
    while kills < 20:
        asked = len(server.requests)
        process = subprocess.Popen(command, cwd=folder, stderr=subprocess.PIPE)
        while process.poll() is None and len(server.requests) < asked + 2:
            time.sleep(0.01)
        if process.poll() is not None:
            break
        process.kill()
        process.wait()
        kills += 1
    subprocess.run(command, cwd=folder, check=True)
    assert kills > 10
    report = json.loads((folder / "out/schelling.json").read_text())
    assert report["C"]["mean"] == [0, 12]
    assert sum(used["calls"] for used in report["models"].values()) == 48


def test_wrong_names_are_refused_at_once(sjdsl: Sjdsl, server: Server) -> None:
    for name, problem in (
        ("models.toml:lune", "models.toml has no model `lune`; did you mean `luna`?"),
        ("absent.toml:luna", "absent.toml can't be read: No such file"),
        ("models.toml:luna+saint", "there is no role `saint`"),
    ):
        assert problem in sjdsl("crossplay", str(MATRIX), "--slots", f"{name},stay").text
        assert problem in sjdsl("record", str(MATRIX), "--policy", name).text
    evaluated = sjdsl("evaluate models.toml:luna --game", str(MATRIX))
    assert "is asked in words, outside of compiled code" in evaluated.text
    trained = sjdsl("train", str(MATRIX), "--set", "partners=1=models.toml:luna")
    assert "neither as a partner in training" in trained.text
    assert server.requests == []


def test_a_person_plays_among_models(
    folder: Path, sjdsl: Sjdsl, server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The person's agent isn't asked; who sat where is recorded, and the episode can be replayed."""
    monkeypatch.setattr("sys.stdin", io.StringIO("betray\n" * 4))
    slots = ("--slots", "models.toml:luna+cooperator,you")
    shown = sjdsl("play", str(MATRIX), *slots, "--record", "played.json")
    assert shown.status == 0, shown.text
    assert "you play agent 1" in shown.out
    assert "0 models.toml:luna+cooperator" in shown.out
    assert "1 you" in shown.out
    assert len(server.requests) == 4
    recording = load_recording(folder / "played.json", 0)
    assert recording.returns == [0, 20]
    assert recording.players == ["models.toml:luna+cooperator", "you"]
    assert recording.why == [["my part", ""]] * 4
    assert "my part" not in shown.out, "the person doesn't read the thoughts of others"
    replayed = sjdsl("replay played.json")
    assert replayed.status == 0
    assert replayed.out.count("  0 models.toml:luna+cooperator: my part\n") == 4

    monkeypatch.setattr("sys.stdin", io.StringIO("stay\n"))
    shown = sjdsl("play", str(MATRIX), "--others", "models.toml:luna+defector", "--steps", "1")
    assert shown.status == 0, shown.text
    assert len(server.requests) == 5
    assert "1 models.toml:luna+defector" in shown.out
    (folder / "own.py").write_text(
        "from sjdsl.models import HostPolicy, Reply\n"
        "class Betrays(HostPolicy):\n"
        "    def decide(self, agent, message):\n"
        "        return Reply('betray', why=f'as {agent}')\n"
        "betrays = Betrays()\n"
    )
    monkeypatch.setattr("sys.stdin", io.StringIO("stay\n"))
    others = ("--others", "own.py:betrays", "--record", "own.json")
    assert sjdsl("play", str(MATRIX), *others).status == 0
    recording = load_recording(folder / "own.json", 0)
    assert (recording.actions, recording.why) == ([[0, 1]], [["", "as 1"]])
    assert recording.players == ["you", "own.py:betrays"]
    for slots_text, problem in (
        ("you", "has 2 agents, but --slots names 1"),
        ("you,you", "`you` can play one agent"),
    ):
        assert problem in sjdsl("play", str(MATRIX), "--slots", slots_text).text
    monkeypatch.setattr("sys.stdin", io.StringIO("stay\n" * 4))
    limited = ("--others", "models.toml:luna+defector", "--calls", "2", "--record", "cut.json")
    stopped = sjdsl("play", str(MATRIX), *limited)
    assert (stopped.status, len(server.requests)) == (3, 7)
    assert "2 calls were made, and at most 2 may be; choose a larger --calls" in stopped.err
    assert len(load_recording(folder / "cut.json", 0).actions) == 2
    refused = sjdsl("play", str(MATRIX), "--others", "stay", "--budget", "2")
    assert "--calls are for language models, and none plays" in refused.err
    refused = sjdsl("play", str(MATRIX), "--slots", "you,stay", "--agent", "0")
    assert "without --agent and --others" in refused.text


def test_models_are_recorded_and_drawn(folder: Path, sjdsl: Sjdsl, server: Server) -> None:
    names = ("--policy", "models.toml:luna+defector")
    record = ("record", str(MATRIX), *names, "--episodes", "3", "-o", "played.npz")
    stopped = sjdsl(*record, "--calls", "10")
    assert stopped.status == 3
    assert not (folder / "played.npz").exists()
    assert sjdsl(*record).status == 0
    assert len(server.requests) == 24
    recording = load_recording(folder / "played.npz", 2)
    assert recording.actions == [[1, 1]] * 4
    assert recording.why == [["my part"] * 2] * 4
    assert Dataset(folder / "played.npz")[1].why.shape == (4, 2)
    told = sjdsl("replay played.npz --messages --agent 1").out
    assert told.count("---- to agent 1 before step ") == 4 == told.count("---- to agent ")
    assert sjdsl("replay played.npz --episode 1").status == 0
    (folder / "own.py").write_text(
        "from sjdsl.models import HostPolicy, Reply\n"
        "class Betrays(HostPolicy):\n"
        "    def decide(self, agent, message):\n"
        "        return Reply('betray', why='so\\nerror: forged\\x1b[2J')\n"
        "betrays = Betrays()\n"
    )
    own = sjdsl("record", str(MATRIX), "--policy", "own.py:betrays", "-o", "own.npz")
    assert own.status == 0, own.text
    assert "0 own.py:betrays: so\\nerror: forged\\x1b[2J\n" in sjdsl("replay own.npz").out
    drawn = sjdsl("render", str(MATRIX), *names, "--steps", "3", "-o", "film.html")
    assert drawn.status == 0, drawn.text
    assert len(server.requests) == 30
    # Six steps are an episode and half of the next one.
    shared = ("render", str(MATRIX), *names, "--steps", "6", "-o", "played.html")
    assert sjdsl(*shared).status == 0
    assert sjdsl("render", str(MATRIX), *names, "--steps", "3", "-o", "film.gif").status == 0
    assert len(server.requests) == 30, "they are the recorded episodes, and those of the film"
    stopped = sjdsl("render", str(MATRIX), *names, "-o", "other.html", "--calls", "3")
    assert (stopped.status, (folder / "other.html").exists()) == (3, False)
    assert len(server.requests) == 33
    write_models(folder, server.url, model="m2")
    other = sjdsl(*shared)
    assert "played_models holds another experiment: its policies differ" in other.err
    assert len(server.requests) == 33
    refused = sjdsl("render", str(MATRIX), "--policy", "stay", "--calls", "3")
    assert "--calls are for language models, and none plays" in refused.err
