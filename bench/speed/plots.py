"""Plots speed against the number of environments, one plot for each observation and number of agents."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sjdsl.bench.loop import YARDSTICK
from sjdsl.bench.timing import Report, Speed
from sjdsl.files import written_whole
from sjdsl.render.plot_style import BLACK, Label, line_colour, name_lines, note_below, plot_style

GAMES_A_PANEL = 4  # with the yardstick five lines: more cannot be told apart


def draw_scaling(report: Report, folder: Path) -> tuple[Path, ...]:
    """Writes PNGs: environment steps a second over environments, both logarithmic, a line a game. Returns their files."""
    folder.mkdir(parents=True, exist_ok=True)
    games = [speed for speed in report.speeds if speed.name != YARDSTICK]
    yardstick = [speed for speed in report.speeds if speed.name == YARDSTICK]
    files = []
    for observation, crowd in dict.fromkeys((speed.observation, speed.crowd) for speed in games):
        shown = [speed for speed in games if (speed.observation, speed.crowd) == (observation, crowd)]
        agents = "own" if crowd is None else str(crowd)
        files.append(folder / f"{report.machine['platform']}_{observation}_{agents}_agents.png")
        _draw(shown + yardstick, f"{observation}, {'own numbers of' if crowd is None else crowd} agents", files[-1])
    return tuple(files)


def _draw(speeds: Sequence[Speed], title: str, file: Path) -> None:
    """Draws the medians, with bars from the slowest round to the fastest: a few games a panel, the yardstick dashed in each."""
    from matplotlib.figure import Figure  # here: importing it costs as much as a short test

    games = [name for name in dict.fromkeys(speed.name for speed in speeds) if name != YARDSTICK]
    count = max(1, math.ceil(len(games) / GAMES_A_PANEL))
    groups = [games[len(games) * n // count : len(games) * (n + 1) // count] for n in range(count)]
    colours = {name: line_colour(number) for number, name in enumerate(games)} | {YARDSTICK: BLACK}
    numbers = sorted({speed.num_envs for speed in speeds})
    with plot_style():
        figure = Figure(figsize=(1.5 + 5.2 * len(groups), 4.5), layout="constrained")
        panels = figure.subplots(1, len(groups), sharex=True, sharey=True, squeeze=False)[0]
        labels: list[list[Label]] = []
        for axes, group in zip(panels, groups, strict=True):
            labels.append([])
            for name in (*group, YARDSTICK):
                line = sorted((s for s in speeds if s.name == name), key=lambda speed: speed.num_envs)
                if line:
                    _draw_line(axes, line, colours[name], "--" if name == YARDSTICK else "-")
                    labels[-1].append(Label(name, line[-1].env_steps_per_s, colours[name]))
            axes.set_xscale("log", base=2)
            axes.set_xticks(numbers, [f"{number:,}" for number in numbers])
            axes.set_yscale("log")
            axes.set_xlabel("environments at once")
        for axes, named in zip(panels, labels, strict=True):
            name_lines(axes, named)
        panels[0].set_ylabel("environment steps a second")
        figure.suptitle(title)
        note_below(figure, "Medians of rounds. Bars: from the slowest round to the fastest.")
    with written_whole(file) as content:
        figure.savefig(content, format=file.suffix.removeprefix("."), dpi=120)


def _draw_line(axes: Any, line: Sequence[Speed], colour: str, dashes: str) -> None:
    """Draws one game over numbers of environments; a single point has a marker, too."""
    rates = [speed.env_steps_per_s for speed in line]
    bars = [[s.env_steps_per_s - s.slowest for s in line], [s.fastest - s.env_steps_per_s for s in line]]
    numbers = [speed.num_envs for speed in line]
    axes.errorbar(numbers, rates, bars, color=colour, linestyle=dashes, linewidth=1, capsize=2, marker="o", markersize=3)
