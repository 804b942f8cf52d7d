"""A training run from a fresh folder to a trained policy."""

import math
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax
import numpy as np

from .config import Config
from .environment import Environment
from .ppo import Metrics, TrainState, make_train
from .progress import ProgressStyle, show_progress
from .run_folder import (
    MANIFEST,
    Row,
    describe_run,
    draw_learning_curve,
    open_metrics,
    write_checkpoint,
    write_json,
)


class RunError(Exception):
    """A run cannot start, or cannot go on."""


@dataclass(frozen=True)
class Result:
    """A finished run."""

    run_dir: Path
    parameters: Any  # of the network, after the last update
    rows: tuple[Row, ...]  # one per update, as in metrics.jsonl
    compile_seconds: float
    seconds: float  # compiling included


def train(
    env: Environment,
    config: Config,
    run_dir: Path | str,
    progress: ProgressStyle = "auto",
    provenance: Mapping[str, Any] | None = None,
) -> Result:
    """Trains IPPO and writes manifest, metrics, checkpoints and learning curve to `run_dir` as it goes.

    Args:
      env: one environment, from `sjdsl.make`.
      config: the run's configuration, seed included.
      run_dir: a new or empty folder.
      progress: `bar` (rich), `lines`, `none`; `auto` is `bar` on a terminal and `lines` elsewhere.
      provenance: JSON values kept in the manifest, such as the arguments `env` was made with.
    Raises:
      RunError: the folder is in use, or training diverged; what was written until then stays.
      ConfigError: the configuration does not fit the environment.
    """
    run_dir = Path(run_dir)
    started = time.perf_counter()
    program = make_train(env, config)
    if run_dir.exists() and (not run_dir.is_dir() or any(run_dir.iterdir())):
        raise RunError(f"{run_dir} is not empty; name a new folder, so that no earlier run is lost")
    run_dir.mkdir(parents=True, exist_ok=True)

    rows: list[Row] = []
    title = f"{env.name}, {config.reward} reward"
    with (
        _manifest(run_dir, describe_run(env, config, provenance or {})) as manifest,
        show_progress(progress, config.num_updates, title) as show,
    ):
        state = jax.jit(program.init)(jax.random.key(config.seed))
        update = jax.jit(program.update).lower(state).compile()
        manifest["compile_seconds"] = compile_seconds = time.perf_counter() - started
        try:
            state = _run_updates(update, state, config, run_dir, rows, show)
        finally:
            draw_learning_curve(run_dir, rows, f"{title}, IPPO, seed {config.seed}")
            manifest["updates"] = len(rows)
            manifest["seconds"] = seconds = time.perf_counter() - started
    return Result(run_dir, jax.device_get(state.learner.params), tuple(rows), compile_seconds, seconds)


def _run_updates(
    update: Callable[[TrainState], tuple[TrainState, Metrics]],
    state: TrainState,
    config: Config,
    run_dir: Path,
    rows: list[Row],
    show: Callable[[Row], None],
) -> TrainState:
    """Runs all updates and returns the last state; appends to `rows` as it goes, for a caller that is interrupted."""
    last = started = time.perf_counter()
    with open_metrics(run_dir) as append:
        try:
            for number in range(1, config.num_updates + 1):
                advanced, metrics = update(state)
                measured = flatten_metrics(jax.device_get(metrics))
                now = time.perf_counter()
                row = {
                    "update": number,
                    "env_steps": number * config.steps_per_update,
                    "seconds": now - started,
                    "steps_per_second": config.steps_per_update / (now - last),
                    **measured,
                }
                last = now
                append(row)
                if not math.isfinite(row["loss"]):
                    raise RunError(
                        f"the loss became {row['loss']} in update {number}; try a smaller learning_rate than {config.learning_rate:g}"
                    )
                state = advanced
                rows.append(row)
                show(row)
                if config.checkpoint_every and number % config.checkpoint_every == 0:
                    write_checkpoint(run_dir, state.learner.params, row)
        finally:
            if rows:
                write_checkpoint(run_dir, state.learner.params, rows[-1])
    return state


@contextmanager
def _manifest(run_dir: Path, manifest: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Writes the manifest at the start, and again with how the run ended."""
    write_json(run_dir / MANIFEST, manifest)
    try:
        yield manifest
        manifest["status"] = "finished"
    except KeyboardInterrupt:
        manifest["status"] = "interrupted"
        raise
    except BaseException as error:
        manifest["status"] = f"failed: {error}"
        raise
    finally:
        write_json(run_dir / MANIFEST, manifest)


def flatten_metrics(metrics: Metrics) -> Row:
    """Returns metrics as flat numbers: `{"event": {"eaten": [3, 4]}}` becomes `event_eaten_agent_0` and `…_1`.

    Raw and shaped returns are per agent; their means over agents are `return` and `shaped_return`.
    """
    row: Row = {}
    for name, value in metrics.items():
        match name:
            case "agent_return" | "shaped_agent_return":
                short = name.replace("agent_", "")
                row[short] = float(np.mean(value))
                row |= _per_agent(short, value)
            case "event" | "mean" | "final" | "metric":
                for inner, count in value.items():
                    row |= _per_agent(f"{name}_{inner}", count)
            case _:
                row[name] = np.asarray(value).item()
    return row


def _per_agent(name: str, value: Any) -> Row:
    if np.ndim(value) == 0:
        return {name: np.asarray(value).item()}
    return {f"{name}_agent_{index}": entry.item() for index, entry in enumerate(np.asarray(value))}
