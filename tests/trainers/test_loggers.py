"""Metrics handed to TensorBoard and to Weights & Biases, which are not installed here: stand-ins take note."""

import importlib.machinery
import sys
import types
from pathlib import Path
from typing import Any

import pytest
from probes import matching
from run_outcomes import SHORT, compiled_once, counting, read_lines

from sjdsl.trainers import ConfigError, resume, run, train
from sjdsl.trainers.loggers import check_loggers


def _stand_in(name: str, monkeypatch: pytest.MonkeyPatch, **members: Any) -> None:
    module = types.ModuleType(name)
    module.__spec__ = importlib.machinery.ModuleSpec(name, None)
    vars(module).update(members)
    monkeypatch.setitem(sys.modules, name, module)


@pytest.mark.slow
def test_tensorboard_gets_every_number_with_its_step(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written: dict[str, list[tuple[str, float, int]]] = {}
    closed: list[str] = []

    class SummaryWriter:
        def __init__(self, folder: str) -> None:
            self.folder = folder

        def add_scalar(self, name: str, value: float, step: int) -> None:
            written.setdefault(self.folder, []).append((name, value, step))

        def close(self) -> None:
            closed.append(self.folder)

    _stand_in("tensorboardX", monkeypatch, SummaryWriter=SummaryWriter)
    with compiled_once():
        run_dir = train(matching(), SHORT, tmp_path / "run", "none", loggers=("tensorboard",)).run_dir
    folder = str(run_dir / "tensorboard")
    assert closed == [folder]
    noted = written[folder]
    wanted = [
        (name, value, row["env_steps"])
        for row in read_lines(run_dir / "metrics.jsonl")
        for name, value in row.items()
        if name not in ("update", "env_steps") and value is not None
    ]
    assert [entry for entry in noted if entry[0] != "evaluation_collective_return"] == wanted
    evaluated = [(row["collective return"]["mean"], row["env_steps"]) for row in read_lines(run_dir / "evaluations.jsonl")]
    assert [entry[1:] for entry in noted if entry[0] == "evaluation_collective_return"] == evaluated


def test_wandb_gets_a_run_for_each_seed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    runs: list[dict[str, Any]] = []

    class Run:
        def __init__(self, **named: Any) -> None:
            self.kept = {**named, "logged": [], "finished": False}
            runs.append(self.kept)

        def log(self, numbers: dict[str, float], step: int) -> None:
            self.kept["logged"].append((numbers, step))

        def finish(self) -> None:
            self.kept["finished"] = True

    _stand_in("wandb", monkeypatch, init=lambda **named: Run(**named))
    monkeypatch.setattr(run, "make_train", lambda *_: counting())
    config = SHORT.model_copy(update={"seeds": 2, "evaluate_every": 0})
    train(matching(), config, tmp_path / "run", "none", loggers=("wandb",))
    assert [kept["name"].endswith(f"seed {seed}") for kept, seed in zip(runs, (5, 6), strict=True)] == [True, True]
    for kept in runs:
        assert kept["finished"]
        assert [step for _, step in kept["logged"]] == [64 * update for update in range(1, 13)]
        assert kept["logged"][3][0]["collective_return"] == 2.0
        assert kept["config"]["seeds"] == 2
    resume(matching(), tmp_path / "run", "none")
    assert len(runs) == 4, "a run goes on with the loggers it was started with"
    resume(matching(), tmp_path / "run", "none", loggers=())
    assert len(runs) == 4, "unless others are asked for, or none"


@pytest.mark.parametrize(("name", "package"), [("tensorboard", "tensorboardX"), ("wandb", "wandb")])
def test_a_missing_package_is_told_of(name: str, package: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    with pytest.raises(ConfigError, match=rf"`{name}` needs the package {package}: pip install 'sjdsl\[{name}\]'"):
        check_loggers([name])


def test_an_unknown_logger_is_refused() -> None:
    with pytest.raises(ConfigError, match="unknown logger `mlflow`; known: tensorboard, wandb"):
        check_loggers(["mlflow"])
