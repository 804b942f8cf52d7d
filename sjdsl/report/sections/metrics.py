"""The metrics table: how much agents cooperate, on the paper's scale, by how they learnt."""

from dataclasses import replace

from sjdsl.report import published
from sjdsl.report.beside import Line, beside_table
from sjdsl.report.cells import Cell
from sjdsl.report.contents import Contents, Game, remarks_of, sweeps_of
from sjdsl.report.page import Section
from sjdsl.report.published import PaperMetric
from sjdsl.report.sections.exchange import RATIOS
from sjdsl.report.sections.svo import PROSOCIAL, by_angle, tried_weights
from sjdsl.report.ways import Way, common, exchanged, individual, mappo, vdn
from sjdsl.report.ways import svo as svo_way

TITLE = "Cooperation metrics"


def metrics(contents: Contents) -> Section:
    """Returns the section of the paper's six ways of training."""
    columns = published.metric_columns()
    lines = []
    empty = []
    for game in contents.games:
        metric = published.metric(game.published)
        if metric is None:
            continue
        cells = [_cell(contents, game, metric, way) for way in _ways(contents, game)]
        empty += [game] if None in cells else []
        chosen = _choices(contents, game, cells)
        lines.append(Line(game.label, cells, [metric.printed[column] for column in columns], (metric.what, chosen)))
    if not lines:
        return Section(
            TITLE, ("The paper has a figure of cooperation for its nine games, as it played them. None of the games here is one of them.",)
        )
    text = [
        "One figure a game says how much its agents cooperate, as the paper has it. "
        "The column of exchange has the ratio with the best return, that of SVO 90 degrees at the weight shown. "
        "Beside each stands of how many: the paper tried four ratios and six weights.",
        f"Published: {published.source('metrics')}.",
    ]
    text += remarks_of(contents, "metrics")
    table = beside_table("metrics", "Cooperation metric", columns, lines, ("figure", "chosen"))
    if empty:
        text.append(
            "The command below trains exchange at the ratio that the paper chose, and SVO at the weight of the configuration. "
            "The best of several ratios and weights are found by the commands of the sections above."
        )
    return Section(TITLE, tuple(text), (table,), fill=sweeps_of([game.asked for game in empty], "--protocol algorithms", "runs/algorithms"))


def _ways(contents: Contents, game: Game) -> list[Way]:
    """Returns the ways of training of the columns: IPPO individual and common, MAPPO, VDN, the best exchange, SVO at 90 degrees."""
    return [individual, common, mappo, vdn, _best_exchange(contents, game), _chosen_svo(contents, game)]


def _choices(contents: Contents, game: Game, cells: list[Cell | None]) -> str:
    """Returns which ratio and which weight the columns of exchange and SVO have, and how many were tried."""
    exchanged_run, svo_run = (None if cell is None else cell.run for cell in cells[-2:])
    said = []
    if exchanged_run is not None:
        ratio = 1 if exchanged_run.exchange_ratio is None else exchanged_run.exchange_ratio
        said.append(f"ratio {ratio:g}, the best of {len(_exchange_means(contents, game))}")
    if svo_run is not None:
        said.append(f"weight {svo_run.svo_weight:g}, {tried_weights(contents, game)}")
    return "; ".join(said)


def _exchange_means(contents: Contents, game: Game) -> dict[float, float]:
    """Returns the mean return by exchange ratio, common reward being 1; none if there is nothing but common reward."""
    if game.setting is None:
        return {}
    others = {run.exchange_ratio for run in contents.index.runs(game.setting) if run.exchange_ratio is not None}
    ratios = [ratio for ratio in sorted({*RATIOS, *others}) if ratio > 0]
    found = {ratio: contents.index.returns(game.setting, exchanged(ratio)) for ratio in ratios}
    means = {ratio: cell.estimate.mean for ratio, cell in found.items() if cell is not None and cell.estimate is not None}
    return means if set(means) & others else {}


def _best_exchange(contents: Contents, game: Game) -> Way:
    means = _exchange_means(contents, game)
    return exchanged(max(means, key=lambda ratio: means[ratio])) if means else lambda _: False


def _chosen_svo(contents: Contents, game: Game) -> Way:
    weight, cells = by_angle(contents, game)
    return svo_way(PROSOCIAL, weight, 2) if cells else lambda _: False


def _cell(contents: Contents, game: Game, metric: PaperMetric, way: Way) -> Cell | None:
    """Returns the figure of the metric on the paper's scale."""
    if game.setting is None:
        return None
    cell = contents.index.measured(game.setting, way, metric.measure)
    if cell is None:
        return None
    scale = metric.scale / (game.setting.num_agents if metric.per_agent else 1)
    return replace(cell, values=tuple(scale * value for value in cell.values))
