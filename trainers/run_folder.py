"""The files of a run: everything is on disk as soon as it is known, so that an interrupted run keeps it."""

import csv
import importlib.metadata
import json
import math
import os
import platform
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import flax.serialization
import jax
import numpy as np
from jax.tree_util import keystr, tree_leaves_with_path

from .config import Config
from .environment import Environment, reset_shapes

MANIFEST = "manifest.json"
METRICS_JSONL = "metrics.jsonl"
METRICS_CSV = "metrics.csv"
LEARNING_CURVE = "learning_curve.png"
CHECKPOINTS = "checkpoints"

Row = dict[str, Any]  # one line of the metrics: column -> number; NaN where there is none


def describe_run(env: Environment, config: Config, provenance: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the manifest of a run that starts now; `provenance` is the caller's account of how `env` was made."""
    device = jax.devices()[0]
    observation, _ = reset_shapes(env)
    return {
        "status": "running",
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
        "seed": config.seed,
        "game": {
            "name": env.name,
            "hash": env.hash,
            "params": {keystr(path, simple=True): leaf for path, leaf in tree_leaves_with_path(env.params)},
            "num_agents": env.num_agents,
            "action_names": list(env.action_names),
            "observation_shape": list(observation.shape),
        },
        "provenance": dict(provenance),
        "config": config.model_dump(),
        "versions": {"python": platform.python_version()} | {name: _version(name) for name in _PACKAGES},
        "device": {"platform": device.platform, "kind": device.device_kind, "count": jax.device_count()},
    }


_PACKAGES = ("sjdsl", "jax", "jaxlib", "flax", "optax", "numpy")


def _version(package: str) -> str | None:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Writes a JSON file whole or not at all; arrays become lists, and what is not finite becomes null."""
    _write_whole(path, (json.dumps(_plain(content), indent=2, allow_nan=False) + "\n").encode())


def _plain(value: Any) -> Any:
    match value:
        case Mapping():
            return {key: _plain(entry) for key, entry in value.items()}
        case list() | tuple():
            return [_plain(entry) for entry in value]
        case np.ndarray() | np.generic() | jax.Array():
            return _plain(np.asarray(value).tolist())
        case float():
            return value if math.isfinite(value) else None
        case _:
            return value


def _write_whole(path: Path, content: bytes) -> None:
    unfinished = path.with_name(path.name + ".unfinished")
    unfinished.write_bytes(content)
    os.replace(unfinished, path)


@contextmanager
def open_metrics(run_dir: Path) -> Iterator[Callable[[Row], None]]:
    """Yields a function that appends one row to both metrics files and flushes them. All rows have the same columns."""
    with (
        open(run_dir / METRICS_JSONL, "w", encoding="utf-8") as lines,
        open(run_dir / METRICS_CSV, "w", encoding="utf-8", newline="") as table,
    ):
        writer = csv.writer(table)

        def append(row: Row) -> None:
            known = _plain(row)
            if table.tell() == 0:
                writer.writerow(known)
            writer.writerow(known.values())
            lines.write(json.dumps(known) + "\n")
            table.flush()
            lines.flush()

        yield append


def write_checkpoint(run_dir: Path, parameters: Any, row: Row) -> Path:
    """Writes the network's parameters after an update, and beside them what is known of that update."""
    (run_dir / CHECKPOINTS).mkdir(exist_ok=True)
    path = run_dir / CHECKPOINTS / f"{row['update']:08d}.msgpack"
    _write_whole(path, flax.serialization.to_bytes(jax.device_get(parameters)))
    write_json(path.with_suffix(".json"), row)
    return path


def read_parameters(checkpoint: Path) -> Any:
    """Returns the parameters in a checkpoint, as a tree of NumPy arrays."""
    return flax.serialization.msgpack_restore(checkpoint.read_bytes())


def draw_learning_curve(run_dir: Path, rows: Sequence[Row], title: str) -> None:
    """Draws the collective return of finished episodes over environment steps; nothing if no episode finished."""
    from matplotlib.figure import Figure  # here: importing it costs as much as a short test

    finished = [row for row in rows if row["episodes"] > 0]
    if not finished:
        return
    figure = Figure(figsize=(7, 4), layout="constrained")
    axes = figure.add_subplot()
    steps = [row["env_steps"] for row in finished]
    axes.plot(steps, [row["collective_return"] for row in finished], label="collective, raw", color="black")
    agents = [name for name in finished[0] if name.startswith("return_agent_")]
    for index, name in enumerate(agents):
        axes.plot(steps, [row[name] for row in finished], label=f"agent {index}, raw", linewidth=0.8)
    axes.set(xlabel="environment steps", ylabel="return per episode", title=title)
    axes.grid(alpha=0.3)
    axes.legend(fontsize="small", ncols=2 if len(agents) > 4 else 1)
    figure.savefig(run_dir / LEARNING_CURVE, dpi=120)
