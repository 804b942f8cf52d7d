"""Runs that differ in numbers without shape, as one program: the same folders as those of runs trained apart."""

import json
import shutil
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest
from run_outcomes import OF_THE_CLOCK, read_lines, read_manifest
from safetensors.numpy import load_file

import sjdsl
from sjdsl.trainers import RunError, Update, compiled, make_config, train
from sjdsl.trainers.compiled import NoMemoryError
from sjdsl.trainers.run import Run, train_side_by_side
from sjdsl.trainers.run_errors import TooLargeError
from sjdsl.trainers.side_by_side import TRACED, kind_of

GAME = Path(__file__).parent / "games" / "prisoners_dilemma.sj"
TINY: dict[str, Any] = {"network": "mlp", "network_width": 4, "num_envs": 4, "num_steps": 4, "num_minibatches": 1, "num_epochs": 1}
TINY |= {"total_timesteps": 16 * 6, "checkpoint_updates": 2, "policy_every": 3, "seeds": 2, "reward": "svo"}
FIGURES = 1e-4  # how far metrics of both ways may differ: the rounding of two programs, over six updates


@pytest.fixture(autouse=True)
def no_key_check() -> Any:
    """JAX takes the keys of any vmapped scan for used."""
    with jax.debug_key_reuse(False):
        yield


def payoffs(defect: float) -> Any:
    return sjdsl.make(GAME, params={"payoff": {"defect": {"cooperate": defect}}})


def the_runs(folder: Path) -> list[Run]:
    """Two runs that differ in the game, the learning rate, the reward and their seeds."""
    configs = [
        make_config(TINY, svo_weight=0.2, learning_rate=1e-3, seed=3),
        make_config(TINY, svo_weight=0.9, svo_angle=30, learning_rate=5e-3, clip_epsilon=0.1),
    ]
    return [Run(payoffs(4.0 + number), config, folder / str(number)) for number, config in enumerate(configs)]


@pytest.fixture(scope="module")
def together(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("together")

    def copy(update: Update) -> None:
        if update.number == 5:  # as a process that is killed then leaves it: the last checkpoint is of update 4
            shutil.copytree(update.run_dir, folder / "killed" / update.run_dir.name)

    with jax.debug_key_reuse(False):
        train_side_by_side(the_runs(folder), "none", copy)
    return folder


@pytest.mark.thorough
def test_as_apart(together: Path, tmp_path: Path) -> None:
    own = the_runs(tmp_path)[1]
    train(own.env, own.config, own.run_dir, "none")
    check_alike(own, together / "1")


@pytest.mark.thorough
def test_under_vmap_as_apart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As on a GPU; on a CPU the lanes of PPO learn one after the other."""
    asked: list[Any] = []
    monkeypatch.setattr(compiled, "one_after_the_other", lambda function: (asked.append(function), jax.vmap(function))[1])
    train_side_by_side(the_runs(tmp_path / "together"), "none")
    assert asked
    monkeypatch.undo()
    own = the_runs(tmp_path)[1]
    train(own.env, own.config, own.run_dir, "none")
    check_alike(own, tmp_path / "together" / "1")


def check_alike(own: Run, beside: Path) -> None:
    """Compares a run that was trained apart with one that was trained beside another, to rounding."""
    apart = own.run_dir
    assert names_in(apart) == names_in(beside)
    for seed in map(str, own.config.seed_numbers):
        for left, right in zip(*(read_lines(folder / f"seed_{seed}" / "metrics.jsonl") for folder in (apart, beside)), strict=True):
            assert left.keys() == right.keys()
            numbers = [name for name in left if name not in OF_THE_CLOCK and left[name] is not None]
            np.testing.assert_allclose([left[name] for name in numbers], [right[name] for name in numbers], rtol=FIGURES, atol=FIGURES)
        tensors = [load_file(folder / f"seed_{seed}" / "policies" / "last.safetensors") for folder in (apart, beside)]
        assert tensors[0].keys() == tensors[1].keys()
        for name in tensors[0]:
            np.testing.assert_allclose(tensors[0][name], tensors[1][name], rtol=FIGURES, atol=FIGURES)
    left, right = read_manifest(apart), read_manifest(beside)
    assert right.pop("together") == 2
    of_the_clock = ("started", "seconds", "compile_seconds", "program_megabytes", "peak_megabytes")
    assert {key: value for key, value in left.items() if key not in of_the_clock} == {
        key: value for key, value in right.items() if key not in of_the_clock
    }


def names_in(folder: Path) -> list[str]:
    """Returns the files of a run, but for what is inside a checkpoint."""
    paths = sorted(path.relative_to(folder) for path in folder.rglob("*"))
    return [str(path) for path in paths if "checkpoints" not in path.parts[:-2]]


@pytest.mark.thorough
def test_runs_differ_as_their_numbers_do(together: Path) -> None:
    for number, seed, rate in ((0, 3, 1e-3), (1, 0, 5e-3)):
        rows = read_lines(together / str(number) / f"seed_{seed}" / "metrics.jsonl")
        assert rows[1]["learning_rate"] == pytest.approx(rate * 5 / 6)


@pytest.mark.thorough
def test_stopped_runs_go_on_side_by_side(together: Path, tmp_path: Path) -> None:
    """One of them has a checkpoint more, as one that is written last when a process is killed: it goes back to the one of both."""
    for number in (0, 1):
        shutil.copytree(together / "killed" / str(number), tmp_path / str(number))
    shutil.rmtree(tmp_path / "1" / "checkpoints" / "4")
    train_side_by_side(the_runs(tmp_path), "none")
    for number, own in enumerate(the_runs(tmp_path)):
        assert read_manifest(tmp_path / str(number))["status"] == "finished"
        for seed in own.config.seed_numbers:
            rows = [read_lines(folder / str(number) / f"seed_{seed}" / "metrics.jsonl") for folder in (together, tmp_path)]
            clean = [[{name: row[name] for name in row if name not in OF_THE_CLOCK} for row in lines] for lines in rows]
            assert clean[0] == clean[1]


def test_kinds() -> None:
    env = payoffs(4.0)
    first = make_config(TINY)
    for key in TRACED:
        if key in type(first).model_fields:
            now = getattr(first, key)
            other = first.model_copy(update={key: (45.0,) if isinstance(now, tuple) else now / 2 + 0.11})
            assert getattr(other, key) != now, key
            assert kind_of(env, other) == kind_of(payoffs(5.0), first), key
    for changes in ({"num_epochs": 2}, {"network_width": 8}, {"reward": "individual"}, {"svo_angle": (0, 90)}, {"seeds": 3}):
        assert kind_of(env, make_config(TINY | changes)) != kind_of(env, first), changes


def test_what_is_no_kind_is_refused(tmp_path: Path) -> None:
    runs = [Run(payoffs(4.0), make_config(TINY, num_epochs=epochs), tmp_path / str(epochs)) for epochs in (1, 2)]
    with pytest.raises(RunError, match="only in seeds and in numbers without shape"):
        train_side_by_side(runs, "none")
    assert [*tmp_path.iterdir()] == []


@pytest.mark.thorough
def test_runs_that_are_not_equally_far_are_refused(together: Path, tmp_path: Path) -> None:
    shutil.copytree(together / "killed" / "0", tmp_path / "0")
    with pytest.raises(RunError, match="stopped at different updates"):
        train_side_by_side(the_runs(tmp_path), "none")


def test_runs_that_do_not_fit_are_told_apart_from_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: Any) -> None:
        raise NoMemoryError("too much")

    monkeypatch.setattr("sjdsl.trainers.run.compile_parts", full)
    with pytest.raises(TooLargeError, match="too much"):
        train_side_by_side(the_runs(tmp_path), "none")
    assert json.loads((tmp_path / "0" / "manifest.json").read_text())["status"] == "failed: too much"


OTHERS: dict[str, dict[str, Any]] = {
    "vdn": {"algorithm": "vdn", "buffer_size": 64, "batch_size": 8, "learning_starts": 16, "num_steps": 4, "network_width": 4},
    "mappo": {**TINY, "algorithm": "mappo", "critic": "state", "reward": "inequity", "scale_clip_epsilon": True},
    "own networks with memory": {**TINY, "sharing": "per_agent", "memory": "gru"},
    "roles": {**TINY, "sharing": "by_role", "roles": (0, 1), "reward": "exchange"},
}
DIFFERENT: dict[str, dict[str, Any]] = {
    "vdn": {"epsilon_end": 0.3, "epsilon_fraction": 0.7, "target_rate": 0.5, "learning_rate": 1e-2, "gamma": 0.5},
    "mappo": {"inequity_envy": 1.0, "inequity_smoothing": 0.2, "max_gradient_norm": 0.1, "clip_epsilon": 0.4},
    "own networks with memory": {"entropy_coefficient": 0.3, "gae_lambda": 0.2, "reward_smoothing": 0.5},
    "roles": {"exchange_ratio": 0.9, "value_coefficient": 2.0},
}


@pytest.mark.slow
@pytest.mark.parametrize("name", OTHERS)
def test_other_programs_as_apart(tmp_path: Path, name: str) -> None:
    """One seed each; the second run has other numbers than the first."""
    base = {**OTHERS[name], "network": "mlp", "num_envs": 4, "total_timesteps": 16 * 6, "seeds": 1}
    configs = [make_config(base), make_config(base, seed=7, **DIFFERENT[name])]
    runs = [Run(payoffs(4.0), config, tmp_path / "together" / str(number)) for number, config in enumerate(configs)]
    train_side_by_side(runs, "none")
    train(payoffs(4.0), configs[1], tmp_path / "apart", "none")
    apart, beside = (read_lines(folder / "metrics.jsonl") for folder in (tmp_path / "apart", runs[1].run_dir))
    for left, right in zip(apart, beside, strict=True):
        numbers = [key for key in left if key not in OF_THE_CLOCK and left[key] is not None]
        np.testing.assert_allclose([left[key] for key in numbers], [right[key] for key in numbers], rtol=1e-3, atol=FIGURES)
    assert read_lines(runs[0].run_dir / "metrics.jsonl")[-1]["loss"] != pytest.approx(beside[-1]["loss"])
