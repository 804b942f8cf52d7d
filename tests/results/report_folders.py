"""Folders and files as the commands write them, with figures that a test chooses: runs, sweeps, diagrams, cross-play, benchmarks."""

import json
import math
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from bench.speed.training import Split, Training
from sjdsl.bench.stored import write_figures
from sjdsl.bench.timing import Report, Speed
from sjdsl.results import ResultsWarning
from sjdsl.results.loading import load_both
from sjdsl.trainers import make_config

MACHINE = {
    "platform": "cpu",
    "device": "Some CPU",
    "cpu_cores": 2,
    "devices": 1,
    "python": "3",
    "jax": "0",
    "sjdsl": "0",
    "compilation_cache": False,
}
UPDATES = 4
SMALL = {
    "num_envs": 10,
    "num_steps": 10,
    "num_minibatches": 1,
    "network": "mlp",
    "total_timesteps": 100 * UPDATES,
}
RULES = {"coins": "c01", "harvest_open": "4a7", "pd_arena": "9da"}  # hashes
POLICIES = ("cooperators", "defectors")
VARIANTS = {"c02": "socialjax", "402": "socialjax"}  # by hash
PAPERS: Mapping[str, Any] = {
    "rules": "c02",
    "provenance": {"variant": "socialjax"},
}  # how the paper played Coins
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
    return Found(
        frame,
        curves,
        tuple(
            str(warning.message)
            for warning in caught
            if issubclass(warning.category, ResultsWarning)
        ),
    )


def write_json(path: Path, content: Any) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(content))


def described(game: str, rules: str | None = None) -> dict[str, Any]:
    """Returns a game as manifests and diagrams describe it."""
    return {
        "name": game,
        "hash": rules or RULES.get(game, "0"),
        "params": {"length": 1000},
        "num_agents": AGENTS.get(game, 3),
    }


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
    tasks: Mapping[str, Any] | None = None,
    held_out: Mapping[str, Sequence[Mapping[str, float]]] | None = None,
    **config: Any,
) -> Path:
    """Writes the folder of a run; returns it.

    Args:
      returns: what the last policy of each seed earned; None: it was not evaluated.
      measures: other figures of the evaluations, a value a seed.
      tasks: what the manifest says of the tasks played, `tasks` and `split`.
      held_out: by split, what the policy of each seed earned there, and other figures by name.
    """
    small = (
        SMALL
        if config.get("algorithm") != "vdn"
        else {key: SMALL[key] for key in ("num_envs", "num_steps", "network", "total_timesteps")}
    )
    made = make_config(
        {
            **small,
            **({"buffer_size": 1000} if config.get("algorithm") == "vdn" else {}),
            **config,
            "seed": first,
            "seeds": len(returns),
        }
    )
    manifest = {
        "status": status,
        "game": {**described(game, rules), **(tasks or {})},
        "provenance": {
            "game": game,
            "variant": None,
            "map": None,
            "num_agents": None,
            "params": {},
            **(provenance or {}),
        },
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
            of_splits = {}
            for split, of_seeds in (held_out or {}).items():
                there = of_seeds[number]
                minus = {"mean": earned - there["collective return"], "low": None, "high": None}
                of_splits[split] = {
                    "summary": summarised(there),
                    "training_minus_held_out": minus,
                }
            write_json(
                own / "evaluation.json",
                {
                    "policy": "last",
                    "update": UPDATES,
                    "seed": 0,
                    "greedy": None,
                    "episodes": 30,
                    "summary": summarised(figures),
                    **({"held_out": of_splits} if of_splits else {}),
                },
            )
    return folder


def summarised(figures: Mapping[str, float]) -> dict[str, dict[str, float]]:
    """Returns figures with an interval of 1 to each side."""
    return {
        name: {"mean": value, "low": value - 1, "high": value + 1}
        for name, value in figures.items()
    }


def write_metrics(folder: Path, steps_per_update: int, earned: float) -> None:
    """Writes metrics of which the first update has no finished episode, and returns rise to what is earned."""
    rows = [
        {
            "update": n,
            "env_steps": n * steps_per_update,
            "collective_return": None if n == 1 else earned * n / UPDATES,
        }
        for n in range(1, UPDATES + 1)
    ]
    (folder / "metrics.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))


def write_sweep(folder: Path, cells: Sequence[str], failed: Sequence[str] = ()) -> None:
    """Writes the files of a sweep around its cells, of which those that are trained are runs in `cells`."""
    write_json(
        folder / "sweep.json", {"format": 1, "axes": {}, "cells": {name: {} for name in cells}}
    )
    for name in failed:
        (folder / "failed").mkdir(exist_ok=True)
        write_json(folder / "failed" / f"{name}.json", {"reason": "it had to"})


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
    pools: str = "runs",
    seeds: int = 5,
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
    figures = {
        name: dict(zip(("mean", "low", "high"), bounds, strict=True))
        for name, bounds in contrasts.items()
    }
    names = (
        ("cooperator", "defector")
        if scripted
        else (f"{pools}/{game}_common", f"{pools}/{game}_individual")
    )
    over = (
        {"unit": "episode", "units": 30} if scripted else {"unit": "training seed", "units": seeds}
    )
    played = {**described(game, rules), **({} if agents is None else {"num_agents": agents})}
    content = {
        "format": 1,
        "game": played,
        **over,
        "episodes": 30,
        "notes": list(notes),
        **dict(zip(POLICIES, names, strict=True)),
    }
    write_json(folder / "schelling.json", {**content, "contrasts": figures, "verdict": verdict})


def write_cross_play(
    folder: Path,
    game: str,
    policies: Mapping[str, tuple[float, float | None, float | None]],
    rules: str | None = None,
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
    yardstick = Speed("yardstick", 7, "tokens", None, 1, 1.0, 1.0, 1.0, 1.0, 0.1, 1, 1.0)
    speeds = [
        Speed(
            f"{game}+crowd" if crowd else game,
            crowd or AGENTS[game],
            "tokens",
            crowd,
            number,
            rate,
            0.9 * rate,
            1.1 * rate,
            1.0,
            0.1,
            1,
            rate,
        )
        for (game, crowd, number), rate in rates.items()
    ]
    write_figures(path, Report(MACHINE, 5, (yardstick, *speeds), (), None))


def write_training(path: Path, seconds: Mapping[str, Sequence[float]]) -> None:
    """Writes the JSON of a benchmark of training: seconds of an update of 8,000 environment steps by round, by game."""
    splits = tuple(
        Split(game, 2, "mlp", 64, 125, 1.0, tuple(rounds), (1.0,), (1.0,), (1.0,), 1e9)
        for game, rounds in seconds.items()
    )
    write_figures(path, Training(MACHINE, 1e9, splits))


SPAWNS = {"params": {"spawn_iron": 0.0004, "spawn_gold": "1.6e-4"}}
# Runs under the rules of the paper: game, reward, returns, what is counted 60 times, rules, more of the provenance.
PAPERS_GAMES: tuple[tuple[str, str, tuple[float, ...], str, str, Mapping[str, Any]], ...] = (
    ("mushrooms", "individual", (300.0, 301.0, 302.0), "event eaten[blue]", "c02", {}),
    ("mushrooms", "common", (100.0, 101.0, 102.0), "", "c02", {}),
    ("clean_up", "common", (900.0, 901.0), "", "c02", {}),
    ("coop_mining", "individual", (10.0, 12.0), "event ores_shared", "c02", {}),
    ("coop_mining", "exchange", (10.0, 12.0), "", "c02", SPAWNS),
    ("coop_mining", "common", (10.0, 12.0), "", "402", SPAWNS),
    ("gift_refinement", "individual", (100.0, 101.0, 102.0), "", "b52", {}),
    ("gift_refinement", "common", (500.0, 510.0, 505.0), "", "b52", {}),
    ("gift_refinement", "individual", (100.0, 101.0, 102.0), "", "a17", {}),
    ("gift_refinement", "common", (500.0, 510.0, 505.0), "", "a17", {}),
)


def write_everything(folder: Path) -> None:
    """Writes one of everything that a report is made of, as its golden shows it."""
    own, shared = (17.0, 14.0, 18.5), (158.0, 154.5, 160.0)

    def coins(name: str, returns: Sequence[float | None], **more: Any) -> None:
        write_run(folder / f"coins_{name}", "coins", returns, **{**PAPERS, **more})

    coins("individual", own, measures={"event own_coins": (92.0, 90.5, 93.0)}, reward="individual")
    coins("common", shared, measures={"event own_coins": (159.0, 156.0, 161.0)}, reward="common")
    coins("apart", (150.0, 157.0, 149.0), reward="common", sharing="per_agent")
    coins("own_apart", (17.0, 15.0, 18.0), sharing="per_agent")
    coins(
        "long",
        (150.0, 152.0),
        first=100,
        reward="common",
        algorithm="mappo",
        total_timesteps=800,
        num_envs=20,
    )
    coins(
        "longer",
        (150.0, 152.0),
        first=200,
        reward="common",
        total_timesteps=800,
        num_envs=20,
        common_reward="mean",
    )
    coins("exchange_50", (150.0, 160.0), reward="exchange", exchange_ratio=0.5)
    coins("exchange_25", (None, 90.0), diverged=(0,), reward="exchange", exchange_ratio=0.25)
    coins("exchange_75", (80.0, 90.0), diverged=(0, 1), reward="exchange", exchange_ratio=0.75)
    coins("harm", (1.0,), rules=None, provenance={"params": {"harm": 0}})
    coins("old", (1.0,), rules="old", provenance={})
    coins("map", (10.0, 12.0), rules="map1", provenance={"map": "maps/large.txt"})
    coins("as_it_is", (1.0,), rules=None, provenance={"params": {"harm": "-2.0"}, "num_agents": 2})
    write_run(
        folder / "harvest_individual",
        "harvest_open",
        (77.0, 77.0),
        measures={"mean apples_left": (2.0, 2.1)},
        reward="individual",
    )
    write_run(
        folder / "harvest_common",
        "harvest_open",
        (310.0, 330.0),
        measures={"mean apples_left": (20.0, 24.0)},
        reward="common",
    )
    write_run(
        folder / "harvest_going_on",
        "harvest_open",
        (None, None),
        status="running",
        reward="common",
        learning_rate=0.01,
    )
    arena: list[dict[str, Any]] = [
        {},
        {"learning_rate": 0.5, "first": 2},
        {"total_timesteps": 800, "first": 4},
        {"first": 6},
    ]
    arena += [
        {"reward": "common"},
        {"sharing": "per_agent"},
        {"reward": "common", "sharing": "per_agent"},
    ]
    for game, way, earned, measure, rules, more in PAPERS_GAMES:
        run = folder / f"{game}_{way}_{rules}"
        variant = {"variant": "socialjax+automatic" if rules == "a17" else "socialjax", **more}
        write_run(
            run,
            game,
            earned,
            measures={measure: (60.0, 60.0, 60.0)} if measure else None,
            rules=rules,
            provenance=variant,
            reward=way,
        )
    for number, way in enumerate(arena):
        write_run(
            folder / f"pd_{number}",
            "pd_arena",
            (10.0 + number, 12.0),
            measures={"event collected[coop]": (60.0, 61.0)},
            **way,
        )
    for name, first, earned, way in (
        ("weight-0.4", 0, (100.0, 120.0), {"svo_weight": 0.4}),
        ("weight-0.6", 0, (140.0, 150.0), {"svo_weight": 0.6}),
        ("angle-45", 2, (60.0, 80.0), {"svo_weight": 0.6, "svo_angle": 45}),
        ("angle-90", 2, (130.0, 144.0), {"svo_weight": 0.6}),
    ):
        write_run(
            folder / f"svo/cells/{name}",
            "coins",
            earned,
            first=first,
            reward="svo",
            **way,
            **PAPERS,
        )
    write_sweep(folder / "svo", ["weight-0.4", "weight-0.6", "angle-45", "angle-90", "angle-0"])
    contrasts = {
        "A": (60.0, 50.0, 70.0),
        "B": (5.0, -1.0, 11.0),
        "fear": (40.0, 30.0, 50.0),
        "greed": (2.0, -3.0, 7.0),
    }
    for number, (rules, agents) in enumerate({"c02": None, "ab12cd34": 3, "map1": None}.items()):
        write_diagram(
            folder / f"diagram_{number}",
            "coins",
            contrasts,
            "undecided",
            rules=rules,
            agents=agents,
            caution="Zeros.",
        )
        write_cross_play(
            folder / f"met_{number}",
            "coins",
            {"random": (-0.5, -1.5, 0.5), "runs/coins_common": (79.0, 77.0, 81.0)},
            rules,
        )
    for number, (game, rules, scripted) in enumerate(
        (("coins", "c01", False), ("coins", "c01", True), ("gift_refinement", "a17", False))
    ):
        agents = {"coins": 2, "gift_refinement": 5}[game]
        write_diagram(
            folder / f"own_{number}",
            game,
            contrasts,
            "dilemma",
            rules=rules,
            scripted=scripted,
            agents=agents,
        )
    write_cross_play(folder / "harvest_random", "harvest_open", {"random": (12.0, None, None)})
    write_cross_play(folder / "arena_random", "pd_arena", {"random": (2.0, None, None)})


def nearly(found: float, wanted: float) -> bool:
    """Returns whether two figures agree to rounding."""
    return math.isclose(found, wanted, rel_tol=1e-9, abs_tol=1e-12)
