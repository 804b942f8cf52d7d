"""Processes of this machine that run cells side by side, each with its share of the cores, and of
the GPUs.

XLA starts a thread for every core that a process may use. Two processes with a thread on each core
wait for one another at every operation that is divided among threads; with cores of its own, each
waits for nobody (docs/research/sweeps.md has the measurement).
"""

import multiprocessing
import os
import signal
import sys
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from sjdsl.sweeps.gpus import variables_of_workers, with_variables
from sjdsl.sweeps.work import REFUSALS, Watch, run_cell
from sjdsl.termination import TERMINATED, Terminated, raising_on_sigterm


@raising_on_sigterm()
def run_in_processes(
    folders: Sequence[Path],
    workers: int,
    gpus: Sequence[str] = (),
    run: Callable[[Path, Watch], Any] = run_cell,
) -> bool:
    """Runs the cells in these folders in several processes.

    Each process goes through all cells, and runs those that no other process is running or has run.
    Its lines go to standard error. Returns whether all processes came to the end; one that is
    killed, or whose disk is full, leaves its cell stopped.
    """
    spawn = multiprocessing.get_context("spawn")
    number = min(workers, len(folders))
    shares = shares_of(_usable_cores(), number)
    processes = [
        spawn.Process(target=_run_all, args=(run, folders, cores), daemon=True) for cores in shares
    ]
    # The processes inherit this: Ctrl-C is for this process, which then ends them.
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        try:
            variables_of_each = variables_of_workers(gpus, number)
            for process, variables in zip(processes, variables_of_each, strict=True):
                with with_variables(variables):  # they are set before the process imports JAX
                    process.start()
        finally:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        for process in processes:
            process.join()
    finally:
        running = [process for process in processes if process.is_alive()]
        for process in running:
            process.terminate()
        for process in running:
            process.join()  # it finishes an update and saves
    return all(process.exitcode == 0 for process in processes)


def shares_of(cores: Sequence[int], workers: int) -> list[tuple[int, ...]]:
    """Returns the cores of each of `workers` processes: equal shares to within one core; all cores
    for each if there are too few."""
    if workers > len(cores):
        return [tuple(cores)] * workers
    bounds = [len(cores) * number // workers for number in range(workers + 1)]
    return [tuple(cores[low:high]) for low, high in pairwise(bounds)]


def _usable_cores() -> list[int]:
    """Returns the cores that this process may use; none if the system (unlike Linux) doesn't let a
    process choose."""
    if not hasattr(os, "sched_getaffinity"):
        return []
    return sorted(os.sched_getaffinity(0))


@raising_on_sigterm()
def _run_all(
    run: Callable[[Path, Watch], Any], folders: Sequence[Path], cores: Sequence[int]
) -> None:
    """Runs cells in this process, in which JAX hasn't started yet: it starts a thread for each
    core.
    """
    if cores:
        os.sched_setaffinity(0, cores)
    watch = Watch(tell=lambda line: print(line, file=sys.stderr, flush=True))
    for folder in folders:
        try:
            run(folder, watch)
        except (OSError, *REFUSALS) as error:
            watch.tell(f"{folder.name}: {error}")
            sys.exit(1)
        except Terminated:
            os._exit(TERMINATED)  # as the command itself does: XLA may still be compiling
