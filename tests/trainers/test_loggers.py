"""Metrics handed to TensorBoard and to Weights & Biases, with stand-ins that take note."""

import importlib.machinery
import sys
import types
from pathlib import Path
from typing import Any

import pytest
from probes import matching
from run_outcomes import SHORT, counting

from sjdsl.extras import MissingExtra
from sjdsl.trainers import ConfigError, resume, train
from sjdsl.trainers.runs import run
from sjdsl.trainers.runs.loggers import check_loggers
from sjdsl.trainers.runs.run_errors import DiskError
from sjdsl.trainers.runs.updates import Update

UNEVALUATED = SHORT.model_copy(update={"evaluate_every": 0})
TWO_SEEDS = UNEVALUATED.model_copy(update={"seeds": 2})


def _stand_in(name: str, monkeypatch: pytest.MonkeyPatch, **members: Any) -> None:
    module = types.ModuleType(name)
    module.__spec__ = importlib.machinery.ModuleSpec(name, None)
    vars(module).update(members)
    monkeypatch.setitem(sys.modules, name, module)


def killed(update: Update) -> None:
    """A callback that ends a run as a process is ended that saves nothing more."""
    if update.number == 5:
        raise OSError("nothing more is saved")


@pytest.fixture(autouse=True)
def learns_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "make_train", lambda *_: counting())


def test_tensorboard_has_each_step_once_after_a_resume(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What was logged after the checkpoint that a run goes on from is purged, for it is logged again."""
    logged: list[tuple[int, list[int]]] = []

    class SummaryWriter:
        def __init__(self, folder: str, purge_step: int, filename_suffix: str) -> None:
            del filename_suffix
            Path(folder).mkdir(exist_ok=True)
            self.steps: list[int] = []
            logged.append((purge_step, self.steps))

        def add_scalar(self, name: str, _: float, step: int) -> None:
            if name == "loss":
                self.steps.append(step)

        def close(self) -> None: ...

    _stand_in("tensorboardX", monkeypatch, SummaryWriter=SummaryWriter)
    with pytest.raises(DiskError):
        train(
            matching(),
            UNEVALUATED,
            tmp_path / "run",
            "none",
            loggers=("tensorboard",),
            callback=killed,
        )
    resume(matching(), tmp_path / "run", "none")
    (first, before), (purge_step, after) = logged
    assert (first, before) == (1, [64 * update for update in range(1, 6)])
    assert [step for step in before if step < purge_step] + after == [
        64 * update for update in range(1, 13)
    ]


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
    train(matching(), TWO_SEEDS, tmp_path / "run", "none", loggers=("wandb",))
    assert [
        kept["name"].endswith(f"seed {seed}") for kept, seed in zip(runs, (5, 6), strict=True)
    ] == [True, True]
    for kept in runs:
        assert kept["finished"]
        assert [step for _, step in kept["logged"]] == [64 * update for update in range(1, 13)]
        assert kept["logged"][3][0]["collective_return"] == 2.0
        assert kept["config"]["seeds"] == 2
    resume(matching(), tmp_path / "run", "none")
    assert len(runs) == 4, "a run goes on with the loggers it was started with"
    assert {kept["reinit"] for kept in runs} == {"create_new"}, (
        "of several seeds in one process each has its own run"
    )
    assert [kept["id"] for kept in runs[2:]] == [kept["id"] for kept in runs[:2]], (
        "and is gone on with"
    )
    assert len({kept["id"] for kept in runs}) == 2
    resume(matching(), tmp_path / "run", "none", loggers=())
    assert len(runs) == 4, "unless others are asked for, or none"


@pytest.mark.parametrize(("name", "package"), [("tensorboard", "tensorboardX"), ("wandb", "wandb")])
def test_a_missing_package_is_told_of(
    name: str, package: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sjdsl.extras.find_spec", lambda _: None)
    with pytest.raises(
        MissingExtra, match=rf"the package {package} is needed: pip install 'sjdsl\[{name}\]'"
    ):
        check_loggers([name])


def test_an_unknown_logger_is_refused() -> None:
    with pytest.raises(ConfigError, match="unknown logger `mlflow`; known: tensorboard, wandb"):
        check_loggers(["mlflow"])
