"""Processes of this machine that run cells side by side, each with its share of the cores.

XLA starts a thread for every core that a process may use. Two processes with a thread on each core wait for one another at every
operation that is divided among threads; with cores of its own each waits for nobody (docs/sweeps.md has the measurement).
"""

import multiprocessing
import os
import signal
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, contextmanager
from itertools import pairwise
from pathlib import Path

from sjdsl.sweeps.folder import cell_at, progress_of, record_failure
from sjdsl.sweeps.work import Tell, run_cell

INTERRUPTED = 130  # the exit status of what Ctrl-C ended
KILLED = "its process was killed, perhaps because memory ran out; --retry resumes it from its last checkpoint"


def run_in_processes(folders: Sequence[Path], workers: int, tell: Tell) -> None:
    """Runs the cells in these folders, each once. If a process is killed, its cell fails, and another process replaces it.

    Raises:
      DiskError, OSError: a disk is full; what was written before stays.
    """
    left = [*folders]
    running: dict[Future[str], tuple[Path, ProcessPoolExecutor, tuple[int, ...]]] = {}
    with ExitStack() as stack:

        def start(cores: tuple[int, ...]) -> ProcessPoolExecutor:
            """Returns a pool of one process, which ends with the others."""
            spawn = multiprocessing.get_context("spawn")
            pool = ProcessPoolExecutor(1, mp_context=spawn, initializer=_keep_to, initargs=(cores,))
            stack.callback(pool.shutdown, cancel_futures=True)
            return pool

        free = [(start(cores), cores) for cores in shares_of(_usable_cores(), min(workers, len(left)))]
        while left or running:
            while left and free:
                pool, cores = free.pop(0)
                try:
                    with _interrupts_held_back():  # here the process starts
                        future = pool.submit(run_cell, left[0])
                except BrokenProcessPool:  # its process was killed while idle
                    free.append((start(cores), cores))
                    continue
                running[future] = left.pop(0), pool, cores
            done, _ = wait(running, return_when=FIRST_COMPLETED)
            for future in done:
                folder, pool, cores = running.pop(future)
                sweep, known, cell = cell_at(folder)
                try:
                    future.result()
                except BrokenProcessPool:
                    if progress_of(sweep, cell, known["episodes"]).state in ("waiting", "stopped"):  # not done, or run by another process
                        record_failure(sweep, cell, KILLED)
                    pool = start(cores)
                free.append((pool, cores))
                tell(f"{cell.name}: {progress_of(sweep, cell, known['episodes']).summary}")


def shares_of(cores: Sequence[int], workers: int) -> list[tuple[int, ...]]:
    """Returns the cores of each of `workers` processes: equal shares to within one core; all cores for each if there are too few."""
    if workers > len(cores):
        return [tuple(cores)] * workers
    bounds = [len(cores) * number // workers for number in range(workers + 1)]
    return [tuple(cores[low:high]) for low, high in pairwise(bounds)]


def _usable_cores() -> list[int]:
    """Returns the cores that this process may use; none if the system doesn't let a process choose (Linux does)."""
    return sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else []


def _keep_to(cores: tuple[int, ...]) -> None:
    """Keeps this process to its cores; called before the process has started JAX, whose threads are then as many."""
    if cores:
        os.sched_setaffinity(0, cores)
    try:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    except KeyboardInterrupt:  # pressed while modules were loaded: nothing has begun
        os._exit(INTERRUPTED)


@contextmanager
def _interrupts_held_back() -> Iterator[None]:
    """Delays Ctrl-C, which reaches all processes of a terminal: one that starts inherits this, and would print a traceback while it loads."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
