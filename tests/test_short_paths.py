"""Short names of paths tell them apart."""

import pytest

from sjdsl.short_paths import short_names


@pytest.mark.parametrize(
    ("names", "short"),
    [
        (["random", "stay"], ["random", "stay"]),
        (["/work/runs/a", "random"], ["a", "random"]),
        (["runs/a/cell", "runs/b/cell"], ["a", "b"]),
        (["/long/way/to/a", "elsewhere/b", "c"], ["a", "b", "c"]),
        (["a/x/1", "a/y/1", "a/x/2"], ["x/1", "y/1", "x/2"]),
        (["runs/a", "runs/a/seed_0"], ["a", "seed_0"]),
        (["runs/a@best", "runs/a@120"], ["a@best", "a@120"]),
        (["runs/random", "random"], ["runs/random", "random"]),
        (["runs/a", "runs//a"], ["runs/a", "runs//a"]),
        ([], []),
    ],
)
def test_short_names(names: list[str], short: list[str]) -> None:
    assert short_names(names) == dict(zip(names, short, strict=True))
