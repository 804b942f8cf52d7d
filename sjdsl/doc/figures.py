"""Measures the returns of a random policy in a game, and keeps them in a file with the hash of the rules."""

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

from sjdsl.compiler import ir
from sjdsl.compiler.ir.hash import picture_hash
from sjdsl.compiler.ir.queries import counts_of

EPISODES = 200
SEED = 0
PICTURE_STEPS = 40  # steps of random play before the picture
SHOWN = "sjdsl:shown"  # the key of its digest in a picture's file
DIGITS = 6  # significant ones that are kept


@dataclass(frozen=True)
class Figure:
    """A mean over episodes and its 95 % confidence interval; None where it is not defined in every episode."""

    mean: float | None
    low: float | None
    high: float | None


@dataclass(frozen=True)
class Figures:
    """The figures of one game by name; `hash` is that of its rules."""

    hash: str
    episodes: int
    seed: int
    values: dict[str, Figure]


def measure(name: str, episodes: int = EPISODES, seed: int = SEED) -> Figures:
    """Returns the figures of a bundled game under the policy that draws every action with equal probability."""
    import jax

    from sjdsl.factory import make
    from sjdsl.trainers import evaluate, random_policy, summarise

    env = make(name)
    found = summarise(evaluate(env, random_policy(env), jax.random.key(seed), episodes))
    wanted = figure_names(env.game)
    values = {shown: Figure(*(_rounded(x) for x in (found[key].mean, found[key].low, found[key].high))) for key, shown in wanted.items()}
    return Figures(env.hash, episodes, seed, values)


def figure_names(game: ir.Game) -> dict[str, str]:
    """Returns the figures that a page shows: their names in an evaluation -> their names on the page."""
    names = {"collective return": "return, summed over agents", "equality": "equality of returns (1 - Gini)"}
    for event in game.events:
        for _, name in counts_of(event):
            names[f"event {name}"] = f"`{name}`, in an episode" + (", all agents" if event.per_agent else "")
    for measured in game.measures:
        sort = "mean" if measured.mean else "final"
        names[f"{sort} {measured.name}"] = f"`{measured.name}`, {'mean over steps' if measured.mean else 'at the end'}"
    return names


def _rounded(value: float) -> float | None:
    return float(f"{value:.{DIGITS}g}") if math.isfinite(value) else None


def read_figures(path: Path) -> dict[str, Figures]:
    """Returns the figures that a file keeps, by game; none if there is no such file."""
    if not path.is_file():
        return {}
    kept = json.loads(path.read_text(encoding="utf-8"))
    return {game: Figures(**{**entry, "values": {n: Figure(**f) for n, f in entry["values"].items()}}) for game, entry in kept.items()}


def figures_text(figures: Mapping[str, Figures]) -> str:
    """Returns figures as the text of their file."""
    return json.dumps({game: asdict(entry) for game, entry in figures.items()}, indent=1, ensure_ascii=False) + "\n"


def draw_picture(name: str, path: Path) -> None:
    """Writes a picture of a game in random play as a PNG."""
    from sjdsl.factory import make
    from sjdsl.render import make_painter, play, random_policy, save_png

    env = make(name)
    *_, last = play(env, random_policy(env), PICTURE_STEPS, SEED, every=PICTURE_STEPS)
    path.parent.mkdir(parents=True, exist_ok=True)
    save_png(make_painter(env).draw(last), path, {SHOWN: picture_hash(env.game)})


def is_picture_of(path: Path, game: ir.Game) -> bool:
    """Returns whether a picture has been drawn from these rules and looks."""
    from PIL import Image

    with Image.open(path) as image:
        return image.info.get(SHOWN) == picture_hash(game)
