"""Files are written whole, through no link, and keep their permissions; those from elsewhere are read up to a limit."""

import ast
import errno
import os
import stat
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from sjdsl.cli import run
from sjdsl.files import parse_json, read_bytes, read_json, write_whole, written_whole
from sjdsl.replay import DatasetWriter, Header, Recording
from sjdsl.replay.recording import save_recording
from sjdsl.studio.folder import Folder, digest
from sjdsl.sweeps.locks import take_lock
from sjdsl.trainers.json_files import write_json
from sjdsl.trainers.runs.metrics_files import (
    EVALUATIONS,
    METRICS_JSONL,
    append_line,
    cut_metrics,
    to_disk,
)
from sjdsl.trainers.runs.run_lock import LOCK, locked

ROOT = Path(__file__).parents[2]
GAME = "sj 1\ngame  tiny { }\n"
RECORDING = Recording(environment={"game": "coins"}, hash="0", seed=0, actions=[], returns=[])


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


@pytest.mark.parametrize("kept", [0o600, 0o640, 0o444, 0o755, 0o666])
def test_permissions_are_kept(kept: int, tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_text("before")
    path.chmod(kept)
    write_whole(path, "after")
    assert (path.read_text(), mode(path)) == ("after", kept)


@pytest.mark.parametrize("mask", [0o022, 0o077, 0o002])
def test_a_new_file_has_those_of_the_umask(mask: int, tmp_path: Path) -> None:
    before = os.umask(mask)
    try:
        write_whole(tmp_path / "a", b"new")
    finally:
        os.umask(before)
    assert mode(tmp_path / "a") == 0o666 & ~mask


def test_nothing_of_a_private_file_can_be_read_while_it_is_written(tmp_path: Path) -> None:
    (tmp_path / "a").touch(0o600)
    with written_whole(tmp_path / "a") as file:
        (unfinished,) = set(tmp_path.iterdir()) - {tmp_path / "a"}
        assert mode(unfinished) == 0o600
        file.write(b"secret")
    assert mode(tmp_path / "a") == 0o600


def test_a_link_is_replaced_and_not_followed(tmp_path: Path) -> None:
    elsewhere = tmp_path / "elsewhere"
    elsewhere.write_text("theirs")
    (tmp_path / "a").symlink_to(elsewhere)
    write_whole(tmp_path / "a", "ours")
    assert (elsewhere.read_text(), (tmp_path / "a").read_text(), (tmp_path / "a").is_symlink()) == (
        "theirs",
        "ours",
        False,
    )


def test_a_link_planted_under_the_unfinished_name_is_not_followed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nobody can guess the name; who could would still reach nothing."""
    monkeypatch.setattr("secrets.token_hex", lambda _: "guessed")
    (tmp_path / "guessed.unfinished").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(FileExistsError) as refused:
        write_whole(tmp_path / "a", "ours")
    assert refused.value.filename == str(tmp_path / "a")
    assert not (tmp_path / "elsewhere").exists()


def test_what_fails_leaves_what_was_there_and_nothing_else(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("before")
    with pytest.raises(KeyboardInterrupt), written_whole(tmp_path / "a"):
        raise KeyboardInterrupt
    with pytest.raises(OSError, match="No space"), written_whole(tmp_path / "a"):
        raise OSError(errno.ENOSPC, "No space left on device")
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("a", "before")]
    with pytest.raises(FileNotFoundError) as refused:
        write_whole(tmp_path / "none/a", "new")
    assert refused.value.filename == str(tmp_path / "none/a")


def test_what_a_killed_process_left_is_removed(tmp_path: Path) -> None:
    """A file that is being written is locked, by whichever process; others may have any other name."""
    script = f"import os; from sjdsl.files import *; from pathlib import Path\nwith written_whole(Path({str(tmp_path / 'a')!r})): os.abort()"
    subprocess.run([sys.executable, "-c", script], check=False, stderr=subprocess.DEVNULL)
    (left,) = tmp_path.iterdir()
    assert left.suffix == ".unfinished"
    (tmp_path / "thesis.unfinished").write_text("theirs")
    with written_whole(tmp_path / "b"):
        (being_written,) = {*tmp_path.iterdir()} - {tmp_path / "thesis.unfinished"}
        write_whole(tmp_path / "c", "new")
        assert being_written.exists()
    assert {path.name for path in tmp_path.iterdir()} == {"thesis.unfinished", "b", "c"}


def test_a_name_may_be_as_long_as_the_system_allows(tmp_path: Path) -> None:
    write_whole(tmp_path / ("a" * 255), "long")
    assert (tmp_path / ("a" * 255)).read_text() == "long"


def test_many_may_write_one_file_at_once(tmp_path: Path) -> None:
    texts = [str(number) * 100_000 for number in range(8)]
    writers = [threading.Thread(target=write_whole, args=(tmp_path / "a", text)) for text in texts]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    assert [path.name for path in tmp_path.iterdir()] == ["a"]
    assert (tmp_path / "a").read_text() in texts


def planted(folder: Path, name: str) -> tuple[Path, Path]:
    """Returns a file with links beside it, under every name that was once that of an unfinished one, and where these lead."""
    victim, target = folder / "victim", folder / name
    victim.write_text("theirs")
    for link in (
        f".{name}.new",
        f"{name}.{os.getpid()}",
        f"{name}.unfinished",
        f"{name}.part",
        f"{name}.new",
        f"{name}.tmp",
    ):
        (folder / link).symlink_to(victim)
    return target, victim


def test_saving_in_the_studio_writes_nothing_elsewhere(tmp_path: Path) -> None:
    target, victim = planted(tmp_path, "a.sj")
    target.write_text(GAME)
    target.chmod(0o600)
    Folder(tmp_path.resolve()).write("a.sj", "new", digest(GAME.encode()))
    assert (victim.read_text(), target.read_text(), mode(target)) == ("theirs", "new", 0o600)


@pytest.mark.parametrize("what", ["fmt", "compile", "recording", "json"])
def test_nothing_is_written_elsewhere(what: str, tmp_path: Path) -> None:
    target, victim = planted(tmp_path, {"fmt": "a.sj", "compile": "a.py"}.get(what, "a.json"))
    target.write_text("game")
    target.chmod(0o600)
    match what:
        case "fmt":
            target.write_text(
                (ROOT / "games/coins.sj")
                .read_text()
                .replace("  kind", "    kind")
                .replace("maps/coins.txt", "coins.txt")
            )
            assert run(["fmt", str(target)]) == 0
        case "compile":
            assert run(["compile", "coins", "-o", str(target)]) == 0
        case "recording":
            save_recording(RECORDING, target)
        case "json":
            write_json(target, {"a": 1})
    assert (victim.read_text(), mode(target), target.read_text() != "game") == (
        "theirs",
        0o600,
        True,
    )


@pytest.mark.parametrize("what", ["run", "metrics", "evaluations", "cut", "cell"])
def test_what_is_changed_in_place_is_no_link(what: str, tmp_path: Path) -> None:
    """Locks, logs and what is taken off their ends: a folder of a stranger may have links in their places."""
    victim = tmp_path / "victim"
    theirs = "".join(
        f'{{"update": {number}, "env_steps": 1, "seconds": 1, "episodes": 0}}\n'
        for number in (1, 2)
    )
    victim.write_text(theirs)
    names = {
        "run": LOCK,
        "metrics": METRICS_JSONL,
        "evaluations": EVALUATIONS,
        "cut": METRICS_JSONL,
        "cell": "locks/cell.lock",
    }
    link = tmp_path / "folder" / names[what]
    link.parent.mkdir(parents=True)
    link.symlink_to(victim)
    changes: dict[str, Callable[[], object]] = {
        "run": lambda: locked(link.parent).__enter__(),
        "metrics": lambda: append_line(link, {"update": 3}),
        "evaluations": lambda: to_disk(link),
        "cut": lambda: list(cut_metrics(link.parent, 1)),
        "cell": lambda: take_lock(link.parents[1], "cell"),
    }
    with pytest.raises(
        OSError, match=r"it is a link, through which nothing is written|symbolic link"
    ):
        changes[what]()
    assert victim.read_text() == theirs


def test_a_data_set_is_written_the_same_way(tmp_path: Path) -> None:
    target, victim = planted(tmp_path, "a.npz")
    header = Header(
        game="coins", environment={"game": "coins"}, hash="0", policy="stay", policy_digest=None, seed=0, episodes=0, observation="none", planes=[],
        action_names=[], versions={},
    )  # fmt: skip
    with DatasetWriter(target, header):
        pass
    assert (victim.read_text(), target.is_file()) == ("theirs", True)


def test_formatting_through_a_link_formats_the_file(tmp_path: Path) -> None:
    real = tmp_path / "real.sj"
    real.write_text((ROOT / "games/coins.sj").read_text().replace("  kind", "    kind"))
    (tmp_path / "link.sj").symlink_to(real)
    assert run(["fmt", str(tmp_path / "link.sj")]) == 0
    assert (tmp_path / "link.sj").is_symlink()
    assert real.read_text() == (ROOT / "games/coins.sj").read_text()


def test_reading_stops_at_the_limit(tmp_path: Path) -> None:
    large = tmp_path / "large"
    with large.open("wb") as file:
        file.truncate(2**40)  # takes no room on the disk
    with pytest.raises(OSError, match="more than 1,000 bytes"):
        read_bytes(large, 1000)
    assert (
        read_bytes(large.with_name("small"), 4) == b"1234"
        if large.with_name("small").write_bytes(b"1234")
        else False
    )
    os.mkfifo(tmp_path / "pipe")
    for name in (tmp_path / "pipe", Path("/dev/zero"), tmp_path):
        with pytest.raises(OSError, match=r"regular file|directory"):
            read_bytes(name, 1000)


@pytest.mark.parametrize(
    "text", ["[" * 100_000, '{"a":' * 100_000, "1" * 5000, "", "nul", "{'a': 1}"]
)
def test_what_is_no_json_is_a_value_error(text: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"."):
        parse_json(text.encode())
    (tmp_path / "a.json").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=r"."):
        read_json(tmp_path / "a.json")


WRITES = {
    "write_text",
    "write_bytes",
    "replace",
    "truncate",
    "touch",
    "mkstemp",
    "NamedTemporaryFile",
}
MAY_WRITE = {
    "sjdsl/files.py",
    "sjdsl/studio/access.py",
}  # the others make files that must be new: O_EXCL


def calls(path: Path) -> set[str]:
    """Returns the functions and methods that a module calls on paths, by their last name."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            owner = node.func.value.id if isinstance(node.func.value, ast.Name) else ""
            if node.func.attr not in ("replace", "truncate") or owner == "os":
                found.add(node.func.attr)
        if (
            isinstance(node, ast.Call)
            and isinstance(node.func, ast.Name)
            and node.func.id == "open"
        ):
            modes = [a.value for a in node.args[1:2] if isinstance(a, ast.Constant)]
            found |= {"write_text"} if modes and set(str(modes[0])) & set("wxa+") else set()
    return found


def test_files_are_written_in_one_place() -> None:
    modules = [
        path for folder in ("sjdsl", "trainers") for path in sorted((ROOT / folder).rglob("*.py"))
    ]
    found = {path.relative_to(ROOT).as_posix() for path in modules if calls(path) & WRITES}
    assert found - MAY_WRITE == set()
