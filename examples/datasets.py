"""Episodes recorded by `sjdsl record`, read back one at a time: how often each action was taken, and what it came to."""

import tempfile
from pathlib import Path

import numpy as np

from sjdsl.cli import run
from sjdsl.replay import Dataset


def main() -> float:
    """Returns the mean collective return of the recorded episodes."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "coins.npz"
        run(
            [
                "record",
                "coins",
                "--episodes",
                "3",
                "--param",
                "length=50",
                "--param",
                "spawn=0.02",
                "-o",
                str(path),
            ]
        )
        dataset = Dataset(path)
        taken = sum(
            np.bincount(episode.actions.ravel(), minlength=len(dataset.header.action_names))
            for episode in dataset
        )
        print(dict(zip(dataset.header.action_names, taken.tolist(), strict=True)))
        return float(dataset.returns.sum(axis=1).mean())


if __name__ == "__main__":
    main()
