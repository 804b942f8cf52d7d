"""A run that would not fit is refused before it starts, and says what to make smaller."""

from pathlib import Path

import pytest
from probes import matching
from run_outcomes import SHORT, counting, read_manifest

from sjdsl.trainers import RunError, train
from sjdsl.trainers.runs import compiled, run


def test_what_does_not_fit_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "free_memory", lambda: 10)
    monkeypatch.setattr(run, "make_train", lambda *_: counting())
    with pytest.raises(
        RunError,
        match=r"an update needs .* MB of memory .* are free; make num_envs, num_steps, seeds or buffer_size smaller",
    ):
        train(matching(), SHORT, tmp_path / "run", "none")
    assert read_manifest(tmp_path / "run")["status"].startswith("failed: an update needs")
    assert not (tmp_path / "run" / "metrics.jsonl").exists()


def test_a_device_without_room_is_told_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What the device refuses while it runs, though it was thought to fit."""
    import jax

    compile_train = compiled.compile_train

    def refuse(*_: object) -> None:
        raise jax.errors.JaxRuntimeError(
            "RESOURCE_EXHAUSTED: Out of memory while trying to allocate 1 byte.\nmore"
        )

    monkeypatch.setattr(run, "make_train", lambda *_: counting())
    monkeypatch.setattr(
        run,
        "compile_train",
        lambda *given: compiled.Compiled(**{**vars(compile_train(*given)), "learn": refuse}),
    )
    with pytest.raises(
        RunError,
        match=r"^RESOURCE_EXHAUSTED: Out of memory.*1 byte\.; make num_envs, num_steps or seeds smaller",
    ):
        train(matching(), SHORT, tmp_path / "run", "none")


def test_free_memory_is_that_of_the_machine() -> None:
    said = {
        line.split(":")[0]: int(line.split()[1]) * 1024
        for line in Path("/proc/meminfo").read_text().splitlines()
    }
    assert 0 < compiled.free_memory() <= said["MemTotal"]
    assert 50 < compiled.peak_megabytes() < said["MemTotal"] / 1e6
