"""Returns by exchange ratio, the ratio that the 95 % rule chooses, and how sure the choice is."""

from functools import partial

from sjdsl.report import published
from sjdsl.report.beside import Line, beside_table
from sjdsl.report.cells import Cell, settings_between
from sjdsl.report.contents import Contents, Game, sweeps_of
from sjdsl.report.ninety_five_percent_rule import RESAMPLES, choice_frequencies, chosen_ratio
from sjdsl.report.page import Picture, Section, Table
from sjdsl.report.small_multiples import Series, draw_series, panel_of
from sjdsl.report.ways import exchanged

RATIOS = (0.0, 0.25, 0.5, 0.75, 1.0)
CHOSEN = "95 % rule"


def exchange(contents: Contents) -> Section:
    """Returns the section of IPPO by exchange ratio."""
    found = {game: _cells(contents, game) for game in contents.games}
    ratios = sorted({*RATIOS, *(ratio for cells in found.values() for ratio in cells)})
    lines = [_line(game, cells, ratios) for game, cells in found.items() if cells or contents.whole_suite]
    columns = [_named(ratio) for ratio in ratios]
    tables = [beside_table("exchange", "Collective return by exchange ratio", columns, lines, (CHOSEN,))] if lines else []
    resampled = {game: _samples(cells) for game, cells in found.items()}
    frequencies = {game: choice_frequencies(samples) for game, samples in resampled.items() if samples}
    if frequencies:
        tables.append(_frequency_table(frequencies, ratios))
    text = [
        "Ratio 0 is individual reward, 1 is common reward. "
        "The 95 % rule chooses the smallest ratio whose mean is at least 0.95 of the best. It chooses none if the best is not above 0. Where all ratios earn alike it chooses the smallest.",
        f"Published: {published.source('exchange')}.",
    ]
    for ratio in ratios:
        text += settings_between(_named(ratio), {game.label: cells.get(ratio) for game, cells in found.items()})
    if frequencies:
        text.append(
            "The seeds that were trained are drawn again to see how often each ratio is chosen. Of few seeds that says little about others."
        )
    panels = [panel_of(game.label, _ours(cells), _printed(game)) for game, cells in found.items() if cells]
    draw = partial(draw_series, panels, "exchange ratio", "collective return")
    fill = sweeps_of(
        [game.asked for game, cells in found.items() if not set(RATIOS) <= cells.keys()], "--protocol exchange", "runs/exchange"
    )
    pictures = (Picture("exchange", "returns by exchange ratio", draw),) if panels else ()
    return Section("Returns by exchange ratio", tuple(text), tuple(tables), pictures, fill)


def _cells(contents: Contents, game: Game) -> dict[float, Cell]:
    if game.setting is None:
        return {}
    others = {run.exchange_ratio for run in contents.index.runs(game.setting) if run.exchange_ratio is not None}
    cells = {ratio: contents.index.returns(game.setting, exchanged(ratio)) for ratio in sorted({*RATIOS, *others})}
    return {ratio: cell for ratio, cell in cells.items() if cell is not None}


def _named(ratio: float) -> str:
    return {0.0: "0: individual", 1.0: "1: common"}.get(ratio, f"{ratio:g}")


def _line(game: Game, cells: dict[float, Cell], ratios: list[float]) -> Line:
    printed = published.exchange(game.published)
    means = {ratio: cell.estimate.mean for ratio, cell in cells.items() if cell.estimate is not None}
    bold = published.exchange_chosen(game.published)
    return Line(
        game.label,
        [cells.get(ratio) for ratio in ratios],
        [printed.get(ratio) for ratio in ratios],
        (_choice(chosen_ratio(means), len(means)),),
        ("" if bold is None else f"{bold:g}",),
    )


def _choice(ratio: float | None, number: int) -> str:
    """Returns the ratio that is chosen among so many; nothing of one alone."""
    few = "" if number >= len(RATIOS) else f" of {number} ratios"
    return "" if number < 2 else ("none" if ratio is None else f"{ratio:g}") + few


def _samples(cells: dict[float, Cell]) -> dict[float, tuple[float, ...]]:
    """Returns the seeds of each ratio that can be drawn again; nothing unless two ratios have two seeds or more each."""
    several = {ratio: cell.values for ratio, cell in cells.items() if cell.estimate is not None and len(cell.values) > 1}
    return several if len(several) > 1 else {}


def _frequency_table(frequencies: dict[Game, dict[float | None, float]], ratios: list[float]) -> Table:
    choices = [*ratios, None]
    rows = [(game.label, *(f"{found[c]:.1%}" if c in found else "" for c in choices)) for game, found in frequencies.items()]
    records = [
        {"game": game.label, "ratio": "none" if choice is None else choice, "frequency": found[choice]}
        for game, found in frequencies.items()
        for choice in choices
        if choice in found
    ]
    title = f"How often the rule chooses each ratio in {RESAMPLES:,} resamplings of seeds"
    return Table("exchange_choices", title, ("game", *map(_named, ratios), "none"), tuple(rows), tuple(records))


def _ours(cells: dict[float, Cell]) -> Series:
    return Series.of((ratio, cell.estimate) for ratio, cell in cells.items() if cell.estimate is not None)


def _printed(game: Game) -> list[tuple[float, float]]:
    return [(ratio, printed.mean) for ratio, printed in published.exchange(game.published).items()]
