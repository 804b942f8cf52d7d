"""Loads results as a table with one row for each seed and its evaluation.

    folders --load--> DataFrame --sections--> tables and pictures

Columns, in this order:

* `record`: the kind of a row: `seed` (the evaluation of the last policy of a training seed), `random` (a random policy), `mixture` (the
  return of an agent of a policy in a mixture of cross-play) or `diagram` (a Schelling diagram).
* `game`, `hash` (of its rules), `variant`, `params` (changed numbers, `a=1 b=2`), `map`, `num_agents`, `tasks` (of a game with tasks those
  played: `training`, `all`, `held_out NAME`, `hue=red pay[red]=3`).
* `run`: a name for all of the following up to `settings`, and the game. Seeds with the same `run` were trained the same and may be averaged.
  `algorithm`, `reward` (after stages, that of the last and ` from stages`), `sharing`, `exchange_ratio`, `svo_weight`, `svo_angle` (degrees;
  NaN where agents differ), `network`, `total_timesteps` (environment steps in the configuration), `settings` (JSON: other settings that
  aren't the default).
* A column for each setting in which the loaded runs differ, with its name: `learning_rate`, `own.NAME`; and `param.NAME` for each number of
  the game in which runs under the same rules differ. `svo_angles` has the angles of agents that differ, `45,90`. Only `load` returns these.
* `preset`: the preset of this version with the same settings, or `""`.
* `seed`, `status` (`done`, `failed`: it diverged, `unfinished`), `steps` (environment steps of its training), `hardware`, `folder`.
* `episodes`, `collective_return` (mean over the episodes, summed over agents), `low` and `high` (its 95 % interval, in rows without a seed).
* Each further figure of an evaluation has a column with its name: `event eaten`, `mean apples_left`; one in held-out tasks of the split
  `late`: `event eaten, held out late`; `training minus held out late` is the difference of the collective return. Mixtures have `mixture`, `policy`,
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
    METHOD,
    WITHOUT_EFFECT,
    flat_numbers,
    numbers_of,
    stored_numbers,
    with_settings,
)
from sjdsl.results.stored_experiments import CrossPlay, Diagram, Game
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
RowsAndPoints = tuple[Rows, Rows]  # evaluations, and points of learning curves

SETTING = ("game", "hash", "variant", "params", "map", "num_agents", "tasks")
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
COLUMNS = ("record", *SETTING, "run", *METHOD, "settings", *OF_SEED)
ADDED = {"folder", "tasks"}  # columns that a stored table may lack
HELD_OUT = ", held out "  # between a figure and the split whose held-out tasks it is of
MINUS_HELD_OUT = "training minus held out "  # before a split
POINT = ("run", "seed", "env_steps", "collective_return", "folder")
# Columns by the type of their values.
TEXTS = {
    "record",
    "game",
    "hash",
    "variant",
    "params",
    "map",
    "tasks",
    "run",
    "algorithm",
    "reward",
    "sharing",
    "network",
    "settings",
    "preset",
    "status",
    "hardware",
    "folder",
    GAME_NUMBERS,
    "mixture",
    "policy",
    "unit",
    "cooperators",
    "defectors",
    "outcome",
    "reason",
    "caution",
}
COUNTS = {"num_agents", "total_timesteps", "seed", "steps", "episodes", "units", "env_steps"}
NUMBERS = {"exchange_ratio", "svo_weight", "svo_angle", "collective_return", "low", "high"}
# Columns that identify a result.
KEY = (
    "record",
    "game",
    "hash",
    "params",
    "num_agents",
    "tasks",
    "run",
    "seed",
    "mixture",
    "policy",
    "cooperators",
    "defectors",
)
CONTRASTS = ("A", "B", "fear", "greed")
OF_EXPERIMENT = (
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
    *(f"{name}_{end}" for name in CONTRASTS for end in ("mean", "low", "high")),
)

RESULTS = "results.csv"  # in the folder `data` of a report
CURVES = "curves.csv"
SWEEP = "sweep.json"
CELLS = "cells"
FAILED = "failed"
PLAN = "experiment.json"
DIAGRAM = "schelling.json"
CROSS_PLAY = "crossplay.json"
# At least, in the evaluation of a seed: the default of `sjdsl train` and `sjdsl evaluate`.
EPISODES = 30
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
        types = {**dict.fromkeys(TEXTS, "string"), **dict.fromkeys(COUNTS, "Int64")}
        frame = pd.read_csv(path, dtype=types, keep_default_na=False, na_values=[""])
        frame = _set_types(frame)
    except (ValueError, TypeError) as error:
        raise ResultsError(f"{path} cannot be read ({type(error).__name__}: {error})") from None
    missing = [name for name in columns if name not in frame]
    if missing:
        raise ResultsError(f"{path} lacks the columns {', '.join(missing)}")
    return frame


def write_frame(frame: "pd.DataFrame") -> str:
    """Returns a table as CSV, with figures in six digits, and without folders, which are of one machine."""
    shown = frame.drop(columns="folder", errors="ignore")
    return str(shown.to_csv(index=False, float_format=f"%.{DIGITS}g", lineterminator="\n"))


def _set_types(frame: "pd.DataFrame") -> "pd.DataFrame":
    """Returns the table with the types of its known columns; texts are never missing, but empty."""
    texts = [name for name in frame if name in TEXTS]
    types = dict.fromkeys(texts, "string")
    types |= {name: "Int64" for name in frame if name in COUNTS}
    types |= {name: "float" for name in frame if name in NUMBERS}
    frame = frame.astype(types)
    frame[texts] = frame[texts].fillna("").astype(object)
    return frame


def _evaluations(rows: Rows) -> "pd.DataFrame":
    """Returns the table of rows, each result once, with the column `GAME_NUMBERS`."""
    names = {name for row in rows for name in row}
    figures_of_games = sorted(names - {*COLUMNS, *OF_EXPERIMENT, GAME_NUMBERS})
    has_experiments = any(row["record"] in ("mixture", "diagram") for row in rows)
    experiments = OF_EXPERIMENT if has_experiments else ()
    columns = [*COLUMNS, *experiments, *figures_of_games, GAME_NUMBERS]
    frame = _set_types(pd.DataFrame(rows, columns=columns))
    numbers = [*frame.select_dtypes("float")]
    frame[numbers] = frame[numbers].map(lambda value: float(f"{value:.{DIGITS}g}"))
    # Of rows with the same key the last one is kept: a finished one, if there is one.
    key = [name for name in KEY if name in frame]
    frame = frame.iloc[np.argsort(frame.status == "done", kind="stable")]
    _warn_of_differences(frame, key)
    frame = frame.drop_duplicates(key, keep="last")
    return _add_variants(frame).sort_values(key, kind="stable", ignore_index=True)


def _warn_of_differences(frame: "pd.DataFrame", key: list[str]) -> None:
    """Warns of each finished result that was read twice with different figures."""
    finished = frame[frame.status.isin(("done", ""))].drop(columns=["folder", GAME_NUMBERS])
    repeated = finished[finished.duplicated(key, keep=False)]
    for values, same in repeated.groupby(key, dropna=False):
        if len(same.drop_duplicates()) > 1:
            name = " ".join(str(value) for value in values if not pd.isna(value) and value != "")
            _warn(
                f"{name} was found twice with different figures; those of the folder named later are used"
            )


def _add_variants(frame: "pd.DataFrame") -> "pd.DataFrame":
    """Returns the table with the variant of each experiment: that of runs with the same rules, else of the bundled game."""
    trained = frame[frame.record == "seed"].drop_duplicates(["game", "hash"])
    by_rules = trained.set_index(["game", "hash"])[["variant", "map"]]
    for index, row in frame[frame.record.isin(("mixture", "diagram"))].iterrows():
        if (row.game, row.hash) in by_rules.index:
            frame.loc[index, ["variant", "map"]] = by_rules.loc[(row.game, row.hash)].to_list()
        else:
            frame.loc[index, "variant"] = variant_now(row.game, row.hash) or ""
    return frame


def _curves(rows: Rows, points: Rows) -> "pd.DataFrame":
    """Returns the table of the learning curves of finished seeds, each seed once: as read last."""
    done = pd.DataFrame(
        [row for row in rows if row.get("status") == "done"], columns=["run", "seed", "folder"]
    )
    last = done.drop_duplicates(["run", "seed"], keep="last")
    key = ["run", "seed", "env_steps"]
    curves = pd.DataFrame(points, columns=POINT).merge(last).drop_duplicates(key, keep="last")
    return curves.sort_values(key, ignore_index=True)


def _read_all(folders: Iterable[str | Path]) -> RowsAndPoints:
    """Reads folders, and renames runs in which one seed was trained from different policies.

    Elsewhere seeds that each started from a policy of their own count as trained the same.
    """
    rows, points = _read_each(folders)
    # The policies that each seed of a run was started from, in any of the folders.
    starts = {(row["run"], row["seed"], row[START]) for row in rows if START in row}
    counts = Counter((run, seed) for run, seed, _ in starts)
    with_several = {run for (run, _), number in counts.items() if number > 1}
    short = short_names(start for run, _, start in starts if run in with_several)
    renamed: dict[str, str] = {}  # folder of a seed -> its run
    for row in rows:
        start = row.pop(START, None)
        if start is not None and row["run"] in with_several:
            row["run"] += f"-{sha256(start.encode()).hexdigest()[:4]}"
            row["settings"] = _compact(json.loads(row["settings"]) | {"init_from": short[start]})
            renamed[row["folder"]] = row["run"]
    return rows, [point | {"run": renamed.get(point["folder"], point["run"])} for point in points]


def _read_each(folders: Iterable[str | Path]) -> RowsAndPoints:
    """Returns the rows and the points of learning curves of all folders."""
    rows: Rows = []
    points: Rows = []
    for folder in folders:
        more_rows, more_points = _read_folder(Path(folder))
        rows += more_rows
        points += more_points
    return rows, points


def _warn(text: str) -> None:
    warnings.warn(text, ResultsWarning, stacklevel=2)


def _read_folder(path: Path) -> RowsAndPoints:
    """Reads a folder of results, or all such folders in it. Raises ResultsError if there are none."""
    if not path.exists():
        raise ResultsError(f"there is no folder or file `{path}`")
    reader = _reader_of(path)
    if reader is not None:
        return reader(path)
    parts = sorted(path.iterdir()) if path.is_dir() else []
    with_results = [part for part in parts if _reader_of(part) is not None]
    if not with_results:
        raise ResultsError(f"`{path}` holds no results; name {KINDS}")
    return _read_each(with_results)


def _reader_of(path: Path) -> Callable[[Path], RowsAndPoints] | None:
    """Returns the function that reads a folder, by the files in it; None if there is none."""
    if not path.is_dir():
        return None
    if (path / SWEEP).exists() or (path / CELLS).is_dir():
        return _read_sweep
    if (path / MANIFEST).is_file():
        return _read_run
    plan = read_object(path / PLAN) or {}
    if (path / DIAGRAM).is_file() or plan.get("experiment") == "schelling":
        return lambda path: (_read_experiment(path, DIAGRAM, Diagram), [])
    if (path / CROSS_PLAY).is_file() or plan.get("experiment") == "crossplay":
        return lambda path: (_read_experiment(path, CROSS_PLAY, CrossPlay), [])
    return _read_report if (path / RESULTS).is_file() else None


def _read_report(path: Path) -> RowsAndPoints:
    """Reads the `data` of a report."""
    frame = read_frame(path / RESULTS, [name for name in COLUMNS if name not in ADDED])
    unknown = sorted(set(frame.status) - {"done", "failed", "unfinished", ""})
    if unknown:
        raise ResultsError(
            f"{path / RESULTS}: `status` is done, failed or unfinished, not `{unknown[0]}`"
        )
    for settings in set(frame.settings) - {""}:
        if not _is_json_table(settings):
            raise ResultsError(
                f"{path / RESULTS}: `settings` must be JSON with names, not `{settings[:80]}`"
            )
    rows = []
    for stored in frame.assign(folder=str(path)).to_dict("records"):
        row = {name: value for name, value in stored.items() if not pd.isna(value)}
        if row["record"] == "seed":
            row[GAME_NUMBERS] = stored_numbers(row)
        rows.append(row)
    if not (path / CURVES).is_file():
        return rows, []
    curves = read_frame(path / CURVES, [name for name in POINT if name != "folder"])
    return rows, curves.assign(folder=str(path)).to_dict("records")


def _is_json_table(text: str) -> bool:
    try:
        return isinstance(parse_json(text.encode()), dict)
    except ValueError:
        return False


# Sweeps, whose cells are ordinary runs.


def _read_sweep(path: Path) -> RowsAndPoints:
    """Reads the runs of a sweep; warns of cells that aren't trained, or have failed."""
    names = _cell_names(path)
    trained = [name for name in names if (path / CELLS / name / MANIFEST).is_file()]
    untrained = len(names) - len(trained)
    if untrained:
        cells, are = ("cell", "is") if untrained == 1 else ("cells", "are")
        _warn(f"{untrained} {cells} of the sweep `{path}` {are} not trained yet")
    for name in names:
        if (path / FAILED / f"{name}.json").is_file():
            _warn(f"the cell `{name}` of the sweep `{path}` has failed")
    return _read_each(path / CELLS / name for name in trained)


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


def _read_run(path: Path) -> RowsAndPoints:
    """Reads a run: a row for each seed, and the learning curves of those that are done."""
    rows: Rows = []
    points: Rows = []
    try:
        manifest = read_manifest(path)
        earlier = [read_manifest(folder) for folder in stage_folders(path)[:-1]]
        shared = columns_of_run(manifest, earlier)
        steps_before = sum(_steps_done(stage) for stage in earlier)
        for seed, folder in _seed_folders(path, manifest["config"]):
            row, curve = _read_seed(folder, seed, shared, manifest, steps_before)
            _check_types(row)
            rows.append(row)
            points += curve
    except (RunError, ConfigError) as error:
        _warn(f"{error}: {path} is left out")
        return [], []
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        _warn(f"{path / MANIFEST} is damaged ({type(error).__name__}: {error}): {path} is left out")
        return [], []
    _warn_of_seeds(path, manifest, rows)
    return rows, points


def columns_of_run(
    manifest: Mapping[str, Any], earlier: Sequence[Mapping[str, Any]] = ()
) -> dict[str, Any]:
    """Returns the columns that all seeds of a run have alike: its game, way of training and settings.

    Args:
      earlier: the manifests of the stages before.
    """
    game = manifest["game"]
    config = manifest["config"]
    provenance = manifest.get("provenance") or {}
    settings = {
        name: value
        for name, value in config.items()
        if name not in WITHOUT_EFFECT and not name.startswith(CHECKPOINTS)
    }
    start = settings.get("init_from")
    if start:
        settings["init_from"] = "a policy"
    if earlier:
        settings["stages"] = [_describe_stage(stage, config) for stage in earlier]
    elif manifest.get("stage", 1) > 1:
        settings["stages"] = f"stage {manifest['stage']} of a run"
    everything = {
        "hash": game["hash"],
        "params": game["params"],
        "agents": game["num_agents"],
        "config": settings,
    }
    tasks = tasks_played(game)
    if tasks:
        everything["tasks"] = tasks
    digest = sha256(json.dumps(everything, sort_keys=True).encode()).hexdigest()[:8]
    reward = str(config["reward"])
    columns = {
        "game": game["name"],
        "hash": game["hash"],
        "variant": provenance.get("variant") or "",
        "params": " ".join(_changed_numbers(game, provenance)),
        GAME_NUMBERS: numbers_of(game, flat_numbers(provenance.get("params") or {})),
        "map": _map_name(provenance.get("map")),
        "num_agents": game["num_agents"],
        "tasks": tasks,
        "run": f"{game['name']}-{Path(str(config['algorithm'])).stem}-{Path(reward).stem}-{digest}",
        "algorithm": config["algorithm"],
        "reward": reward_label(reward, "stages" in settings),
        "sharing": config.get("sharing", "shared"),
        "network": str(config["network"]),
        "total_timesteps": int(config["total_timesteps"]),
        "preset": preset_of(game["name"], settings),
    }
    named = {*METHOD}  # settings that have a column
    if reward == "exchange":
        columns["exchange_ratio"] = config["exchange_ratio"]
    if reward == "svo":
        columns["svo_weight"] = config["svo_weight"]
        angles = set(config.get("svo_angle", []))
        if len(angles) == 1:
            columns["svo_angle"] = angles.pop()
        else:
            named.remove("svo_angle")
    usual = stored_config({"algorithm": settings["algorithm"]}).model_dump(mode="json")
    unusual = {
        name: value
        for name, value in sorted(settings.items())
        if name not in named and value != usual.get(name)
    }
    columns["settings"] = _compact(unusual)
    if start:
        columns[START] = str(start)
    return columns


def _compact(settings: Mapping[str, Any]) -> str:
    return json.dumps(settings, separators=(",", ":"))


def _map_name(map_: Any) -> str:
    """Returns the file of a run's map; `own` for rows from Python, `""` for the game's own map."""
    if isinstance(map_, str):
        return Path(map_).name
    return "own" if map_ else ""


def tasks_played(game: Mapping[str, Any]) -> str:
    """Returns which tasks a run was trained on, or an experiment played: `held_out late`; empty in
    a game without tasks.

    game: in a manifest, or in the file of an experiment.
    """
    tasks = game.get("tasks") or ""
    if isinstance(tasks, Mapping):
        return " ".join(f"{name}={value}" for name, value in tasks.items())
    return f"{tasks} {game.get('split') or ''}".strip()


def _describe_stage(manifest: Mapping[str, Any], last: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the game of a stage, and the settings in which it differs from the last one. last: the configuration of that."""
    game = manifest["game"]
    settings = {key: value for key, value in manifest["config"].items() if value != last.get(key)}
    settings["init_from"] = "a policy" if settings.get("init_from") else ""
    if tasks := tasks_played(game):
        settings["tasks"] = tasks
    return {
        "hash": game["hash"],
        "params": " ".join(_changed_numbers(game, manifest.get("provenance") or {})),
        "num_agents": game["num_agents"],
        **settings,
    }


def _check_types(row: Mapping[str, Any]) -> None:
    """Raises ValueError, TypeError or OverflowError for a value of the wrong type for its column."""
    for name, value in row.items():
        if value is None:
            continue
        is_count = isinstance(value, int) and abs(value) < 2**63
        if (name in TEXTS and not isinstance(value, str)) or (name in COUNTS and not is_count):
            raise ValueError(f"its {name} is {value!r}")
        if name in NUMBERS:
            float(value)  # raises for what is no number


def _changed_numbers(game: Mapping[str, Any], provenance: Mapping[str, Any]) -> list[str]:
    """Returns the parameters, and perhaps the number of agents, that a run's user changed.

    Args:
      game: of the run's manifest: its `name`, `hash` and `params`.
      provenance: of the manifest: the `variant`, `params` and `num_agents` that the user asked for.
        It may be empty for a run that was started from Python; then the game itself is compared
        with the bundled one.

    Returns:
      `name=value` for each number that differs from its default in the variant, by name.
    """
    if "game" not in provenance:
        return other_numbers(game)
    asked_for = flat_numbers(provenance.get("params") or {})
    num_agents = provenance.get("num_agents")
    if num_agents is not None:
        asked_for["num_agents"] = num_agents
    variant = provenance.get("variant") or ""
    changed = []
    for name, value in sorted(asked_for.items()):
        if not is_usual(game["name"], variant, name, value):
            changed.append(as_assignment(name, value))
    return changed


def _seed_folders(path: Path, config: Mapping[str, Any]) -> list[tuple[int, Path]]:
    """Returns the seeds of a run, and the folder of each."""
    first = int(config["seed"])
    number = int(config["seeds"])
    if not 1 <= number <= MOST_SEEDS:
        raise ValueError(f"it has {number} seeds")
    if number == 1:
        return [(first, path)]
    return [(seed, path / f"seed_{seed}") for seed in range(first, first + number)]


def _steps_done(manifest: Mapping[str, Any]) -> int:
    """Returns the environment steps that a run has done, or a stage of one."""
    return int(manifest["updates"] * manifest["derived"]["steps_per_update"])


def _read_seed(
    folder: Path,
    seed: int,
    shared: Mapping[str, Any],
    manifest: Mapping[str, Any],
    steps_before: int,
) -> tuple[dict[str, Any], Rows]:
    """Returns the row of a seed, and its learning curve where it is done.

    Args:
      shared: the columns of all seeds of the run (`columns_of_run`).
      steps_before: environment steps in earlier stages.
    """
    if seed in [entry["seed"] for entry in manifest.get("diverged", ())]:
        status = "failed"
    else:
        status = "done" if manifest.get("status") == "finished" else "unfinished"
    device = manifest.get("device") or {}
    number = device.get("count", 1)
    kind = device.get("kind", "unknown")
    steps, returns = _read_curve(folder)
    row = {
        "record": "seed",
        **shared,
        "seed": seed,
        "status": status,
        "hardware": f"{number} x {kind}" if number > 1 else str(kind),
        "folder": str(folder),
    }
    if status != "done":
        return row | {"steps": int(max(steps, default=0)), "episodes": 0}, []
    means, episodes = _read_means(folder / EVALUATION)
    row |= {"steps": steps_before + _steps_done(manifest), "episodes": episodes}
    for name, mean in means.items():
        row["collective_return" if name == RETURN else name] = mean
    points = [
        {
            "run": shared["run"],
            "seed": seed,
            "env_steps": int(step),
            "collective_return": value,
            "folder": str(folder),
        }
        for step, value in zip(steps, returns, strict=True)
    ]
    return row, points


def _read_curve(folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """Returns environment steps and collective returns, `[P]` each: at most `POINTS`, each the mean of neighbouring updates.

    The steps are the ends of equal parts of the run, the same for all seeds.
    """
    steps, returns = figures(run_rows(folder), "collective_return")
    known = np.isfinite(returns)
    if not known.any():
        return np.zeros(0), np.zeros(0)
    steps_of_point = math.ceil(len(steps) / POINTS) * steps[0]
    ends = np.minimum(np.ceil(steps / steps_of_point) * steps_of_point, steps[-1])
    points = np.unique(ends[known])
    return points, np.array([returns[known & (ends == point)].mean() for point in points])


def _read_means(path: Path) -> tuple[dict[str, float], int]:
    """Returns the means of an evaluation of the last policy, without those of single agents, and its number of episodes.

    Empty if there is none, or if it was made with `--greedy` or `--drawn`.
    """
    stored = read_evaluation(path)
    if stored is None or stored.greedy is not None:
        return {}, 0
    figures = dict(stored.summary)
    for split, of_split in stored.held_out.items():
        figures |= {f"{name}{HELD_OUT}{split}": f for name, f in of_split.summary.items()}
        figures[f"{MINUS_HELD_OUT}{split}"] = of_split.training_minus_held_out
    means = {
        name: figure.mean
        for name, figure in figures.items()
        if " of agent " not in name and figure.mean is not None
    }
    return means, stored.episodes


def _warn_of_seeds(path: Path, manifest: Mapping[str, Any], rows: Rows) -> None:
    """Warns of the seeds of a run that are left out, or whose figures need care."""
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
    unevaluated = [row for row in done if "collective_return" not in row]
    damaged = [row for row in unevaluated if not (Path(row["folder"]) / POLICIES).is_dir()]
    if damaged:
        _warn(
            f"left out of `{path}`: {seeds_in_words(row['seed'] for row in damaged)}, without `{POLICIES}`"
        )
    if len(unevaluated) > len(damaged):
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


def _read_experiment(path: Path, name: str, kind: type[Diagram] | type[CrossPlay]) -> Rows:
    """Reads the file of a diagram or of cross-play; warns, and returns no rows, if there is none."""
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
    shared = {
        "game": game.name,
        "hash": game.hash,
        "num_agents": game.num_agents,
        "params": " ".join(other_numbers(game.model_dump())),
        "tasks": tasks_played(game.model_dump()),
        "folder": str(path),
    }
    rows = [_diagram_row(stored)] if isinstance(stored, Diagram) else _cross_play_rows(stored)
    return [shared | row for row in rows]


def _diagram_row(stored: Diagram) -> dict[str, Any]:
    """Returns the row of a stored Schelling diagram."""
    verdict = stored.verdict.model_dump()
    verdict["caution"] = stored.verdict.caution or ""
    sample = stored.model_dump(include={"cooperators", "defectors", "unit", "units", "episodes"})
    row = {"record": "diagram", **sample, **verdict}
    for contrast, figure in stored.contrasts.model_dump().items():
        for end, value in figure.items():  # mean, low and high
            row[f"{contrast}_{end}"] = value
    return row


def _cross_play_rows(stored: CrossPlay) -> Rows:
    """Returns a row for each policy and mixture, and one with the collective return of random policies alone."""
    rows: Rows = []
    has_usual_numbers = not other_numbers(stored.game.model_dump())
    for mixture in stored.mixtures:
        unit = mixture.unit or stored.unit
        for policy, figure in mixture.policies.items():
            rows.append(
                {
                    "record": "mixture",
                    "mixture": mixture.mixture,
                    "policy": policy,
                    **dict(figure),
                    "unit": unit,
                    "units": len(stored.keys) if unit == "training seed" else mixture.episodes,
                    "episodes": mixture.episodes,
                }
            )
        is_random = set(mixture.slots) == {"random"} and set(mixture.policies) == {"random"}
        if is_random and has_usual_numbers:
            of_agent = mixture.policies["random"]
            rows.append(
                {
                    "record": "random",
                    "collective_return": _of_all_agents(of_agent.mean, stored.game),
                    "low": _of_all_agents(of_agent.low, stored.game),
                    "high": _of_all_agents(of_agent.high, stored.game),
                    "episodes": mixture.episodes,
                }
            )
    return rows


def _of_all_agents(value: float | None, game: Game) -> float | None:
    return None if value is None else game.num_agents * value
