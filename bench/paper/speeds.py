"""Speed of random play and hours of training, beside the published ones: read from JSON of
benchmarks, and as sections.

JSON of benchmarks: of `sjdsl bench --json`, or of `python -m bench.speed race` or `training` with
`--json`.
"""

import statistics
from collections.abc import Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from bench.paper import published
from bench.paper.contents import in_order
from bench.paper.small_multiples import Multiple, Series, draw_series
from bench.speed.stored import read_figures
from bench.speed.training import Training
from sjdsl.bench.loop import YARDSTICK
from sjdsl.bench.machine import and_devices
from sjdsl.bench.tables import thousands
from sjdsl.bench.timing import Report
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
ONE_LINE = ["num_agents", "observation", "hardware", "rounds"]
NUMBERS = (1, 128, 1024, 4096)  # of environments
OBSERVATION = "tokens"  # what agents see in the pictures
CROWD = "+crowd"  # behind the name of a game on the map for many agents
HOURS = 1e9 / 3600  # of 1e9 environment steps, times the rate


def read_speeds(data: Path, files: Iterable[Path]) -> dict[str, pd.DataFrame]:
    """Returns the tables `speeds` and `updates` of the data of the page, with the figures of JSON
    of benchmarks (see above) added.
    """
    frames = {name: pd.read_csv(data / file) for name, file in FILES.items()}
    for file in files:
        found = read_figures(file)
        machine = found.machine  # the processor with its cores, or the accelerator
        cores = f", {machine['cpu_cores']} cores" if machine["platform"] == "cpu" else ""
        hardware = f"{machine['device']}{cores}{and_devices(dict(machine))}"
        match found:
            case Report():
                name, rows = (
                    "speeds",
                    [_speed(found, speed) for speed in found.speeds if speed.name != YARDSTICK],
                )
            case Training():
                name, rows = "updates", [_update_row(split) for split in found.splits]
            case _:
                raise ValueError(
                    f"{file} holds a measurement that no table shows "
                    f"({type(found).__name__.lower()})"
                )
        more = pd.DataFrame(rows).assign(hardware=hardware)
        frames[name] = pd.concat([frames[name], more]).drop_duplicates(KEYS[name], keep="last")
    return {
        name: frame.sort_values(KEYS[name], ignore_index=True) for name, frame in frames.items()
    }


def _speed(found: Report, speed: Any) -> dict[str, Any]:
    rates = {
        "rate": speed.env_steps_per_s,
        "slowest": speed.slowest,
        "fastest": speed.fastest,
        "rounds": found.repeats,
    }
    own = {name: getattr(speed, name) for name in ("num_agents", "observation", "num_envs")}
    return {
        "game": speed.name.removesuffix(CROWD),
        "crowd": speed.crowd is not None,
        **own,
        **rates,
    }


def _update_row(split: Any) -> dict[str, Any]:
    steps, seconds = split.num_envs * split.num_steps, split.update
    rates = dict(
        zip(
            ("rate", "slowest", "fastest"),
            (steps / f(seconds) for f in (statistics.median, max, min)),
            strict=True,
        )
    )
    names = ("num_agents", "algorithm", "sharing", "network", "num_envs", "num_steps")
    return {
        "game": split.name,
        **{name: getattr(split, name) for name in names},
        **rates,
        "rounds": len(seconds),
    }


def _rate(row: Any) -> Figure:
    numbers = {name: getattr(row, name) for name in ("rate", "slowest", "fastest")}
    return Figure(
        f"{thousands(row.rate)} [{thousands(row.slowest)}, {thousands(row.fastest)}]", numbers
    )


def _ordered(names: Iterable[str]) -> list[str]:
    return sorted({*names, *published.suite()}, key=in_order)


def speed(frame: pd.DataFrame) -> Section:
    """Returns the section of random play at 1, 128, 1,024 and 4,096 environments, and with 20
    agents.
    """
    numbers = sorted({*NUMBERS, *frame.num_envs})
    names = _ordered(frame.game)
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
    """Yields the rows of a game with its own number of agents, or with a crowd."""
    printed = published.speed(game, crowd)
    found = frame[(frame.game == game) & (frame.crowd == crowd)]
    kinds = [
        (names, {row.num_envs: row for row in rows.itertuples()})
        for names, rows in found.groupby(ONE_LINE)
    ]
    if not kinds and printed:
        yield (
            f"{game}, {'20 agents' if crowd else 'own agents'}",
            "ours",
            *("",) * (len(numbers) + 1),
        )
    for (agents, observation, hardware, rounds), rates in kinds:
        shown = (_rate(rates[n]) if n in rates else EMPTY for n in numbers)
        yield (
            f"{game}, {agents} agents, {observation}",
            "ours",
            *shown,
            f"{counted(rounds, 'round')}, {hardware}",
        )
    if printed:
        yield (
            "",
            "published",
            *(
                Figure(thousands(printed[n]), {"": printed[n]}) if n in printed else EMPTY
                for n in numbers
            ),
            "",
        )
    before = published.melting_pot_speed(game)
    if before is not None and not crowd:
        yield (
            "",
            "published, Melting Pot",
            *(Figure(thousands(before), {"": before}) if n == 1 else EMPTY for n in numbers),
            "",
        )
    for (_, observation, *_), rates in kinds if printed else ():
        ratios = (
            rates[n].rate / printed[n] if n in rates and n in printed else None for n in numbers
        )
        shown = (
            EMPTY if ratio is None else Figure(number(float(f"{ratio:.2g}")), {"": ratio})
            for ratio in ratios
        )
        yield ("", f"ours / published, {observation}", *shown, "")


def _plot(frame: pd.DataFrame, game: str) -> Multiple | None:
    own = frame[
        (frame.game == game) & (frame.observation == OBSERVATION) & ~frame.crowd
    ].sort_values("num_envs")
    columns = ("num_envs", "rate", "slowest", "fastest")
    series = [
        Series(*(rows[name].to_numpy(float) for name in columns), str(hardware))
        for hardware, rows in own.groupby("hardware")
    ]
    return (
        Multiple(game, tuple(series), tuple(published.speed(game, crowd=False).items()))
        if series
        else None
    )


def hours(frame: pd.DataFrame) -> Section:
    """Returns the section on hours of training for 1e9 environment steps, extrapolated from the
    speed of single updates.
    """
    rows = [
        _hours(row)
        for name in _ordered(frame.game)
        for row in frame[frame.game == name].itertuples()
    ]
    headings = (
        *(
            "game",
            "algorithm",
            "network",
            "parameters",
            "env-steps/s",
            "hours to 1e9 steps, extrapolated",
            "published",
        ),
        "environments x steps, rounds, hardware",
    )
    return Section(
        "Hours of training", (), (Table("hours", "Hours of training", headings, rows, 4),)
    )


def _hours(row: Any) -> tuple[str | Figure, ...]:
    printed = published.hours(row.game)
    before = [
        f"{name} {number(needed)}" for name, needed in published.melting_pot_hours(row.game).items()
    ]
    said = "" if printed is None else ", ".join([number(printed), *before])
    shape = f"{row.num_envs} x {row.num_steps}, {counted(row.rounds, 'round')}, {row.hardware}"
    way = (
        row.game,
        NAMES.get(row.algorithm, row.algorithm),
        row.network,
        row.sharing.replace("_", " "),
    )
    return (
        *way,
        _rate(row),
        interval(*(HOURS / rate for rate in (row.rate, row.fastest, row.slowest))),
        said,
        shape,
    )
