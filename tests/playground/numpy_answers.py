"""Prints what the studio answers about games, as a digest for each: with NumPy, or with the stand-in if its folder is on the path."""

import hashlib
import json
import sys
from pathlib import Path
from typing import Any

for _missing in ("PIL", "flax", "jax", "resvg_py", "scipy"):
    sys.modules[_missing] = None  # type: ignore[assignment]  # the playground has none of them

from sjdsl.library.games_folder import find_game, games_folder  # noqa: E402
from sjdsl.studio.bench import Bench  # noqa: E402
from sjdsl.studio.requests import READ  # noqa: E402


def answers(name: str) -> list[Any]:
    """Returns the answers to a few steps, with random and with scripted agents, and to all panels but the checks."""
    home = games_folder()
    bench, path = Bench(home), find_game(name)
    found: list[Any] = []

    def ask(**request: Any) -> None:
        found.append(bench.answer(READ.validate_json(json.dumps(request))))
        assert "refused" not in found[-1], found[-1]

    ask(
        do="text",
        version=1,
        path=path.relative_to(home).as_posix(),
        text=Path(path).read_text(encoding="utf-8"),
    )
    for _ in range(8):
        ask(do="step")
    for panel in ("state", "seen", "trace", "rules", "python"):
        ask(do="panel", panel=panel)
    for policy in bench.opened.game.policies[:1]:
        ask(do="others", policy=policy.name)
        ask(do="step")
    ask(do="share")
    return found


def plain(value: Any) -> Any:
    """Returns answers as JSON holds them: a real of 32 bits of the stand-in is a float."""
    if isinstance(value, dict):
        return {key: plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    return float(value) if isinstance(value, float) else value


if __name__ == "__main__":
    import numpy

    print(Path(numpy.__file__).parent.parent.name)
    for game in sys.argv[1:]:
        print(
            game,
            hashlib.sha256(json.dumps(plain(answers(game)), allow_nan=False).encode()).hexdigest(),
        )
