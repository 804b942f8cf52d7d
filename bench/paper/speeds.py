"""Speed of random play and hours of training, beside the published ones: read from JSON of
benchmarks, and as sections.

JSON of benchmarks: of `sjdsl bench --json`, or of `python -m bench.speed race` or `training` with
`--json`.
"""

from collections.abc import Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from bench.paper import published
from bench.paper.contents import sort_key
from bench.paper.small_multiples import Multiple, Series, draw_series
from bench.speed.stored import read_figures
from bench.speed.training import Split, Training
from sjdsl.bench.loop import YARDSTICK
from sjdsl.bench.machine import and_devices
from sjdsl.bench.tables import thousands
from sjdsl.bench.timing import Report, Speed
from sjdsl.results.figures import EMPTY, Figure, Table, counted, interval, number
from sjdsl.results.page import Picture, Section
from sjdsl.results.selecting import NAMES

FILES = {"speeds": "speeds.csv", "updates": "updates.csv"}
KEYS = {
    "speeds": ["game", "num_agents", "crowd", "observation", "num_envs", "hardware"],
    "updates": [
        "game",
        "num_agents",
        "algorithm",
        "sharing",
        "network",
        "num_envs",
        "num_steps",
        "hardware",
    ],
}
ONE_LINE = ["num_agents", "observation", "hardware", "rounds"]  # speeds alike in these share a line
NUMBERS = (1, 128, 1024, 4096)  # of environments
OBSERVATION = "tokens"  # what agents see in the pictures
CROWD = "+crowd"  # behind the name of a game on the map for many agents
STEPS = 1e9  # environment steps for which hours are shown, as in the paper


def read_speeds(data: Path, files: Iterable[Path]) -> dict[str, pd.DataFrame]:
    """Returns the tables `speeds` and `updates` of the data of the page, with the figures of JSON
    of benchmarks (see above) added.
    """
    frames = {name: pd.read_csv(data / file) for name, file in FILES.items()}
    for file in files:
        figures = read_figures(file)
        machine = figures.machine  # the processor with its cores, or the accelerator
        cores = f", {machine['cpu_cores']} cores" if machine["platform"] == "cpu" else ""
        hardware = f"{machine['device']}{cores}{and_devices(dict(machine))}"
        match figures:
            case Report():
                name = "speeds"
                speeds = [speed for speed in figures.speeds if speed.name != YARDSTICK]
                rows = [_speed_row(speed, figures.repeats) for speed in speeds]
            case Training():
                name = "updates"
                rows = [_update_row(split) for split in figures.splits]
            case _:
                raise ValueError(
                    f"{file} holds a measurement that no table shows "
                    f"({type(figures).__name__.lower()})"
                )
        more = pd.DataFrame(rows).assign(hardware=hardware)
        frames[name] = pd.concat([frames[name], more]).drop_duplicates(KEYS[name], keep="last")
    return {
        name: frame.sort_values(KEYS[name], ignore_index=True) for name, frame in frames.items()
    }


def _speed_row(speed: Speed, rounds: int) -> dict[str, Any]:
    return {
        "game": speed.name.removesuffix(CROWD),
        "crowd": speed.crowd is not None,
        "num_agents": speed.num_agents,
        "observation": speed.observation,
        "num_envs": speed.num_envs,
        "rate": speed.env_steps_per_s,
        "slowest": speed.slowest,
        "fastest": speed.fastest,
        "rounds": rounds,
    }


def _update_row(split: Split) -> dict[str, Any]:
    steps = split.num_envs * split.num_steps
    return {
        "game": split.name,
        "num_agents": split.num_agents,
        "algorithm": split.algorithm,
        "sharing": split.sharing,
        "network": split.network,
        "num_envs": split.num_envs,
        "num_steps": split.num_steps,
        "rate": split.env_steps_per_s,
        "slowest": steps / max(split.update),
        "fastest": steps / min(split.update),
        "rounds": len(split.update),
    }


def _rate_figure(row: Any) -> Figure:
    """Returns the rate of a row of either table with those of its slowest and fastest round."""
    text = f"{thousands(row.rate)} [{thousands(row.slowest)}, {thousands(row.fastest)}]"
    numbers = {"rate": row.rate, "slowest": row.slowest, "fastest": row.fastest}
    return Figure(text, numbers)


def _with_the_papers_games(names: Iterable[str]) -> list[str]:
    """Returns the games of the paper and these, in the order of the page."""
    return sorted({*names, *published.suite()}, key=sort_key)


def speed(frame: pd.DataFrame) -> Section:
    """Returns the section of random play at 1, 128, 1,024 and 4,096 environments, and with 20
    agents.
    """
    numbers = sorted({*NUMBERS, *frame.num_envs})
    names = _with_the_papers_games(frame.game)
    lines = [
        line
        for name in names
        for crowd in (False, True)
        for line in _lines(frame, name, crowd, numbers)
    ]
    headings = ("game", "", *(f"{number:,}" for number in numbers), "rounds, hardware")
    plots = [plot for name in names if (plot := _plot(frame, name)) is not None]
    draw = partial(
        draw_series,
        plots,
        "environments at once",
        "environment steps a second",
        logarithmic=True,
        bars="from the slowest round to the fastest",
    )
    pictures = (Picture("speed", "speed over environments", draw),) if plots else ()
    return Section(
        "Speed", (), (Table("speed", "Environment steps a second", headings, lines, 2),), pictures
    )


def _lines(
    frame: pd.DataFrame, game: str, crowd: bool, numbers: list[int]
) -> Iterator[tuple[str | Figure, ...]]:
    """Yields the lines of a game with its own number of agents, or with a crowd.

    numbers: of environments, one a column.
    """
    printed = published.speed(game, crowd)
    of_game = frame[(frame.game == game) & (frame.crowd == crowd)]
    kinds = [
        (names, {row.num_envs: row for row in rows.itertuples()})
        for names, rows in of_game.groupby(ONE_LINE)
    ]
    if not kinds and printed:
        yield (
            f"{game}, {'20 agents' if crowd else 'own agents'}",
            "ours",
            *("",) * (len(numbers) + 1),
        )
    for (agents, observation, hardware, rounds), rates in kinds:
        shown = (_rate_figure(rates[n]) if n in rates else EMPTY for n in numbers)
        yield (
            f"{game}, {agents} agents, {observation}",
            "ours",
            *shown,
            f"{counted(rounds, 'round')}, {hardware}",
        )
    if printed:
        shown = (_thousands_figure(printed[n]) if n in printed else EMPTY for n in numbers)
        yield ("", "published", *shown, "")
    of_melting_pot = published.melting_pot_speed(game)
    if of_melting_pot is not None and not crowd:
        figure = _thousands_figure(of_melting_pot)
        shown = (figure if n == 1 else EMPTY for n in numbers)
        yield ("", "published, Melting Pot", *shown, "")
    if not printed:
        return
    for (_, observation, *_), rates in kinds:
        figures = []
        for n in numbers:
            figure = EMPTY
            if n in rates and n in printed:
                ratio = rates[n].rate / printed[n]
                figure = Figure(number(float(f"{ratio:.2g}")), {"": ratio})
            figures.append(figure)
        yield ("", f"ours / published, {observation}", *figures, "")


def _thousands_figure(rate: float) -> Figure:
    return Figure(thousands(rate), {"": rate})


def _plot(frame: pd.DataFrame, game: str) -> Multiple | None:
    """Returns the plot of a game's speeds with tokens; None if none were measured."""
    of_game = frame[(frame.game == game) & (frame.observation == OBSERVATION) & ~frame.crowd]
    series = [
        Series(
            x=rows.num_envs.to_numpy(float),
            mean=rows.rate.to_numpy(float),
            low=rows.slowest.to_numpy(float),
            high=rows.fastest.to_numpy(float),
            label=str(hardware),
        )
        for hardware, rows in of_game.sort_values("num_envs").groupby("hardware")
    ]
    if not series:
        return None
    printed = tuple(published.speed(game, crowd=False).items())
    return Multiple(game, tuple(series), printed)


def hours(frame: pd.DataFrame) -> Section:
    """Returns the section on hours of training for 1e9 environment steps, extrapolated from the
    speed of single updates.
    """
    rows = [
        _hours_row(row)
        for name in _with_the_papers_games(frame.game)
        for row in frame[frame.game == name].itertuples()
    ]
    headings = (
        "game",
        "algorithm",
        "network",
        "parameters",
        "env-steps/s",
        "hours to 1e9 steps, extrapolated",
        "published",
        "environments x steps, rounds, hardware",
    )
    table = Table("hours", "Hours of training", headings, rows, 4)
    return Section("Hours of training", (), (table,))


def _hours_row(row: Any) -> tuple[str | Figure, ...]:
    """Returns a line of the table of hours for a row of the table `updates`."""
    hours = published.hours(row.game)
    in_paper = [] if hours is None else [number(hours)]
    if in_paper:
        for name, its_hours in published.melting_pot_hours(row.game).items():
            in_paper.append(f"{name} {number(its_hours)}")
    return (
        row.game,
        NAMES.get(row.algorithm, row.algorithm),
        row.network,
        row.sharing.replace("_", " "),
        _rate_figure(row),
        interval(_hours_at(row.rate), _hours_at(row.fastest), _hours_at(row.slowest)),
        ", ".join(in_paper),
        f"{row.num_envs} x {row.num_steps}, {counted(row.rounds, 'round')}, {row.hardware}",
    )


def _hours_at(rate: float) -> float:
    return STEPS / rate / 3600
