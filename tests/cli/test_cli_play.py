"""`sjdsl play`, `replay` and `new`: lines become actions, what was played can be shown again, and a new game passes its own tests."""

import io
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from itertools import repeat
from pathlib import Path

import jax
import numpy as np
import pytest
from command_line import Sjdsl

import sjdsl as package
from sjdsl.cli.play import play_compiled, play_interpreted
from sjdsl.interpreter.state import default_params
from sjdsl.policies.compiled import scripted_policy
from sjdsl.render import Moment, random_policy
from sjdsl.replay import EpisodePlayer, RecordingError, replayed
from sjdsl.runtime.env import Environment
from sjdsl.trace.choices import chooser
from sjdsl.trace.jax_random import fold_in, key_of

TESTS = Path(__file__).parents[1]
ORCHARD = TESTS / "policies/orchard.sj"
SEED = 2**31 + 5
Typed = Callable[..., tuple[str, list[str]]]


@pytest.fixture
def env(folder: Path) -> Environment:
    return package.make(folder / "orchard.sj")


@pytest.fixture
def typed(monkeypatch: pytest.MonkeyPatch, folder: Path, sjdsl: Sjdsl) -> Typed:
    """Plays Orchard with lines on standard input; returns what was shown, and what agent 0 did."""

    def play(text: str, *options: str) -> tuple[str, list[str]]:
        monkeypatch.setattr("sys.stdin", io.StringIO(text))
        shown = sjdsl("play", str(ORCHARD), "--seed", "3", "--record", "played.json", *options)
        assert shown.status == 0, shown.text
        names = ("turn_left", "turn_right", "forward", "stay", "sing")
        return shown.out, [
            names[actions[0]]
            for actions in json.loads((folder / "played.json").read_text())["actions"]
        ]

    return play


@pytest.mark.parametrize(
    ("text", "taken"),
    [
        ("sing\n2\nst\n", ["sing", "forward", "stay"]),
        ("\nf turn_l 4\n", ["stay", "forward", "turn_left", "sing"]),
        ("f\nquit\nf\n", ["forward"]),
        ("f q f\n", ["forward"]),
    ],
    ids=["name, number, beginning", "several in a line", "quit", "quit among others"],
)
def test_lines_are_actions(typed: Typed, text: str, taken: list[str]) -> None:
    shown, found = typed(text)
    assert found == taken
    assert f"played.json  {len(taken)} steps of A Small Orchard" in shown


def test_a_mistake_lists_the_actions_and_plays_nothing_of_its_line(typed: Typed) -> None:
    shown, found = typed("f zap\nturn\n5\nsing\n")
    assert found == ["sing"]
    actions = "the actions are 0 turn_left, 1 turn_right, 2 forward, 3 stay, 4 sing; `quit` ends the episode"
    for wrong in (
        "`zap` is no action",
        "`turn` can be turn_left or turn_right",
        "`5` is no action",
    ):
        assert f"{wrong}; {actions}\n" in shown


def test_what_a_player_sees(typed: Typed) -> None:
    shown, _ = typed("turn_left forward sing\n", "--others", "stay")
    assert "you play agent 0" in shown
    assert "A soil: ripe" in shown
    second, third = (
        shown.partition(f"step {number}\n")[2].split("\n\n")[0].splitlines() for number in (2, 3)
    )
    assert second == [
        "  ########",
        "  #>.AA..#  1",
        "  #.AAA<.#  0",
        "  ########",
        "  agent   action      reward  return",
        "  0 you   forward          1       1",
        "  1       stay             0       0",
        "  eaten 1",
    ]
    assert third[5].endswith("  can only stay")
    assert "\x1b" not in shown, "this is no terminal"


def test_the_episode_ends_by_its_rules_or_after_the_steps_asked_for(typed: Typed) -> None:
    shown, found = typed("\n" * 20)
    assert (len(found), shown.count("the episode is over")) == (12, 1)
    shown, found = typed("\n" * 20, "--steps", "4")
    assert (len(found), shown.count("the episode is over")) == (4, 0)


def test_ctrl_c_keeps_what_was_recorded(folder: Path) -> None:
    script = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); from sjdsl.cli import main; main()"
    call = [sys.executable, "-u", "-c", script, "play", "orchard.sj", "--record", "kept.json"]
    process = subprocess.Popen(
        call, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdin is not None and process.stdout is not None
    process.stdin.write("forward\nstay\n")
    process.stdin.flush()
    while process.stdout.readline() != "step 2\n":
        pass
    os.kill(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, err.split()) == (130, ["interrupted"])
    assert "kept.json  2 steps of A Small Orchard" in out
    assert len(json.loads((folder / "kept.json").read_text())["actions"]) == 2


def test_what_was_recorded_is_shown_again(env: Environment, sjdsl: Sjdsl, folder: Path) -> None:
    (folder / "kept").mkdir()
    played = sjdsl("play orchard.sj --watch --seed 5 --record kept/episode.json")
    assert played.status == 0, played.text
    assert "kept/episode.json  6 steps of A Small Orchard" in played.out
    kept = json.loads((folder / "kept/episode.json").read_text())
    assert kept["hash"] == env.hash
    assert kept["seed"] == 5
    assert np.shape(kept["actions"]) == (6, 2)
    player = EpisodePlayer(env, 5)
    for step in kept["actions"]:
        player.step(step)
    assert kept["returns"] == player.returns.tolist()
    boards = played.out.partition("\n\n")[2].partition("\n\nkept")[0]
    assert boards.count("step ") == 7
    shown = sjdsl("replay kept/episode.json")
    assert shown.status == 0, shown.text
    assert shown.out.partition("\n\n")[2] == boards + "\n"
    filmed = sjdsl("replay kept/episode.json -o film.gif")
    assert "film.gif  7 frames" in filmed.out
    assert (folder / "film.gif").read_bytes().startswith(b"GIF8")


def test_an_episode_of_other_rules_is_refused(env: Environment, sjdsl: Sjdsl, folder: Path) -> None:
    player = EpisodePlayer(env, 5)
    player.step([0, 0])
    recording = player.recording({"game": str(folder / "orchard.sj")})
    (folder / "episode.json").write_text(recording.model_dump_json())
    (folder / "orchard.sj").write_text(
        (folder / "orchard.sj").read_text().replace("none: 0.1", "none: 0.2")
    )
    shown = sjdsl("replay episode.json")
    assert shown.status == 1
    assert "the rules of orchard have changed since the episode was recorded" in shown.err
    with pytest.raises(RecordingError, match="were recorded"):
        list(replayed(recording.model_copy(update={"returns": [9.0, 9.0]}), env))


@pytest.mark.thorough
def test_a_new_game_passes_its_tests(sjdsl: Sjdsl, folder: Path) -> None:
    made = sjdsl("new pond")
    assert made.status == 0, made.text
    assert made.out.split()[:3] == ["pond.sj", "pond.txt", "test_pond.py"]
    assert "pond.sj: no problems" in sjdsl("check pond.sj").text
    assert sjdsl("fmt --check pond.sj").status == 0
    again = sjdsl("new pond")
    assert again.status == 1
    assert "pond.sj exists already; nothing was written" in again.err
    tests = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "test_pond.py"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert tests.returncode == 0, tests.stdout
    assert "3 passed" in tests.stdout
    assert sjdsl("test pond.sj --examples 20").status == 0


def alike(first: Moment, second: Moment) -> bool:
    """Returns whether two moments show the same."""
    ours, theirs = ({**vars(m), **vars(m.snapshot)} for m in (first, second))
    common = (
        ours["values"].keys() & theirs["values"].keys()
    )  # the compiled state has more than the fields of the game
    for moment in (ours, theirs):
        moment |= {"snapshot": 0, "values": {name: moment["values"][name] for name in common}}
    assert len(common) > 1
    return jax.tree.all(
        jax.tree.map(
            lambda a, b: np.array_equal(np.asarray(a, float), np.asarray(b, float)), ours, theirs
        )
    )


@pytest.mark.parametrize(
    ("game", "others"),
    [
        (ORCHARD, "eater"),
        ("coins", "random"),
        *(
            pytest.param(game, "random", marks=pytest.mark.thorough)
            for game in (ORCHARD, "clean_up", TESTS / "cases/moving.sj")
        ),
    ],
    ids=str,
)
def test_the_interpreter_plays_the_episode_of_the_compiled_game(
    game: str | Path, others: str
) -> None:
    """Draw by draw, the others' draws too, and one agent steered."""
    env = package.make(game)
    policy = random_policy(env) if others == "random" else scripted_policy(env, others)
    steering = [{0: env.num_actions - 1}, {}, *repeat({}, 20)]  # longer than Orchard
    ours = list(
        play_interpreted(
            env.game, default_params(env.game), SEED, chooser(env.game, others, SEED), steering
        )
    )
    theirs = list(play_compiled(env, policy, SEED, steering))
    assert len(ours) == len(theirs) > 8
    assert all(map(alike, ours, theirs))
    assert others != "eater" or (ours[-1].done and ours[-1].snapshot.returns.sum() > 0), (
        "something happened"
    )


def test_keys_are_folded_as_jax_folds_them() -> None:
    for seed in (0, 7, SEED):
        for number in (0, 1, 1000, 2**32 - 1):
            found = jax.random.key_data(jax.random.fold_in(jax.random.key(seed), np.uint32(number)))
            assert fold_in(key_of(seed), number) == tuple(int(word) for word in found)
