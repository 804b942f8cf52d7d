"""Protocols: sweeps of the SocialJax paper by name, as lists of points."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

from sjdsl.library.games_folder import games_folder

Protocol = Literal["exchange", "svo", "algorithms", "sharing"]
PROTOCOLS: tuple[str, ...] = get_args(Protocol)
RATIOS = (0.25, 0.5, 0.75)  # of exchanged rewards, between individual and common; source: the paper's table of returns
WEIGHTS = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)  # of SVO, at 90 degrees; source: the paper's protocol
ANGLES = (0.0, 22.5, 45.0, 67.5, 90.0)  # degrees of SVO, at the best weight; source: the paper's table of angles
FULL = 90.0  # degrees

# The settings that a protocol sets itself, so that no axis and no other option may.
SETS: Mapping[str, tuple[str, ...]] = {
    "exchange": ("reward", "exchange_ratio"),
    "svo": ("reward", "svo_weight", "svo_angle"),
    "algorithms": ("algorithm", "reward", "svo_angle"),
    "sharing": ("sharing",),
}


@dataclass(frozen=True)
class Point:
    """One place of a protocol: the settings it has, and its name."""

    values: Mapping[str, Any] = field(default_factory=dict)
    place: Any = None
    stage: int = 1


def points_of(protocol: str | None, game: str, settings: Mapping[str, Any]) -> list[Point]:
    """Returns the points of a protocol's first stage; without a protocol, one point that sets nothing.

    Args:
      game: by the name in its file.
      settings: of the configuration; if they have an exchange ratio, `algorithms` uses it.
    """
    match protocol:
        case "exchange":
            between = [Point({"reward": "exchange", "exchange_ratio": ratio}, ratio) for ratio in RATIOS]
            return [Point({"reward": "individual"}, 0.0), *between, Point({"reward": "common"}, 1.0)]
        case "svo":
            return [Point({"reward": "svo", "svo_weight": weight, "svo_angle": FULL}, weight) for weight in WEIGHTS]
        case "algorithms":
            return _columns(game, settings)
        case "sharing":
            return [Point({"sharing": way}, way) for way in ("shared", "per_agent")]
    return [Point()]


def angles_at(weight: float) -> list[Point]:
    """Returns the second stage of `svo`: the angles, at the weight that was best in the first. At weight 0 all are the same, so one."""
    angles = ANGLES if weight > 0 else (FULL,)
    return [Point({"reward": "svo", "svo_weight": weight, "svo_angle": angle}, angle, stage=2) for angle in angles]


def _columns(game: str, settings: Mapping[str, Any]) -> list[Point]:
    """Returns the six columns of the paper's table of metrics.

    Its column of exchanged rewards has the best ratio of each game, not ratio 1: the published one, unless the settings have another.
    """
    published = tomllib.loads((games_folder() / "published.toml").read_text(encoding="utf-8"))["exchange"]["games"].get(game)
    ratio = settings.get("exchange_ratio", None if published is None else float(published["chosen"]))  # printed in bold
    exchange = {"algorithm": "ippo", "reward": "exchange"} | ({} if ratio is None else {"exchange_ratio": ratio})
    return [
        Point({"algorithm": "ippo", "reward": "individual"}, "ippo_individual"),
        Point({"algorithm": "ippo", "reward": "common"}, "ippo_common"),
        Point({"algorithm": "mappo", "reward": "common"}, "mappo"),
        Point({"algorithm": "vdn", "reward": "common"}, "vdn"),
        Point(exchange, "exchange"),
        Point({"algorithm": "ippo", "reward": "svo", "svo_angle": FULL}, "svo_90"),
    ]
