"""Shared against separate parameters: one network for all agents, or one for each."""

from collections import defaultdict
from dataclasses import replace

from sjdsl.report.cells import Cell, Setting, settings_between
from sjdsl.report.comparing import Pair, compared_table
from sjdsl.report.contents import Contents, sweeps_of
from sjdsl.report.page import Section
from sjdsl.report.ways import APART, SHARED, in_words


def sharing(contents: Contents) -> Section:
    """Returns the section: every way of training that was tried with both."""
    lines: list[Pair] = []
    tried = set()
    for game in contents.games:
        ways: dict[str, set[str]] = defaultdict(set)
        for run in contents.index.runs(game.setting) if game.setting is not None else ():
            ways[in_words(replace(run, sharing=SHARED))].add(run.sharing)
        for way in sorted(way for way, found in ways.items() if {SHARED, APART} <= found):
            tried.add(game.label)
            lines.append(((game.label, way), _cell(contents, game.setting, way, SHARED), _cell(contents, game.setting, way, APART)))
    text = [
        "Agents share one network, or each has its own, with its own initial weights. "
        "The paper says that both take about the same time and converge alike, and has no figures.",
    ]
    for (label, way), shared, separate in lines:
        text += settings_between(f"{label}, {way}", {"shared": shared, "separate": separate})
    title = "Collective return with shared and with separate parameters"
    table = compared_table("sharing", title, ("game", "way of training"), ("shared", "separate"), lines)
    fill = sweeps_of((game.asked for game in contents.games if game.label not in tried), "--protocol sharing", "runs/sharing")
    return Section("Shared and separate parameters", tuple(text), (table,) if lines else (), fill=fill)


def _cell(contents: Contents, setting: Setting | None, way: str, sharing: str) -> Cell | None:
    if setting is None:
        return None
    return contents.index.returns(setting, lambda run: in_words(replace(run, sharing=SHARED)) == way and run.sharing == sharing)
