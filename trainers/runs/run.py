"""Runs a whole training: in a new folder or a resumed one, all updates of all stages."""

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext, suppress
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from itertools import pairwise, zip_longest
from pathlib import Path
from typing import Any

import jax
import numpy as np

from sjdsl.several import several
from sjdsl.termination import raising_on_sigterm

from ..devices.processes import any_process, is_first
from ..environment import Environment, episode_length
from ..json_files import write_json
from ..policies.loading import parameter_shapes
from ..policies.policy_file import START, copy_policy, policy_path, read_policy
from ..settings.config import Config, ConfigError, stored_config
from ..settings.stage_settings import STAGES, check_settings
from .checkpoints import Checkpoints, resumption
from .compiled import NoMemoryError, compile_train, peak_megabytes, with_spread_starts
from .learning_signs import said_once
from .loggers import LoggerName
from .make_train import make_train
from .manifest import MANIFEST
from .metric_rows import mean_row
from .metrics_files import Row, run_rows
from .progress import ProgressStyle, show_progress
from .recorder import open_recorders
from .resuming import check_same_run, extend_manifest
from .run_errors import DiskError, RunError
from .run_folder import describe_run
from .run_lock import is_unused, locked
from .run_stage import RunStage
from .run_state import FINISHED
from .stages import stage_folders
from .updates import Callback, Loop, describe_divergence, diverged_before

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
class Result:
    """A finished run."""

    run_dir: Path
    parameters: Any  # of the networks, after the last update; those of several seeds are stacked
    updates: int
    # seed -> the update in which its loss was not finite, while other seeds went on
    diverged: Mapping[int, int]
    folders: tuple[Path, ...]  # of each seed
    compile_seconds: float
    seconds: float  # compiling included
    peak_megabytes: float  # the most memory this process, or the device, held
    stage: int = 0  # that before the last in which its callback ended the run; 0: none

    @property
    def rows(self) -> tuple[Row, ...]:
        """One row an update of all stages, read from metrics.jsonl.

        With several seeds, they are means over those that learnt.
        """
        means = []
        for rows in zip_longest(*map(run_rows, self.folders)):  # of the seeds, in one update
            means.append(mean_row([row for row in rows if row is not None]))
        return tuple(means)


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
    """Trains, and writes manifest, metrics, checkpoints, policies and learning curve to `run_dir`.

    Args:
      env: one environment, from `sjdsl.make`.
      config: the run's configuration, seed included.
      run_dir: a new or empty folder.
      progress: `bar` (rich), `lines`, `none`; `auto` is `bar` on a terminal and `lines` elsewhere.
      provenance: JSON values for the manifest, such as the arguments that made `env`.
      loggers: where metrics go as well: `tensorboard`, `wandb`, or both.
      asked: further JSON values for the manifest, for when the run is resumed.
      callback: called with an `Update` after each update, in the first of several processes; the
        run ends there if it returns True.
      earlier: stages before the training in `env`. Each stage starts from the policies of the one
        before; all have the same seeds. Their folders are `stages/1`, `stages/2` and so on in
        `run_dir`.
    Raises:
      RunError: the folder isn't empty, or another process trains there; every seed diverged, or one
        before the last stage; or the disk or the memory is full. What was written before stays.
      ConfigError: a configuration doesn't fit its environment, or a stage can't follow the one
        before. PolicyError: a policy that one names can't be read.
    """
    run_dir = Path(run_dir)
    if any_process(not is_unused(run_dir)):
        raise RunError(NOT_EMPTY.format(run_dir))
    stages = [*earlier, Stage(env, config, provenance or {})]
    check_stages(stages)  # fails before the folder is made if something doesn't fit
    with _lock(run_dir):
        if is_first() and not is_unused(run_dir):  # another process was faster
            raise RunError(NOT_EMPTY.format(run_dir))
        options = {"loggers": list(several(loggers)), "asked": dict(asked or {})}
        manifests = [
            describe_run(stage.env, stage.config, stage.provenance) | options for stage in stages
        ]
        run_stages = _place_stages(run_dir, stages, manifests)
        for stage in run_stages:
            stage.folder.mkdir(parents=True, exist_ok=True)
        if is_first():
            _write_start(run_stages)
        return _run_stages(run_stages, progress, callback)


def _place_stages(
    run_dir: Path, stages: Sequence[Stage], manifests: Sequence[dict[str, Any]]
) -> list[RunStage]:
    """Returns the stages of a run in their folders, in order."""
    before: RunStage | None = None
    run_stages = []
    for number, (stage, manifest) in enumerate(zip(stages, manifests, strict=True), 1):
        folder = run_dir if number == len(stages) else run_dir / STAGES / str(number)
        shown = number if len(stages) > 1 else 0
        before = RunStage(stage.env, stage.config, folder, manifest, shown, before)
        run_stages.append(before)
    return run_stages


def _write_start(stages: Sequence[RunStage]) -> None:
    """Writes what a run starts from, and the manifests of all stages but the last."""
    *earlier, last = stages
    if stages[0].config.init_from:
        copy_policy(stages[0].config.init_from, stages[0].folder / START)
    for stage in earlier:
        stage.manifest.update(status=WAITING, stage=stage.number)
        write_json(stage.folder / MANIFEST, stage.manifest)
    if earlier:
        last.manifest[STAGES] = [str(stage.folder.relative_to(last.folder)) for stage in earlier]


def check_stages(stages: Sequence[Stage], place: str = STAGES) -> None:
    """Checks that each stage fits its environment, and can continue from the one before.

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
                f"{place}[{number}]: this algorithm can't start from a policy: "
                "its `Train` has no `adopt`"
            )
        if _shapes(before) != _shapes(stage):
            raise ConfigError(
                f"{place}[{number}]: its networks have other shapes than those of the stage "
                "before, as observations, actions, partners or settings of your own differ, or, "
                "with `sharing=per_agent` or a critic of all observations or of the state, the number of agents, "
                f"{before.env.num_agents} before and {stage.env.num_agents} here"
            )


def _shapes(stage: Stage) -> Any:
    """Returns the shapes of the parameters of a stage's networks."""
    return jax.tree.map(lambda leaf: leaf.shape, parameter_shapes(stage.env, stage.config))


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
    """Resumes a run from its last checkpoint.

    On a CPU it ends with the metrics of a run that was never stopped.

    Args:
      env: made as the run's manifest says.
      run_dir: the folder of a run that was stopped, in whatever way.
      progress, loggers, asked, callback: as in `train`; loggers and `asked` stay those of the run
        unless given.
      total_timesteps: makes the run longer, even a finished one. From there on, schedules over the
        whole run (of the learning rate, for example) are those of the longer run.
      provenance: how `env` was made, where the run's game has moved.
      earlier: the environments of the stages before the last, if the run has any.
    Raises:
      RunError: there is no such run, it is a stage of another, or another process trains in its
        folder; it was of another game or other versions, or has done more steps already; or rows of
        its metrics are lost.
    """
    run_dir = Path(run_dir)
    check_same_run(env, run_dir)
    environments = [*earlier, env]
    folders = stage_folders(run_dir)
    if len(environments) != len(folders):
        raise RunError(
            f"{run_dir} has {len(folders)} stages: "
            f"`earlier` must have the environments of the first {len(folders) - 1}"
        )
    with _lock(run_dir):
        # read again, as no other process writes now
        manifests = [
            check_same_run(env, folder) for env, folder in zip(environments, folders, strict=True)
        ]
        last = manifests[-1]
        if "stage" in last:
            raise RunError(
                f"{run_dir} is stage {last['stage']} of a run: resume {run_dir.parents[1]}"
            )
        if total_timesteps is not None:
            last.update(extend_manifest(last, run_dir, total_timesteps))
        if provenance is not None:
            last["provenance"] = dict(provenance)
        last["status"] = "running"
        now = datetime.now(UTC).isoformat(timespec="seconds")
        for manifest in manifests:
            if manifest.get("status") != WAITING:
                manifest["resumed"] = [*manifest.get("resumed", []), now]
            if loggers is not None or "loggers" not in manifest:
                manifest["loggers"] = list(several(loggers or ()))
            manifest.setdefault("asked", {}).update(asked or {})
        stages = [
            Stage(env, stored_config(manifest["config"]))
            for env, manifest in zip(environments, manifests, strict=True)
        ]
        return _run_stages(_place_stages(run_dir, stages, manifests), progress, callback)


def _lock(run_dir: Path) -> AbstractContextManager[None]:
    """Returns the lock of a run's folder, in the process that writes there."""
    return locked(run_dir) if is_first() else nullcontext()


@raising_on_sigterm()
def _run_stages(
    stages: Sequence[RunStage], progress: ProgressStyle, callback: Callback | None
) -> Result:
    """Runs the remaining updates of all stages.

    If a callback ends the run in a stage before the last, it returns the result of that.
    """
    *earlier, last = stages
    with recording_status(last.folder, last.manifest):
        for stage in earlier:
            manifest = stage.manifest
            if manifest.get("status") != FINISHED:
                manifest["status"] = "running"
                with recording_status(stage.folder, manifest):
                    result = _run_stage(stage, progress, callback)
                if manifest["status"] != FINISHED:
                    last.manifest["status"] = manifest["status"]
                    return replace(result, stage=stage.number)
            diverged = {entry["seed"]: entry["update"] for entry in manifest.get("diverged", ())}
            if diverged:
                raise RunError(
                    f"stage {stage.number}: {describe_divergence(diverged)}. "
                    "The next stage starts only if no seed diverged"
                )
        return _run_stage(last, progress, callback)


def _run_stage(stage: RunStage, progress: ProgressStyle, callback: Callback | None) -> Result:
    """Runs the remaining updates of a stage; its manifest is updated as the run goes on."""
    began = time.perf_counter()
    config = stage.config
    manifest = stage.manifest
    with ExitStack() as stack:
        style = progress if is_first() else "none"
        steps_before = stage.steps_after(0)
        show = stack.enter_context(
            show_progress(style, config.num_updates, stage.title, config.seeds, steps_before)
        )
        to_compile = config
        if (stage.folder / START).is_file():
            # The policy it began with may be gone from its old place, so a run has a copy.
            start = {"init_from": str(stage.folder / START)}
            to_compile = config.model_copy(update=start)
        compiled = compile_train(
            make_train(stage.env, to_compile), config, _parameters_before(stage)
        )
        compiled = with_spread_starts(compiled, config, episode_length(stage.env))
        checkpoints = Checkpoints(stage.folder)
        state, done = checkpoints.restore_last(compiled.start())
        is_resumed = "resumed" in manifest and (done > 0 or stage.before is None)
        if is_resumed and done < config.num_updates and style != "none":
            print(f"{stage.title}: {resumption(done)}", flush=True)
        manifest.update(compile_seconds=compiled.seconds, program_megabytes=compiled.megabytes)
        recorders = stack.enter_context(open_recorders(stage, done))
        loop = Loop(
            stage=stage,
            compiled=compiled,
            state=state,
            recorders=recorders,
            save=checkpoints.save,
            show=show,
            callback=callback if is_first() else None,
            updates=done,
            diverged=diverged_before(state, recorders, config),
        )
        try:
            loop.run()
        finally:
            warnings = {recorder.seed: recorder.history.warnings for recorder in recorders}
            manifest.update(
                updates=loop.updates,
                warnings=said_once(warnings),
                diverged=[
                    {"seed": seed, "update": update} for seed, update in loop.diverged.items()
                ],
                seconds=time.perf_counter() - began,
                peak_megabytes=peak_megabytes(),
            )
        if loop.stopped:
            manifest["status"] = f"stopped by its callback after update {loop.updates}"
        return Result(
            run_dir=stage.folder,
            parameters=jax.device_get(compiled.parameters(loop.state)),
            updates=loop.updates,
            diverged=loop.diverged,
            folders=stage.seed_folders,
            compile_seconds=compiled.seconds,
            seconds=manifest["seconds"],
            peak_megabytes=manifest["peak_megabytes"],
        )


def _parameters_before(stage: RunStage) -> Any:
    """Returns the parameters at the end of the stage before, or None.

    If there are several seeds, they are on a first axis.
    """
    if stage.before is None:
        return None
    any_process(False)  # waits for the first process, which writes them
    seeds = []
    for folder in stage.before.seed_folders:
        file = policy_path(folder, "last")
        parameters, _ = read_policy(file, lambda config: parameter_shapes(stage.env, config))
        if parameters is None:
            raise RunError(
                f"the last policy of {folder} has other networks than stage {stage.number}"
            )
        seeds.append(parameters)
    if len(seeds) == 1:
        return seeds[0]
    return jax.tree.map(lambda *leaves: np.stack(leaves), *seeds)


@contextmanager
def recording_status(run_dir: Path, manifest: dict[str, Any]) -> Iterator[None]:
    """Writes the manifest at the start, and again with how the run ended.

    Faults of memory and disk become RunErrors.
    """
    if is_first():
        write_json(run_dir / MANIFEST, manifest)
    try:
        yield
        if manifest["status"] == "running":
            manifest["status"] = FINISHED
    except KeyboardInterrupt:
        manifest["status"] = "interrupted"
        raise
    except BaseException as error:
        manifest["status"] = f"failed: {error}"
        if isinstance(error, NoMemoryError):
            raise RunError(str(error)) from None
        if isinstance(error, OSError):
            raise DiskError(
                f"{error.filename or run_dir} could not be written: {error.strerror or error}. "
                f"What was saved before is whole: make room, and resume {run_dir}"
            ) from error
        raise
    finally:
        if is_first():
            with suppress(OSError):  # a full disk leaves the manifest from the start
                write_json(run_dir / MANIFEST, manifest)
