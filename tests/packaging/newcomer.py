"""The path of a newcomer, timed: from `pip install` of this tree's wheel to a changed rule that moves (`make newcomer`).

It installs into a new environment from the index that pip uses, with nothing of pip's cache, of sjdsl's or of JAX's. It does what
README.md says: a new game, a page of it, a changed rule, and the page of that.
"""

import json
import os
import re
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

GOAL = 120.0  # seconds on the clock
RULE, CHANGED = (
    "0: 0, 1..: regrow",
    "0: 1, 1..: 1",
)  # a bare tree bears again at once, whatever is near
LINE = "{:44} {:>9} {:>10}"

Run = Callable[..., object]


def walk(run: Run, sjdsl: Path, folder: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Begins a game in a folder, changes one of its rules, and returns what the pages before and after show.

    run: called with the words of each command, which it runs in the folder.
    """
    run(sjdsl, "new", "pond")
    run(sjdsl, "render", "pond.sj", "-o", "before.html")
    game = folder / "pond.sj"
    text = game.read_text("utf-8")
    assert text.count(RULE) == 1
    game.write_text(text.replace(RULE, CHANGED), "utf-8")
    run(sjdsl, "check", "pond.sj")
    run(sjdsl, "render", "pond.sj", "-o", "after.html")
    return shown(folder / "before.html"), shown(folder / "after.html")


def shown(page: Path) -> dict[str, Any]:
    """Returns the data of an episode's page."""
    found = re.search(
        r"<script[^>]*application/json[^>]*>(.*?)</script>", page.read_text("utf-8"), re.DOTALL
    )
    assert found is not None
    return dict(json.loads(found[1]))


def differs(before: dict[str, Any], after: dict[str, Any]) -> bool:
    """Whether two episodes begin alike, and go on otherwise."""
    return bool(
        before["moments"][0] == after["moments"][0] and before["moments"] != after["moments"]
    )


def main() -> int:
    """Walks the path in a temporary folder and prints what each step takes; returns 1 if it takes longer than the goal."""
    repository = Path(__file__).parents[2]
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        own = {
            "XDG_CACHE_HOME": str(folder / "cache"),
            "SJDSL_CACHE": str(folder / "cache/sjdsl"),
            "PIP_NO_CACHE_DIR": "1",
        }
        environment = {
            name: value
            for name, value in os.environ.items()
            if not name.startswith(("JAX_", "PYTHON"))
        } | own
        seconds: list[tuple[float, float]] = []

        def run(*command: str | Path) -> None:
            began, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run(
                [str(part) for part in command],
                cwd=folder,
                env=environment,
                check=True,
                stdout=subprocess.DEVNULL,
            )
            spent, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
            processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            seconds.append((spent, processor))
            words = [Path(command[0]).name, *(str(part) for part in command[1:])]
            print(
                LINE.format(
                    " ".join(Path(word).name for word in words)[:44],
                    f"{spent:.1f}",
                    f"{processor:.1f}",
                ),
                flush=True,
            )

        print(LINE.format("what", "seconds", "processor"))
        run(
            sys.executable,
            "-m",
            "pip",
            "wheel",
            "-q",
            "--no-deps",
            "--no-build-isolation",
            "-w",
            folder / "dist",
            repository,
        )
        run(sys.executable, "-m", "venv", "own")
        (wheel,) = (folder / "dist").glob("*.whl")
        seconds.clear()  # what comes before `pip install` is not the newcomer's
        run(folder / "own/bin/pip", "install", "-q", "--disable-pip-version-check", wheel)
        pages = walk(run, folder / "own/bin/sjdsl", folder)
    spent, processor = (sum(part) for part in zip(*seconds, strict=True))
    print(LINE.format("from `pip install` to a changed rule", f"{spent:.1f}", f"{processor:.1f}"))
    if not differs(*pages):
        print("the changed rule was not seen")
        return 1
    if spent > GOAL:
        print(f"longer than {GOAL:.0f} seconds")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
