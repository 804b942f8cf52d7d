"""Games of the tests of sweeps, described without being made; and sweeps of a game so small that a cell trains in seconds."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sjdsl.sweeps.axes import read_axis
from sjdsl.sweeps.cells import Cell, SweepSpec
from sjdsl.sweeps.plan import plan_sweep

GAME = str(Path(__file__).parents[1] / "experiments" / "games" / "matrix_game.sj")
TINY: dict[str, Any] = {
    "network": "mlp",
    "network_width": 4,
    "num_envs": 4,
    "num_steps": 4,
    "num_minibatches": 1,
    "num_epochs": 1,
}
TINY |= {"total_timesteps": 16 * 4, "checkpoint_updates": 1, "seeds": 2}


def describe(
    game: str, variant: str | None, params: Mapping[str, Any], **others: Any
) -> tuple[dict[str, Any], str, str]:
    """Stands in for reading a game: it has the numbers `apple` and `regrow`, and its hash tells its variant."""
    name = Path(game).stem
    unknown = [param for param in params if param not in ("apple", "regrow")]
    if unknown:
        raise ValueError(f"the game has no number `{unknown[0]}`")
    provenance = {
        "game": game,
        "variant": variant,
        "map": None,
        "num_agents": None,
        "params": dict(params),
        **others,
    }
    return provenance, name, f"{name}-{variant}"


def plan(*axes: str, games: Sequence[str] = ("coins",), **changes: Any) -> tuple[Cell, ...]:
    """Returns the cells of a sweep without anything being made. `changes`: fields of `SweepSpec`."""
    settings = {"seeds": 2, **changes.pop("settings", {})}
    return plan_sweep(
        SweepSpec(games, [read_axis(axis) for axis in axes], settings, **changes), describe
    )
