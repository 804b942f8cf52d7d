"""Reads the folder of a training run: how it was trained, what each seed earned, and its learning curve."""

import json
import math
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from sjdsl.experiments.bundled_rules import is_usual, other_numbers
from sjdsl.files import read_json
from sjdsl.report.evidence import Evidence, Measure, Point, Run, Seed, Status, rounded
from sjdsl.trainers.config import MOST_SEEDS, ConfigError, stored_config
from sjdsl.trainers.curves import figures
from sjdsl.trainers.manifest import MANIFEST, read_manifest
from sjdsl.trainers.metrics_files import METRICS_JSONL, read_rows
from sjdsl.trainers.policy_file import POLICIES
from sjdsl.trainers.run_errors import RunError

EPISODES = 30  # of the evaluation of a seed, at least: the default of `sjdsl train` and `sjdsl evaluate`
POINTS = 40  # of the learning curve of a seed, at most
RETURN = "collective return"  # its name in an evaluation
# What does not make a way of training another: which seeds, and what is written when.
NOT_A_WAY = ("seed", "seeds", "keep_policies", "policy_every", "evaluate_every", "evaluation_episodes")
NOT_A_WAY_EITHER = "checkpoint_"
# Settings that runs of earlier versions lack, with what these did: runs that have them so are of the same way.
AS_EVER = {"own": {}, "loss": "ppo"}
# What has a column of its own in the table of runs.
COLUMNS = ("algorithm", "reward", "sharing", "exchange_ratio", "svo_weight", "svo_angle", "network", "total_timesteps")


def is_run(path: Path) -> bool:
    """Returns whether a folder is that of a training run."""
    return (path / MANIFEST).is_file()


def read_run(path: Path, stage: int | None = None) -> Evidence:
    """Returns what a run has found; a run that is not finished, or not evaluated, with a note that says how it gets so.

    Args:
      path: what `sjdsl train --run` wrote.
      stage: of a sweep of svo.
    """
    try:
        manifest = read_manifest(path)
    except RunError as error:
        return Evidence(notes=(f"{error}: it is left out",))
    try:
        run = run_of(manifest, stage)
        parts = [_read_seed(folder, seed, run, manifest) for seed, folder in _folders(path, manifest["config"])]
    except (RunError, ConfigError) as error:
        return Evidence(notes=(f"{error}: {path} is left out",))
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        return Evidence(notes=(f"{path / MANIFEST} is damaged ({type(error).__name__}: {error}): {path} is left out",))
    rows = {name: tuple(row for part in parts for row in getattr(part, name)) for name in ("seeds", "measures", "curves")}
    return Evidence(runs=(run,), **rows, notes=_notes(path, manifest, rows["seeds"]))


def run_of(manifest: Mapping[str, Any], stage: int | None = None) -> Run:
    """Returns the way of training that a manifest tells of; `stage`: of a sweep of svo, which two stages never share seeds."""
    game, config = manifest["game"], manifest["config"]
    made = manifest.get("provenance") or {}
    way = {key: value for key, value in config.items() if key not in NOT_A_WAY and not key.startswith(NOT_A_WAY_EITHER)}
    way = {key: value for key, value in way.items() if key not in AS_EVER or value != AS_EVER[key]}
    everything = {"hash": game["hash"], "params": game["params"], "agents": game["num_agents"], "config": way, "stage": stage}
    digest = sha256(json.dumps(everything, sort_keys=True).encode()).hexdigest()[:8]
    reward, angles = str(config["reward"]), config.get("svo_angle", [])
    return Run(
        run=f"{game['name']}-{Path(str(config['algorithm'])).stem}-{Path(reward).stem}-{digest}",
        game=game["name"],
        hash=game["hash"],
        variant=made.get("variant") or "",
        num_agents=game["num_agents"],
        params=" ".join(_numbers(game, made)),
        map=Path(made["map"]).name if isinstance(made.get("map"), str) else "own" if made.get("map") else "",
        algorithm=config["algorithm"],
        reward=reward,
        sharing=config.get("sharing", "shared"),
        exchange_ratio=config["exchange_ratio"] if reward == "exchange" else None,
        svo_weight=config["svo_weight"] if reward == "svo" else None,
        svo_angle=angles[0] if reward == "svo" and len(set(angles)) == 1 else None,
        stage=stage,
        network=str(config["network"]),
        steps=int(config["total_timesteps"]),
        settings=_settings(way),
    )


def _settings(way: Mapping[str, Any]) -> str:
    """Returns the settings of a way of training that are not the defaults of its algorithm, but for those with columns of their own."""
    usual = stored_config({"algorithm": way["algorithm"]}).model_dump(mode="json")
    own = {key: value for key, value in sorted(way.items()) if key not in COLUMNS and value != usual.get(key)}
    return json.dumps(own, separators=(",", ":"))


def _numbers(game: Mapping[str, Any], made: Mapping[str, Any]) -> list[str]:
    """Returns what was asked for besides the game and a variant: numbers of the game, and of agents, that it would not have otherwise.

    A run that was started from Python may not say what was asked for: then the numbers that a bundled game has otherwise.
    """
    if "game" not in made:
        return other_numbers(game)
    asked = {**(made.get("params") or {}), **({} if made.get("num_agents") is None else {"num_agents": made["num_agents"]})}
    variant = made.get("variant") or ""
    return [f"{name}={value}" for name, value in sorted(asked.items()) if not is_usual(game["name"], variant, name, value)]


def _folders(path: Path, config: Mapping[str, Any]) -> list[tuple[int, Path]]:
    """Returns the seeds of a run, and the folder of each."""
    first, number = int(config["seed"]), int(config["seeds"])
    if not 1 <= number <= MOST_SEEDS:
        raise ValueError(f"it has {number} seeds")
    return [(first, path)] if number == 1 else [(seed, path / f"seed_{seed}") for seed in range(first, first + number)]


def _read_seed(folder: Path, seed: int, run: Run, manifest: Mapping[str, Any]) -> Evidence:
    status = _status(seed, manifest)
    device = manifest.get("device") or {}
    number, kind = device.get("count", 1), device.get("kind", "unknown")
    hardware = f"{number} x {kind}" if number > 1 else str(kind)
    steps, returns = _curve(folder)
    points = tuple(Point(run.run, seed, int(step), rounded(value)) for step, value in zip(steps, returns, strict=True))
    if status != "done":
        return Evidence(seeds=(Seed(run.run, seed, status, int(max(steps, default=0)), hardware, 0, None),))
    means, episodes = _evaluation(folder / "evaluation.json")
    earned = means.pop(RETURN, None)
    measures = tuple(Measure(run.run, seed, name, rounded(value)) for name, value in means.items())
    row = Seed(run.run, seed, status, _steps(manifest), hardware, episodes, None if earned is None else rounded(earned))
    return Evidence(seeds=(row,), measures=measures, curves=points)


def _status(seed: int, manifest: Mapping[str, Any]) -> Status:
    if seed in {entry["seed"] for entry in manifest.get("diverged", ())}:
        return "failed"
    return "done" if manifest.get("status") == "finished" else "unfinished"


def _steps(manifest: Mapping[str, Any]) -> int:
    return int(manifest["updates"] * manifest["derived"]["steps_per_update"])


def _curve(folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """Returns environment steps and collective returns, `[P]` each: at most `POINTS`, each the mean of neighbouring updates.

    The steps are those at the ends of as many equal parts of the run: seeds of a run have them alike.
    """
    steps, returns = figures(read_rows(folder / METRICS_JSONL), "collective_return")
    if not np.isfinite(returns).any():
        return np.zeros(0), np.zeros(0)
    together = math.ceil(len(steps) / POINTS) * steps[0]  # environment steps of a point
    ends = np.minimum(np.ceil(steps / together) * together, steps[-1])
    known = np.isfinite(returns)
    places = np.unique(ends[known])
    return places, np.array([returns[known & (ends == place)].mean() for place in places])


def _evaluation(path: Path) -> tuple[dict[str, float], int]:
    """Returns the means of an evaluation of the last policy, without those of single agents, and its episodes.

    Nothing where there is none, or where its actions were chosen otherwise than the run's own evaluation chooses them.
    """
    try:
        stored = read_json(path)
        if stored.get("greedy") is not None:
            return {}, 0
        means = {name: figure["mean"] for name, figure in stored["summary"].items() if " of agent " not in name}
        return {name: float(mean) for name, mean in means.items() if mean is not None}, int(stored["episodes"])
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}, 0


def _notes(path: Path, manifest: Mapping[str, Any], seeds: tuple[Seed, ...]) -> tuple[str, ...]:
    notes = []
    if any(row.status == "unfinished" for row in seeds):
        status = manifest.get("status")
        how = "is not finished" if status == "running" else f"has ended early ({status})"
        notes.append(f"`{path}` {how}: it is left out. `sjdsl train --resume {path}` goes on with it")
    for row in seeds:
        if row.status == "failed":
            notes.append(f"seed {row.seed} of `{path}` has failed, for its loss was not finite: nothing is averaged with it")
    wanting = {row.seed for row in seeds if row.status == "done" and row.collective_return is None}
    damaged = [folder for seed, folder in _folders(path, manifest["config"]) if seed in wanting and not (folder / POLICIES).is_dir()]
    notes += [f"`{folder}` is not whole, for it has no `{POLICIES}`: it is left out" for folder in damaged]
    few = {row.episodes for row in seeds if row.collective_return is not None and row.episodes < EPISODES}
    if few:
        notes.append(
            f"`{path}` was evaluated in {min(few)} episodes a seed, where other cells have {EPISODES}: `sjdsl evaluate {path}` does it so"
        )
    if len(wanting) > len(damaged):
        notes.append(
            f"`{path}` is not evaluated, or was with `--greedy` or `--drawn`: `sjdsl evaluate {path}` does it as the tables want it"
        )
    return tuple(notes)
