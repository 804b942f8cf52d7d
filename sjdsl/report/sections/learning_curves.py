"""Learning curves: the collective return over environment steps, game by game, with all ways of training."""

import re
from collections import defaultdict
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from sjdsl.report.cells import each_once, settings_apart
from sjdsl.report.contents import Contents, Game
from sjdsl.report.drawing import colours
from sjdsl.report.evidence import Run
from sjdsl.report.figure_text import finite
from sjdsl.report.page import Picture, Section, Table
from sjdsl.report.ways import in_words
from sjdsl.trainers.estimates import estimate
from sjdsl.trainers.panels import Line, draw_panels, split_lines

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Y_TITLE = "collective return of an episode"
EXPLORING = "The curves of VDN are of episodes in which it explores. The last policies, in the tables, are evaluated without exploring."


def learning_curves(contents: Contents) -> Section:
    """Returns a picture for each game: the mean over seeds, with the band of its 95 % interval by Student's t."""
    pictures, records = [], []
    for game in contents.games:
        found = _lines(contents, game)
        if found:
            lines = [line for line, _ in found]
            pictures.append(Picture(re.sub(r"[^\w.-]+", "_", f"curves_{game.label}"), game.label, partial(_draw, lines, game.label)))
        for line, origin in found:
            low, high = (np.full(line.values.shape, np.nan) if bound is None else bound for bound in (line.low, line.high))
            for step, *figures in zip(line.steps, line.values, low, high, strict=True):
                records.append({"game": game.label, "way": line.label, "env_steps": int(step), **_bounds(*figures), **origin})
    failed = [f"{in_words(run)} in {game.label}" for game in contents.games for run in _failed(contents, game)]
    text = (
        "Mean over seeds, with the band of its 95 % interval (Student's t). One seed has no band.",
        *((EXPLORING,) if any(run.algorithm == "vdn" for run in contents.evidence.runs) else ()),
        *((f"Left out, for a seed has failed: {'; '.join(failed)}.",) if failed else ()),
    )
    tables = (Table("learning_curves", "", (), (), tuple(records)),) if records else ()
    fill = () if pictures else ("sjdsl train coins --preset two_cores --seeds 5 --run runs/coins",)
    return Section("Learning curves", text, tables, tuple(pictures), fill)


def _bounds(mean: float, low: float, high: float) -> dict[str, float | None]:
    return {"mean": mean, "low": None if np.isnan(low) else finite(low), "high": None if np.isnan(high) else finite(high)}


def _lines(contents: Contents, game: Game) -> list[tuple[Line, dict[str, Any]]]:
    """Returns the lines of a game, each with how many seeds it is of and on what they were trained."""
    if game.setting is None:
        return []
    whole = [run for run in contents.index.runs(game.setting) if not contents.index.has_failed(run)]
    found = [(run, curve) for run in whole if (curve := _curve(contents, run)) is not None]
    return [
        (_line(run, curve, _apart(run, [other for other, _ in found])), _origin(contents, run))
        for run, curve in sorted(found, key=lambda pair: (in_words(pair[0]).casefold(), pair[0].run))
    ]


def _origin(contents: Contents, run: Run) -> dict[str, Any]:
    seeds = [row for row in contents.index.seeds(run) if row.status == "done"]
    return {"seeds": len(seeds), "hardware": each_once(row.hardware for row in seeds)}


def _failed(contents: Contents, game: Game) -> list[Run]:
    """Returns the ways of training of which a seed has failed: nothing is averaged without it."""
    return [] if game.setting is None else [run for run in contents.index.runs(game.setting) if contents.index.has_failed(run)]


def _curve(contents: Contents, run: Run) -> dict[int, list[float]] | None:
    """Returns the returns of the seeds of a run that are done, by environment steps; None where there are none."""
    done = {row.seed for row in contents.index.seeds(run) if row.status == "done"}
    by_step: dict[int, list[float]] = defaultdict(list)
    for point in contents.index.curve(run):
        if point.seed in done:
            by_step[point.env_steps].append(point.collective_return)
    whole = {step: values for step, values in sorted(by_step.items()) if len(values) == len(done)}
    return whole or None


def _apart(run: Run, others: Sequence[Run]) -> str:
    """Returns what tells a way of training from those that have the same name in words: its settings, else its digest."""
    alike = [other for other in others if other is not run and in_words(other) == in_words(run)]
    if not alike:
        return ""
    own = {name: mine for other in alike for name, (mine, _) in settings_apart(run, other).items()}
    return f" ({', '.join(f'{name} {value}' for name, value in own.items()) or run.run[-8:]})"


def _line(run: Run, curve: dict[int, list[float]], apart: str) -> Line:
    found = [estimate(np.array(values)) for values in curve.values()]
    seeds = len(next(iter(curve.values())))
    label = f"{in_words(run)}{apart}, {seeds} seed{'s' if seeds > 1 else ''}"
    steps, means = np.array([*curve], float), np.array([figure.mean for figure in found])
    if seeds < 2:
        return Line(label, steps, means)
    return Line(label, steps, means, np.array([figure.low for figure in found]), np.array([figure.high for figure in found]))


def _draw(lines: Sequence[Line], title: str) -> "Figure":
    with colours():
        return draw_panels(split_lines(lines, Y_TITLE), title)
