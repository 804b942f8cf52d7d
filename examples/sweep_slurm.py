"""A sweep as an array of jobs of Slurm, by submitit.

pip install 'sjdsl[slurm]'
python examples/sweep_slurm.py runs/rewards

The folder is one that all machines share. A job that is pre-empted, or whose time is over, is queued again and goes on from its cell's
last checkpoint. Without submitit, `sbatch --array=1-8` of the ordinary command `sjdsl sweep … --run DIR` does the same: each job takes
the cells that no other has.
"""

import sys
from pathlib import Path

import submitit

from sjdsl.sweeps import Axis, SweepSpec, prepare, run_cell

SPEC = SweepSpec(
    ["coins"], [Axis("reward", ("individual", "common"))], preset="two_cores", settings={"seeds": 3}
)


class Cell:
    """What a job does: it runs a cell."""

    def __call__(self, path: Path) -> str:
        return run_cell(path)

    def checkpoint(self, path: Path) -> submitit.helpers.DelayedSubmission:
        """Returns what is queued again: the same, for `run_cell` goes on where it was stopped."""
        return submitit.helpers.DelayedSubmission(self, path)


def main(folder: str, spec: SweepSpec = SPEC, cluster: str = "slurm") -> list[str]:
    """Trains the cells of a sweep and returns how far each is: `done`, or `failed`."""
    executor = submitit.AutoExecutor(f"{folder}_logs", cluster=cluster)
    executor.update_parameters(
        name="sjdsl_sweep", timeout_min=600
    )  # and slurm_partition, gpus_per_node, slurm_array_parallelism, …
    return [job.result() for job in executor.map_array(Cell(), prepare(spec, folder))]


if __name__ == "__main__":
    print(main(sys.argv[1]))
