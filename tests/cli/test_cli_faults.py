"""Mistakes in a command line: one line each, with what was probably meant, and never a traceback."""

import os
import subprocess
import sys
from pathlib import Path

import click
import pytest
from command_line import Sjdsl

from sjdsl.cli import check, run
from sjdsl.games_folder import find_game


@pytest.mark.parametrize(
    ("arguments", "status", "said"),
    [
        ("chek orchard.sj", 2, "did you mean `check`?"),
        ("frobnicate", 2, "the commands are"),
        ("check orchard.sj --varient rich", 2, "--variant"),
        ("check", 2, "FILE"),
        ("check coin", 1, "did you mean `coins`?"),
        ("check nonsense", 1, "the bundled games are"),
        ("check missing.sj", 1, "missing.sj"),
        ("check orchard.sj --variant ritch", 1, "rich"),
        ("compile", 2, "FILE"),
        ("compile orchard.sj -o x --check", 2, "--check"),
        ("compile orchard.sj --map none.txt", 1, "none.txt"),
        ("compile orchard.sj -o orchard.sj/x.py", 1, "orchard.sj"),
        ("dump orchard.sj --after irr", 2, "'program'"),
        ("render orchard.sj -o film.mpeg", 2, "film.mpeg"),
        ("render orchard.sj --policy clever", 1, "random, stay"),
        ("render orchard.sj --param aple=3", 1, "did you mean `apple`?"),
        ("render orchard.sj --param apple=7", 1, "outside 0 .. 5"),
        ("render orchard.sj --param apple=NaN", 1, "`apple` is a number (reward), not nan"),
        ("render orchard.sj --param length=1099511627776", 1, "`length` is 1099511627776, outside 0 .. 1073741824"),
        ("trace orchard.sj --param length=0", 1, "`length` is 0, and can be 1 at least"),
        ("trace orchard.sj --param growth[none]=1e39", 1, "`growth[none]` is 1e+39, outside 0 .. 1"),
        ("trace orchard.sj --param players=1099511627776", 1, "`players` is 1099511627776; the most is 1073741824"),
        ("render orchard.sj --param apple", 2, "name=value"),
        ("render orchard.sj --param growth[soon]=0.1", 1, "none, ripe"),
        ("render orchard.sj --agents 9", 1, "1 .. 3"),
        ("train", 2, "name the game"),
        ("train orchard.sj --set learning_rat=1", 1, "did you mean `learning_rate`?"),
        ("train orchard.sj --preset quik", 1, "did you mean `quick`?"),
        ("train orchard.sj --algorithm dqn", 1, "known: ippo, mappo, irat, vdn"),
        ("evaluate nowhere", 1, "nowhere"),
        ("bench orchard.sj --envs 1,many", 2, "1,128,1024"),
        ("bench orchard.sj --agents own,few", 2, "own,20"),
        ("bench orchard.sj --observation pixels", 2, "tokens,onehot"),
        ("bench orchard.sj --agents 9", 1, "left out with 9 agents"),
        ("bench coinz", 1, "did you mean `coins`?"),
    ],
)
def test_a_mistake_is_told_in_the_users_words(sjdsl: Sjdsl, arguments: str, status: int, said: str) -> None:
    shown = sjdsl(*arguments.split())
    assert shown.status == status
    assert said in shown.text
    assert "Traceback" not in shown.text


def test_an_interrupt_is_one_line(sjdsl: Sjdsl, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(check, "open_game", interrupted)
    shown = sjdsl("check", "orchard.sj")
    assert shown.status == 130
    assert shown.text.split() == ["interrupted"]


def test_a_mistake_of_ours_keeps_its_traceback(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    del folder
    monkeypatch.setattr(check, "open_game", lambda _: {}["x"])
    with pytest.raises(KeyError):
        run(["check", "orchard.sj"])


def test_help_lists_the_commands_without_importing_them() -> None:
    program = (
        "import sys; from sjdsl.cli import run; run(['--help']); "
        "assert 'jax' not in sys.modules; assert 'sjdsl.compiler' not in sys.modules"
    )
    shown = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True).stdout
    for name in ("check", "compile", "dump", "explain", "list", "bench", "render", "train", "evaluate"):
        assert name in shown


def test_no_help_and_nothing_that_only_reads_a_game_waits_for_jax(tmp_path: Path) -> None:
    (tmp_path / "coins.sj").write_text(find_game("coins").read_text())
    calls = [
        "check coins",
        "fmt coins.sj",
        "doc coins",
        "diff coins pd_arena",
        "trace coins --steps 2 --param length=9",
        "list coins",
        "explain SJ101",
    ]
    program = (
        "import sys; from sjdsl.cli import COMMANDS, run\n"
        f"assert not any(run([name, '--help']) for name in COMMANDS); assert not any(run(call.split()) for call in {calls})\n"
        "assert not {'jax', 'flax', 'matplotlib', 'hypothesis', 'orbax', 'textual'} & set(sys.modules), set(sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", program], check=False, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr


def test_the_package_runs_as_a_module() -> None:
    shown = subprocess.run([sys.executable, "-m", "sjdsl", "--version"], check=True, capture_output=True, text=True)
    assert shown.stdout.startswith("sjdsl ")


def test_every_command_has_help(sjdsl: Sjdsl) -> None:
    from sjdsl.cli import COMMANDS, commands

    for name in COMMANDS:
        assert isinstance(commands.get_command(click.Context(commands), name), click.Command)
        assert sjdsl(name, "--help").status == 0


@pytest.mark.skipif(sys.platform == "win32", reason="there is no such pipe")
@pytest.mark.parametrize("arguments", ["check game.sj", "list", "--help"])
def test_a_reader_that_has_closed_gets_no_traceback(arguments: str, tmp_path: Path) -> None:
    """As with `sjdsl check game.sj | head`: the command ends without a word on the standard error."""
    (tmp_path / "game.sj").write_text("sj 1\ngame game {\n  kind\n}\n")
    program = "import sys; sys.argv[0] = 'sjdsl'; from sjdsl.cli import main; main()"
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(
        [sys.executable, "-c", program, *arguments.split()], cwd=tmp_path, stdout=write, stderr=subprocess.PIPE, check=False
    )
    os.close(write)
    assert (done.returncode, done.stderr) == (1, b"")
