"""Shares of this machine's cores, for processes that work side by side.

XLA starts a thread for every core that a process may use. Two processes with a thread on each core wait for one another at every
operation that is divided among threads; with cores of its own each waits for nobody (docs/sweeps.md has the measurement).
"""

import multiprocessing
import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import pairwise
from typing import Any


def processes(workers: int) -> ProcessPoolExecutor:
    """Returns a pool of spawned processes that have a share of the cores each, where the system lets a process choose (Linux)."""
    spawn = multiprocessing.get_context("spawn")
    if not hasattr(os, "sched_setaffinity"):
        return ProcessPoolExecutor(workers, mp_context=spawn)
    shares = spawn.SimpleQueue()
    for share in shares_of(sorted(os.sched_getaffinity(0)), workers):
        shares.put(share)
    return ProcessPoolExecutor(workers, mp_context=spawn, initializer=_take_share, initargs=(shares,))


def shares_of(cores: Sequence[int], workers: int) -> list[tuple[int, ...]]:
    """Returns the cores of each of `workers` processes: equal shares but for one core; all of them where there are too few."""
    if workers > len(cores):
        return [tuple(cores)] * workers
    bounds = [len(cores) * number // workers for number in range(workers + 1)]
    return [tuple(cores[low:high]) for low, high in pairwise(bounds)]


def _take_share(shares: Any) -> None:
    """Keeps this process to the next share; called before the process has started JAX, whose threads are then as many."""
    os.sched_setaffinity(0, shares.get())
