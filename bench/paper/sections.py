"""The sections of docs/results.md that compare our results with the paper's: each is a function of the results."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import pandas as pd

from bench.paper import published
from bench.paper.contents import (
    COMMON,
    INDIVIDUAL,
    MAPPO,
    PROSOCIAL,
    RATIOS,
    SVO,
    VDN,
    Game,
    Way,
    exchanged,
    in_order,
)
from bench.paper.ninety_five_percent_rule import RESAMPLES, choice_frequencies, chosen_ratio
from bench.paper.published import PaperMetric, Printed
from bench.paper.small_multiples import Series, draw_series, panel_of
from sjdsl.results import sections
from sjdsl.results.figures import (
    EMPTY,
    Cell,
    Figure,
    Table,
    interval,
    number,
    of_cell,
    unlike_settings,
)
from sjdsl.results.page import Picture, Section
from sjdsl.results.sections import (
    BEHIND,
    compared_table,
    diagram_rows,
    of_record,
    scored,
    section_over_games,
)
from sjdsl.results.selecting import APART, SHARED, cell_of, in_words, select, setting_of
from sjdsl.results.statistics import compare

TRAINED = "training seed"  # the sampling unit of diagrams of trained pools
OF_COMMON = ("common_reward",)  # a setting that only common reward uses
HOLDS, FAILS, UNDECIDED, UNKNOWN = "holds", "does not hold", "undecided", "not run"
SURE = 0.05  # p below which a difference counts
ALIKE = 0.1  # share of the return: a smaller difference, at 95 %, counts as none
WEIGHTS = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)  # of SVO
AT_CHOSEN_WEIGHT = "IPPO, SVO 90°, chosen weight"
ANGLES = (0.0, 22.5, 45.0, 67.5, 90.0)  # degrees


# Findings: which claims of the paper hold for runs under its rules. The claims are orderings in its tables, and its diagrams.


@dataclass(frozen=True)
class Compared:
    """A way of training that is compared with another: its name, its reward, and its results here and in the paper."""

    name: str
    reward: str
    ours: Callable[[Game], Cell | None]
    theirs: Callable[[str], Printed | None]


def _exchange(ratio: float, name: str) -> Compared:
    return Compared(
        name,
        str(exchanged(ratio)["reward"]),
        lambda game: game.cell(exchanged(ratio)),
        lambda game: published.exchange(game).get(ratio),
    )


def _angle(angle: float) -> Compared:
    return Compared(
        f"SVO {angle:g}°",
        "svo",
        lambda game: game.by_angle[1].get(angle),
        lambda game: published.svo(game).get(angle),
    )


AT_NINETY = replace(_angle(PROSOCIAL), ours=lambda game: game.at_chosen_weight[1])
OWN, ALL, HALF = (
    _exchange(0.0, "individual reward"),
    _exchange(1.0, "common reward"),
    _exchange(0.5, "exchange 0.5"),
)
PAIRS = (
    (ALL, OWN),
    (HALF, OWN),
    (HALF, ALL),
    (AT_NINETY, OWN),
    (_angle(67.5), OWN),
    (AT_NINETY, ALL),
)


def findings(games: Sequence[Game], frame: pd.DataFrame) -> Section:
    """Returns the first section of the page: one line for each claim."""
    suite = {game.published: game for game in games if game.published}
    found = [_order(suite, more, less) for more, less in PAIRS]
    found.append(
        (
            "The 95 % rule chooses the paper's ratio",
            "in 9 games",
            {name: _same_ratio(game) for name, game in suite.items()},
        )
    )
    trained = _trained_diagrams(suite, frame)
    is_one = {name: _verdict(row) for name, row in trained.items()}
    found.append(("The diagram of trained agents is a dilemma", "in 9 games", is_one))
    as_theirs = {
        name: _verdict(row, published.shape(name)["shape"]) for name, row in trained.items()
    }
    found.append(
        (
            "The diagram of trained agents is a dilemma with the paper's fear or greed",
            "in 9 games",
            as_theirs,
        )
    )
    alike = {name: _alike(game) for name, game in suite.items()}
    found.append(
        (
            "IPPO with shared and with separate parameters converge alike",
            "stated, without figures",
            alike,
        )
    )
    rows = []
    for claim, theirs, verdicts in found:
        by_verdict = {
            verdict: [game for game, one in verdicts.items() if one == verdict]
            for verdict in (HOLDS, FAILS, UNDECIDED, UNKNOWN)
        }
        said = [
            f"{name}: {'all' if len(own) == len(verdicts) else ', '.join(own)}"
            for name, own in by_verdict.items()
            if own
        ]
        rows.append(
            (
                claim,
                theirs,
                Figure("; ".join(said), verdicts),
                f"{len(by_verdict[HOLDS])} of {len(verdicts)}",
            )
        )
    return Section(
        "Findings",
        (),
        (
            Table(
                "findings",
                "Claims of the paper",
                ("claim", "the paper", "ours", "holds in"),
                rows,
                3,
            ),
        ),
    )


def _order(
    suite: Mapping[str, Game], more: Compared, less: Compared
) -> tuple[str, str, dict[str, str]]:
    """Returns the claim that one way of training earns more than another, the games in which the paper claims it, and verdicts by game."""
    signs: dict[str, int] = {}
    for name in suite:
        first, second = more.theirs(name), less.theirs(name)
        if first is not None and second is not None:
            margin = (first.deviation or 0) + (second.deviation or 0) or 0.05 * max(
                first.mean, second.mean
            )
            difference = first.mean - second.mean
            signs |= {name: 1 if difference > 0 else -1} if abs(difference) > margin else {}
    alike = {name: suite[name].like(more.reward) for name in signs}
    verdicts = {
        name: _sign(more.ours(alike[name]), less.ours(alike[name]), sign)
        for name, sign in signs.items()
    }
    other = [name for name, sign in signs.items() if sign < 0]
    theirs = f"in {len(signs) - len(other)} games" + (
        f", and less in {', '.join(other)}" if other else ""
    )
    return f"{more.name} earns more than {less.name}", theirs, verdicts


def _sign(more: Cell | None, less: Cell | None, wanted: int) -> str:
    if more is None or less is None or more.estimate is None or less.estimate is None:
        return UNKNOWN
    found = compare(less.values, more.values)
    if found.p is None or found.p >= SURE:
        return UNDECIDED
    return HOLDS if found.difference * wanted > 0 else FAILS


def _same_ratio(game: Game) -> str:
    """Returns the verdict on whether the 95 % rule chooses the paper's ratio: in which share of resamplings of seeds it does.

    UNKNOWN unless several seeds of all the paper's ratios were run.
    """
    cells = game.by_ratio
    if any(
        ratio not in cells or cells[ratio].estimate is None or len(cells[ratio].values) < 2
        for ratio in RATIOS
    ):
        return UNKNOWN
    share = choice_frequencies({ratio: cells[ratio].values for ratio in RATIOS}).get(
        published.exchange_chosen(game.published), 0.0
    )
    return HOLDS if share >= 1 - SURE else FAILS if share < SURE else UNDECIDED


def _trained_diagrams(suite: Iterable[str], frame: pd.DataFrame) -> dict[str, Any]:
    """Returns the diagram of trained pools of each game: of several, that over the most seeds; None where there is none."""
    trained = [
        row for row in of_record(frame, "diagram") if row.unit == TRAINED and _of_the_paper(row)
    ]
    found = {row.game: row for row in sorted(trained, key=lambda row: row.units)}
    return {name: found.get(name) for name in suite}


def _verdict(row: Any, shape: str = "") -> str:
    """Returns the verdict on the claim that a diagram is a dilemma, and one with fear or greed if `shape` says so."""
    if row is None:
        return UNKNOWN
    if row.outcome == "dilemma":
        if not shape or row[shape]:
            return HOLDS
        return FAILS if row[f"{shape}_high"] <= 0 else UNDECIDED
    return UNDECIDED if row.outcome == UNDECIDED else FAILS


def _of_the_paper(row: pd.Series) -> bool:
    return bool(
        row.game in published.suite()
        and row.variant == published.variant(row.game)
        and not row.params
    )


def _alike(game: Game) -> str:
    """Returns the verdict on whether shared and separate parameters end alike: the interval of their difference lies within ALIKE of the larger mean.

    Individual reward counts if it was run both ways, else common reward; UNKNOWN if neither was.
    """
    pairs = [(game.cell(way), game.cell({**way, "sharing": APART})) for way in (INDIVIDUAL, COMMON)]
    first, second = next((pair for pair in pairs if None not in pair), (None, None))
    if first is None or second is None or first.estimate is None or second.estimate is None:
        return UNKNOWN
    found, margin = (
        compare(first.values, second.values),
        ALIKE * max(abs(first.estimate.mean), abs(second.estimate.mean)),
    )
    if found.low is None or found.high is None or found.p is None:
        return UNDECIDED
    if -margin <= found.low and found.high <= margin:
        return HOLDS
    return FAILS if found.p < SURE else UNDECIDED


# Individual and common reward; shared and separate parameters.


def own_and_common(games: Sequence[Game], frame: pd.DataFrame) -> Section:
    """Returns the section of IPPO with individual and with common reward."""
    random = {(row.game, row.hash): row for row in of_record(frame, "random")}
    lines: list[tuple[tuple[str, ...], Cell | None, Cell | None]] = []
    for game in games:
        own, common = game.cell(INDIVIDUAL), game.cell(COMMON)
        if own is None and common is None and not game.published:
            continue
        row = (
            random.get((game.name, game.setting.hash))
            if game.setting is not None and not game.setting.params
            else None
        )
        shown = "" if row is None else interval(row.collective_return, row.low, row.high).text
        lines.append(((game.label, published.difficulty(game.published), shown), own, common))
    words = ("game", "the paper calls it", "random policy, over episodes")
    table = compared_table(
        "own_and_common", "Collective return of IPPO", words, ("individual", "common"), lines
    )
    text = []
    for (label, *_), own, common in lines:
        text += [
            f"* {label}: {said}"
            for said in unlike_settings({"individual": own, "common": common}, OF_COMMON)
        ]
    return Section("Individual and common reward", tuple(text), (table,))


def sharing(games: Sequence[Game]) -> Section:
    """Returns the section on ways of training that were run with both shared and separate parameters."""
    lines = []
    for game in games:
        rows = game.rows.assign(
            way=[in_words(row, sharing=False) for row in game.rows.itertuples()]
        )
        for way, own in rows.groupby("way"):
            cells = [cell_of(select(own, sharing=kind)) for kind in (SHARED, APART)]
            if None not in cells:
                lines.append(((game.label, way), *cells))
    text = []
    for (label, way), shared, apart in lines:
        text += [
            f"* {label}, {way}: {said}"
            for said in unlike_settings({"shared": shared, "separate": apart})
        ]
    title = "Collective return with shared and with separate parameters"
    table = compared_table(
        "sharing", title, ("game", "way of training"), ("shared", "separate"), lines
    )
    return Section("Shared and separate parameters", tuple(text), (table,) if lines else ())


def mappo(games: Sequence[Game]) -> Section:
    """Returns the section of IPPO and MAPPO with common reward."""
    lines = [
        ((game.label,), game.like("mappo").cell(COMMON), game.cell(MAPPO))
        for game in games
        if game.cell(MAPPO) is not None
    ]
    table = compared_table(
        "mappo", "Collective return with common reward", ("game",), ("IPPO", "MAPPO"), lines
    )
    return Section("IPPO and MAPPO", (), (table,) if lines else ())


# Tables of our cells beside the published ones, three lines for each game. We run no tests against published figures, as the paper reports
# no seed counts.


def beside(
    label: str,
    cells: Sequence[Cell | None],
    printed: Sequence[Printed | None],
    more: Sequence[str] = (),
    theirs: Sequence[str] = (),
) -> list[tuple[str | Figure, ...]]:
    """Returns the lines of a game: our cells, the published ones, and the differences with whether the published figure is in our interval.

    Args:
      more: further columns of our line; theirs: the same columns of the published line.
    """
    if not (any(cells) or any(printed)):
        return []
    alike, apart = _behind(cells)
    shown = []
    for cell in cells:
        figure, said = (
            of_cell(cell),
            ", ".join(filter(None, (cell.origins[place] for place in apart)))
            if cell is not None
            else "",
        )
        shown.append(Figure(f"{figure.text} ({said})" if said else figure.text, figure.numbers))
    lines: list[tuple[str | Figure, ...]] = [(label, "ours", *shown, *more, alike)]
    none = ("",) * len(more)
    if any(printed):
        lines.append(
            (
                "",
                "published",
                *(EMPTY if one is None else one.figure for one in printed),
                *(theirs or none),
                "",
            )
        )
    differences = [_difference(cell, one) for cell, one in zip(cells, printed, strict=True)]
    if any(figure.text for figure in differences):
        lines.append(("", "ours - published", *differences, *none, ""))
    return lines


def _behind(cells: Sequence[Cell | None]) -> tuple[str, list[int]]:
    """Returns what the cells of a line have in common (seeds, steps, preset, hardware), and the indices of those that differ."""
    kinds = list(zip(*(cell.origins for cell in cells if cell is not None), strict=True))
    apart = [place for place, found in enumerate(kinds) if len(set(found)) > 1]
    return ", ".join(
        found[0] for place, found in enumerate(kinds) if place not in apart and found[0]
    ), apart


def _difference(cell: Cell | None, printed: Printed | None) -> Figure:
    if cell is None or cell.estimate is None or printed is None:
        return EMPTY
    found = cell.estimate
    difference, known = found.mean - printed.mean, len(cell.values) > 1
    inside = found.low <= printed.mean <= found.high
    where = {True: ", inside", False: ", outside"}[inside] if known else ""
    return Figure(
        f"{'+' if difference > 0 else ''}{number(difference)}{where}",
        {"difference": difference, "published_inside": inside},
    )


def exchange(games: Sequence[Game]) -> Section:
    """Returns the section on IPPO by exchange ratio, the ratio that the 95 % rule chooses, and how certain that choice is."""
    found = {
        game.label: (game, game.by_ratio)
        for game in games
        if game.published or "exchange" in set(game.rows.reward)
    }
    ratios = sorted({*RATIOS, *(ratio for _, cells in found.values() for ratio in cells)})
    names = {
        ratio: {0.0: "0: individual", 1.0: "1: common"}.get(ratio, f"{ratio:g}") for ratio in ratios
    }
    lines, choices, panels = [], [], []
    for label, (game, cells) in found.items():
        printed, bold = (
            published.exchange(game.published),
            published.exchange_chosen(game.published),
        )
        means = {
            ratio: cell.estimate.mean for ratio, cell in cells.items() if cell.estimate is not None
        }
        theirs = ("" if bold is None else f"{bold:g}",)
        lines += beside(
            label, [*map(cells.get, ratios)], [*map(printed.get, ratios)], (_choice(means),), theirs
        )
        several = {
            ratio: cell.values
            for ratio, cell in cells.items()
            if cell.estimate is not None and len(cell.values) > 1
        }
        if len(several) > 1:
            shares = choice_frequencies(several)
            shown = [
                Figure(f"{shares[choice]:.1%}", {"": shares[choice]}) if choice in shares else EMPTY
                for choice in (*ratios, None)
            ]
            choices.append((label, *shown))
        if len(means) > 1 or (means and printed):  # one point alone is no curve
            panels.append(
                panel_of(
                    label, _series(cells), [(ratio, one.mean) for ratio, one in printed.items()]
                )
            )
    headings = ("game", "", *names.values(), "95 % rule", BEHIND)
    tables = [Table("exchange", "Collective return by exchange ratio", headings, lines, 2)]
    text = []
    for label, (_, cells) in found.items():
        text += [
            f"* {label}: {said}"
            for said in unlike_settings(
                {names[ratio]: cells.get(ratio) for ratio in ratios}, OF_COMMON
            )
        ]
    if choices:
        title = f"How often the rule chooses each ratio in {RESAMPLES:,} resamplings of seeds"
        tables.append(Table("exchange_choices", title, ("game", *names.values(), "none"), choices))
    pictures = (
        Picture(
            "exchange",
            "returns by exchange ratio",
            partial(draw_series, panels, "exchange ratio", "collective return"),
        ),
    )
    return Section(
        "Returns by exchange ratio", tuple(text), tuple(tables), pictures if panels else ()
    )


def _choice(means: Mapping[float, float]) -> str:
    """Returns the ratio that the rule chooses, and from how many; empty if there is only one."""
    if len(means) < 2:
        return ""
    ratio = chosen_ratio(means)
    return ("none" if ratio is None else f"{ratio:g}") + (
        "" if len(means) >= len(RATIOS) else f" of {len(means)} ratios"
    )


def _series(cells: Mapping[float, Cell]) -> Series:
    return Series.of((x, cell.estimate) for x, cell in cells.items() if cell.estimate is not None)


def svo(games: Sequence[Game]) -> Section:
    """Returns the section on IPPO with social value orientation: returns by weight at 90 degrees, and by angle at the chosen weight."""
    tried = {game.label: game.by_weight for game in games}
    found = {game.label: (game, *game.by_angle) for game in games}
    tables = []
    weights = sorted({*WEIGHTS, *(weight for cells in tried.values() for weight in cells)})
    lines = [
        line
        for label, cells in tried.items()
        if cells
        for line in beside(label, [*map(cells.get, weights)], [None] * len(weights))
    ]
    if lines:
        headings = ("game", "", *(f"{weight:g}" for weight in weights), BEHIND)
        tables.append(
            Table(
                "svo_weights", "Collective return by SVO weight, at 90 degrees", headings, lines, 2
            )
        )
    angles = sorted({*ANGLES, *(angle for _, _, cells in found.values() for angle in cells)})
    lines, panels = [], []
    for label, (game, weight, cells) in found.items():
        printed = published.svo(game.published)
        ours = f"{weight:g}, {tried_weights(game)}" if cells else ""
        lines += beside(label, [*map(cells.get, angles)], [*map(printed.get, angles)], (ours,))
        if len(cells) > 1 or (cells and printed):
            points = [(angle, one.mean) for angle, one in printed.items()]
            panels.append(panel_of(f"{label}, weight {weight:g}", _series(cells), points))
    headings = ("game", "", *(f"{angle:g}°" for angle in angles), "weight", BEHIND)
    tables.append(Table("svo_angles", "Collective return by SVO angle", headings, lines, 2))
    pictures = (
        Picture(
            "svo",
            "returns by SVO angle",
            partial(draw_series, panels, "SVO angle (degrees)", "collective return"),
        ),
    )
    return Section("Social value orientation", (), tuple(tables), pictures if panels else ())


def tried_weights(game: Game) -> str:
    """Returns the number of weights tried at 90 degrees, in words."""
    tried = len(game.by_weight)
    return f"of {tried} tried" if tried > 1 else "no other tried"


def metrics(games: Sequence[Game]) -> Section:
    """Returns the section on how much agents cooperate, on the paper's scale, by the paper's six ways of training."""
    lines: list[tuple[str | Figure, ...]] = []
    for game in games:
        metric = published.metric(game.published)
        if metric is None:
            continue
        ratios = {
            ratio: cell
            for ratio, cell in game.by_ratio.items()
            if ratio > 0 and cell.estimate is not None
        }
        weight, prosocial = game.at_chosen_weight
        cells = [_scaled(game, metric, way) for way in (INDIVIDUAL, COMMON, MAPPO, VDN)] + [
            None,
            None,
        ]
        chosen = []
        if set(ratios) - {1.0}:
            best = max(ratios, key=lambda ratio: ratios[ratio].estimate.mean)
            cells[4] = _scaled(game.like("exchange"), metric, exchanged(best))
            chosen.append(f"ratio {best:g}, the best of {len(ratios)}")
        if prosocial is not None:
            cells[5] = _scaled(
                game,
                metric,
                {**SVO, "svo_angle": PROSOCIAL, "svo_weight": weight, "run": prosocial.run},
            )
            chosen.append(f"weight {weight:g}, {tried_weights(game)}")
        printed = [metric.printed[column] for column in published.metric_columns()]
        lines += beside(game.label, cells, printed, (metric.what, "; ".join(chosen)))
    headings = ("game", "", *published.metric_columns(), "figure", "chosen", BEHIND)
    return Section(
        "Cooperation metrics", (), (Table("metrics", "Cooperation metric", headings, lines, 2),)
    )


def _scaled(game: Game, metric: PaperMetric, way: Way) -> Cell | None:
    """Returns the metric on the paper's scale."""
    cell = game.cell(way, metric.measure)
    if cell is None or game.setting is None:
        return None
    scale = metric.scale / (game.setting.num_agents if metric.per_agent else 1)
    return replace(cell, values=tuple(scale * value for value in cell.values))


def over_games(games: Sequence[Game], frame: pd.DataFrame) -> Section:
    """Returns the section on scores between a random policy and the best of the paper; SVO at each weight, and at the one chosen in each game.

    All ways of training are compared over all of the paper's games that were run: without the games in which it earns little, a mean is higher.
    """
    scores = {}
    for game in games:
        best = published.best_return(game.published)
        if best is None or game.setting is None:
            continue
        named = {
            words: cell_of(own)
            for words, own in game.rows.assign(
                way=[in_words(row) for row in game.rows.itertuples()]
            ).groupby("way")
        }
        named[AT_CHOSEN_WEIGHT] = game.at_chosen_weight[1]
        scores[game.label] = scored(
            frame,
            game.setting,
            best,
            {way: cell for way, cell in named.items() if cell is not None},
        )
    what = "A score is (return - random) / (best published - random): 0 is a random policy, 1 the best of the paper."
    if any(AT_CHOSEN_WEIGHT in found for found in scores.values()):
        what += " In each game, the chosen weight of SVO is the one of those tried that earns most."
    return section_over_games(scores, what, [game for game, found in scores.items() if found])


# Experiments with policies.


def diagrams(frame: pd.DataFrame) -> Section:
    """Returns the section on Schelling verdicts beside those of the paper: in each game, those under the paper's rules come first."""
    section = sections.diagrams(frame)
    found = sorted(
        of_record(frame, "diagram"),
        key=lambda row: (
            in_order(row.game),
            not _of_the_paper(row),
            setting_of(row).label,
            row.unit != TRAINED,
            row.cooperators,
        ),
    )
    rows: list[tuple[str | Figure, ...]] = []
    for name in dict.fromkeys((*published.suite(), *(row.game for row in found))):
        own, shape, variant = (
            [row for row in found if row.game == name],
            published.shape(name),
            published.variant(name),
        )
        note = f" ({shape['note']})" if shape and shape["note"] else ""
        said = f"{shape['shape']}, called a {shape['type']}{note}" if shape else ""
        cells = zip(own, diagram_rows(own), strict=True)
        lines = [
            (*figures, said if row is own[0] and _of_the_paper(row) else "")
            for row, figures in cells
        ]
        if shape and not (own and _of_the_paper(own[0])):
            lines.insert(0, (f"{name}, variant {variant}", *("",) * 8, said))
        rows += [(*line[:8], line[9], line[8]) for line in lines]
    headings = (
        "game",
        "cooperators",
        "defectors",
        "A",
        "B",
        "fear",
        "greed",
        "verdict",
        "published",
        "over",
    )
    table = Table("schelling", "Contrasts of the return of an agent", headings, rows, 3)
    return replace(section, tables=(table,))
