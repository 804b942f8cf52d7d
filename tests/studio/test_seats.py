"""A person takes a seat among trained, scripted and other agents: they act as in the terminal, and who sat where is recorded."""

import asyncio
import io
import json
from pathlib import Path
from typing import Any

import pytest

import sjdsl
from sjdsl.cli import run
from sjdsl.studio.bench import Bench
from sjdsl.studio.child import Child
from sjdsl.studio.seats import Seats
from sjdsl.studio.server import FirstGame
from tests.experiments.stored_policies import store
from tests.studio.test_workbench import GAME, ask, opened

SLOTS = ("you", "runs/a", "idler", "random", "models.toml:luna")
FIVE = GAME.replace("agents 2", "agents 5").replace('"..." }', '"..." "..." }')
SIZED = (
    FIVE.replace("  param fine", "  size players : count = 5 in 1 .. 5\n  param fine")
    .replace("agents 5", "agents players")
    .replace("  variant", "  policy walker { when agent.bag >= 0 choose forward }\n  variant")
)
KEYS = [1, 0, 3, 2, 1, 1]  # what the person does in each step


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working folder, with a game of five agents and a model."""
    monkeypatch.chdir(tmp_path)
    Path("yard.sj").write_text(FIVE)
    Path("models.toml").write_text('[luna]\nkind = "fake"\n')
    return tmp_path


@pytest.fixture
def trained(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A run with memory, which draws its actions."""
    monkeypatch.setattr("tests.experiments.stored_policies.SURE", 1.0)
    reads = {"memory": "gru", "memory_reads": ("action", "reward")}
    store(folder / "runs/a", sjdsl.make("yard.sj"), 1, **reads)


def seated(folder: Path, *names: str) -> Bench:
    """Returns a bench with the game on the board, and somebody in each seat."""
    bench = Bench(folder, Seats("yard.sj", names))
    assert opened(bench, FIVE)["game"]["seats"] == list(names)
    return bench


def play(bench: Bench, keys: list[int]) -> list[list[int]]:
    """Returns the actions of each step in which agent 0, the person, presses these keys."""
    return [ask(bench, do="step", actions={"0": key})["scene"]["actions"] for key in keys]


def refusal(bench: Bench, **request: object) -> str:
    return str(ask(bench, **request)["refused"])


@pytest.mark.usefixtures("trained")
def test_an_episode_is_that_of_the_terminal(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO(" ".join(map(str, KEYS)) + "\n"))
    options = ["--slots", ",".join(SLOTS), "--seed", "3", "--record", "played.json"]
    assert run(["play", "yard.sj", *options]) == 0
    played = json.loads(Path("played.json").read_text())
    assert len({actions[1] for actions in played["actions"]}) > 1, "the run does something"

    bench = seated(folder, *SLOTS)
    ask(bench, do="begin", seed=3)
    assert play(bench, KEYS) == played["actions"]
    recorded = ask(bench, do="record")
    assert recorded["name"] == "yard.json"
    kept = json.loads(recorded["recording"])
    same = ("hash", "seed", "actions", "returns", "players", "why")
    assert [kept[name] for name in same] == [played[name] for name in same]
    assert kept["players"] == list(SLOTS)
    assert kept["why"] == [["", "", "", "", "by a hash"]] * len(KEYS)
    Path("kept.json").write_text(recorded["recording"])
    assert run(["replay", "kept.json"]) == 0

    ask(bench, do="go", to=2)
    assert "can't forget" in refusal(bench, do="step", actions={"0": 1})


@pytest.mark.usefixtures("trained")
def test_agents_with_memory_go_back(folder: Path) -> None:
    """They remember what they knew at the moment from which the episode goes on."""
    bench = seated(folder, "you", *["runs/a"] * 4)
    first = play(bench, KEYS)
    ask(bench, do="go", to=2)
    play(bench, [0])
    ask(bench, do="go", to=2)
    assert play(bench, KEYS[2:]) == first[2:]
    ask(bench, do="begin", seed=0)
    assert play(bench, KEYS[:3]) == first[:3], "nothing is left of the episode before"


def test_a_number_reaches_the_policies(folder: Path) -> None:
    """A scripted policy that reads a number follows it from the next step on."""
    text = FIVE.replace("agent.bag >= 0 choose stay", "fine > 2 choose forward")
    bench = Bench(folder, Seats("yard.sj", ("you", *["idler"] * 4)))
    opened(bench, text)
    assert play(bench, [0]) == [[0, 2, 2, 2, 2]]
    ask(bench, do="number", name="fine", value=3)
    assert play(bench, [0]) == [[0, 1, 1, 1, 1]]
    assert "a number was changed" in refusal(bench, do="record")


def test_a_seat_is_of_whom_it_names(folder: Path) -> None:
    bench = seated(folder, "random", "you", "stay", "stay", "stay")
    assert "you play agent 1: click on the board" in refusal(bench, do="step")
    answer = refusal(bench, do="step", actions={"1": 0, "2": 0})
    assert "agent 2 is played by stay, not by you" in answer
    assert ask(bench, do="step", actions={"1": 0})["at"] == 1
    watched = seated(folder, *["stay"] * 5)
    assert ask(watched, do="step")["scene"]["actions"] == [2] * 5
    other = ask(watched, do="text", version=2, path="other.sj", text=FIVE)
    assert other["game"]["seats"] == [], "the seats are those of one game"
    assert other["at"] == 0, "and so is an episode in which they play"
    assert ask(watched, do="step", actions={"0": 0})["scene"]["actions"][0] == 0


def test_who_cannot_play_is_told_in_words(folder: Path) -> None:
    bench = seated(folder, "you", *["idler"] * 4)
    opened(bench, FIVE.replace("agents 5", "agents 4"))
    told = refusal(bench, do="step", actions={"0": 1})
    assert told == "yard has 4 agents, but --slots names 5; name one for each"
    opened(bench, FIVE.replace("policy idler", "policy loafer"))
    assert "there is no policy `idler`" in refusal(bench, do="step", actions={"0": 1})
    opened(bench, FIVE)
    assert ask(bench, do="step", actions={"0": 1})["at"] == 1


@pytest.mark.usefixtures("trained")
def test_a_run_of_another_game_is_refused(folder: Path) -> None:
    bench = seated(folder, "you", *["runs/a"] * 4)
    opened(bench, FIVE.replace("ahead 1, behind 1", "ahead 2, behind 1"))
    assert "doesn't fit yard" in refusal(bench, do="step", actions={"0": 1})


def test_what_no_file_can_say_is_not_recorded(folder: Path) -> None:
    bench = Bench(folder)
    opened(bench, FIVE, variants=["poor"])
    ask(bench, do="number", name="fine", value=2.5)
    ask(bench, do="begin", seed=0)
    ask(bench, do="step")
    kept = json.loads(ask(bench, do="record")["recording"])
    assert kept["environment"]["variant"] == "poor"
    assert kept["environment"]["params"] == {"fine": 2.5}
    assert "players" not in kept, "nobody has a seat"
    ask(bench, do="put", agent=0, row=2, col=2)
    assert "didn't begin with the start" in refusal(bench, do="record")
    ask(bench, do="begin", seed=0)
    opened(bench, FIVE.replace("give fine", "give 2 * fine"), fresh=True)
    assert "save the game to record it" in refusal(bench, do="record")


@pytest.fixture
def pages(folder: Path, monkeypatch: pytest.MonkeyPatch) -> list[tuple[FirstGame | None, Any]]:
    """What each page would open, and who plays it there, where no server runs."""
    del folder
    asked: list[tuple[FirstGame | None, Any]] = []

    def make_app(_folder: Path, _access: Any, first: FirstGame | None, seats: Any) -> None:
        asked.append((first, seats))

    monkeypatch.setattr("sjdsl.studio.server.make_app", make_app)
    monkeypatch.setattr("uvicorn.Server.run", lambda _server, sockets: sockets[0].close())
    return asked


@pytest.mark.usefixtures("no_code_allowed")
def test_the_command_says_variant_and_number_of_agents(
    pages: list[tuple[FirstGame | None, Any]],
) -> None:
    Path("yard.sj").write_text(SIZED)
    chosen = ("--variant", "poor", "--agents", "4")
    slots = ("--slots", "you,file,file,models.toml:luna", "--calls", "9", "--budget", "0.5")
    assert run(["studio", "yard.sj", "--no-browser", "--port", "0", *chosen, *slots]) == 0
    assert run(["studio", "yard.sj", "--no-browser", "--port", "0", *chosen[:2]]) == 0
    names = ("you", "walker", "idler", "models.toml:luna")
    limits = {"parallel": 16, "budget": 0.5, "calls": 9}
    assert pages == [
        (FirstGame("yard.sj", "poor", 4), Seats("yard.sj", names, limits=limits)),
        (FirstGame("yard.sj", "poor", None), None),
    ]


@pytest.mark.usefixtures("trained")
def test_the_command_refuses_a_run_of_another_game(
    pages: list[tuple[FirstGame | None, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    Path("yard.sj").write_text(FIVE.replace("ahead 1, behind 1", "ahead 2, behind 1"))
    slots = ("--slots", "you,runs/a,runs/a,runs/a,runs/a")
    assert run(["studio", "yard.sj", "--no-browser", "--port", "0", *slots]) == 1
    assert "doesn't fit yard: it was trained on yard with 4 actions" in capsys.readouterr().err
    assert pages == []


def test_a_seat_by_file_is_of_the_agents_policy_in_the_file(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As `play` deals them out: to agent 1 the second, to agent 2 the first."""
    Path("yard.sj").write_text(SIZED)
    monkeypatch.setattr("sys.stdin", io.StringIO("turn_left\n"))
    options = ["--slots", "you,file,file", "--agents", "3", "--record", "played.json"]
    assert run(["play", "yard.sj", *options]) == 0
    played = json.loads(Path("played.json").read_text())
    assert played["players"] == ["you", "walker", "idler"]
    assert played["actions"] == [[0, 1, 2]]
    bench = Bench(folder, Seats("yard.sj", ("you", "walker", "idler")))
    opened(bench, SIZED, agents=3)
    assert play(bench, [0]) == played["actions"]


@pytest.mark.usefixtures("pages")
@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("yard.sj", "--slots", "you,stay"), "yard has 5 agents, but --slots names 2"),
        (("yard.sj", "--slots", "you,you,stay,stay,stay"), "`you` can play one agent"),
        (("yard.sj", "--slots", "you,idle,stay,stay,stay"), "there is no policy `idle`"),
        (("--slots", "you,stay"), "name a game before them"),
        (("--variant", "poor"), "name a game before them"),
        (("yard.sj", "--variant", "rich"), "no variant `rich`"),
        (("yard.sj", "--calls", "3"), "--calls are for language models, and none plays"),
        (("yard.sj", "--agents", "3"), "`agents` does not name a `size` that says how many"),
    ],
)
def test_the_command_refuses_seats_as_play_does(
    capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], told: str
) -> None:
    assert run(["studio", "--no-browser", *arguments]) != 0
    assert told in capsys.readouterr().err


def test_models_are_asked_within_limits(folder: Path) -> None:
    names = ("you", "idler", "idler", "idler", "models.toml:luna")
    bench = Bench(folder, Seats("yard.sj", names, limits={"calls": 2}))
    opened(bench, FIVE)
    play(bench, KEYS[:2])
    assert "2 calls were made, and at most 2 may be" in refusal(bench, do="step", actions={"0": 1})
    ask(bench, do="begin", seed=0)
    assert "at most 2 may be" in refusal(bench, do="step", actions={"0": 1}), "of all episodes"


def test_the_process_of_a_page_knows_the_seats(folder: Path) -> None:
    async def ask_for_text() -> str:
        worker = Child(folder, Seats("yard.sj", SLOTS))
        request = {"do": "text", "version": 1, "path": "yard.sj", "text": FIVE}
        answer = await worker.ask(json.dumps(request))
        await worker.stop()
        return answer

    assert json.loads(asyncio.run(ask_for_text()))["game"]["seats"] == list(SLOTS)
