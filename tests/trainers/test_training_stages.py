"""Runs in stages: each continues from the policies of the one before, and one that was stopped ends as one that wasn't."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest
from probes import QUICK, matching
from run_outcomes import assert_same_end, copy_run, counting, read_lines, read_manifest

from sjdsl.trainers import (
    Config,
    ConfigError,
    RunError,
    Stage,
    Train,
    check_stages,
    load_preset,
    make_config,
    resume,
    train,
)
from sjdsl.trainers.runs import run
from sjdsl.trainers.runs.curves import read_seeds
from sjdsl.trainers.runs.learning_curve import curve_panels
from sjdsl.trainers.runs.metrics_files import run_rows
from sjdsl.trainers.runs.recorder import Recorder

SMALL = {
    **QUICK,
    "num_steps": 4,
    "network_width": 8,
    "checkpoint_updates": 2,
    "policy_every": 2,
    "seed": 5,
}


def config(updates: int, num_envs: int = 8, **changes: Any) -> Config:
    """Returns the configuration of a stage of so many updates."""
    return make_config(
        {
            **SMALL,
            "num_envs": num_envs,
            "total_timesteps": updates * num_envs * SMALL["num_steps"],
            **changes,
        }
    )


def stages() -> tuple[Stage, Stage, Stage]:
    """Returns three stages, with three agents, then two; with rollouts of 64, then 32 environment steps."""
    return (
        Stage(matching(3), config(3, num_envs=16)),
        Stage(matching(2), config(2, reward="common")),
        Stage(matching(2), config(5)),
    )


def adding(diverges_after: int = 1_000_000) -> Train:
    """Returns a run that compiles at once and adds 1 to its parameter in each update; seed 5 may diverge."""
    base = counting(diverges_after, seed_that_diverges=5)

    def learn(state: Any, played: Any) -> Any:
        after, metrics = base.learn(state, played)
        learnt = state.learner["updates"] + jax.numpy.where(after.diverged, 0.0, 1.0)
        return after.replace(learner={"updates": learnt}), metrics

    return replace(
        base, learn=learn, adopt=lambda state, parameters: state.replace(learner=parameters)
    )


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    _be_quick(monkeypatch, adding())


def _be_quick(patch: pytest.MonkeyPatch, program: Train) -> None:
    """Has all runs be `program`."""
    patch.setattr(run, "make_train", lambda *_: program)
    patch.setattr(
        run, "parameter_shapes", lambda *_: {"updates": jax.ShapeDtypeStruct((), "float32")}
    )


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A run that nothing stopped, and copies of its folder as it was after updates of its stages: `STAGE_UPDATE`."""
    folder = tmp_path_factory.mktemp("runs")
    run_dir, append = folder / "whole", Recorder.append
    *earlier, last = stages()

    def append_and_copy(self: Recorder, row: dict[str, Any]) -> None:
        append(self, row)
        copy_run(run_dir, folder / f"{row['stage']}_{row['update']}")

    with pytest.MonkeyPatch.context() as patch:
        _be_quick(patch, adding())
        patch.setattr(Recorder, "append", append_and_copy)
        result = train(last.env, last.config, run_dir, "none", earlier=earlier)
    assert float(result.parameters["updates"]) == 3 + 2 + 5
    return run_dir, folder


def test_rows_go_on_from_stage_to_stage(whole: tuple[Path, Path]) -> None:
    run_dir, _ = whole
    steps = [64, 128, 192, 224, 256, 288, 320, 352, 384, 416]
    assert [(row["stage"], row["env_steps"]) for row in run_rows(run_dir)] == [
        *zip([1] * 3 + [2] * 2 + [3] * 5, steps, strict=True)
    ]
    assert [row["stage"] for row in read_lines(run_dir / "metrics.jsonl")] == [3] * 5
    (seed,) = read_seeds(run_dir, "return")
    assert seed[0].tolist() == steps
    manifest = read_manifest(run_dir)
    assert (manifest["status"], manifest["stages"], manifest["game"]["num_agents"]) == (
        "finished",
        ["stages/1", "stages/2"],
        2,
    )
    assert [read_manifest(run_dir / stage)["status"] for stage in manifest["stages"]] == [
        "finished"
    ] * 2
    assert read_manifest(run_dir / "stages/1")["game"]["num_agents"] == 3


def test_the_curve_shows_where_stages_begin(whole: tuple[Path, Path]) -> None:
    rows = list(run_rows(whole[0]))
    panels = curve_panels(rows)
    assert {panel.marks for panel in panels} == {(224, 288)}
    returns = [row["collective_return"] for row in rows]
    assert (
        panels[0].lines[1].values.tolist() == [returns[0]] * 3 + [returns[3]] * 2 + [returns[5]] * 5
    )


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("moment", ["1_1", "1_3", "2_1", "2_2", "3_1", "3_4"])
def test_a_run_that_was_killed_ends_as_one_that_was_not(
    whole: tuple[Path, Path], moment: str
) -> None:
    run_dir, folder = whole
    environments = [stage.env for stage in stages()]
    assert read_manifest(folder / moment)["status"] == "running"
    resume(environments[2], folder / moment, "none", earlier=environments[:2])
    for part in ("stages/1", "stages/2", ""):
        assert_same_end(folder / moment / part, run_dir / part)


@pytest.mark.thorough
@pytest.mark.parametrize("seeds", [1, 2])
def test_a_stage_starts_from_the_policies_of_the_one_before(tmp_path: Path, seeds: int) -> None:
    """A last stage that learns next to nothing ends with the parameters of the one before, those of each seed."""
    first, last = (config(2, seeds=seeds, learning_rate=rate) for rate in (1e-2, 1e-30))
    result = train(matching(2), last, tmp_path / "run", "none", earlier=[Stage(matching(3), first)])
    alone = train(matching(3), first, tmp_path / "alone", "none")
    jax.tree.map(np.testing.assert_array_equal, result.parameters, alone.parameters)


@pytest.mark.usefixtures("quick")
def test_a_callback_ends_the_run_in_its_stage(tmp_path: Path, whole: tuple[Path, Path]) -> None:
    *earlier, last = stages()
    run_dir = tmp_path / "run"
    result = train(
        last.env,
        last.config,
        run_dir,
        "none",
        callback=lambda update: update.env_steps == 128,
        earlier=earlier,
    )
    assert (result.run_dir, result.updates) == (run_dir / "stages/1", 2)
    assert read_manifest(run_dir)["status"] == "stopped by its callback after update 2"
    with pytest.raises(RunError, match=r"is stage 1 of a run: resume .*run$"):
        resume(earlier[0].env, run_dir / "stages/1", "none")
    with pytest.raises(
        RunError, match="has 3 stages: `earlier` must have the environments of the first 2"
    ):
        resume(last.env, run_dir, "none")
    resume(last.env, run_dir, "none", earlier=[stage.env for stage in earlier])
    assert_same_end(run_dir, whole[0])


def test_a_seed_that_diverges_ends_the_run_with_its_stage(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its last policy is kept, and those of the other seeds."""
    _be_quick(monkeypatch, adding(diverges_after=1))
    with pytest.raises(
        RunError,
        match=r"stage 1: the loss became nan in update 2 of seed 5; .* The next stage starts only if no seed",
    ):
        train(
            matching(2),
            config(2, seeds=2),
            tmp_path / "run",
            "none",
            earlier=[Stage(matching(2), config(3, seeds=2))],
        )
    assert (tmp_path / "run/stages/1/seed_6/policies/last.safetensors").is_file()
    assert not (tmp_path / "run/checkpoints").exists()
    assert read_manifest(tmp_path / "run")["status"].startswith("failed: stage 1")


@pytest.mark.parametrize(
    ("first", "last", "message"),
    [
        (
            {"network_width": 8},
            {"network_width": 16},
            r"stages\[2\]: `network_width` can't change from stage to stage: it is 8 before, and 16",
        ),
        ({"seed": 1}, {"seed": 2}, r"stages\[2\]: `seed` can't change"),
        ({"memory": "gru"}, {}, r"stages\[2\]: `memory` can't change"),
        (
            {"sharing": "per_agent"},
            {"sharing": "per_agent"},
            r"stages\[2\]: its networks .*`sharing=per_agent`.* number of agents, 3 before and 2 here",
        ),
        (
            {"algorithm": "mappo"},
            {"algorithm": "mappo"},
            r"stages\[2\]: .*a critic of all .*, the number of agents, 3 before and 2 here",
        ),
        ({}, {"init_from": "somewhere"}, r"stages\[2\]: leave `init_from` out"),
    ],
)
def test_what_cannot_change_between_stages(
    first: dict[str, Any], last: dict[str, Any], message: str
) -> None:
    with pytest.raises(ConfigError, match=message):
        check_stages(
            [Stage(matching(3), config(1, **first)), Stage(matching(2), config(1, **last))]
        )


def test_a_pooled_critic_goes_on_with_another_number_of_agents() -> None:
    pooled = config(1, algorithm="mappo", critic="pooled")
    check_stages([Stage(matching(3), pooled), Stage(matching(2), pooled)])


PRESET = """
extends = "two_cores"
[environment]
params = { length = 50, spawn = 0.5 }
[config]
reward = "common"
network_width = 8
[reward.svo]
gamma = 0.9
[[stages]]
environment = { num_agents = 3, params = { spawn = 0.1 } }
config = { total_timesteps = 64_000, reward = "svo" }
[[stages]]
config.total_timesteps = 1_000_000
[[games.pd_arena.stages]]
environment.map = "small.txt"
[[games.pd_arena.stages]]
config = { learning_rate = 1e-3 }
[games.clean_up]
stages = []
"""


def test_a_preset_with_stages(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(PRESET)
    preset = load_preset(
        tmp_path / "mine.toml", {"init_from": str(tmp_path), "svo_angle": 45}, "coins"
    )
    (first,) = preset.earlier
    assert (first.environment, preset.environment) == (
        {"num_agents": 3, "params": {"length": 50, "spawn": 0.1}},
        {"params": {"length": 50, "spawn": 0.5}},
    )
    assert [
        (one.config.total_timesteps, one.config.reward, one.config.gamma) for one in (first, preset)
    ] == [
        (64_000, "svo", 0.9),
        (1_000_000, "common", 0.995),
    ]
    assert [one.config.init_from for one in (first, preset)] == [str(tmp_path), ""]
    arena = load_preset(tmp_path / "mine.toml", game="pd_arena")
    assert (arena.earlier[0].environment["map"], arena.config.learning_rate) == ("small.txt", 1e-3)
    assert load_preset(tmp_path / "mine.toml", game="clean_up").earlier == ()


@pytest.mark.parametrize(
    ("text", "changes", "message"),
    [
        ("stages = 3\n", {}, r"mine\.toml: `stages` must be a list of tables, not 3"),
        ("stages = [3]\n", {}, r"mine\.toml: `stages\[1\]` must be a table, not 3"),
        ("[[stages]]\n[[stages]]\nmap = 'x'\n", {}, r"mine\.toml: stages\[2\]: unknown key `map`"),
        (
            "[[stages]]\nenvironment.agents = 3\n",
            {},
            r"mine\.toml: stages\[1\]\.environment: unknown key `agents`",
        ),
        (
            "[[games.coins.stages]]\nreward.svoo = {}\n",
            {},
            r"mine\.toml: games\.coins\.stages\[1\]\.reward: unknown key `svoo`",
        ),
        (
            "[[stages]]\n[[stages]]\nconfig.gama = 1\n",
            {},
            r"mine\.toml: stages\[2\]: unknown key `gama`",
        ),
        (
            "[[stages]]\n[[stages]]\nconfig.algorithm = 'vdn'\n",
            {},
            r"mine\.toml: stages\[2\]: `algorithm` can't change",
        ),
        (
            "[[stages]]\n[[games.coins.stages]]\n[[games.coins.stages]]\nconfig.seeds = 2\n",
            {},
            r"games\.coins\.stages\[2\]: `seeds` can't",
        ),
        (
            "[[stages]]\nconfig.gamma = 0.5\n",
            {"gamma": 0.9},
            r"mine\.toml: stages set `gamma` themselves: change it there",
        ),
        (
            "[[stages]]\nalgorithm.ippo.gamma = 0.5\n[[stages]]\n",
            {"gamma": 0.9},
            "stages set `gamma` themselves",
        ),
        (
            "[[stages]]\n[[stages]]\nconfig.own.bonus = 2\n",
            {"own.bonus": 1},
            r"stages set `own\.bonus` themselves",
        ),
        (
            "[[stages]]\n[[stages]]\n",
            {"exchange_ratio": 0.5},
            "`exchange_ratio` has no effect while `reward` is individual",
        ),
    ],
)
def test_stages_of_a_preset_are_refused_with_their_place(
    tmp_path: Path, text: str, changes: dict[str, Any], message: str
) -> None:
    (tmp_path / "mine.toml").write_text(text)
    with pytest.raises(ConfigError, match=message):
        load_preset(tmp_path / "mine.toml", changes, "coins")
