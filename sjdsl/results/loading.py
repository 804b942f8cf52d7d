"""Loads results as a table with one row for each seed and its evaluation.

    folders --load--> DataFrame --sections--> tables and pictures

Columns, in this order:

* `record`: the kind of a row: `seed` (the evaluation of the last policy of a training seed), `random` (a random policy), `mixture` (the
  return of an agent of a policy in a mixture of cross-play) or `diagram` (a Schelling diagram).
* `game`, `hash` (of its rules), `variant`, `params` (changed numbers, `a=1 b=2`), `map`, `num_agents`.
* `run`: a name for all of the following up to `settings`, and the game. Seeds with the same `run` were trained the same and may be averaged.
  `algorithm`, `reward` (after stages, that of the last and ` from stages`), `sharing`, `exchange_ratio`, `svo_weight`, `svo_angle` (degrees;
  NaN where agents differ), `network`, `total_timesteps` (environment steps in the configuration), `settings` (JSON: other settings that
  aren't the default).
* A column for each setting in which the loaded runs differ, with its name: `learning_rate`, `own.NAME`; and `param.NAME` for each number of
  the game in which runs under the same rules differ. `svo_angles` has the angles of agents that differ, `45,90`. Only `load` returns these.
* `preset`: the preset of this version with the same settings, or `""`.
* `seed`, `status` (`done`, `failed`: it diverged, `unfinished`), `steps` (environment steps of its training), `hardware`, `folder`.
* `episodes`, `collective_return` (mean over the episodes, summed over agents), `low` and `high` (its 95 % interval, in rows without a seed).
* Each further figure of an evaluation has a column with its name: `event eaten`, `mean apples_left`. Mixtures have `mixture`, `policy`,
  `mean`, `unit` and `units`; diagrams have `cooperators`, `defectors`, `outcome`, `fear`, `greed`, and A, B, fear and greed with bounds.
"""

import json
import math
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from sjdsl.experiments.folder import read_json as read_object
from sjdsl.extras import needs
from sjdsl.files import parse_json, read_json
from sjdsl.results.bundled import as_assignment, is_usual, other_numbers, variant_now
from sjdsl.results.presets import preset_of
from sjdsl.results.refusals import ResultsError, ResultsWarning
from sjdsl.results.settings import (
    CHECKPOINTS,
    GAME_NUMBERS,
    NOT_A_WAY,
    WAY,
    flat_numbers,
    numbers_of,
    stored_numbers,
    with_settings,
)
from sjdsl.results.stored_experiments import CrossPlay, Diagram
from sjdsl.short_paths import short_names
from sjdsl.trainers.policies.policy_file import POLICIES
from sjdsl.trainers.policies.stored_evaluation import EVALUATION, RETURN, read_evaluation
from sjdsl.trainers.runs.curves import figures
from sjdsl.trainers.runs.manifest import MANIFEST, read_manifest
from sjdsl.trainers.runs.metrics_files import run_rows
from sjdsl.trainers.runs.run_errors import RunError
from sjdsl.trainers.runs.seeds_in_words import seeds_in_words
from sjdsl.trainers.runs.stages import reward_label, stage_folders
from sjdsl.trainers.settings.config import MOST_SEEDS, ConfigError, stored_config

with needs("results"):
    import pandas as pd

Rows = list[dict[str, Any]]
Found = tuple[Rows, Rows]  # evaluations, and points of learning curves

SETTING = ("game", "hash", "variant", "params", "map", "num_agents")
OF_SEED = (
    "preset",
    "seed",
    "status",
    "steps",
    "hardware",
    "folder",
    "episodes",
    "collective_return",
    "low",
    "high",
)
COLUMNS = ("record", *SETTING, "run", *WAY, "settings", *OF_SEED)
POINT = ("run", "seed", "env_steps", "collective_return", "folder")
TEXTS = {
    "record",
    *SETTING[:-1],
    "run",
    *WAY[:3],
    "network",
    "settings",
    "preset",
    "status",
    "hardware",
    "folder",
    GAME_NUMBERS,
}
TEXTS |= {"mixture", "policy", "unit", "cooperators", "defectors", "outcome", "reason", "caution"}
COUNTS = {"num_agents", "total_timesteps", "seed", "steps", "episodes", "units", "env_steps"}
NUMBERS = {"exchange_ratio", "svo_weight", "svo_angle", "collective_return", "low", "high"}
# Columns that identify a result.
KEY = (
    "record",
    "game",
    "hash",
    "params",
    "num_agents",
    "run",
    "seed",
    "mixture",
    "policy",
    "cooperators",
    "defectors",
)
CONTRASTS = ("A", "B", "fear", "greed")
OF_EXPERIMENT = (
    *(
        "mixture",
        "policy",
        "mean",
        "unit",
        "units",
        "cooperators",
        "defectors",
        "outcome",
        "fear",
        "greed",
        "reason",
        "caution",
    ),
    *(f"{name}_{end}" for name in CONTRASTS for end in ("mean", "low", "high")),
)

RESULTS, CURVES = "results.csv", "curves.csv"  # in the folder `data` of a report
SWEEP, CELLS, FAILED = "sweep.json", "cells", "failed"
ASKED, DIAGRAM, CROSS_PLAY = "experiment.json", "schelling.json", "crossplay.json"
EPISODES = (
    30  # at least, in the evaluation of a seed: the default of `sjdsl train` and `sjdsl evaluate`
)
POINTS = 40  # at most, of the learning curve of a seed
DIGITS = 6  # significant digits of a figure, here and in a CSV
START = "started from"  # in the rows of runs that are read: the policy that a seed started from
KINDS = "the folder of a run, a sweep, a Schelling diagram, a cross-play, or the `data` of a report"


def load(*folders: str | Path) -> "pd.DataFrame":
    """Returns the results in folders: one row for each seed and its evaluation, with the columns listed in this module.

    Args:
      folders: of runs, sweeps, diagrams, cross-play, the `data` of a report, or folders of these. If a result is found twice, that of the
        folder named later is used; a finished seed is never replaced by an unfinished one.
    Raises:
      ResultsError: a folder doesn't exist or holds no results; a file is damaged.
    Warns:
      ResultsWarning: something is left out.
    """
    rows, _ = _read_all(folders)
    return with_settings(_evaluations(rows))


def load_curves(*folders: str | Path) -> "pd.DataFrame":
    """Returns the learning curves of the finished seeds: `run`, `seed`, `env_steps`, `collective_return`, `folder`.

    Each seed has at most 40 points, each the mean of episodes that ended in neighbouring updates. Raises and warns as `load`.
    """
    return load_both(folders)[1]


def load_both(
    folders: Iterable[str | Path], more: Iterable[dict[str, Any]] = ()
) -> tuple["pd.DataFrame", "pd.DataFrame"]:
    """Returns what `load`, without the columns of single settings, and `load_curves` return, from one reading.

    Args:
      more: further rows, by column, as if they were read last.
    """
    rows, points = _read_all(folders)
    rows += more
    return _evaluations(rows).drop(columns=GAME_NUMBERS), _curves(rows, points)


def read_frame(path: Path, columns: Iterable[str]) -> "pd.DataFrame":
    """Returns a CSV written by `write_frame`. Raises ResultsError if it lacks a column, or a value has the wrong type."""
    try:
        kinds = {**dict.fromkeys(TEXTS, "string"), **dict.fromkeys(COUNTS, "Int64")}
        frame = _typed(pd.read_csv(path, dtype=kinds, keep_default_na=False, na_values=[""]))
    except (ValueError, TypeError) as error:
        raise ResultsError(f"{path} cannot be read ({type(error).__name__}: {error})") from None
    missing = [name for name in columns if name not in frame]
    if missing:
        raise ResultsError(f"{path} lacks the columns {', '.join(missing)}")
    return frame


def write_frame(frame: "pd.DataFrame") -> str:
    """Returns a table as CSV, with figures in six digits, and without folders, which are of one machine."""
    return str(
        frame.drop(columns="folder", errors="ignore").to_csv(
            index=False, float_format=f"%.{DIGITS}g", lineterminator="\n"
        )
    )


def _typed(frame: "pd.DataFrame") -> "pd.DataFrame":
    texts = {name: "string" for name in frame if name in TEXTS}
    kinds = {
        name: "Int64" if name in COUNTS else "float" for name in frame if name in COUNTS | NUMBERS
    }
    frame = frame.astype({**texts, **kinds})
    frame[[*texts]] = frame[[*texts]].fillna("").astype(object)
    return frame


def _evaluations(rows: Rows) -> "pd.DataFrame":
    """Returns the table of rows, each result once, with the column `GAME_NUMBERS`."""
    more = sorted({name for row in rows for name in row} - {*COLUMNS, *OF_EXPERIMENT, GAME_NUMBERS})
    experiments = (
        OF_EXPERIMENT if any(row["record"] in ("mixture", "diagram") for row in rows) else ()
    )
    frame = _typed(pd.DataFrame(rows, columns=[*COLUMNS, *experiments, *more, GAME_NUMBERS]))
    numbers = [*frame.select_dtypes("float")]
    frame[numbers] = frame[numbers].map(lambda value: float(f"{value:.{DIGITS}g}"))
    key = [name for name in KEY if name in frame]
    frame = frame.iloc[
        np.argsort(frame.status == "done", kind="stable")
    ]  # of two rows the last one stays
    told = frame[frame.duplicated(key, keep=False) & frame.status.isin(("done", ""))].drop(
        columns=["folder", GAME_NUMBERS]
    )
    for names, same in told.groupby(key, dropna=False):
        if len(same.drop_duplicates()) > 1:
            what = " ".join(str(name) for name in names if not pd.isna(name) and name != "")
            _warn(
                f"{what} was found twice with different figures; those of the folder named later are used"
            )
    frame = frame.drop_duplicates(key, keep="last")
    return _named_variants(frame).sort_values(key, kind="stable", ignore_index=True)


def _named_variants(frame: "pd.DataFrame") -> "pd.DataFrame":
    """Returns the table with the variant of each experiment: that of runs with the same rules, else of the bundled game."""
    trained = (
        frame[frame.record == "seed"]
        .drop_duplicates(["game", "hash"])
        .set_index(["game", "hash"])[["variant", "map"]]
    )
    for place, row in frame[frame.record.isin(("mixture", "diagram"))].iterrows():
        if (row.game, row.hash) in trained.index:
            frame.loc[place, ["variant", "map"]] = trained.loc[(row.game, row.hash)].to_list()
        else:
            frame.loc[place, "variant"] = variant_now(row.game, row.hash) or ""
    return frame


def _curves(rows: Rows, points: Rows) -> "pd.DataFrame":
    done = [
        {name: row[name] for name in ("run", "seed", "folder")}
        for row in rows
        if row.get("status") == "done"
    ]
    kept = pd.DataFrame(done, columns=["run", "seed", "folder"]).drop_duplicates(
        ["run", "seed"], keep="last"
    )
    found = pd.DataFrame(points, columns=POINT).merge(kept)
    return found.drop_duplicates(["run", "seed", "env_steps"], keep="last").sort_values(
        ["run", "seed", "env_steps"], ignore_index=True
    )


def _read_all(folders: Iterable[str | Path]) -> Found:
    """Reads folders, and names runs apart whose seeds of one number started from different policies.

    Elsewhere seeds that each started from a policy of their own count as trained the same.
    """
    rows, points = _read_each(folders)
    starts = {(row["run"], row["seed"], row[START]) for row in rows if START in row}
    several = {run for (run, _), number in Counter(key[:2] for key in starts).items() if number > 1}
    short = short_names(start for run, _, start in starts if run in several)
    renamed: dict[str, str] = {}  # folder of a seed -> its run
    for row in rows:
        start = row.pop(START, None)
        if start is not None and row["run"] in several:
            row["run"] += f"-{sha256(start.encode()).hexdigest()[:4]}"
            row["settings"] = _compact(json.loads(row["settings"]) | {"init_from": short[start]})
            renamed[row["folder"]] = row["run"]
    return rows, [point | {"run": renamed.get(point["folder"], point["run"])} for point in points]


def _read_each(folders: Iterable[str | Path]) -> Found:
    rows: Rows = []
    points: Rows = []
    for folder in folders:
        found, curve = _read(Path(folder))
        rows += found
        points += curve
    return rows, points


def _warn(text: str) -> None:
    warnings.warn(text, ResultsWarning, stacklevel=2)


def _read(path: Path) -> Found:
    if not path.exists():
        raise ResultsError(f"there is no folder or file `{path}`")
    reader = _reader(path)
    if reader is not None:
        return reader(path)
    inside = (
        [part for part in sorted(path.iterdir()) if _reader(part) is not None]
        if path.is_dir()
        else []
    )
    if not inside:
        raise ResultsError(f"`{path}` holds no results; name {KINDS}")
    return _read_each(inside)


def _reader(path: Path) -> Callable[[Path], Found] | None:
    """Returns the reader of a folder, by the files in it; None if there is none."""
    if not path.is_dir():
        return None
    if (path / SWEEP).exists() or (path / CELLS).is_dir():
        return _sweep
    if (path / MANIFEST).is_file():
        return _run
    asked = (read_object(path / ASKED) or {}).get("experiment")
    if (path / DIAGRAM).is_file() or asked == "schelling":
        return lambda path: (_experiment(path, DIAGRAM, Diagram), [])
    if (path / CROSS_PLAY).is_file() or asked == "crossplay":
        return lambda path: (_experiment(path, CROSS_PLAY, CrossPlay), [])
    return _stored if (path / RESULTS).is_file() else None


def _stored(path: Path) -> Found:
    """Reads the `data` of a report."""
    frame = read_frame(path / RESULTS, set(COLUMNS) - {"folder"})
    unknown = sorted(set(frame.status) - {"done", "failed", "unfinished", ""})
    if unknown:
        raise ResultsError(
            f"{path / RESULTS}: `status` is done, failed or unfinished, not `{unknown[0]}`"
        )
    for settings in set(frame.settings) - {""}:
        if not _is_table(settings):
            raise ResultsError(
                f"{path / RESULTS}: `settings` must be JSON with names, not `{settings[:80]}`"
            )
    curves = read_frame(path / CURVES, POINT[:-1]) if (path / CURVES).is_file() else None
    rows, points = (
        [] if table is None else table.assign(folder=str(path)).to_dict("records")
        for table in (frame, curves)
    )
    known = [{name: value for name, value in row.items() if not pd.isna(value)} for row in rows]
    return [
        row | {GAME_NUMBERS: stored_numbers(row)} if row["record"] == "seed" else row
        for row in known
    ], points


def _is_table(text: str) -> bool:
    """Whether a text is a table of JSON."""
    try:
        return isinstance(parse_json(text.encode()), dict)
    except ValueError:
        return False


# Sweeps, whose cells are ordinary runs.


def _sweep(path: Path) -> Found:
    names = _cell_names(path)
    there = [name for name in names if (path / CELLS / name / MANIFEST).is_file()]
    absent = len(names) - len(there)
    if absent:
        _warn(
            f"{absent} cell{'s' if absent > 1 else ''} of the sweep `{path}` {'are' if absent > 1 else 'is'} not trained yet"
        )
    for name in names:
        if (path / FAILED / f"{name}.json").is_file():
            _warn(f"the cell `{name}` of the sweep `{path}` has failed")
    found = [_run(path / CELLS / name) for name in there]
    return [row for rows, _ in found for row in rows], [
        point for _, points in found for point in points
    ]


def _cell_names(path: Path) -> list[str]:
    """Returns the names of a sweep's cells. Raises ResultsError."""
    try:
        names = [*read_json(path / SWEEP)["cells"]]
        if any(Path(name).name != name for name in names):
            raise ValueError("a cell is named by a path")
        return names
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ResultsError(
            f"{path / SWEEP} cannot be read ({type(error).__name__}: {error})"
        ) from None


# Runs.


def _run(path: Path) -> Found:
    try:
        manifest = read_manifest(path)
        earlier = [read_manifest(folder) for folder in stage_folders(path)[:-1]]
        ids = ids_of(manifest, earlier)
        steps_before = sum(_steps(one) for one in earlier)
        found = [
            _seed(folder, seed, ids, manifest, steps_before)
            for seed, folder in _folders(path, manifest["config"])
        ]
        rows = [row for row, _ in found]
        for row in rows:
            _check(row)
    except (RunError, ConfigError) as error:
        _warn(f"{error}: {path} is left out")
        return [], []
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        _warn(f"{path / MANIFEST} is damaged ({type(error).__name__}: {error}): {path} is left out")
        return [], []
    _warn_of_seeds(path, manifest, rows)
    return rows, [point for _, points in found for point in points]


def ids_of(
    manifest: Mapping[str, Any], earlier: Sequence[Mapping[str, Any]] = ()
) -> dict[str, Any]:
    """Returns the game, way of training and settings of a run, by column, from its manifest.

    Args:
      earlier: the manifests of the stages before.
    """
    game, config = manifest["game"], manifest["config"]
    made = manifest.get("provenance") or {}
    way = {
        key: value
        for key, value in config.items()
        if key not in NOT_A_WAY and not key.startswith(CHECKPOINTS)
    }
    start = way.get("init_from")
    if start:
        way["init_from"] = "a policy"
    if earlier:
        way["stages"] = [_stage(one, config) for one in earlier]
    elif manifest.get("stage", 1) > 1:
        way["stages"] = f"stage {manifest['stage']} of a run"
    everything = {
        "hash": game["hash"],
        "params": game["params"],
        "agents": game["num_agents"],
        "config": way,
    }
    digest = sha256(json.dumps(everything, sort_keys=True).encode()).hexdigest()[:8]
    reward, angles = str(config["reward"]), config.get("svo_angle", [])
    ids = {
        "game": game["name"],
        "hash": game["hash"],
        "variant": made.get("variant") or "",
        "params": " ".join(_numbers(game, made)),
        GAME_NUMBERS: numbers_of(game, flat_numbers(made.get("params") or {})),
        "map": Path(made["map"]).name
        if isinstance(made.get("map"), str)
        else "own"
        if made.get("map")
        else "",
        "num_agents": game["num_agents"],
        "run": f"{game['name']}-{Path(str(config['algorithm'])).stem}-{Path(reward).stem}-{digest}",
        "algorithm": config["algorithm"],
        "reward": reward_label(reward, "stages" in way),
        "sharing": config.get("sharing", "shared"),
        "network": str(config["network"]),
        "total_timesteps": int(config["total_timesteps"]),
        "preset": preset_of(game["name"], way),
    }
    if reward == "exchange":
        ids["exchange_ratio"] = config["exchange_ratio"]
    if reward == "svo":
        ids["svo_weight"] = config["svo_weight"]
        ids |= {"svo_angle": angles[0]} if len(set(angles)) == 1 else {}
    usual = stored_config({"algorithm": way["algorithm"]}).model_dump(mode="json")
    columns = {*WAY} - ({"svo_angle"} if reward == "svo" and "svo_angle" not in ids else set())
    own = {
        key: value
        for key, value in sorted(way.items())
        if key not in columns and value != usual.get(key)
    }
    return ids | {"settings": _compact(own)} | ({START: str(start)} if start else {})


def _compact(settings: Mapping[str, Any]) -> str:
    return json.dumps(settings, separators=(",", ":"))


def _stage(manifest: Mapping[str, Any], last: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the game of a stage, and the settings in which it differs from the last one. last: the configuration of that."""
    game, made = manifest["game"], manifest.get("provenance") or {}
    settings = {key: value for key, value in manifest["config"].items() if value != last.get(key)}
    settings["init_from"] = "a policy" if settings.get("init_from") else ""
    return {
        "hash": game["hash"],
        "params": " ".join(_numbers(game, made)),
        "num_agents": game["num_agents"],
        **settings,
    }


def _check(row: Mapping[str, Any]) -> None:
    """Raises ValueError, TypeError or OverflowError for a value of the wrong type for its column."""
    for name, value in row.items():
        if value is None:
            continue
        is_count = isinstance(value, int) and abs(value) < 2**63
        if (name in TEXTS and not isinstance(value, str)) or (name in COUNTS and not is_count):
            raise ValueError(f"its {name} is {value!r}")
        if name in NUMBERS:
            float(value)


def _numbers(game: Mapping[str, Any], made: Mapping[str, Any]) -> list[str]:
    """Returns the changed numbers of the game, including that of agents, besides its variant.

    The manifest of a run that was started from Python may lack them: then they are the differences from the bundled game.
    """
    if "game" not in made:
        return other_numbers(game)
    asked = flat_numbers(made.get("params") or {}) | (
        {} if made.get("num_agents") is None else {"num_agents": made["num_agents"]}
    )
    variant = made.get("variant") or ""
    return [
        as_assignment(name, value)
        for name, value in sorted(asked.items())
        if not is_usual(game["name"], variant, name, value)
    ]


def _folders(path: Path, config: Mapping[str, Any]) -> list[tuple[int, Path]]:
    """Returns the seeds of a run, and the folder of each."""
    first, number = int(config["seed"]), int(config["seeds"])
    if not 1 <= number <= MOST_SEEDS:
        raise ValueError(f"it has {number} seeds")
    if number == 1:
        return [(first, path)]
    return [(seed, path / f"seed_{seed}") for seed in range(first, first + number)]


def _steps(manifest: Mapping[str, Any]) -> int:
    """Returns the environment steps that a run has done, or a stage of one."""
    return int(manifest["updates"] * manifest["derived"]["steps_per_update"])


def _seed(
    folder: Path, seed: int, ids: Mapping[str, Any], manifest: Mapping[str, Any], steps_before: int
) -> tuple[dict[str, Any], Rows]:
    """Returns the row of a seed, and its learning curve where it is done. steps_before: in earlier stages."""
    if seed in {entry["seed"] for entry in manifest.get("diverged", ())}:
        status = "failed"
    else:
        status = "done" if manifest.get("status") == "finished" else "unfinished"
    device = manifest.get("device") or {}
    number, kind = device.get("count", 1), device.get("kind", "unknown")
    steps, returns = _curve(folder)
    row = {
        "record": "seed",
        **ids,
        "seed": seed,
        "status": status,
        "hardware": f"{number} x {kind}" if number > 1 else str(kind),
    }
    row["folder"] = str(folder)
    if status != "done":
        return row | {"steps": int(max(steps, default=0)), "episodes": 0}, []
    means, episodes = _evaluation(folder / EVALUATION)
    row |= {"steps": steps_before + _steps(manifest), "episodes": episodes}
    row |= {"collective_return" if name == RETURN else name: value for name, value in means.items()}
    named = zip(steps, returns, strict=True)
    points = [
        {
            "run": ids["run"],
            "seed": seed,
            "env_steps": int(x),
            "collective_return": y,
            "folder": str(folder),
        }
        for x, y in named
    ]
    return row, points


def _curve(folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """Returns environment steps and collective returns, `[P]` each: at most `POINTS`, each the mean of neighbouring updates.

    The steps are the ends of equal parts of the run, the same for all seeds.
    """
    steps, returns = figures(run_rows(folder), "collective_return")
    if not np.isfinite(returns).any():
        return np.zeros(0), np.zeros(0)
    steps_of_point = math.ceil(len(steps) / POINTS) * steps[0]
    ends = np.minimum(np.ceil(steps / steps_of_point) * steps_of_point, steps[-1])
    known = np.isfinite(returns)
    points = np.unique(ends[known])
    return points, np.array([returns[known & (ends == point)].mean() for point in points])


def _evaluation(path: Path) -> tuple[dict[str, float], int]:
    """Returns the means of an evaluation of the last policy, without those of single agents, and its number of episodes.

    Empty if there is none, or if it was made with `--greedy` or `--drawn`.
    """
    stored = read_evaluation(path)
    if stored is None or stored.greedy is not None:
        return {}, 0
    means = {
        name: figure.mean for name, figure in stored.summary.items() if " of agent " not in name
    }
    return {name: mean for name, mean in means.items() if mean is not None}, stored.episodes


def _warn_of_seeds(path: Path, manifest: Mapping[str, Any], rows: Rows) -> None:
    if any(row["status"] == "unfinished" for row in rows):
        status = manifest.get("status")
        how = "isn't finished" if status == "running" else f"ended early ({status})"
        _warn(f"`{path}` {how}: it is left out. Resume it with `sjdsl train --resume {path}`")
    done = [row for row in rows if row["status"] == "done"]
    failed = [row["seed"] for row in rows if row["status"] == "failed"]
    if failed:
        _warn(
            f"{seeds_in_words(failed)} of `{path}` diverged (non-finite loss): this run has no mean"
        )
    wanting = [row for row in done if "collective_return" not in row]
    damaged = [row for row in wanting if not (Path(row["folder"]) / POLICIES).is_dir()]
    if damaged:
        _warn(
            f"left out of `{path}`: {seeds_in_words(row['seed'] for row in damaged)}, without `{POLICIES}`"
        )
    if len(wanting) > len(damaged):
        _warn(
            f"`{path}` isn't evaluated, or only with `--greedy` or `--drawn`: run `sjdsl evaluate {path}`"
        )
    few = [
        row["episodes"] for row in done if "collective_return" in row and row["episodes"] < EPISODES
    ]
    if few:
        _warn(
            f"`{path}` was evaluated in {min(few)} episodes a seed, others in {EPISODES}: run `sjdsl evaluate {path}`"
        )


# Experiments with policies.


def _experiment(path: Path, name: str, kind: type[Diagram] | type[CrossPlay]) -> Rows:
    file = path / name
    if not file.is_file():
        _warn(
            f"`{path}` is an experiment that isn't finished: it is left out. Its command, run again, resumes it"
        )
        return []
    try:
        stored = kind.model_validate(read_json(file))
    except ValidationError as error:
        fault = error.errors()[0]
        raise ResultsError(
            f"{file} cannot be read, for `{'.'.join(map(str, fault['loc']))}`: {fault['msg']}; play it again"
        ) from None
    except (OSError, ValueError) as error:
        raise ResultsError(f"{file} cannot be read: {error}; play it again") from None
    for note in stored.notes:
        _warn(note)
    game = stored.game
    of = {"game": game.name, "hash": game.hash, "num_agents": game.num_agents}
    params = " ".join(other_numbers(game.model_dump()))
    rows = _diagram(stored) if isinstance(stored, Diagram) else _cross_play(stored)
    return [{**of, "params": params, "folder": str(path), **row} for row in rows]


def _diagram(stored: Diagram) -> Rows:
    verdict = stored.verdict
    row = {
        "record": "diagram",
        **stored.model_dump(include={"cooperators", "defectors", "unit", "units", "episodes"}),
    }
    row |= {**verdict.model_dump(), "caution": verdict.caution or ""}
    for contrast, figure in stored.contrasts:
        row |= {f"{contrast}_{end}": value for end, value in figure}
    return [row]


def _cross_play(stored: CrossPlay) -> Rows:
    """Returns a row for each policy and mixture, and one with the collective return of random policies alone."""
    rows: Rows = []
    plain = not other_numbers(stored.game.model_dump())
    for mixture in stored.mixtures:
        unit, episodes = mixture.unit or stored.unit, mixture.episodes
        over = {
            "unit": unit,
            "units": len(stored.keys) if unit == "training seed" else episodes,
            "episodes": episodes,
        }
        for policy, figure in mixture.policies.items():
            rows.append(
                {
                    "record": "mixture",
                    "mixture": mixture.mixture,
                    "policy": policy,
                    **dict(figure),
                    **over,
                }
            )
        if plain and {*mixture.slots} == {*mixture.policies} == {"random"}:
            alone = {
                end: None if value is None else stored.game.num_agents * value
                for end, value in mixture.policies["random"]
            }
            rows.append(
                {
                    "record": "random",
                    "collective_return": alone.pop("mean"),
                    **alone,
                    "episodes": episodes,
                }
            )
    return rows
