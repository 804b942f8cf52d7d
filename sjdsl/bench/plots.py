"""Pictures of how speed grows with the number of environments, one for each observation and number of agents asked for."""

from collections.abc import Sequence
from pathlib import Path

from sjdsl.bench.loop import YARDSTICK
from sjdsl.bench.timing import Report, Speed


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
    """Draws the medians, with bars from the slowest round to the fastest; the yardstick is dashed."""
    from matplotlib.figure import Figure  # here: importing it costs as much as a short test

    figure = Figure(figsize=(7, 4.5), layout="constrained")
    axes = figure.add_subplot()
    for name in dict.fromkeys(speed.name for speed in speeds):
        line = sorted((speed for speed in speeds if speed.name == name), key=lambda speed: speed.num_envs)
        rates = [speed.env_steps_per_s for speed in line]
        bars = [[s.env_steps_per_s - s.slowest for s in line], [s.fastest - s.env_steps_per_s for s in line]]
        style = {"color": "black", "linestyle": "--"} if name == YARDSTICK else {"marker": "o", "markersize": 3}
        axes.errorbar([speed.num_envs for speed in line], rates, bars, label=name, linewidth=1, capsize=2, **style)
    axes.set_xscale("log", base=2)
    numbers = sorted({speed.num_envs for speed in speeds})
    axes.set_xticks(numbers, [f"{number:,}" for number in numbers])
    axes.set_yscale("log")
    axes.set(xlabel="environments", ylabel="environment steps a second", title=title)
    axes.grid(alpha=0.3, which="both")
    axes.legend(fontsize="small", ncols=2)
    figure.savefig(file, dpi=120)
