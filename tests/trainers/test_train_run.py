"""What a run leaves on disk, however it ends."""

import csv
import dataclasses
import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import optax
import pytest
from flax.training.train_state import TrainState as Learner
from probes import QUICK, matching

from sjdsl.trainers import Config, PolicyError, Result, RunError, Train, TrainState, evaluate, load_policy, run, train
from sjdsl.trainers.progress import show_progress
from sjdsl.trainers.run_folder import read_parameters

CONFIG = Config(**{**QUICK, "total_timesteps": 16 * 16 * 20, "checkpoint_every": 8, "seed": 5})


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Result:
    return train(matching(), CONFIG, tmp_path_factory.mktemp("runs") / "first", "none", {"game": "matching"})


def _manifest(run_dir: Path) -> dict[str, object]:
    return json.loads((run_dir / "manifest.json").read_text())


def _rows(run_dir: Path) -> list[dict[str, float]]:
    return [json.loads(line) for line in (run_dir / "metrics.jsonl").read_text().splitlines()]


def test_the_manifest_tells_how_to_repeat_the_run(result: Result) -> None:
    manifest = _manifest(result.run_dir)
    assert manifest["status"] == "finished"
    assert manifest["seed"] == 5
    assert Config(**manifest["config"]) == CONFIG
    assert manifest["provenance"] == {"game": "matching"}
    assert manifest["game"] == {
        "name": "matching",
        "hash": "probe",
        "params": {},
        "num_agents": 2,
        "action_names": ["action_0", "action_1"],
        "observation_shape": [2, 1, 1, 1],
    }
    assert manifest["versions"]["jax"] == jax.__version__
    assert manifest["device"]["platform"] == jax.devices()[0].platform
    assert manifest["seconds"] == pytest.approx(result.seconds, abs=1.0)


def test_metrics_have_one_row_an_update_in_both_files(result: Result) -> None:
    rows = _rows(result.run_dir)
    assert [row["update"] for row in rows] == list(range(1, 21))
    assert rows[-1]["env_steps"] == 16 * 16 * 20
    wanted = {"return", "return_agent_1", "shaped_return", "collective_return", "episodes", "entropy", "kl"}
    wanted |= {"clip_fraction", "explained_variance", "policy_loss", "value_loss", "steps_per_second"}
    wanted |= {"event_second_action_agent_0", "event_steps", "metric_step", "mean_step", "final_step", "equality"}
    assert wanted <= rows[0].keys()
    with open(result.run_dir / "metrics.csv", newline="") as table:
        read = [{name: float(value) if value else None for name, value in row.items()} for row in csv.DictReader(table)]
    assert read == rows


def test_the_learning_curve_is_drawn(result: Result) -> None:
    assert (result.run_dir / "learning_curve.png").read_bytes().startswith(b"\x89PNG")


def test_checkpoints_hold_the_parameters(result: Result) -> None:
    stored = sorted((result.run_dir / "checkpoints").iterdir())
    assert [path.name for path in stored if path.suffix == ".msgpack"] == [
        "00000008.msgpack",
        "00000016.msgpack",
        "00000020.msgpack",
    ]
    assert json.loads((result.run_dir / "checkpoints" / "00000016.json").read_text())["update"] == 16
    jax.tree.map(np.testing.assert_array_equal, read_parameters(stored[-1]), result.parameters)
    assert not list(result.run_dir.rglob("*.unfinished"))


def test_a_stored_policy_acts_as_it_learnt(result: Result) -> None:
    policy = load_policy(result.run_dir, matching())
    actions = policy(jax.random.key(0), jnp.zeros((2, 1, 1, 1), jnp.uint8))
    assert actions.dtype == jnp.int32
    assert actions.shape == (2,)
    sampled = evaluate(matching(), policy, jax.random.key(1), 200).returns.mean()
    greedy = evaluate(matching(), load_policy(result.run_dir, matching(), greedy=True), jax.random.key(1), 200)
    early = evaluate(matching(), load_policy(result.run_dir, matching(), update=8), jax.random.key(1), 200)
    assert greedy.returns.mean() == 1.0
    assert 0.6 < early.returns.mean() < sampled


def test_a_stored_policy_must_fit(result: Result, tmp_path: Path) -> None:
    with pytest.raises(PolicyError, match="2 actions"):
        load_policy(result.run_dir, dataclasses.replace(matching(), num_actions=3))
    with pytest.raises(PolicyError, match="no checkpoint of update 7, but of 8, 16, 20"):
        load_policy(result.run_dir, matching(), update=7)
    with pytest.raises(PolicyError, match="is no run folder"):
        load_policy(tmp_path, matching())
    with pytest.warns(UserWarning, match="another form of the game"):
        load_policy(result.run_dir, dataclasses.replace(matching(), hash="changed"))


def test_a_run_never_writes_over_another(result: Result) -> None:
    with pytest.raises(RunError, match="is not empty"):
        train(matching(), CONFIG, result.run_dir, "none")


def _quick_to_compile(diverges_after: int) -> Train:
    """Returns a run that learns nothing; its parameter counts the updates."""

    def init(key: jax.Array) -> TrainState:
        learner = Learner.create(apply_fn=None, params={"updates": jnp.zeros(())}, tx=optax.sgd(1.0))
        return TrainState(key, learner, None, jnp.int32(0))

    def update(state: TrainState) -> tuple[TrainState, dict[str, jax.Array]]:
        updates = state.updates + 1
        learner = state.learner.replace(params={"updates": updates.astype(jnp.float32)})
        loss = jnp.where(updates > diverges_after, jnp.nan, 1.0)
        metrics = {"episodes": updates, "collective_return": jnp.float32(2), "agent_return": jnp.ones(2), "loss": loss}
        return state.replace(learner=learner, updates=updates), metrics

    return Train(init, update)


def test_an_interrupted_run_keeps_what_it_has(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    @contextmanager
    def interrupt(*_: object) -> Iterator[object]:
        def show(row: dict[str, float]) -> None:
            if row["update"] == 3:
                assert len(_rows(tmp_path / "run")) == 3  # on disk already, should the process be killed
                raise KeyboardInterrupt

        yield show

    monkeypatch.setattr(run, "show_progress", interrupt)
    monkeypatch.setattr(run, "make_train", lambda *_: _quick_to_compile(diverges_after=100))
    with pytest.raises(KeyboardInterrupt):
        train(matching(), CONFIG, tmp_path / "run", "none")
    assert _manifest(tmp_path / "run")["status"] == "interrupted"
    assert [row["update"] for row in _rows(tmp_path / "run")] == [1, 2, 3]
    assert (tmp_path / "run" / "learning_curve.png").exists()
    assert read_parameters(tmp_path / "run" / "checkpoints" / "00000003.msgpack")["updates"] == 3.0


def test_a_diverged_run_stops_with_its_last_good_parameters(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "make_train", lambda *_: _quick_to_compile(diverges_after=4))
    with pytest.raises(RunError, match="the loss became nan in update 5"):
        train(matching(), CONFIG, tmp_path / "run", "none")
    assert "the loss became nan" in str(_manifest(tmp_path / "run")["status"])
    assert [row["loss"] for row in _rows(tmp_path / "run")] == [1.0, 1.0, 1.0, 1.0, None]
    (stored,) = (tmp_path / "run" / "checkpoints").glob("*.msgpack")
    assert read_parameters(stored)["updates"] == 4.0


def test_progress_in_plain_lines(capsys: pytest.CaptureFixture[str]) -> None:
    with show_progress("lines", 3, "a run") as show:
        for update, episodes in ((1, 0), (2, 4), (3, 0)):
            show(
                {
                    "update": update,
                    "env_steps": 1000 * update,
                    "seconds": 1.5 * update,
                    "steps_per_second": 5e4,
                    "episodes": episodes,
                    "collective_return": 7.25 if episodes else float("nan"),
                }
            )
    printed = capsys.readouterr().out.splitlines()  # the second update comes too soon after the first
    title, first, last = (" ".join(line.split()) for line in printed)
    assert title == "a run: compiling"
    assert first == "update 1/3 1,000 steps 50,000 steps/s 3 s left no episode finished yet"
    assert last == "update 3/3 3,000 steps 50,000 steps/s 0 s left collective return 7.2"
