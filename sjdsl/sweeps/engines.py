"""Engines: what maps `run_cells` over the cells of a sweep, in this process, in others of this machine, or on many machines.

None of them keeps a queue of ours. Running a cell twice does it once, so that an engine may try again as it likes.
"""

import logging
import os
import signal
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal, get_args

from sjdsl.experiments.refusals import ExperimentError
from sjdsl.near_names import meant
from sjdsl.sweeps.claims import left_by
from sjdsl.sweeps.cores import processes
from sjdsl.sweeps.folder import FAILED, cells_of, progress_of, read_sweep, record_failure
from sjdsl.sweeps.work import Tell, Watch, run_cells
from sjdsl.trainers.progress import ProgressStyle

EngineName = Literal["local", "ray", "slurm"]
ENGINES: tuple[str, ...] = get_args(EngineName)
PACKAGES: Mapping[str, str] = {"ray": "ray", "slurm": "submitit"}
LOGS = "slurm"  # folder of the jobs' output and of what submitit keeps

Batch = tuple[str, ...]  # folders of cells that are run by one call of `run_cells`


@dataclass(frozen=True)
class Crew:
    """How a sweep is worked on."""

    engine: str = "local"
    workers: int | None = None  # processes or jobs at once; None: one, or with ray and slurm as many as there is room for
    options: Mapping[str, Any] = field(default_factory=dict)  # of the engine: `ray.remote` or submitit's `update_parameters`
    progress: ProgressStyle = "none"  # of runs in this process
    tell: Tell = lambda _: None


def check_engine(crew: Crew) -> None:
    """Raises ExperimentError for an engine that there is not, or whose package is not installed."""
    if crew.engine not in ENGINES:
        raise ExperimentError(f"there is no engine `{crew.engine}`{meant(crew.engine, ENGINES, 'the engines are')}")
    package = PACKAGES.get(crew.engine)
    if package is not None and find_spec(package) is None:
        raise ExperimentError(f"the engine {crew.engine} needs the package {package}: pip install 'sjdsl[{crew.engine}]'")
    if crew.engine == "local" and crew.options:
        raise ExperimentError(f"the engine local has no options: leave out {', '.join(crew.options)}, or name --engine ray or slurm")


def run_batches(batches: Sequence[Batch], crew: Crew) -> None:
    """Runs batches of cells, each once.

    Raises:
      DiskError, OSError: a disk is full; what was written before stays.
    """
    match crew.engine:
        case "ray":
            _with_ray(batches, crew)
        case "slurm":
            _with_slurm(batches, crew)
        case _ if (crew.workers or 1) > 1 and len(batches) > 1:
            _with_processes(batches, crew)
        case _:
            for batch in batches:
                run_cells(batch, Watch(crew.progress, crew.tell))


def _with_processes(batches: Sequence[Batch], crew: Crew) -> None:
    """Runs batches in spawned processes, which share the cores; one that the system kills costs its cell, and the others go on in new ones."""
    left = [*batches]
    while left:
        with processes(min(crew.workers or 1, len(left))) as pool:
            futures: dict[Future[list[str]], Batch] = {pool.submit(run_cells, batch): batch for batch in left}
            try:
                for done in as_completed(futures):
                    done.result()
                    left.remove(futures[done])
                    _tell_states(futures[done], crew.tell)
            except BrokenProcessPool:
                pass
            except BaseException:
                pool.shutdown(cancel_futures=True)
                raise
        died = [batch for batch in left if _blame(batch, crew.tell)]
        if left and not died:  # a process was killed between two cells: nobody is to blame, and the cells are run again
            crew.tell("a process was killed; another goes on in its place")


def _blame(batch: Batch, tell: Tell) -> bool:
    """Writes down the cells of a batch that a process died of; returns whether there are any."""
    found = False
    for folder in batch:
        path = Path(folder)
        holder = left_by(path.parents[1], path.name)
        if holder is not None and _is_open(path):
            reason = (
                f"its process was killed ({holder.host} {holder.pid}), perhaps for want of memory; --retry goes on from its last checkpoint"
            )
            _fail(path, reason, tell)
            found = True
    return found


def _is_open(path: Path) -> bool:
    sweep = path.parents[1]
    return not (sweep / FAILED / f"{path.name}.json").exists() and _state(path) in ("waiting", "stopped")


def _state(path: Path) -> str:
    known = read_sweep(path.parents[1])
    cell = next(cell for cell in cells_of(known) if cell.name == path.name)
    return progress_of(path.parents[1], cell, known["episodes"]).state


def _fail(path: Path, reason: str, tell: Tell) -> None:
    cell = next(cell for cell in cells_of(read_sweep(path.parents[1])) if cell.name == path.name)
    record_failure(path.parents[1], cell, reason)
    tell(f"{path.name}: failed, for {reason}")


def _tell_states(batch: Batch, tell: Tell) -> None:
    for folder in batch:
        tell(f"{Path(folder).name}: {_state(Path(folder))}")


def _with_ray(batches: Sequence[Batch], crew: Crew) -> None:
    """Runs batches as tasks of Ray, at most `workers` at once.

    They run in the cluster that RAY_ADDRESS names, else in one on this machine, which is ended afterwards.
    """
    import ray

    ours = not ray.is_initialized()
    if ours:
        here: dict[str, Any] = {} if os.environ.get("RAY_ADDRESS") else {"num_cpus": crew.workers, "include_dashboard": False}
        ray.init(log_to_driver=False, logging_level=logging.ERROR, **here)
    try:
        gpus = {"num_gpus": 1} if ray.cluster_resources().get("GPU") else {}
        task = ray.remote(run_cells).options(**{"num_cpus": 1, **gpus, **crew.options})
        left, waiting = [*batches], dict[Any, Batch]()
        while left or waiting:
            while left and len(waiting) < (crew.workers or len(batches)):  # a cluster may have room for more than are asked for
                batch = left.pop(0)
                waiting[task.remote(batch)] = batch
            (done,), _ = ray.wait([*waiting], num_returns=1)
            batch = waiting.pop(done)
            _take_result(partial(ray.get, done), batch, crew.tell, (ray.exceptions.WorkerCrashedError, ray.exceptions.OutOfMemoryError))
    finally:
        if ours:
            ray.shutdown()


def _take_result(result: Callable[[], Any], batch: Batch, tell: Tell, lost: tuple[type[Exception], ...]) -> None:
    """Takes what an engine says of a batch; the cells of one whose process is lost have failed, unless they are done or run elsewhere."""
    try:
        result()
    except lost as error:
        for folder in batch:
            if _is_open(Path(folder)):
                said = str(error).strip().splitlines()
                _fail(Path(folder), f"its process ended without a result: {said[0] if said else type(error).__name__}", tell)
        return
    _tell_states(batch, tell)


class SlurmCells:
    """What a job of Slurm does; when it is pre-empted, or its time is over, the cells are saved and the job is queued again."""

    def __call__(self, batch: Batch) -> list[str]:
        with _told_to_stop() as (stopping, queue_again):
            states = run_cells(batch, Watch(stop=stopping))
            if stopping():
                queue_again()
        return states

    def checkpoint(self, batch: Batch) -> Any:
        """Returns what submitit queues again: the same, which goes on with the cells where they were stopped."""
        from submitit.helpers import DelayedSubmission

        return DelayedSubmission(self, batch)


@contextmanager
def _told_to_stop() -> Iterator[tuple[Callable[[], bool], Callable[[], None]]]:
    """Yields whether submitit's signal has come, and what does then what submitit would have done at once.

    It would have cut the update under way in two, and lost all since the last checkpoint.
    """
    name = f"SIG{os.environ.get('SUBMITIT_PREEMPT_SIGNAL', 'USR2')}"
    number = getattr(signal, name)
    come: list[Any] = []
    theirs = signal.signal(number, lambda _, frame: come.append(frame))
    try:
        yield lambda: bool(come), lambda: theirs(number, come[-1]) if callable(theirs) else None
    finally:
        signal.signal(number, theirs)


def _with_slurm(batches: Sequence[Batch], crew: Crew) -> None:
    """Runs batches as one array of jobs of Slurm, and waits for them."""
    import submitit

    folder = Path(batches[0][0]).parents[1] / LOGS
    options = {"name": "sjdsl_sweep", **crew.options}
    try:
        executor = submitit.AutoExecutor(folder=folder, cluster=options.pop("cluster", "slurm"))
        parallel = {"slurm_array_parallelism": crew.workers} if crew.workers else {}
        executor.update_parameters(**{**parallel, **options})
        jobs = executor.map_array(SlurmCells(), batches)
    except (RuntimeError, NameError, TypeError, ValueError) as error:
        raise ExperimentError(f"the engine slurm: {error}") from None
    crew.tell(f"{len(jobs)} jobs are queued; their output is in {folder}")
    lost = (submitit.core.utils.FailedJobError, submitit.core.utils.UncompletedJobError)
    for job, batch in zip(jobs, batches, strict=True):
        _take_result(job.result, batch, crew.tell, lost)
