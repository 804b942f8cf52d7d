"""Runs a whole training: starts a new folder or resumes one, runs all updates, and returns the trained policies."""

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext, suppress
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from itertools import pairwise, zip_longest
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from sjdsl.several import several
from sjdsl.termination import raising_on_sigterm

from .algorithms import make_train
from .checkpoints import Checkpoints, resumption
from .compiled import NoMemoryError, compile_train, peak_megabytes, with_spread_starts
from .config import Config, ConfigError, PPOConfig, stored_config
from .environment import Environment, episode_length
from .extensions import short_name
from .learning_signs import said_once
from .loggers import LoggerName
from .manifest import MANIFEST
from .metric_rows import mean_row
from .metrics_files import Row, run_rows
from .policies import Policy, parameter_shapes, trained_policy
from .policy_file import START, copy_policy, policy_path, read_policy
from .processes import any_process, is_first
from .progress import ProgressStyle, show_progress
from .recorder import open_recorders
from .resuming import check_same_run, extended
from .run_errors import DiskError, RunError
from .run_files import write_json
from .run_folder import describe_run, seed_folders
from .run_lock import is_unused, locked
from .run_state import FINISHED
from .stages import STAGES, check_settings, stage_folders
from .updates import (
    AfterUpdate,
    Callback,
    Keeping,
    Progress,
    Update,
    describe_divergence,
    diverged_before,
    of_seed,
    run_updates,
)

WAITING = "waiting"  # the status of a stage that hasn't begun
NOT_EMPTY = (
    "{} is not empty; name a new folder, so that no earlier run is lost, or resume the run in it"
)

__all__ = ["Result", "RunError", "Stage", "check_stages", "resume", "train"]


@dataclass(frozen=True)
class Stage:
    """A stage of a run."""

    env: Environment
    config: Config
    provenance: Mapping[str, Any] = field(default_factory=dict)  # how `env` was made, as in `train`


@dataclass(frozen=True)
class _Part:
    """A stage of a run in its folder, or a run without stages."""

    env: Environment
    config: Config
    folder: Path
    manifest: dict[str, Any]  # updated as the run goes on
    number: int  # of the stage, from 1; 0: the run has no stages
    before: "_Part | None"

    @property
    def steps_before(self) -> int:
        """Environment steps of the stages before, for each seed."""
        before = self.before
        return (
            0
            if before is None
            else before.steps_before + before.config.num_updates * before.config.steps_per_update
        )


@dataclass(frozen=True)
class Result:
    """A finished run."""

    run_dir: Path
    parameters: Any  # of the networks, after the last update; those of several seeds are stacked
    updates: int
    diverged: Mapping[
        int, int
    ]  # seed -> the update in which its loss was not finite, while other seeds went on
    folders: tuple[Path, ...]  # of each seed
    compile_seconds: float
    seconds: float  # compiling included
    peak_megabytes: float  # the most memory this process, or the device, held
    stage: int = 0  # that before the last in which its callback ended the run; 0: none

    @property
    def rows(self) -> tuple[Row, ...]:
        """One row an update of all stages, read from metrics.jsonl; with several seeds, the means over those that learnt."""
        seeds = zip_longest(*map(run_rows, self.folders))
        return tuple(mean_row([row for row in rows if row is not None]) for rows in seeds)


def train(
    env: Environment,
    config: Config,
    run_dir: Path | str,
    progress: ProgressStyle = "auto",
    provenance: Mapping[str, Any] | None = None,
    loggers: LoggerName | Sequence[LoggerName] = (),
    asked: Mapping[str, Any] | None = None,
    callback: Callback | None = None,
    earlier: Sequence[Stage] = (),
) -> Result:
    """Trains, and writes manifest, metrics, checkpoints, policies and learning curve to `run_dir` along the way.

    Args:
      env: one environment, from `sjdsl.make`.
      config: the run's configuration, seed included.
      run_dir: a new or empty folder.
      progress: `bar` (rich), `lines`, `none`; `auto` is `bar` on a terminal and `lines` elsewhere.
      provenance: JSON values for the manifest, such as the arguments that made `env`.
      loggers: where metrics go as well: `tensorboard`, `wandb`, or both.
      asked: further JSON values for the manifest, for when the run is resumed.
      callback: called with an `Update` after each update, in the first of several processes; the run ends there if it returns True.
      earlier: stages before the training in `env`. Each stage starts from the policies of the one before; all have the same seeds. Their
        folders are `stages/1`, `stages/2` and so on in `run_dir`.
    Raises:
      RunError: the folder isn't empty, or another process trains there; every seed diverged, or one before the last stage; or the disk or
        the memory is full. What was written before stays.
      ConfigError: a configuration doesn't fit its environment, or a stage can't follow the one before. PolicyError: a policy that one names
        can't be read.
    """
    run_dir = Path(run_dir)
    if any_process(not is_unused(run_dir)):
        raise RunError(NOT_EMPTY.format(run_dir))
    stages = [*earlier, Stage(env, config, provenance or {})]
    check_stages(stages)  # fails before the folder is made if something doesn't fit
    with _lock(run_dir):
        if is_first() and not is_unused(run_dir):  # another process was faster
            raise RunError(NOT_EMPTY.format(run_dir))
        more = {"loggers": list(several(loggers)), "asked": dict(asked or {})}
        parts = _parts(
            run_dir,
            stages,
            [describe_run(one.env, one.config, one.provenance) | more for one in stages],
        )
        for part in parts:
            part.folder.mkdir(parents=True, exist_ok=True)
        if is_first():
            _prepare(parts)
        return _run(parts, progress, callback)


def _parts(
    run_dir: Path, stages: Sequence[Stage], manifests: Sequence[dict[str, Any]]
) -> list[_Part]:
    """Returns the stages of a run as parts, in order."""
    parts: list[_Part] = []
    for number, (stage, manifest) in enumerate(zip(stages, manifests, strict=True), 1):
        folder = run_dir if number == len(stages) else run_dir / STAGES / str(number)
        before = parts[-1] if parts else None
        parts.append(
            _Part(
                stage.env, stage.config, folder, manifest, number if len(stages) > 1 else 0, before
            )
        )
    return parts


def _prepare(parts: Sequence[_Part]) -> None:
    """Writes what a run starts from, and the manifests of all stages but the last."""
    *earlier, last = parts
    if parts[0].config.init_from:
        copy_policy(parts[0].config.init_from, parts[0].folder / START)
    for part in earlier:
        part.manifest.update(status=WAITING, stage=part.number)
        write_json(part.folder / MANIFEST, part.manifest)
    if earlier:
        last.manifest[STAGES] = [str(part.folder.relative_to(last.folder)) for part in earlier]


def check_stages(stages: Sequence[Stage], place: str = STAGES) -> None:
    """Checks that each stage fits its environment, and can continue with the parameters of the one before.

    Args:
      place: of the stages, for messages.
    Raises:
      ConfigError: one doesn't. PolicyError: as in `train`.
    """
    check_settings([stage.config for stage in stages], place)
    programs = [make_train(stage.env, stage.config) for stage in stages]
    for number, (before, stage) in enumerate(pairwise(stages), 2):
        if programs[number - 1].adopt is None:
            raise ConfigError(
                f"{place}[{number}]: this algorithm can't start from a policy: its `Train` has no `adopt`"
            )
        if _shapes(before) != _shapes(stage):
            raise ConfigError(
                f"{place}[{number}]: its networks have other shapes than those of the stage before: {_unlike(before, stage)}"
            )


def _shapes(stage: Stage) -> Any:
    return jax.tree.map(lambda leaf: leaf.shape, parameter_shapes(stage.env, stage.config))


def _unlike(before: Stage, stage: Stage) -> str:
    """Returns what may be why networks differ, in words."""
    reasons = []
    if before.env.num_agents != stage.env.num_agents:
        reasons.append(
            f"there are {before.env.num_agents} agents before, and {stage.env.num_agents} here"
        )
    if isinstance(stage.config, PPOConfig) and stage.config.sharing == "per_agent":
        reasons.append("each agent has a network of its own (`sharing=per_agent`)")
    if isinstance(stage.config, PPOConfig) and stage.config.algorithm == "mappo":
        reasons.append(f"the central critic reads the {stage.config.critic} of all agents")
    return "; ".join(reasons) or "observations, actions, partners or settings of your own differ"


def resume(
    env: Environment,
    run_dir: Path | str,
    progress: ProgressStyle = "auto",
    loggers: LoggerName | Sequence[LoggerName] | None = None,
    asked: Mapping[str, Any] | None = None,
    callback: Callback | None = None,
    total_timesteps: int | None = None,
    provenance: Mapping[str, Any] | None = None,
    earlier: Sequence[Environment] = (),
) -> Result:
    """Resumes a run from its last checkpoint; on a CPU it ends with the metrics of a run that was never stopped.

    Args:
      env: made as the run's manifest says.
      run_dir: the folder of a run that was stopped, in whatever way.
      progress, loggers, asked, callback: as in `train`; loggers and `asked` stay those of the run unless given.
      total_timesteps: makes the run longer, even a finished one. From there on, schedules over the whole run (of the learning rate, for
        example) are those of the longer run.
      provenance: how `env` was made, where the run's game has moved.
      earlier: the environments of the stages before the last, if the run has any.
    Raises:
      RunError: there is no such run, it is a stage of another, or another process trains in its folder; it was of another game or other
        versions, or has done more steps already; or rows of its metrics are lost.
    """
    run_dir = Path(run_dir)
    check_same_run(env, run_dir)
    environments, folders = [*earlier, env], stage_folders(run_dir)
    if len(environments) != len(folders):
        raise RunError(
            f"{run_dir} has {len(folders)} stages: `earlier` must have the environments of the first {len(folders) - 1}"
        )
    with _lock(run_dir):
        manifests = [
            check_same_run(one, folder) for one, folder in zip(environments, folders, strict=True)
        ]  # no other process writes now
        last = manifests[-1]
        if "stage" in last:
            raise RunError(
                f"{run_dir} is stage {last['stage']} of a run: resume {run_dir.parents[1]}"
            )
        if total_timesteps is not None:
            last |= extended(last, run_dir, total_timesteps)
        if provenance is not None:
            last["provenance"] = dict(provenance)
        last["status"] = "running"
        for manifest in manifests:
            if manifest.get("status") != WAITING:
                manifest["resumed"] = [
                    *manifest.get("resumed", []),
                    datetime.now(UTC).isoformat(timespec="seconds"),
                ]
            manifest["loggers"] = list(
                manifest.get("loggers", ()) if loggers is None else several(loggers)
            )
            manifest["asked"] = manifest.get("asked", {}) | dict(asked or {})
        stages = [
            Stage(one, stored_config(manifest["config"]))
            for one, manifest in zip(environments, manifests, strict=True)
        ]
        return _run(_parts(run_dir, stages, manifests), progress, callback)


def _lock(run_dir: Path) -> AbstractContextManager[None]:
    """Returns the lock of a run's folder, in the process that writes there."""
    return locked(run_dir) if is_first() else nullcontext()


@raising_on_sigterm()
def _run(parts: Sequence[_Part], progress: ProgressStyle, callback: Callback | None) -> Result:
    """Runs the remaining updates of all stages; if a callback ends the run in one before the last, returns the result of that."""
    *earlier, last = parts
    with recording_status(last.folder, last.manifest):
        for part in earlier:
            if part.manifest.get("status") != FINISHED:
                part.manifest["status"] = "running"
                with recording_status(part.folder, part.manifest):
                    result = _run_part(part, progress, callback)
                if part.manifest["status"] != FINISHED:
                    last.manifest["status"] = part.manifest["status"]
                    return replace(result, stage=part.number)
            if diverged := part.manifest.get("diverged"):
                said = describe_divergence({entry["seed"]: entry["update"] for entry in diverged})
                raise RunError(
                    f"stage {part.number}: {said}. The next stage starts only if no seed diverged"
                )
        return _run_part(last, progress, callback)


def _run_part(part: _Part, progress: ProgressStyle, callback: Callback | None) -> Result:
    """Runs the remaining updates of a stage; its manifest is updated as the run goes on."""
    began = time.perf_counter()
    env, config, manifest = part.env, part.config, part.manifest
    folders = seed_folders(part.folder, config)
    title = (
        f"{env.name}, {short_name(config.algorithm)}, {short_name(config.reward)} reward"
        + f", stage {part.number}" * (part.number > 0)
    )
    # The policy it began with may be gone from its old place, so a run has a copy of its own.
    start = {"init_from": str(part.folder / START)} if (part.folder / START).is_file() else {}
    with ExitStack() as stack:
        style = progress if is_first() else "none"
        show = stack.enter_context(
            show_progress(style, config.num_updates, title, config.seeds, part.steps_before)
        )
        compiled = compile_train(
            make_train(env, config.model_copy(update=start)), config, _parameters_before(part)
        )
        compiled = with_spread_starts(compiled, config, episode_length(env))
        checkpoints = Checkpoints(part.folder)
        state, done = checkpoints.restore_last(compiled.start())
        goes_on = done > 0 or part.before is None
        if (
            "resumed" in manifest
            and goes_on
            and done < config.num_updates
            and progress != "none"
            and is_first()
        ):
            print(f"{title}: {resumption(done)}", flush=True)
        manifest.update(compile_seconds=compiled.seconds, program_megabytes=compiled.megabytes)
        recorders = stack.enter_context(
            open_recorders(
                folders, env, config, done, manifest["loggers"], title, part.steps_before
            )
        )
        so_far = Progress(done, diverged_before(state, recorders, config))
        try:
            keeping = Keeping(
                recorders, checkpoints.save, show, steps_before=part.steps_before, stage=part.number
            )
            if callback is not None and is_first():
                keeping = replace(
                    keeping, after_update=_call_after_update(callback, env, config, part.folder)
                )
            state = run_updates(compiled, state, so_far, config, keeping)
        finally:
            manifest.update(
                updates=so_far.updates,
                warnings=said_once(
                    {recorder.seed: recorder.history.warnings for recorder in recorders}
                ),
                diverged=[
                    {"seed": seed, "update": update} for seed, update in so_far.diverged.items()
                ],
                seconds=time.perf_counter() - began,
                peak_megabytes=peak_megabytes(),
            )
        if so_far.stopped:
            manifest["status"] = f"stopped by its callback after update {so_far.updates}"
        parameters = jax.device_get(compiled.parameters(state))
    seconds = time.perf_counter() - began
    return Result(
        part.folder,
        parameters,
        so_far.updates,
        so_far.diverged,
        folders,
        compiled.seconds,
        seconds,
        peak_megabytes(),
    )


def _parameters_before(part: _Part) -> Any:
    """Returns the parameters at the end of the stage before, with a first axis for several seeds; None if there is none."""
    if part.before is None:
        return None
    any_process(False)  # waits until the first process has written them
    seeds = []
    for folder in seed_folders(part.before.folder, part.before.config):
        parameters, _ = read_policy(
            policy_path(folder, "last"), lambda config: parameter_shapes(part.env, config)
        )
        if parameters is None:
            raise RunError(
                f"the last policy of {folder} has other networks than stage {part.number}"
            )
        seeds.append(parameters)
    return jax.tree.map(lambda *leaves: np.stack(leaves), *seeds) if len(seeds) > 1 else seeds[0]


def _call_after_update(
    callback: Callback, env: Environment, config: Config, run_dir: Path
) -> AfterUpdate:
    """Returns a function that calls the callback with an `Update`, and returns whether it ends the run."""

    def after_update(
        number: int, rows: Sequence[Row], learning: Sequence[int], parameters: Any
    ) -> bool:
        def policy_of(seed: int) -> Policy:
            own = of_seed(parameters, config.seed_numbers.index(seed), config)
            return trained_policy(
                env, config, jax.tree.map(jnp.copy, own)
            )  # the next update reuses their memory

        known = {config.seed_numbers[index]: rows[index] for index in learning}
        row = mean_row([*known.values()])
        return callback(Update(number, row["env_steps"], row, known, run_dir, policy_of)) is True

    return after_update


@contextmanager
def recording_status(run_dir: Path, manifest: dict[str, Any]) -> Iterator[None]:
    """Writes the manifest at the start, and again with how the run ended; turns faults of memory and disk into RunErrors."""
    if is_first():
        write_json(run_dir / MANIFEST, manifest)
    try:
        yield
        if manifest["status"] == "running":
            manifest["status"] = "finished"
    except KeyboardInterrupt:
        manifest["status"] = "interrupted"
        raise
    except BaseException as error:
        manifest["status"] = f"failed: {error}"
        if isinstance(error, NoMemoryError):
            raise RunError(str(error)) from None
        if isinstance(error, OSError):
            raise DiskError(_disk_message(error, run_dir)) from error
        raise
    finally:
        if is_first():
            with suppress(OSError):  # a full disk leaves the manifest from the start
                write_json(run_dir / MANIFEST, manifest)


def _disk_message(error: OSError, run_dir: Path) -> str:
    """Returns the message about a disk; of several errors, about the first, as a full disk also fails what is tried afterwards."""
    faults: list[OSError] = []
    fault: BaseException | None = error
    while fault is not None:
        faults += [fault] if isinstance(fault, OSError) else []
        fault = fault.__context__
    first = next((fault for fault in reversed(faults) if fault.filename), faults[-1])
    where = first.filename or run_dir
    return f"{where} could not be written: {first.strerror or first}. What was saved before is whole: make room, and resume {run_dir}"
