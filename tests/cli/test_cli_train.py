"""`sjdsl train` and `evaluate` on a small game: the files of a run, and a run found again."""

import json
import re
import shlex
from pathlib import Path

import pytest
from command_line import Sjdsl

SMALL = "total_timesteps=96 num_envs=4 num_steps=12 num_minibatches=1 num_epochs=1 network=mlp"
QUICK = [part for value in SMALL.split() for part in ("--set", value)]


def next_commands(output: str) -> list[str]:
    """Returns the commands at the end of an output, without their purposes."""
    _, _, commands = output.rpartition("\nnext:\n")
    return [line.strip().split("  ")[0] for line in commands.splitlines()]


@pytest.mark.thorough
def test_a_run_can_be_evaluated_and_drawn(sjdsl: Sjdsl, folder: Path) -> None:
    trained = sjdsl("train orchard.sj --param apple=2 --episodes 0", *QUICK)
    assert trained.status == 0, trained.text
    run_dir = Path(
        "runs/orchard_ippo_individual_seed0"
    )  # each learns from its own reward, unless asked otherwise
    assert (
        f"\n{run_dir}/: learning_curve.png, manifest.json, metrics.jsonl, checkpoints/, policies/\n"
        in trained.out
    )
    assert next_commands(trained.out) == [
        f"sjdsl evaluate {run_dir}@best --film orchard_ippo_individual_seed0.gif",
        f"sjdsl train --resume {run_dir} --set total_timesteps=192",
    ]
    assert "training 96 environment steps: 2 updates of 4 environments x 12 steps" in trained.err
    assert "loading JAX and the game" in trained.err
    rates = re.findall(r"([\d,]+) steps(?:/s| a second)", trained.out)
    assert len(rates) == 3
    assert rates[1] == rates[2], "the end says what the last line of progress said"
    manifest = json.loads((run_dir / "manifest.json").read_text())
    assert manifest["provenance"]["params"] == {"apple": 2}
    assert manifest["provenance"]["game"] == str(folder / "orchard.sj")

    for missing in ("@7", "@bst"):
        shown = sjdsl(f"evaluate {run_dir}{missing}")
        assert shown.status == 1
        assert "has no policy" in shown.err
    evaluated = sjdsl(f"evaluate {run_dir}@best --episodes 3")
    assert evaluated.status == 0, evaluated.text
    assert "means of 3 episodes" in evaluated.out
    assert "playing 3 episodes of the trained policy" in evaluated.err
    assert "return " in evaluated.out
    assert "the best policy: means of 3 episodes" in evaluated.out
    filming, plotting = next_commands(evaluated.out)
    assert filming == (
        f"sjdsl evaluate {run_dir}@best --film orchard_ippo_individual_seed0_best.gif"
    )
    plotted = sjdsl(*shlex.split(plotting)[1:])
    assert (plotted.status, (folder / "curves.png").is_file()) == (0, True), plotted.text
    stored = json.loads((run_dir / "evaluation_best.json").read_text())
    said = {"policy": "best", "seed": 0, "greedy": None, "episodes": 3}
    assert {name: stored[name] for name in said} == said
    assert not (run_dir / "evaluation.json").exists(), "that is the last policy's"

    for state, said in (
        ({"status": "interrupted"}, "may not have finished its training: interrupted"),
        ({"diverged": [{"seed": 0, "update": 2}]}, "diverged (non-finite loss) in update 2"),
    ):
        (run_dir / "manifest.json").write_text(json.dumps(manifest | state))
        noted = sjdsl("evaluate", run_dir, "--episodes", "1")
        assert (noted.status, said in noted.err) == (0, True), noted.text
    (run_dir / "manifest.json").write_text(json.dumps(manifest))

    drawn = sjdsl("render orchard.sj --steps 2 -o film.gif --policy", run_dir)
    assert drawn.status == 0, drawn.text
    assert (folder / "film.gif").stat().st_size > 0
    said = [
        "loading JAX and the game",
        "compiling orchard",
        "playing orchard",
        "drawing the pictures",
        "writing film.gif",
    ]
    assert [line for line in drawn.err.splitlines() if line in said] == said


def test_a_preset_names_the_game(
    sjdsl: Sjdsl, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from sjdsl.cli import train as module

    seen = {}
    monkeypatch.setattr(
        module, "make_environment", lambda described: seen.update(described) or _stop()
    )
    (folder / "p.toml").write_text(
        'game = "coins"\n[environment]\nparams = { length = 20 }\n[config]\nseed = 3\n'
    )
    sjdsl("train --preset p.toml --param spawn=0.1")
    assert seen["game"] == "coins"
    assert seen["params"] == {"length": 20, "spawn": 0.1}
    sjdsl("train orchard.sj --preset p.toml")
    assert seen["params"] == {}, "another game does not take the preset's environment"


@pytest.mark.slow
def test_seeds_have_folders(sjdsl: Sjdsl, folder: Path) -> None:
    seeds = "--seed 4 --seeds 2 --algorithm mappo --reward svo"
    evaluated = "--set evaluate_every=1 --set evaluation_episodes=3 --episodes 2"
    trained = sjdsl(f"train orchard.sj --run run {seeds} {evaluated}", *QUICK)
    assert trained.status == 0, trained.text
    config = json.loads((folder / "run/manifest.json").read_text())["config"]
    wanted = {"algorithm": "mappo", "reward": "svo", "seed": 4, "seeds": 2}
    assert {name: config[name] for name in wanted} == wanted
    losses = []
    for seed in (4, 5):
        own = folder / f"run/seed_{seed}"
        assert (own / "policies/best.safetensors").is_file()
        assert json.loads((own / "policies/last.json").read_text())["seed"] == seed
        assert json.loads((own / "evaluation.json").read_text())["episodes"] == 2
        rows = [json.loads(line) for line in (own / "metrics.jsonl").read_text().splitlines()]
        assert len(rows) == 2
        losses.append(rows[0]["loss"])
    assert losses[0] != losses[1], "seeds differ"
    shown = sjdsl("train --resume run --episodes 0")
    assert shown.status == 0, shown.text
    assert "the run in run is finished" in shown.err
    assert "--set total_timesteps=… makes it longer" in shown.err


def _stop() -> None:
    import click

    raise click.ClickException("far enough")


@pytest.mark.thorough
def test_a_resumed_run_keeps_its_episodes_and_loggers(
    sjdsl: Sjdsl, monkeypatch: pytest.MonkeyPatch
) -> None:
    from sjdsl.cli import train as module
    from sjdsl.trainers.runs import recorder

    asked: list[object] = []
    monkeypatch.setattr(recorder, "draw_learning_curve", lambda *_: None)
    monkeypatch.setattr(module, "_finish", lambda *given: asked.append(given[-1]))
    assert sjdsl("train orchard.sj --run kept --episodes 7", *QUICK).status == 0
    manifest = json.loads(Path("kept/manifest.json").read_text())
    assert (manifest["asked"], manifest["loggers"]) == ({"episodes": 7}, [])
    manifest["loggers"] = ["wandb"]
    Path("kept/manifest.json").write_text(json.dumps(manifest))
    shown = sjdsl("train --resume kept")
    assert "pip install 'sjdsl[wandb]'" in shown.err, "the run's logger is asked for again"
    manifest["loggers"] = []
    Path("kept/manifest.json").write_text(json.dumps(manifest))
    assert sjdsl("train --resume kept").status == 0
    assert sjdsl("train --resume kept --episodes 2").status == 0
    assert sjdsl("train --resume kept").status == 0
    assert asked == [7, 7, 2, 2], "and the last that was asked for stays"


def test_the_end_says_which_seeds_stopped(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    from sjdsl.cli.train import _finish
    from sjdsl.trainers import Result, make_config

    (tmp_path / "metrics.jsonl").write_text('{"env_steps": 40960, "seconds": 4.0}\n')
    diverged = {3: 4, 4: 5, 5: 4}
    _finish(
        Result(tmp_path, None, 5, diverged, (tmp_path,) * 4, 0.0, 1.0, 1.0),
        None,
        make_config(seed=2, seeds=4),
        0,
    )  # type: ignore[arg-type]
    said = capsys.readouterr().out
    assert (
        "seeds 3 and 5 diverged (non-finite loss) in update 4; the policy of update 3 is kept"
        in said
    )
    assert "seed 4 diverged (non-finite loss) in update 5; the policy of update 4 is kept" in said
    assert "163,840 environment steps in 4.0 s: 40,960 steps a second" in said
    assert (
        "no learning curve was drawn, as no episode ended within the 640 steps of each environment"
        in said
    )


BROUGHT = """import jax.numpy as jnp
from pathlib import Path


def double(step):
    return 2.0 * step.reward


def ahead(key, observation):
    return jnp.full(len(observation), 2)


def watch(update):
    with open("told.txt", "a") as file:
        file.write(f"{update.number} ")
"""


@pytest.mark.thorough
def test_what_users_bring_along_is_named_on_the_command_line(
    sjdsl: Sjdsl, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A reward, a partner and a callback in a file; the run goes on longer with them, and its policy is found by its name."""
    from sjdsl.trainers.runs import recorder

    monkeypatch.setattr(recorder, "draw_learning_curve", lambda *_: None)
    (folder / "mine.py").write_text(BROUGHT)
    brought = "--reward mine.py:double --partners 1=mine.py:ahead --callback mine.py:watch"
    shown = sjdsl(f"train orchard.sj --episodes 0 {brought}", *QUICK)
    assert shown.status == 0, shown.text
    run_dir = Path("runs/orchard_ippo_double_seed0")
    ahead = f"--allow-code {folder}/mine.py:ahead"
    assert next_commands(shown.out) == [
        f"sjdsl evaluate {run_dir}@best {ahead} --film orchard_ippo_double_seed0.gif",
        f"sjdsl train --resume {run_dir} --allow-code {folder}/mine.py:double {ahead} "
        "--set total_timesteps=192",
    ]
    config = json.loads((run_dir / "manifest.json").read_text())["config"]
    assert (config["reward"], config["partners"]) == (
        f"{folder}/mine.py:double",
        [[1, f"{folder}/mine.py:ahead"]],
    )
    shown = sjdsl("train --set total_timesteps=144 --resume", run_dir)
    assert shown.status == 0, shown.text
    assert (folder / "told.txt").read_text() == "1 2 3 "
    row = json.loads((run_dir / "metrics.jsonl").read_text().splitlines()[-1])
    assert row["shaped_return"] == pytest.approx(2 * row["return"], abs=1e-6)
    shown = sjdsl(f"render orchard.sj --policy {run_dir}@best --steps 1 -o film.gif")
    assert shown.status == 0, shown.text
    shown = sjdsl(f"render orchard.sj --policy {run_dir}@7 --steps 1 -o film.gif")
    assert shown.status == 1
    assert "has no policy of update 7, but of 1, 2, 3" in shown.err
    shown = sjdsl("train --set total_timesteps=48 --resume", run_dir)
    assert shown.status == 1
    assert "a run can only be made longer" in shown.err


STAGED = """
[[stages]]
environment = { num_agents = 3, params = { apple = 2 } }
config.total_timesteps = 96
[[stages]]
config.total_timesteps = 48
"""


@pytest.mark.thorough
def test_a_run_in_stages_goes_on_in_its_stage(sjdsl: Sjdsl, folder: Path) -> None:
    (folder / "p.toml").write_text(STAGED)
    (folder / "mine.py").write_text("def stop(update):\n    return update.env_steps == 48\n")
    quick = [part for part in QUICK if part != "total_timesteps=96"][1:]
    call = ("train", "orchard.sj", "--preset", "p.toml", *quick, "--run", "run", "--episodes", "2")
    stopped = sjdsl(*call, "--callback", "mine.py:stop")
    assert stopped.status == 0, stopped.text
    assert "stage 1: training 96 environment steps" in stopped.err
    assert (
        "the callback ended the run in stage 1; sjdsl train --resume run continues it"
        in stopped.out
    )
    resumed = sjdsl("train --resume run")
    assert resumed.status == 0, resumed.text
    assert "orchard, ippo, individual reward, stage 1: resuming after update 1" in resumed.out
    assert "the last stage: 48 environment steps" in resumed.out
    assert json.loads((folder / "run/evaluation.json").read_text())["episodes"] == 2
    rows = [json.loads(line) for line in (folder / "run/metrics.jsonl").read_text().splitlines()]
    assert [(row["stage"], row["env_steps"]) for row in rows] == [(2, 144)]
