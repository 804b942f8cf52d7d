"""A run that was stopped, at whatever moment and by whatever, goes on to the end it would have had."""

import dataclasses
import errno
import json
import os
import shutil
import signal
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, TextIO

import jax
import pytest
from probes import matching
from run_outcomes import (
    SHORT,
    assert_same_end,
    compiled_once,
    copy_run,
    counting,
    read_lines,
    read_manifest,
)

from sjdsl.files import open_in_place
from sjdsl.termination import Terminated
from sjdsl.trainers import RunError, resume, train
from sjdsl.trainers.runs import metrics_files, recorder, run
from sjdsl.trainers.runs.checkpoints import Checkpoints
from sjdsl.trainers.runs.recorder import Recorder
from sjdsl.trainers.runs.updates import Loop

pytestmark = pytest.mark.usefixtures("shared")


@pytest.fixture(scope="module")
def stopped(shared: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same run as it lies there when its process was killed in update 8: checkpoints of 4 and 6, metrics until 7."""
    del shared
    run_dir = tmp_path_factory.mktemp("runs") / "stopped"
    _photograph(run_dir, run_dir.parent / "photographs", 7)
    return run_dir.parent / "photographs" / "7"


def _photograph(run_dir: Path, folder: Path, *updates: int) -> None:
    """Trains, and copies the folder of the run as it is when the metrics of some updates have been written."""
    append = Recorder.append

    def append_and_copy(self: Recorder, row: dict[str, Any]) -> None:
        append(self, row)
        if row["update"] in updates:
            copy_run(run_dir, folder / str(row["update"]))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Recorder, "append", append_and_copy)
        train(matching(), SHORT, run_dir, "none")


@pytest.mark.thorough
@pytest.mark.parametrize("evaluate_every", [0, pytest.param(3, marks=pytest.mark.slow)])
def test_a_run_goes_on_from_every_moment(tmp_path: Path, evaluate_every: int) -> None:
    """The folder is copied as it is around each of the writes from update 6 to 7, half-written files included."""
    config = SHORT.model_copy(update={"evaluate_every": evaluate_every})
    run_dir = tmp_path / "run"
    moments: list[Path] = []

    def copy_around(function: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any, **named: Any) -> Any:
            _copy()
            result = function(*arguments, **named)
            _copy()
            return result

        return call

    def _copy() -> None:
        lines = run_dir / "metrics.jsonl"
        if lines.exists() and 5 < len(lines.read_text().splitlines()) < 7:
            moments.append(copy_run(run_dir, tmp_path / f"moment_{len(moments)}"))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "replace", copy_around(os.replace))
        patch.setattr(recorder, "append_line", copy_around(metrics_files.append_line))
        patch.setattr(Checkpoints, "save", copy_around(Checkpoints.save))
        patch.setattr(Recorder, "evaluate", copy_around(Recorder.evaluate))
        train(matching(), config, run_dir, "none")
    different = {_content(moment): moment for moment in moments}
    assert len(different) > 8
    for moment in different.values():
        resume(matching(), moment, "none")
        assert_same_end(moment, run_dir)
    assert not list(moment.rglob("*.unfinished"))


def _content(folder: Path) -> tuple[tuple[str, bytes], ...]:
    return tuple(
        (str(path.relative_to(folder)), path.read_bytes())
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    )


def test_lines_that_were_cut_off_are_written_again(
    stopped: Path, whole: Path, tmp_path: Path
) -> None:
    """Of what follows the last checkpoint: that waits for what went before to be on the disk."""
    torn = copy_run(stopped, tmp_path / "torn")
    metrics = torn / "metrics.jsonl"
    metrics.write_bytes(metrics.read_bytes()[:-20])
    resume(matching(), torn, "none")
    assert_same_end(torn, whole)


@pytest.mark.parametrize(
    ("pressed_in", "signals", "raised"),
    [
        (5, [signal.SIGINT], KeyboardInterrupt),
        (6, [signal.SIGINT], KeyboardInterrupt),
        (5, [signal.SIGTERM], Terminated),
        (6, [signal.SIGTERM, signal.SIGTERM], Terminated),
    ],
)
def test_a_signal_ends_the_update_and_saves_it(
    tmp_path: Path,
    whole: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    pressed_in: int,
    signals: list[signal.Signals],
    raised: type[BaseException],
) -> None:
    """In update 5, after which no checkpoint is due, and in 6, after which one is; `timeout` sends its signal twice."""
    record = Loop._record

    def press(loop: Loop, rows: Any) -> None:
        for number in signals if rows[0]["update"] == pressed_in else ():
            os.kill(os.getpid(), number)
        record(loop, rows)

    monkeypatch.setattr(Loop, "_record", press)
    before = {number: signal.getsignal(number) for number in signals}
    run_dir = tmp_path / "run"
    with pytest.raises(raised) as stopped:
        train(matching(), SHORT, run_dir, "none")
    assert type(stopped.value) is raised
    assert {number: signal.getsignal(number) for number in signals} == before
    assert read_manifest(run_dir)["status"] == "interrupted"
    assert [row["update"] for row in read_lines(run_dir / "metrics.jsonl")] == list(
        range(1, pressed_in + 1)
    )
    assert (run_dir / "checkpoints" / f"{pressed_in}.safetensors").is_file()
    assert (run_dir / "learning_curve.png").exists()
    monkeypatch.setattr(Loop, "_record", record)
    resume(matching(), run_dir, "lines")
    assert f"resuming after update {pressed_in}\n" in capsys.readouterr().out
    assert_same_end(run_dir, whole)


def test_a_run_without_a_checkpoint_says_that_it_starts_again(
    tmp_path: Path, whole: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run_dir = copy_run(whole, tmp_path / "run")
    shutil.rmtree(run_dir / "checkpoints")
    resume(matching(), run_dir, "lines")
    assert "there is no checkpoint yet: starting again at update 1" in capsys.readouterr().out


def _flip(checkpoint: Path) -> None:
    content = bytearray(checkpoint.read_bytes())
    content[len(content) // 2] ^= 0xFF
    checkpoint.write_bytes(content)


def _empty(checkpoint: Path) -> None:
    checkpoint.write_bytes(b"")


@pytest.mark.thorough
@pytest.mark.parametrize("damage", [_flip, _empty], ids=lambda function: function.__name__)
def test_a_damaged_checkpoint_is_told_of_and_passed_over(
    stopped: Path, whole: Path, tmp_path: Path, damage: Callable[[Path], None]
) -> None:
    again = copy_run(stopped, tmp_path / "run")
    damage(again / "checkpoints" / "6.safetensors")
    with pytest.warns(
        UserWarning,
        match=r"checkpoints/6\.safetensors (is damaged|can't be read).*resuming from the one before",
    ):
        resume(matching(), again, "none")
    assert_same_end(again, whole)


def test_no_checkpoint_left_is_a_start_from_the_beginning(
    stopped: Path, whole: Path, tmp_path: Path
) -> None:
    again = copy_run(stopped, tmp_path / "run")
    for name in ("4", "6"):
        _flip(again / "checkpoints" / f"{name}.safetensors")
    with pytest.warns(UserWarning, match="resuming from the one before") as told:
        resume(matching(), again, "none")
    assert sum("resuming from the one before" in str(note.message) for note in told) == 2
    assert_same_end(again, whole)


@pytest.mark.thorough
def test_the_checkpoint_of_another_run_is_none_of_this_one(
    stopped: Path, whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its arrays have other shapes: that is said, and nothing goes wrong later."""
    other = tmp_path / "other"
    monkeypatch.setattr(run, "compile_train", _compile)
    monkeypatch.setattr(run, "make_train", lambda *_: counting())
    train(
        matching(),
        SHORT.model_copy(update={"evaluate_every": 0, "total_timesteps": 64 * 6}),
        other,
        "none",
    )
    monkeypatch.undo()
    again = copy_run(stopped, tmp_path / "run")
    shutil.copy(other / "checkpoints/6.safetensors", again / "checkpoints/6.safetensors")
    with pytest.warns(UserWarning, match="resuming from the one before"):
        resume(matching(), again, "none")
    assert_same_end(again, whole)


def _compile(program: Any, config: Any, parameters: Any) -> Any:
    from sjdsl.trainers.runs.compiled import compile_train

    return compile_train(program, config, parameters)


def _edit(run_dir: Path, **changes: Any) -> None:
    (run_dir / "manifest.json").write_text(json.dumps(read_manifest(run_dir) | changes))


def test_only_the_run_it_was_is_gone_on_with(stopped: Path, tmp_path: Path) -> None:
    again = copy_run(stopped, tmp_path / "run")
    before = _content(again)
    with pytest.raises(
        RunError,
        match=r"rules probe, and they are changed now; restore the file, or start a new run",
    ):
        resume(dataclasses.replace(matching(), hash="changed"), again, "none")
    with pytest.raises(RunError, match=r"other numbers of the game"):
        resume(dataclasses.replace(matching(), params=(1.0,)), again, "none")
    assert _content(again) == before, "a run that is refused is left as it was"
    _edit(again, versions=read_manifest(again)["versions"] | {"jax": "0.1.2"})
    with pytest.raises(
        RunError,
        match=rf"made with jax 0\.1\.2 \(here {jax.__version__}\).*install those, or start a new run",
    ):
        resume(matching(), again, "none")


@pytest.mark.parametrize(
    ("config", "named"),
    [
        ({"learning_rat": 1.0}, "learning_rat"),
        ({"algorithm": "sarsa"}, "sarsa"),
        ({"num_envs": -1}, "num_envs"),
        (None, "is not the folder of a training run"),
    ],
)
def test_a_manifest_with_another_configuration_is_refused(
    stopped: Path, tmp_path: Path, config: Any, named: str
) -> None:
    again = copy_run(stopped, tmp_path / "run")
    _edit(again, config=config)
    with pytest.raises(RunError, match=named):
        resume(matching(), again, "none")


@pytest.mark.parametrize(
    "text",
    [None, "", "{", "[]", "{}", '{"config": {}}', '{"game": 3, "config": {}, "versions": {}}'],
)
def test_what_is_no_run_is_refused(tmp_path: Path, text: str | None) -> None:
    if text is not None:
        (tmp_path / "manifest.json").write_text(text)
    with pytest.raises(RunError, match=r"is not the folder of a training run"):
        resume(matching(), tmp_path, "none")


def _full(*_: Any, **__: Any) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_disk_that_is_full_when_metrics_are_written(
    tmp_path: Path, whole: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Linux has a file that is always full; in update 6 the metrics are led into it."""

    def open_full(_: Path, mode: Any) -> TextIO:
        return open_in_place(Path("/dev/full"), mode)

    def lead_astray(path: Path, row: dict[str, Any]) -> None:
        if row["update"] == 6:
            patch.setattr(metrics_files, "open_in_place", open_full)
        metrics_files.append_line(path, row)

    run_dir = tmp_path / "run"
    with monkeypatch.context() as patch:
        patch.setattr(recorder, "append_line", lead_astray)
        with pytest.raises(
            RunError,
            match=r"metrics\.jsonl could not be written: No space left on device.*make room, and resume",
        ):
            train(matching(), SHORT, run_dir, "none")
    assert "No space left" in read_manifest(run_dir)["status"]
    resume(matching(), run_dir, "none")
    assert_same_end(run_dir, whole)


@pytest.mark.parametrize("name", ["checkpoints/6.safetensors", "policies/00000006.safetensors"])
def test_a_disk_that_is_full_when_a_checkpoint_is_written(
    tmp_path: Path, whole: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    from sjdsl import files

    run_dir = tmp_path / "run"
    replace = os.replace

    def replace_or_not(unfinished: Path, path: Path) -> None:
        if path == run_dir / name:
            _full()
        replace(unfinished, path)

    monkeypatch.setattr(files.os, "replace", replace_or_not)
    with pytest.raises(RunError, match=f"{name} could not be written: No space left on device"):
        train(matching(), SHORT, run_dir, "none")
    monkeypatch.undo()
    with compiled_once():
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # the checkpoint before is whole
            resume(matching(), run_dir, "none")
        assert_same_end(run_dir, whole)
