"""A sweep as tasks of Ray, on a cluster or on this machine.

pip install 'sjdsl[ray]'
python examples/sweep_ray.py runs/rewards

The folder is one that all machines share. Started again, whatever went wrong, it goes on: cells that are done are kept.
"""

import sys

import ray

from sjdsl.sweeps import Axis, SweepSpec, prepare, run_cell

SPEC = SweepSpec(
    ["coins"], [Axis("reward", ("individual", "common"))], preset="two_cores", settings={"seeds": 3}
)


def main(folder: str, spec: SweepSpec = SPEC) -> list[str]:
    """Trains the cells of a sweep and returns how far each is: `done`, or `failed`."""
    ray.init()  # joins the cluster in RAY_ADDRESS, or else starts one here
    try:
        task = ray.remote(num_cpus=1)(run_cell)  # or num_gpus=1, for each cell
        return ray.get([task.remote(path) for path in prepare(spec, folder)])
    finally:
        ray.shutdown()


if __name__ == "__main__":
    print(main(sys.argv[1]))
