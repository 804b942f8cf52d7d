"""Folders and files as the commands write them, with figures that a test chooses: runs, sweeps, diagrams, cross-play, benchmarks."""

import csv
import json
import math
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from bench.speed.training import Split, Training
from sjdsl.bench.stored import write_found
from sjdsl.bench.timing import Report, Speed
from sjdsl.results import ResultsWarning
from sjdsl.results.loading import load_both
from sjdsl.trainers import make_config

MACHINE = {"platform": "cpu", "device": "Some CPU", "cpu_cores": 2, "python": "3", "jax": "0", "sjdsl": "0", "compilation_cache": False}
UPDATES = 4
SMALL = {"num_envs": 10, "num_steps": 10, "num_minibatches": 1, "network": "mlp", "total_timesteps": 100 * UPDATES}
RULES = {"coins": "c01", "harvest_open": "4a7", "pd_arena": "9da"}  # hashes
POLICIES = ("cooperators", "defectors")
VARIANTS = {"c02": "socialjax", "402": "socialjax"}  # by hash
PAPERS: Mapping[str, Any] = {"rules": "c02", "provenance": {"variant": "socialjax"}}  # how the paper played Coins
AGENTS = {"coins": 2, "harvest_open": 7, "pd_arena": 4}


class Found(NamedTuple):
    """What folders hold: the table of results, the learning curves, and what was warned of."""

    frame: pd.DataFrame
    curves: pd.DataFrame
    notes: tuple[str, ...]

    def rows(self, record: str) -> list[Any]:
        return [row for _, row in self.frame[self.frame.record == record].iterrows()]


def read(*folders: Path) -> Found:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ResultsWarning)
        frame, curves = load_both(folders)
    return Found(frame, curves, tuple(str(warning.message) for warning in caught if issubclass(warning.category, ResultsWarning)))


def write_json(path: Path, content: Any) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(content))


def described(game: str, rules: str | None = None) -> dict[str, Any]:
    """Returns a game as manifests and diagrams describe it."""
    return {"name": game, "hash": rules or RULES.get(game, "0"), "params": {"length": 1000}, "num_agents": AGENTS.get(game, 3)}


def write_run(
    folder: Path,
    game: str,
    returns: Sequence[float | None],
    *,
    first: int = 0,
    status: str = "finished",
    diverged: Sequence[int] = (),
    measures: Mapping[str, Sequence[float]] | None = None,
    rules: str | None = None,
    provenance: Mapping[str, Any] | None = None,
    device: str = "cpu",
    **config: Any,
) -> Path:
    """Writes the folder of a run; returns it.

    Args:
      returns: what the last policy of each seed earned; None: it was not evaluated.
      measures: other figures of the evaluations, a value a seed.
    """
    small = (
        SMALL if config.get("algorithm") != "vdn" else {key: SMALL[key] for key in ("num_envs", "num_steps", "network", "total_timesteps")}
    )
    made = make_config(
        {**small, **({"buffer_size": 1000} if config.get("algorithm") == "vdn" else {}), **config, "seed": first, "seeds": len(returns)}
    )
    manifest = {
        "status": status,
        "game": described(game, rules),
        "provenance": {"game": game, "variant": None, "map": None, "num_agents": None, "params": {}, **(provenance or {})},
        "config": made.model_dump(mode="json"),
        "derived": {"updates": UPDATES, "steps_per_update": made.steps_per_update},
        "versions": {"python": "3"},
        "device": {"platform": "cpu", "kind": device, "count": 1},
        "updates": UPDATES,
        "diverged": [{"seed": seed, "update": 2} for seed in diverged],
    }
    write_json(folder / "manifest.json", manifest)
    for number, earned in enumerate(returns):
        own = folder if len(returns) == 1 else folder / f"seed_{first + number}"
        (own / "policies").mkdir(parents=True, exist_ok=True)
        write_metrics(own, made.steps_per_update, earned or 0.0)
        if earned is not None and first + number not in diverged and status == "finished":
            figures = {
                "collective return": earned,
                "return of agent 0": earned,
                **{name: values[number] for name, values in (measures or {}).items()},
            }
            summary = {name: {"mean": value, "low": value - 1, "high": value + 1} for name, value in figures.items()}
            write_json(own / "evaluation.json", {"policy": "last", "seed": 0, "greedy": None, "episodes": 30, "summary": summary})
    return folder


def write_metrics(folder: Path, steps_per_update: int, earned: float) -> None:
    """Writes metrics of which the first update has no finished episode, and returns rise to what is earned."""
    rows = [
        {"update": n, "env_steps": n * steps_per_update, "collective_return": None if n == 1 else earned * n / UPDATES}
        for n in range(1, UPDATES + 1)
    ]
    (folder / "metrics.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))


def write_sweep(folder: Path, protocol: str, stages: Mapping[str, int], absent: Sequence[str] = (), failed: Sequence[str] = ()) -> None:
    """Writes the files of a sweep around its cells, which are runs in `cells`: their names and stages, and those that are not there."""
    cells = {name: {"stage": stage} for name, stage in {**stages, **dict.fromkeys([*absent, *failed], 1)}.items()}
    write_json(folder / "sweep.json", {"format": 1, "protocol": protocol, "axes": {}, "cells": cells})
    with open(folder / "status.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["cell", "state"])
        writer.writerows([name, "failed" if name in failed else "waiting" if name in absent else "done"] for name in cells)


def write_diagram(
    folder: Path,
    game: str,
    contrasts: Mapping[str, tuple[float, float, float]],
    outcome: str,
    notes: Sequence[str] = (),
    caution: str | None = None,
    rules: str | None = None,
    agents: int | None = None,
    scripted: bool = False,
) -> None:
    """Writes the JSON of a diagram of two pools, or of two policies of the game's file; of other rules or agents where they are given."""
    verdict = {
        "outcome": outcome,
        "fear": contrasts["fear"][1] > 0,
        "greed": contrasts["greed"][1] > 0,
        "reason": "by its bounds",
        "wanted": None,
        "caution": caution,
    }
    figures = {name: dict(zip(("mean", "low", "high"), bounds, strict=True)) for name, bounds in contrasts.items()}
    names = ("cooperator", "defector") if scripted else (f"runs/{game}_common", f"runs/{game}_individual")
    over = {"unit": "episode", "units": 30} if scripted else {"unit": "training seed", "units": 5}
    played = {**described(game, rules), **({} if agents is None else {"num_agents": agents})}
    content = {"format": 1, "game": played, **over, "episodes": 30, "notes": list(notes), **dict(zip(POLICIES, names, strict=True))}
    write_json(folder / "schelling.json", {**content, "contrasts": figures, "verdict": verdict})


def write_cross_play(
    folder: Path, game: str, policies: Mapping[str, tuple[float, float | None, float | None]], rules: str | None = None
) -> None:
    """Writes the JSON of a cross-play of each policy with itself: what an agent of it earned."""
    number = AGENTS.get(game, 3)
    mixtures = [
        {
            "mixture": f"{number} x {name}",
            "slots": [name] * number,
            "policies": {name: dict(zip(("mean", "low", "high"), figure, strict=True))},
            "episodes": 30,
        }
        for name, figure in policies.items()
    ]
    write_json(
        folder / "crossplay.json",
        {
            "format": 1,
            "game": described(game, rules),
            "unit": "episode",
            "episodes": 30,
            "keys": [[0, 0]],
            "notes": [],
            "mixtures": mixtures,
        },
    )


def write_speeds(path: Path, rates: Mapping[tuple[str, int | None, int], float]) -> None:
    """Writes the JSON of a benchmark: speeds by game, number of agents (None: its own) and environments."""
    yardstick = Speed("yardstick", 7, "tokens", None, 1, 1.0, 1.0, 1.0, 1.0, 0.1, 1)
    speeds = [
        Speed(f"{game}+crowd" if crowd else game, crowd or AGENTS[game], "tokens", crowd, number, rate, 0.9 * rate, 1.1 * rate, 1.0, 0.1, 1)
        for (game, crowd, number), rate in rates.items()
    ]
    write_found(path, Report(MACHINE, 5, (yardstick, *speeds), (), None))


def write_training(path: Path, seconds: Mapping[str, Sequence[float]]) -> None:
    """Writes the JSON of a benchmark of training: seconds of an update of 8,000 environment steps by round, by game."""
    splits = tuple(Split(game, 2, "mlp", 64, 125, 1.0, tuple(rounds), (1.0,), (1.0,), (1.0,), 1e9) for game, rounds in seconds.items())
    write_found(path, Training(MACHINE, 1e9, splits))


def random_returns(path: Path, returns: Mapping[str, float], rules: str | None = None) -> None:
    """Writes the file that bench/game_pages.py keeps the figures of a random policy in; `rules`: a hash that all games have."""
    figures = {game: {"return, summed over agents": {"mean": mean, "low": mean - 1, "high": mean + 1}} for game, mean in returns.items()}
    write_json(
        path, {game: {"hash": rules or RULES[game], "episodes": 200, "seed": 0, "values": values} for game, values in figures.items()}
    )


def write_everything(folder: Path) -> list[Path]:
    """Writes one of everything that a report is made of, as its golden shows it; returns what to name."""
    own, shared = (17.0, 14.0, 18.5), (158.0, 154.5, 160.0)
    coins = {"event own_coins": (92.0, 90.5, 93.0)}
    write_run(folder / "coins_individual", "coins", own, measures=coins, reward="individual", **PAPERS)
    write_run(folder / "coins_common", "coins", shared, measures={"event own_coins": (159.0, 156.0, 161.0)}, reward="common", **PAPERS)
    write_run(folder / "coins_apart", "coins", (150.0, 157.0, 149.0), reward="common", sharing="per_agent", **PAPERS)
    write_run(folder / "coins_exchange_50", "coins", (150.0, 160.0), reward="exchange", exchange_ratio=0.5, **PAPERS)
    write_run(folder / "coins_exchange_25", "coins", (None, 90.0), diverged=(0,), reward="exchange", exchange_ratio=0.25, **PAPERS)
    write_run(folder / "harvest_individual", "harvest_open", (77.0, 77.0), measures={"mean apples_left": (2.0, 2.1)}, reward="individual")
    write_run(folder / "harvest_common", "harvest_open", (310.0, 330.0), measures={"mean apples_left": (20.0, 24.0)}, reward="common")
    write_run(folder / "harvest_going_on", "harvest_open", (None, None), status="running", reward="common", learning_rate=0.01)
    write_run(folder / "pd_once", "pd_arena", (150.0,), measures={"event collected[coop]": (60.0,)}, reward="individual")
    sweep = folder / "svo"
    write_run(sweep / "cells/coins_weight-0.4", "coins", (100.0, 120.0), reward="svo", svo_weight=0.4, **PAPERS)
    write_run(sweep / "cells/coins_weight-0.6", "coins", (140.0, 150.0), reward="svo", svo_weight=0.6, **PAPERS)
    write_run(sweep / "cells/coins_angle-45", "coins", (60.0, 80.0), first=2, reward="svo", svo_weight=0.6, svo_angle=45, **PAPERS)
    write_run(sweep / "cells/coins_angle-90", "coins", (130.0, 144.0), first=2, reward="svo", svo_weight=0.6, **PAPERS)
    stages = {"coins_weight-0.4": 1, "coins_weight-0.6": 1, "coins_angle-45": 2, "coins_angle-90": 2}
    write_sweep(sweep, "svo", stages, absent=["coins_angle-0"])
    contrasts = {"A": (60.0, 50.0, 70.0), "B": (5.0, -1.0, 11.0), "fear": (40.0, 30.0, 50.0), "greed": (2.0, -3.0, 7.0)}
    write_diagram(folder / "coins_diagram", "coins", contrasts, "undecided", rules="c02")
    write_cross_play(folder / "coins_random", "coins", {"random": (-0.5, -1.5, 0.5), "runs/coins_common": (79.0, 77.0, 81.0)})
    rates = {("coins", None, 1): 5_000.0, ("coins", None, 128): 400_000.0, ("harvest_open", 20, 1024): 900_000.0}
    write_speeds(folder / "speed.json", rates)
    write_training(folder / "training.json", {"coins": (0.2, 0.25, 0.3)})
    random_returns(folder / "games.json", {"harvest_open": 60.0})
    return [folder / "svo", *sorted(path for path in folder.iterdir() if path.name != "svo")]


def nearly(found: float, wanted: float) -> bool:
    """Returns whether two figures agree to rounding."""
    return math.isclose(found, wanted, rel_tol=1e-9, abs_tol=1e-12)
