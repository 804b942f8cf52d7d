"""The model `luna` of a server on this machine, and commands in which it plays."""

import json
from pathlib import Path
from typing import Any

GAMES = Path(__file__).parents[1] / "experiments/games"
MATRIX = GAMES / "matrix_game.sj"
VISITORS = GAMES / "visitors.sj"
KEY = "sk-another-secret"
ROLES = ("--cooperators", "models.toml:luna+cooperator", "--defectors", "models.toml:luna+defector")
SCHELLING = ("schelling", str(MATRIX), *ROLES, "--episodes", "2", "-o", "out")
CALLS = 48  # of that: three line-ups of two agents, two episodes of four steps


def by_role(body: dict[str, Any]) -> str:
    """Cooperators stay and defectors betray, as their text says who they are."""
    system = body["messages"][0]["content"]
    is_selfish = "not what others get" in system or "whatever it costs others" in system
    action = "betray" if is_selfish else "stay"
    return json.dumps({"why": "my part", "goal": "", "note": {"op": "none"}, "action": action})


def write_models(folder: Path, url: str, model: str = "m") -> None:
    """Writes the file that names it."""
    (folder / "models.toml").write_text(
        f'[luna]\nurl = "{url}"\nmodel = "{model}"\nkey = "LUNA_KEY"\nretries = 1\n'
        "price = { input = 1, cached = 0.1, output = 10 }\n"
    )
