"""SVO: returns by weight at 90 degrees, and by angle at the weight that was chosen."""

from collections import Counter
from functools import partial

from sjdsl.report import published
from sjdsl.report.beside import Line, beside_table
from sjdsl.report.cells import Cell
from sjdsl.report.contents import Contents, Game, remarks_of, sweeps_of
from sjdsl.report.page import Picture, Section, Table
from sjdsl.report.small_multiples import Series, draw_series, panel_of
from sjdsl.report.ways import svo as way

WEIGHTS = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)
ANGLES = (0.0, 22.5, 45.0, 67.5, 90.0)
PROSOCIAL = 90.0  # degrees, at which weights are compared


def svo(contents: Contents) -> Section:
    """Returns the section of IPPO with social value orientation."""
    weights = {game: _by_weight(contents, game) for game in contents.games}
    angles = {game: by_angle(contents, game) for game in contents.games}
    text = (
        "The weight is chosen at 90 degrees, as the best of those in the first table. The angles are trained at that weight, with other seeds: "
        "the best of several noisy means is too high on average.",
        "At 90 degrees an agent that alone is rewarded loses 1.57 times the weight (a quarter turn in radians). From a weight of 0.64 on that is "
        "more than a reward of 1, so that earning does not pay, unless as much is deducted while nobody is rewarded. The released code and "
        "`svo_at_rest=selfish` do that; `svo_at_rest=content` does not.",
        *_without_weight(angles),
        f"Published: {published.source('svo')}.",
        *remarks_of(contents, "svo"),
    )
    tables = [*_weight_table(weights), *_angle_table(contents, angles)]
    panels = []
    for game, (weight, cells) in angles.items():
        if cells:
            series = Series.of((angle, cell.estimate) for angle, cell in cells.items() if cell.estimate is not None)
            printed = [(angle, figure.mean) for angle, figure in published.svo(game.published).items()]
            panels.append(panel_of(f"{game.label}, weight {weight:g}", series, printed))
    draw = partial(draw_series, panels, "SVO angle (degrees)", "collective return")
    pictures = (Picture("svo", "returns by SVO angle", draw),) if panels else ()
    # of weight 0 a sweep trains one angle, for all are alike
    wanted = [game.asked for game, (weight, cells) in angles.items() if not (set(ANGLES) <= cells.keys() or (cells and not weight))]
    fill = sweeps_of(wanted, "--protocol svo", "runs/svo")
    return Section("Social value orientation", text, tuple(tables), pictures, fill)


def _without_weight(angles: dict[Game, tuple[float, dict[float, Cell]]]) -> list[str]:
    found = [game.label for game, (weight, cells) in angles.items() if cells and not weight]
    if not found:
        return []
    return [f"In {', '.join(found)} the chosen weight is 0, which is individual reward. All angles are alike then, and one is trained."]


def _by_weight(contents: Contents, game: Game) -> dict[float, Cell]:
    """Returns the cells at 90 degrees: those of a sweep's first stage, or of runs outside sweeps."""
    if game.setting is None:
        return {}
    weights = {run.svo_weight for run in contents.index.runs(game.setting) if run.svo_angle == PROSOCIAL and run.stage != 2}
    cells = {
        weight: contents.index.returns(game.setting, way(PROSOCIAL, weight, 1)) for weight in sorted(w for w in weights if w is not None)
    }
    return {weight: cell for weight, cell in cells.items() if cell is not None}


def tried_weights(contents: Contents, game: Game) -> str:
    """Returns of how many weights at 90 degrees one was chosen, in words."""
    tried = len(_by_weight(contents, game))
    return f"of {tried} tried" if tried > 1 else "no other tried"


def by_angle(contents: Contents, game: Game) -> tuple[float, dict[float, Cell]]:
    """Returns the weight of which there are most angles, and its cells: those of a sweep's second stage, or of runs outside sweeps."""
    if game.setting is None:
        return 0.0, {}
    runs = [run for run in contents.index.runs(game.setting) if run.svo_angle is not None and run.stage != 1]
    tried = Counter(weight for weight, _ in {(run.svo_weight, run.svo_angle) for run in runs} if weight is not None)
    if not tried:
        return 0.0, {}
    weight = max(tried, key=lambda weight: (tried[weight], weight))
    angles = sorted({run.svo_angle for run in runs if run.svo_weight == weight and run.svo_angle is not None})
    cells = {angle: contents.index.returns(game.setting, way(angle, weight, 2)) for angle in angles}
    return weight, {angle: cell for angle, cell in cells.items() if cell is not None}


def _weight_table(weights: dict[Game, dict[float, Cell]]) -> list[Table]:
    found = {game: cells for game, cells in weights.items() if cells}
    if not found:
        return []
    columns = sorted({*WEIGHTS, *(weight for cells in found.values() for weight in cells)})
    lines = [Line(game.label, [cells.get(weight) for weight in columns], [None] * len(columns)) for game, cells in found.items()]
    return [beside_table("svo_weights", "Collective return by SVO weight, at 90 degrees", [f"{weight:g}" for weight in columns], lines)]


def _angle_table(contents: Contents, angles: dict[Game, tuple[float, dict[float, Cell]]]) -> list[Table]:
    found = {game: pair for game, pair in angles.items() if pair[1] or contents.whole_suite}
    if not found:
        return []
    columns = sorted({*ANGLES, *(angle for _, cells in found.values() for angle in cells)})
    lines = []
    for game, (weight, cells) in found.items():
        printed = published.svo(game.published)
        ours = (f"{weight:g}, {tried_weights(contents, game)}",) if cells else ("",)
        lines.append(Line(game.label, [cells.get(angle) for angle in columns], [printed.get(angle) for angle in columns], ours))
    return [beside_table("svo_angles", "Collective return by SVO angle", [f"{angle:g}°" for angle in columns], lines, ("weight",))]
