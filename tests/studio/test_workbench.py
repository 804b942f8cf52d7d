"""The bench behind the page: texts, episodes, panels; what an edit keeps, and what is refused."""

import json
from pathlib import Path
from typing import Any

import pytest

from sjdsl.cli import run
from sjdsl.library.games_folder import find_game
from sjdsl.studio.bench import Bench
from sjdsl.studio.requests import READ
from sjdsl.studio.worker import answer_line

GAME = """sj 1
game yard "Yard" {
  param fine : reward = 1 in 0 .. 5
  episode 6
  kind floor "."
  kind soil "A" { field fruit : { none, ripe } = ripe }
  map { "..A"
        "..." }
  agents 2 {
    acts turn_left, forward, stay, grab
    moves relative
    field bag : 0 .. 3 capped = 0
  }
  phase start { each agent { send agent to floor facing north } }
  schedule walk -> eat
  phase walk { move each agent }
  phase eat { each agent on soil where soil.fruit is ripe { add 1 to agent.bag  give fine to agent  set soil.fruit = none  tally eaten for agent } }
  observe { window ahead 1, behind 1, left 1, right 1 }
  metrics { event eaten }
  checks { always count(agent where agent.bag > 3) == 0 }
  policy idler { when agent.bag >= 0 choose stay }
  variant poor "a fruit pays nothing" { set fine = 0 }
}
"""


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    return Bench(tmp_path)


def ask(bench: Bench, **request: Any) -> dict[str, Any]:
    """Returns the answer as the page has it."""
    answer = json.loads(
        json.dumps(bench.answer(READ.validate_json(json.dumps({"id": 7, **request}))))
    )
    assert answer["id"] == 7
    return answer


def opened(bench: Bench, text: str = GAME, **other: Any) -> dict[str, Any]:
    answer = ask(bench, do="text", version=1, path="yard.sj", text=text, **other)
    assert answer["compiles"], answer
    return answer


def take_steps(bench: Bench, count: int) -> dict[str, Any]:
    """Returns the answer to the last of some steps."""
    return [ask(bench, do="step") for _ in range(count)][-1]


def test_a_text_becomes_a_board(bench: Bench) -> None:
    answer = opened(bench)
    assert (answer["game"]["height"], answer["game"]["width"], answer["game"]["agents"]) == (
        2,
        3,
        2,
    )
    assert answer["game"]["policies"] == ["random", "stay", "idler"]
    assert answer["game"]["variants"] == [["poor", "a fruit pays nothing"]]
    (fine,) = answer["game"]["numbers"]
    assert (fine["name"], fine["unit"], fine["low"], fine["high"], fine["entries"]) == (
        "fine",
        "reward",
        0,
        5,
        [[[], 1.0, 1.0]],
    )
    assert len(answer["scene"]["cells"]) == 2 * 6
    assert len(answer["scene"]["figures"]) == 2
    assert all(url.startswith("data:image/svg+xml;base64,") for url in answer["pictures"])


def test_a_text_with_errors_leaves_the_board_as_it_is(bench: Bench) -> None:
    opened(bench)
    ask(bench, do="step")
    answer = ask(
        bench, do="text", version=2, path="yard.sj", text=GAME.replace("kind floor", "kind flor")
    )
    assert answer["compiles"] is False
    assert answer["errors"] >= 1
    line, message = answer["problems"][0]
    assert line == GAME[: GAME.index("phase start")].count("\n") + 1, "where the kind is named"
    assert "floor" in message
    assert ask(bench, do="step")["at"] == 2


def test_a_start_beyond_float32_is_told_with_its_line(bench: Bench) -> None:
    text = GAME.replace("field bag", "field wealth : reward = 1 field bag").replace(
        "facing north", "facing north set agent.wealth = 1e20 * 1e20"
    )
    answer = ask(
        bench,
        do="text",
        version=1,
        path="yard.sj",
        text=text.replace("1e20", "1" + 20 * "0" + ".0"),
    )
    assert "yard.sj:14: in step 0" in answer["refused"]
    assert "leaves float32" in answer["refused"]


def test_an_edit_keeps_the_state_where_it_fits(bench: Bench) -> None:
    opened(bench)
    take_steps(bench, 3)
    places = ask(bench, do="go", to=3)["scene"]["places"]
    richer = opened(bench, GAME.replace("add 1 to agent.bag", "add 2 to agent.bag"))
    assert richer["kept"]
    assert richer["scene"]["step"] == 3
    assert richer["scene"]["places"] == places
    assert richer["moments"] == 1, "the moments before it were of other rules"
    larger = opened(bench, GAME.replace('"..." }', '"..." "..." }'))
    assert not larger["kept"]
    assert larger["scene"]["step"] == 0


def test_a_field_that_no_longer_fits_starts_anew(bench: Bench) -> None:
    opened(bench)
    ask(bench, do="put", agent=0, row=0, col=2)
    ask(bench, do="step", actions={"0": 2})
    ask(bench, do="others", policy="stay")
    assert dict(ask(bench, do="panel", panel="state", row=0, col=2)["agents"][0])["bag"] == "1"
    changed = opened(
        bench,
        GAME.replace("{ none, ripe } = ripe", "{ empty, full } = full")
        .replace("is ripe", "is full")
        .replace("= none  tally", "= empty  tally"),
    )
    assert changed["kept"]
    state = ask(bench, do="panel", panel="state", row=0, col=2)
    assert dict(state["cell"]["values"]) == {"fruit": "full"}
    assert dict(state["agents"][0])["bag"] == "1"


def test_back_scrub_and_another_way_on(bench: Bench) -> None:
    opened(bench)
    first = [ask(bench, do="step")["scene"]["places"] for _ in range(4)]
    assert ask(bench, do="go", to=2)["scene"]["places"] == first[1]
    assert ask(bench, do="go", to=99)["at"] == 4
    ask(bench, do="go", to=2)
    other = ask(bench, do="step", actions={"0": 2, "1": 2})
    assert (other["at"], other["moments"]) == (3, 4), "what came after is forgotten"
    ask(bench, do="go", to=2)
    again = ask(bench, do="step", actions={"0": 2, "1": 2})
    assert again["scene"]["places"] == other["scene"]["places"], "the same draws"


def test_the_end_of_an_episode(bench: Bench) -> None:
    opened(bench)
    last = take_steps(bench, 6)
    assert last["at"] == 6
    assert last["scene"]["done"]
    assert "is over" in ask(bench, do="step")["refused"]
    assert ask(bench, do="begin", seed=3)["at"] == 0


def test_who_is_driven_acts_and_the_others_follow_a_policy(bench: Bench) -> None:
    opened(bench)
    ask(bench, do="others", policy="idler")
    assert ask(bench, do="step", actions={"1": 1})["scene"]["actions"] == [2, 1]
    assert "no policy" in ask(bench, do="others", policy="nobody")["refused"]
    assert opened(bench, GAME.replace("capped = 0", "capped = 1"))["game"]["others"] == "idler"
    assert (
        opened(bench, GAME.replace("policy idler", "policy loafer"))["game"]["others"] == "random"
    )


def test_a_number_counts_from_the_next_step_on(bench: Bench) -> None:
    opened(bench)
    ask(bench, do="others", policy="stay")
    ask(bench, do="number", name="fine", value=3.5)
    ask(bench, do="put", agent=1, row=0, col=2)
    answer = ask(bench, do="step")
    assert answer["scene"]["rewards"] == [0, 3.5]
    assert answer["scene"]["events"] == [["eaten", [0, 1]]]
    assert "outside 0 .. 5" in ask(bench, do="number", name="fine", value=9)["refused"]


def test_a_table_is_set_entry_by_entry(bench: Bench) -> None:
    text = GAME.replace(
        "param fine : reward = 1 in 0 .. 5",
        "param fine : reward = 1\n  param pay : reward = { none: { none: 1, ripe: 2 }, ripe: { none: 3, ripe: 4 } }",
    )
    text = text.replace("give fine", "give pay[ripe][none]").replace("set fine = 0", "set fine = 9")
    answer = opened(bench, text)
    pay = next(number for number in answer["game"]["numbers"] if number["name"] == "pay")
    assert pay["entries"] == [
        [["none", "none"], 1, 1],
        [["none", "ripe"], 2, 2],
        [["ripe", "none"], 3, 3],
        [["ripe", "ripe"], 4, 4],
    ]
    ask(bench, do="others", policy="stay")
    ask(bench, do="put", agent=1, row=0, col=2)
    ask(bench, do="number", name="pay", value={"ripe": {"none": 2.5}})
    assert ask(bench, do="step")["scene"]["rewards"] == [0, 2.5]
    kept = opened(bench, text + "# mine\n", params={"pay": {"ripe": {"none": 2.5}}})["game"][
        "numbers"
    ]
    assert next(number["entries"][2] for number in kept if number["name"] == "pay") == [
        ["ripe", "none"],
        2.5,
        3,
    ]
    assert "no entry" in ask(bench, do="number", name="pay", value={"raw": {"none": 2}})["refused"]


def test_a_require_is_kept_whatever_is_set(bench: Bench) -> None:
    text = GAME.replace("param fine", "param tax : reward = 0 in 0 .. 5\n  param fine").replace(
        "checks {", "checks { require tax <= fine "
    )
    opened(bench, text)
    assert "require" in ask(bench, do="number", name="tax", value=2)["refused"]
    ask(bench, do="number", name="fine", value=3)
    assert "refused" not in ask(bench, do="number", name="tax", value=2)
    assert opened(bench, text, params={"fine": 3, "tax": 2})["game"]["left"] == []
    (tenth,) = opened(bench, GAME.replace("fine : reward = 1", "fine : reward = 0.1"))["game"][
        "numbers"
    ]
    assert tenth["entries"][0][1] == tenth["entries"][0][2], "no reason to offer a way back"
    later = opened(bench, text.replace("tax <= fine", "tax == 0"), params={"fine": 3, "tax": 2})[
        "game"
    ]
    assert later["left"] == ["tax"], "the last one set goes"
    assert {n["name"]: n["entries"][0][1] for n in later["numbers"]} == {"tax": 0, "fine": 3}


@pytest.mark.parametrize(
    ("variants", "name", "entry", "value", "wanted"),
    [
        ((), "fine", (), "2.5", "param fine : reward = 2.5 in"),
        (("poor",), "fine", (), "3", "set fine = 3 "),
        ((), "pay", ("ripe", "none"), "-7", "ripe: { none: -7, ripe: 4 }"),
        ((), "pay", ("raw", "none"), "1", "written together with others"),
        ((), "gone", (), "1", "no number `gone`"),
    ],
)
def test_a_number_is_written_where_the_text_has_it(
    bench: Bench,
    variants: tuple[str, ...],
    name: str,
    entry: tuple[str, ...],
    value: str,
    wanted: str,
) -> None:
    text = (
        GAME.replace("sj 1", "sj 1  # 🍎")
        .replace(
            "param fine",
            "param pay : reward = { none: { none: 1, ripe: 2 }, ripe: { none: 3, ripe: 4 } }\n  param fine",
        )
        .replace("give fine", "give fine + pay[ripe][none]")
    )
    opened(bench, text, variants=variants)
    answer = ask(bench, do="write", name=name, entry=entry, value=value)
    if "refused" in answer:
        assert wanted in answer["refused"]
        return
    change, units = answer["change"], text.encode("utf-16-le")
    assert wanted in (
        units[: 2 * change["start"]]
        + change["glyph"].encode("utf-16-le")
        + units[2 * change["end"] :]
    ).decode("utf-16-le")


def test_why_tells_the_rule_and_the_cells(bench: Bench) -> None:
    opened(bench)
    ask(bench, do="others", policy="stay")
    ask(bench, do="put", agent=0, row=0, col=2)
    ask(bench, do="step")
    turns = ask(bench, do="panel", panel="trace")["turns"]
    rules = [rule for turn in turns if turn["phase"] == "eat" for rule in turn["rules"]]
    said = {
        effect["said"]: (rule["line"], effect["cells"])
        for rule in rules
        for effect in rule["effects"]
    }
    line = GAME[: GAME.index("phase eat")].count("\n") + 1
    assert said["soil (0, 2)  fruit: ripe -> none"] == (line, [[0, 2]])
    assert said["agent 0  reward +1"][1] == [
        [0, 2]
    ]  # where the agent stands: who asks about another cell doesn't see it


def test_an_episode_is_shared_as_a_page(bench: Bench) -> None:
    opened(bench)
    take_steps(bench, 3)
    ask(bench, do="go", to=1)
    shared = ask(bench, do="share")
    assert shared["name"] == "yard.html"
    assert shared["html"].startswith("<!doctype html>")
    assert ask(bench, do="go", to=99)["at"] == 3


@pytest.mark.parametrize(
    "request_",
    [
        {"do": "put", "agent": 9, "row": 0, "col": 0},
        {"do": "put", "agent": 0, "row": 9, "col": 0},
        {"do": "panel", "panel": "state", "row": -1, "col": 0},
        {"do": "panel", "panel": "seen", "agent": 5},
        {"do": "step", "actions": {"0": 99}},
        {"do": "step", "actions": {"7": 0}},
        {"do": "panel", "panel": "seen", "agent": -1},
        {"do": "number", "name": "fine", "value": "much"},
        {"do": "number", "name": "gone", "value": 1},
    ],
    ids=str,
)
def test_what_cannot_be_is_refused_in_words(bench: Bench, request_: dict[str, Any]) -> None:
    assert "compiled yet" in ask(bench, **request_)["refused"]
    opened(bench)
    assert ask(bench, **request_)["refused"]
    assert ask(bench, do="step")["at"] == 1, "and nothing else happened"


def test_an_agent_is_seen_as_a_model_sees_it(bench: Bench) -> None:
    """The text of its window, and what it may do; it is another one for an agent elsewhere."""
    opened(bench)
    first, second = (ask(bench, do="panel", panel="seen", agent=agent) for agent in (0, 1))
    assert first["message"].startswith("WHAT YOU SEE NOW:\n")
    assert "YOUR ACTIONS NOW:\n" in first["message"]
    assert first["message"] != second["message"]


def test_the_cells_that_an_agent_sees_are_told_as_they_lie_in_its_window(bench: Bench) -> None:
    """Both face north in two rows: one row ahead and one behind, a column to either side."""
    scene = opened(bench)["scene"]
    for agent, (row, col) in enumerate(scene["places"]):
        panel = ask(bench, do="panel", panel="seen", agent=agent)
        around = [[[row + down, col + right] for right in (-1, 0, 1)] for down in (-1, 0, 1)]
        on_map = [
            [cell if cell[0] in range(2) and cell[1] in range(3) else None for cell in cells]
            for cells in around
        ]
        assert (panel["heading"], panel["window"]) == (0, on_map)
    ask(bench, do="step", actions={0: 0, 1: 1})  # agent 0 turns to the left: west is up
    panel = ask(bench, do="panel", panel="seen", agent=0)
    assert panel["heading"] == 3
    row, col = scene["places"][0]
    assert panel["window"][1][1] == [row, col]
    assert panel["window"][0][1] == ([row, col - 1] if col else None)


def test_a_cell_is_painted_in_the_text(bench: Bench) -> None:
    answer = opened(bench, GAME.replace("sj 1", "sj 1  # 🍎"))
    assert answer["game"]["glyphs"] == [[".", "floor"], ["A", "soil"]]
    assert answer["game"]["map_file"] is None
    change = ask(bench, do="paint", row=1, col=0, glyph="A")["change"]
    units = GAME.replace("sj 1", "sj 1  # 🍎").encode("utf-16-le")
    assert (
        units[2 * change["start"] : 2 * change["end"]].decode("utf-16-le")
        == change["before"]
        == "."
    )
    painted = (
        units[: 2 * change["start"]]
        + change["glyph"].encode("utf-16-le")
        + units[2 * change["end"] :]
    ).decode("utf-16-le")
    assert opened(bench, painted)["scene"]["cells"] != answer["scene"]["cells"]
    assert '"A.."' in painted
    assert "no kind" in ask(bench, do="paint", row=1, col=0, glyph="?")["refused"]


def test_a_map_of_a_file_is_painted_there(bench: Bench) -> None:
    (bench.folder / "maps").mkdir()
    (bench.folder / "maps" / "yard.txt").write_text("..A\n...\n", encoding="utf-8")
    text = GAME.replace('map { "..A"\n        "..." }', 'map "maps/yard.txt"')
    assert opened(bench, text)["game"]["map_file"] == "maps/yard.txt"
    change = ask(bench, do="paint", row=1, col=1, glyph="A")["change"]
    assert (change["path"], change["start"], change["before"]) == ("maps/yard.txt", 5, ".")
    opened(bench, text, over={"maps/yard.txt": "..A\n.A.\n"})
    assert ask(bench, do="paint", row=1, col=1, glyph=".")["change"]["before"] == "A"
    assert (bench.folder / "maps" / "yard.txt").read_text(encoding="utf-8") == "..A\n...\n"


@pytest.mark.parametrize(
    "path",
    ["../yard.sj", "/tmp/yard.sj", "yard.txt", "\0.sj", "example:../yard.sj", "tour:/etc/yard.sj"],
)
def test_a_text_is_of_a_game_in_the_folder(bench: Bench, path: str) -> None:
    """Else the maps and bases beside it would be read from anywhere."""
    assert "`" in ask(bench, do="text", version=1, path=path, text=GAME)["refused"]


def test_a_fault_of_our_own_is_told_and_nothing_is_lost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = Bench(tmp_path)
    opened(made)
    ask(made, do="step")
    monkeypatch.setattr("sjdsl.studio.bench.state_panel", lambda *_: 1 / 0)
    assert "a fault of sjdsl" in str(
        answer_line(made, '{"do": "panel", "panel": "state"}')["refused"]
    )
    assert answer_line(made, '{"do": "step"}')["at"] == 2


def test_a_game_with_a_split_plays_its_training_tasks(
    bench: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As `sjdsl play` does: the orders `our` and `oru` of red are held out."""
    monkeypatch.chdir(tmp_path)
    text = find_game("open_harvest").read_text()
    ask(bench, do="text", version=1, path="example:open_harvest.sj", text=text)
    red = set()
    for seed in range(8):
        ask(bench, do="begin", seed=seed)
        red.add(bench.episode.now.world.fields["pay_order"][0])
    assert red <= {"uro", "uor", "ruo", "rou"}
    for _ in range(3):
        ask(bench, do="step")
    kept = json.loads(ask(bench, do="record")["recording"])
    options = ("--watch", "--seed", "7", "--steps", "3", "--record", "played.json")
    assert run(["play", "open_harvest", *options]) == 0
    played = json.loads(Path("played.json").read_text())
    same = ("hash", "seed", "actions", "returns")
    assert [kept[name] for name in same] == [played[name] for name in same]
    assert kept["environment"]["tasks"] == played["environment"]["tasks"] == "training"
