"""Speed: environment steps a second of random play at 1, 128, 1,024 and 4,096 environments, and with 20 agents."""

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from sjdsl.bench.tables import thousands
from sjdsl.report import published
from sjdsl.report.contents import Contents, called
from sjdsl.report.evidence import SpeedRow
from sjdsl.report.figure_text import rough
from sjdsl.report.page import Picture, Section, Table
from sjdsl.report.small_multiples import Multiple, Series, draw_series

NUMBERS = (1, 128, 1024, 4096)
OBSERVATION = "tokens"  # what agents see in the pictures and in empty rows


def speed(contents: Contents) -> Section:
    """Returns the section of random play, beside the published speeds on other hardware."""
    rows = contents.evidence.speeds
    numbers = sorted({*NUMBERS, *(row.num_envs for row in rows)})
    lines = [line for name in contents.names for crowd in (False, True) for line in _lines(contents, name, crowd, numbers)]
    records = tuple(_record(row) for row in rows)
    text = (
        "Environment steps a second under random actions: the median of the rounds, from the slowest to the fastest in brackets. "
        "No seeds stand behind these figures, and no interval.",
        f"Published: {published.source('speed')}. Other hardware: the ratio is no comparison of programs.",
    )
    headings = ("game", "", *(f"{number:,}" for number in numbers), "rounds, hardware")
    table = Table("speed", "Environment steps a second", headings, tuple(lines), records, 2)
    plots = [plot for name in contents.names if (plot := _plot(contents, name)) is not None]
    draw = partial(draw_series, plots, "environments at once", "environment steps a second", logarithmic=True)
    missing = [name for name in contents.plain_names if not _complete(contents, name)]
    fill = [f"sjdsl bench {called(missing)} --envs 1,128,1024,4096 --agents own,20 --json runs/speed.json"] if missing else []
    pictures = (Picture("speed", "speed over environments", draw),) if plots else ()
    return Section("Speed", text, (table,) if lines else (), pictures, tuple(fill))


def _lines(contents: Contents, game: str, crowd: bool, numbers: list[int]) -> Iterator[tuple[str, ...]]:
    """Yields the rows of a game with its own number of agents, or with a crowd."""
    printed = published.speed(game, crowd)
    found = [row for row in contents.evidence.speeds if row.game == game and row.crowd == crowd]
    kinds = list(dict.fromkeys((row.num_agents, row.observation, row.hardware, row.rounds) for row in found))
    agents = "20 agents" if crowd else "own agents"
    if not kinds and printed and contents.whole_suite:
        yield (f"{game}, {agents}", "ours", *("",) * len(numbers), "")
    for kind in kinds:
        rates = {row.num_envs: row for row in found if (row.num_agents, row.observation, row.hardware, row.rounds) == kind}
        label = f"{game}, {kind[0]} agents, {kind[1]}"
        yield (label, "ours", *(_text(rates.get(number)) for number in numbers), f"{kind[3]} round{'s' * (kind[3] != 1)}, {kind[2]}")
    if printed and (kinds or contents.whole_suite):
        yield ("", "published", *(thousands(printed[number]) if number in printed else "" for number in numbers), "")
    before = published.melting_pot_speed(game)
    if before is not None and not crowd and (kinds or contents.whole_suite):
        yield ("", "published, Melting Pot", *(thousands(before) if number == 1 else "" for number in numbers), "")
    for kind in kinds if printed else ():
        rates = {row.num_envs: row for row in found if (row.num_agents, row.observation, row.hardware, row.rounds) == kind}
        ratios = (rough(rates[n].rate / printed[n]) if n in rates and n in printed else "" for n in numbers)
        yield ("", f"ours / published, {kind[1]}", *ratios, "")


def _text(row: SpeedRow | None) -> str:
    return "" if row is None else f"{thousands(row.rate)} [{thousands(row.slowest)}, {thousands(row.fastest)}]"


def _record(row: SpeedRow) -> dict[str, Any]:
    printed = published.speed(row.game, row.crowd).get(row.num_envs)
    return {**vars(row), "published": printed, "ratio": printed and row.rate / printed}


def _complete(contents: Contents, game: str) -> bool:
    there = {(row.crowd, row.num_envs) for row in contents.evidence.speeds if row.game == game}
    return all((crowd, number) in there for crowd in (False, True) for number in published.speed(game, crowd) or NUMBERS * (not crowd))


def _plot(contents: Contents, game: str) -> Multiple | None:
    own = [row for row in contents.evidence.speeds if (row.game, row.observation, row.crowd) == (game, OBSERVATION, False)]
    series = []
    for hardware in dict.fromkeys(row.hardware for row in own):
        rows = sorted((row for row in own if row.hardware == hardware), key=lambda row: row.num_envs)
        x, mean, low, high = (np.array([getattr(row, name) for row in rows], float) for name in ("num_envs", "rate", "slowest", "fastest"))
        series.append(Series(x, mean, low, high, hardware))
    return Multiple(game, tuple(series), tuple(published.speed(game, crowd=False).items())) if series else None
