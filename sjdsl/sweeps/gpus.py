"""The GPUs of this machine, shared out among the processes of a sweep.

Left to itself, JAX would give each process all GPUs, and reserve most of their memory for the
first.
"""

import os
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import jax

from sjdsl.experiments.refusals import ExperimentError

VISIBLE = "CUDA_VISIBLE_DEVICES"
RESERVING = "XLA_PYTHON_CLIENT_PREALLOCATE"
# Variables by which the user has decided how much memory a process takes.
MEMORY = (
    RESERVING,
    "XLA_CLIENT_MEM_FRACTION",
    "XLA_PYTHON_CLIENT_MEM_FRACTION",
    "XLA_PYTHON_CLIENT_ALLOCATOR",
)
# A machine with an NVIDIA GPU has one of these devices; the last under WSL.
DEVICES = ("/dev/nvidiactl", "/dev/nvidia0", "/dev/dxg")
COUNT = "import jax; print(sum(device.platform == 'gpu' for device in jax.devices()))"  # a program


def gpus_for_workers(workers: int) -> list[str]:
    """Returns the GPUs for so many worker processes, by their names in `CUDA_VISIBLE_DEVICES`.

    There are none for a single worker, which is this process. If there are any, this process
    computes on the CPU from now on: on a GPU, it would take memory from a worker.

    Raises:
      ExperimentError: JAX doesn't start.
    """
    gpus = usable_gpus() if workers > 1 else []
    if gpus:
        jax.config.update("jax_platforms", "cpu")
    return gpus


def usable_gpus() -> list[str]:
    """Returns the GPUs that JAX uses on this machine, by their names in `CUDA_VISIBLE_DEVICES`.

    There are none without an NVIDIA GPU, or if JAX doesn't use it. If the user has listed GPUs,
    only these count. Another process counts them, as JAX takes memory of each GPU in the process
    where it starts.
    """
    if not any(Path(device).exists() for device in DEVICES):
        return []
    counting = subprocess.run(
        [sys.executable, "-c", COUNT],
        env={**os.environ, RESERVING: "false"},
        capture_output=True,
        text=True,
        check=False,
    )
    if counting.returncode:
        reason = (counting.stderr.strip() or "it was killed").splitlines()[-1]
        raise ExperimentError(f"JAX doesn't start, so its GPUs can't be counted: {reason}")
    count = int(counting.stdout.split()[-1])
    listed = os.environ.get(VISIBLE)
    if listed is None:
        return [str(number) for number in range(count)]
    names = [name.strip() for name in listed.split(",")]
    # Of the parts of a GPU (MIG), a process sees only the first.
    are_parts = count == 1 and names[0].startswith("MIG-")
    return names if are_parts else names[:count]


def variables_of_workers(gpus: Sequence[str], workers: int) -> list[dict[str, str]]:
    """Returns the environment variables of each worker, which gets one of the GPUs in turn; none
    without GPUs."""
    if not gpus:
        return [{} for _ in range(workers)]
    are_shared = workers > len(gpus)
    memory = {}
    if are_shared and not any(name in os.environ for name in MEMORY):
        memory[RESERVING] = "false"
    return [{VISIBLE: gpus[number % len(gpus)], **memory} for number in range(workers)]


def describe_shares(gpus: Sequence[str], workers: int) -> str:
    """Returns how workers share GPUs, in words."""
    if workers > len(gpus):
        shared = "1 GPU" if len(gpus) == 1 else f"{len(gpus)} GPUs"
        return f"{workers} processes share {shared}"
    text = f"{workers} processes have a GPU each"
    idle = len(gpus) - workers
    if idle:
        text += f"; {idle} more {'are' if idle > 1 else 'is'} not used"
    return text


@contextmanager
def with_variables(variables: Mapping[str, str]) -> Iterator[None]:
    """Sets environment variables, for processes that start in the block."""
    before = dict(os.environ)
    os.environ.update(variables)
    try:
        yield
    finally:
        os.environ.clear()
        os.environ.update(before)
