"""What a run leaves on disk, however it ends."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.tree_util import keystr, tree_leaves_with_path
from probes import QUICK, matching
from run_outcomes import counting, read_lines, read_manifest
from safetensors.numpy import load_file

from sjdsl.trainers import (
    Result,
    RunError,
    evaluate,
    load_policy,
    make_config,
    resume,
    train,
)
from sjdsl.trainers.devices.device import device_name
from sjdsl.trainers.runs import recorder, run
from sjdsl.trainers.runs.compiled import compile_train
from sjdsl.trainers.runs.learning_curve import draw_learning_curve
from sjdsl.trainers.runs.progress import ProgressStyle, show_progress

CONFIG = make_config(
    {
        **QUICK,
        "total_timesteps": 16 * 16 * 20,
        "checkpoint_updates": 8,
        "policy_every": 8,
        "seed": 5,
    }
)


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Result:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(recorder, "draw_learning_curve", draw_learning_curve)
        return train(
            matching(),
            CONFIG,
            tmp_path_factory.mktemp("runs") / "first",
            "none",
            {"game": "matching"},
        )


def test_the_manifest_tells_how_to_repeat_the_run(result: Result) -> None:
    manifest = read_manifest(result.run_dir)
    assert manifest["status"] == "finished"
    assert manifest["seed"] == 5
    assert make_config(manifest["config"]) == CONFIG
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
    device = jax.devices()[0]
    assert manifest["device"] == {
        "platform": device.platform,
        "kind": device_name(device),
        "count": jax.device_count(),
    }
    assert manifest["device"]["kind"] not in ("", "cpu"), "a report must tell processors apart"
    assert 0 < manifest["compile_seconds"] < manifest["seconds"] == result.seconds
    assert 0 < manifest["program_megabytes"] < manifest["peak_megabytes"]


def test_a_run_starts_though_jax_has_dropped_what_it_traced() -> None:
    compiled = compile_train(counting(), CONFIG)
    jax.clear_caches()
    assert jax.tree.structure(compiled.start()) == jax.tree.structure(compiled.state)


def test_metrics_have_one_row_an_update(result: Result) -> None:
    rows = read_lines(result.run_dir / "metrics.jsonl")
    assert [row["update"] for row in rows] == list(range(1, 21))
    assert rows[-1]["env_steps"] == 16 * 16 * 20
    wanted = {
        "return",
        "return_agent_1",
        "shaped_return",
        "collective_return",
        "episodes",
        "entropy",
        "kl",
    }
    wanted |= {
        "clip_fraction",
        "explained_variance",
        "policy_loss",
        "value_loss",
        "steps_per_second",
    }
    wanted |= {
        "event_second_action_agent_0",
        "event_steps",
        "metric_step",
        "mean_step",
        "final_step",
        "equality",
    }
    assert wanted <= rows[0].keys()


def test_the_learning_curve_is_drawn(result: Result) -> None:
    assert (result.run_dir / "learning_curve.png").read_bytes().startswith(b"\x89PNG")


def test_policies_and_checkpoints_are_kept(result: Result) -> None:
    policies = result.run_dir / "policies"
    assert {path.stem for path in policies.iterdir()} == {
        "00000008",
        "00000016",
        "00000020",
        "last",
        "best",
    }
    assert json.loads((policies / "00000016.json").read_text())["update"] == 16
    stored = load_file(policies / "last.safetensors")
    trained = {keystr(place): leaf for place, leaf in tree_leaves_with_path(result.parameters)}
    assert stored.keys() == trained.keys()
    for name, leaf in trained.items():
        np.testing.assert_array_equal(stored[name], leaf)
    assert sorted(path.name for path in (result.run_dir / "checkpoints").iterdir()) == [
        "16.safetensors",
        "20.safetensors",
    ], "the last two"
    assert not list(result.run_dir.rglob("*.unfinished"))


@pytest.mark.thorough
def test_a_stored_policy_acts_as_it_learnt(result: Result) -> None:
    policy = load_policy(result.run_dir, matching())
    actions = policy(jax.random.key(0), jnp.zeros((2, 1, 1, 1), jnp.uint8))
    assert actions.dtype == jnp.int32
    assert actions.shape == (2,)
    sampled = evaluate(matching(), policy, jax.random.key(1), 200).returns.mean()
    greedy = evaluate(
        matching(), load_policy(result.run_dir, matching(), greedy=True), jax.random.key(1), 200
    )
    early = evaluate(
        matching(), load_policy(result.run_dir, matching(), which=8), jax.random.key(1), 200
    )
    assert greedy.returns.mean() == 1.0
    assert 0.6 < early.returns.mean() < sampled


def test_a_run_never_writes_over_another(result: Result) -> None:
    with pytest.raises(RunError, match="is not empty"):
        train(matching(), CONFIG, result.run_dir, "none")


def _updates_of(run_dir: Path, name: str) -> float:
    """Returns what `counting` keeps as its parameter."""
    return load_file(run_dir / "policies" / f"{name}.safetensors")["['updates']"].item()


def test_an_interrupted_run_keeps_what_it_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    @contextmanager
    def interrupt(*_: object) -> Iterator[object]:
        def show(row: dict[str, float], _: object) -> None:
            if row["update"] == 3:
                assert (
                    len(read_lines(tmp_path / "run" / "metrics.jsonl")) == 3
                )  # on disk already, should the process be killed
                raise KeyboardInterrupt

        yield show

    monkeypatch.setattr(run, "show_progress", interrupt)
    monkeypatch.setattr(run, "make_train", lambda *_: counting())
    with pytest.raises(KeyboardInterrupt):
        train(matching(), CONFIG, tmp_path / "run", "none")
    assert read_manifest(tmp_path / "run")["status"] == "interrupted"
    assert [row["update"] for row in read_lines(tmp_path / "run" / "metrics.jsonl")] == [1, 2, 3]
    assert (tmp_path / "run" / "learning_curve.png").exists()
    assert _updates_of(tmp_path / "run", "last") == 3.0


@pytest.mark.parametrize(
    ("changes", "folders", "named"),
    [({"seed": 0}, [""], "seed 0"), ({"seeds": 2}, ["seed_5", "seed_6"], "seeds 5 and 6")],
)
def test_a_diverged_run_stops_with_its_last_good_parameters(
    changes: dict[str, int],
    folders: list[str],
    named: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With several seeds, as the last of them diverges."""
    program = counting(diverges_after=9, seed_that_diverges=None)
    monkeypatch.setattr(run, "make_train", lambda *_: program)
    said = f"the loss became nan in update 10 of {named}; the policy of update 9 is kept.*smaller learning_rate"
    with pytest.raises(RunError, match=said):
        train(matching(), CONFIG.model_copy(update=changes), tmp_path, "none")
    assert str(read_manifest(tmp_path)["status"]).startswith("failed: the loss became nan")
    for folder in (tmp_path / name for name in folders):
        rows = read_lines(folder / "metrics.jsonl")
        assert [row["loss"] for row in rows] == [1.0] * 9 + [None]
        for name, updates in (("last", 9.0), ("00000009", 9.0), ("00000008", 8.0)):
            assert _updates_of(folder, name) == updates
    kept = [path.name for path in (tmp_path / "checkpoints").iterdir()]
    assert kept == ["8.safetensors"], "what diverged is not gone on from"


@pytest.mark.thorough
def test_parameters_that_are_not_finite_are_never_kept(tmp_path: Path) -> None:
    """A real run whose steps are absurd: whatever is stored can be played."""
    config = CONFIG.model_copy(
        update={"learning_rate": 1e38, "max_gradient_norm": 1e38, "anneal_learning_rate": False}
    )
    with pytest.raises(
        RunError,
        match=r"the loss became nan in update \d+.*Try a smaller learning_rate than 1e\+38",
    ):
        train(matching(), config, tmp_path / "run", "none")
    for tensor in load_file(tmp_path / "run" / "policies" / "last.safetensors").values():
        assert np.isfinite(tensor).all()


def test_one_seed_of_several_that_diverges_stops_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The others go on, also after a resume, and the manifest says which stopped."""
    monkeypatch.setattr(
        run, "make_train", lambda *_: counting(diverges_after=9, seed_that_diverges=6)
    )
    run_dir = tmp_path / "run"
    result = train(matching(), CONFIG.model_copy(update={"seeds": 3}), run_dir, "none")
    assert sorted(path.name for path in run_dir.glob("seed_*")) == ["seed_5", "seed_6", "seed_7"]
    manifest = read_manifest(run_dir)
    assert (manifest["status"], manifest["diverged"], manifest["updates"]) == (
        "finished",
        [{"seed": 6, "update": 10}],
        20,
    )
    assert result.diverged == {6: 10}
    assert _updates_of(run_dir / "seed_6", "last") == 9.0
    assert [row["loss"] for row in read_lines(run_dir / "seed_6" / "metrics.jsonl")] == [
        1.0
    ] * 9 + [None]
    for other in ("seed_5", "seed_7"):
        assert _updates_of(run_dir / other, "last") == 20.0
        assert [row["loss"] for row in read_lines(run_dir / other / "metrics.jsonl")] == [1.0] * 20
    assert [row["loss"] for row in result.rows] == [1.0] * 20, "means are of the seeds that learn"
    again = resume(matching(), run_dir, "none")
    assert again.diverged == {6: 10}
    assert len(read_lines(run_dir / "seed_6" / "metrics.jsonl")) == 10


def _show_three_updates(style: ProgressStyle) -> None:
    with show_progress(style, 3, "a run", seeds=2) as show:
        for update, episodes in ((1, 0), (2, 4), (3, 0)):
            show(
                {
                    "update": update,
                    "env_steps": 1000 * update,
                    "seconds": 1.5 * update,  # both seeds take 2,000 steps in them
                    "steps_per_second": 5e4,
                    "rollout_share": 0.25,
                    "episodes": episodes,
                    "collective_return": 7.25 if episodes else float("nan"),
                    "before_learning": 3.0,
                    "entropy": 1.25,
                    "kl": 0.004,
                },
                ["nobody was rewarded"] if update == 2 else [],
            )


def test_progress_in_plain_lines(capsys: pytest.CaptureFixture[str]) -> None:
    _show_three_updates("lines")
    printed = (
        capsys.readouterr().out.splitlines()
    )  # the second update comes too soon after the first
    title, first, warning, last = (" ".join(line.split()) for line in printed)
    assert title == "a run: compiling"
    assert (
        first
        == "update 1/3 1,000 steps 1,333 steps/s acting 25 % of the time, learning 75 % 3 s left no episode has ended yet, entropy 1.25, KL 0.004"
    )
    assert warning == "warning: nobody was rewarded", "also in an update that is not shown"
    assert last.endswith(
        "learning 75 % 0 s left collective return 7.2 (before learning 3.0), entropy 1.25, KL 0.004"
    )
